"""Checks one effect on the rows of one set, and describes the outcome of each check in words."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from arctrue.workbench.check.formula import formula_faults
from arctrue.workbench.effects.base import Effect, FitContext, Nonlinear, SearchParameter
from arctrue.workbench.effects.registry import built_in
from arctrue.workbench.inference.design_matrix import Term, channel_columns
from arctrue.workbench.model.model_file import known_unit
from arctrue.workbench.observations import CaptureRows, Observations, ReferenceRows

Float = NDArray[np.float64]
Rows = CaptureRows | ReferenceRows
Outcome = Literal["right", "wrong", "open"]

EXPLAINED = 1e-6
"""A column counts as contained in other columns if the part outside their span is at most this
share of its length."""
LOOK_ALIKE = 0.95
"""Two effects count as look-alikes if the smallest canonical correlation of their columns exceeds
this value."""
SAME = 1e-9
"""Largest relative difference of columns that are calculated twice from the same rows."""


@dataclass(frozen=True)
class Check:
    """The question of one check, its outcome, and the finding in words."""

    question: str
    outcome: Outcome
    words: str


def checks_of(
    kind: type[Effect], observations: Observations, others: Mapping[str, type[Effect]]
) -> list[Check]:
    """Run all checks of an effect on a set. ``others`` are the known effects with which its columns
    are compared.

    Raises EffectFileError where a method fails, returns a wrong shape or takes too long.
    """
    effect = kind()
    lacking = effect.missing(observations)
    found = [_units(effect)]
    if lacking:
        said = f"this set lacks {'; '.join(lacking)}: check with a set that has it (--set)"
        return [*found, Check("columns", "open", said)]
    subject = _Subject(effect, observations)
    found += [
        subject.named(),
        subject.seen(),
        subject.same_again(),
        subject.row_by_row(),
        subject.formula(),
        subject.searched(),
        subject.parameters(),
        subject.independent(),
    ]
    if found[-1].outcome == "right":
        found.append(subject.look_alikes(others))
    return found


def _check(question: str, faults: Sequence[str], right: str) -> Check:
    if faults:
        return Check(question, "wrong", "; ".join(faults))
    return Check(question, "right", right)


def _units(effect: Effect) -> Check:
    stated = {**effect.parameter_units, **{item.name: item.unit for item in effect.search}}
    faults = [
        f"{name}: unit {unit!r} is not known to model files"
        for name, unit in stated.items()
        if not known_unit(unit)
    ]
    words = (
        ", ".join(f"{name} in {unit}" for name, unit in stated.items()) or "coefficients in arcsec"
    )
    return _check("units", faults, words)


class _Subject:
    """Holds an effect, the rows of a set, and the effect's columns for some search parameters."""

    def __init__(self, effect: Effect, observations: Observations) -> None:
        self.effect = effect
        self.observations = observations
        self.context = FitContext(
            cosine_arcsec=np.array([40.0, 1.0]),
            sine_arcsec=np.array([10.0, -2.0]),
            orders=np.array([1, 2]),
        )
        self.names = effect.column_names(observations)
        self.places = [
            {item.name: _value(item, share) for item in effect.search}
            for share in ((0.0, 0.5, 1.0) if effect.search else (0.0,))
        ]
        self.channels: dict[str, Rows] = {
            name: rows
            for name, rows in (
                ("capture", observations.capture),
                ("reference", observations.reference),
            )
            if rows is not None
        }
        self.columns = {
            name: [self._columns(rows, place) for place in self.places]
            for name, rows in self.channels.items()
        }

    def _columns(self, rows: Rows, place: Nonlinear) -> Float | None:
        if isinstance(rows, CaptureRows):
            return self.effect.capture_columns(rows.of_head(2), place, self.context)
        return self.effect.reference_columns(rows, place, self.context)

    def _each(self) -> list[tuple[str, int, Float]]:
        """Return each block of columns with its channel and the number of its place in
        ``places``."""
        return [
            (name, number, columns)
            for name, blocks in self.columns.items()
            for number, columns in enumerate(blocks)
            if columns is not None
        ]

    def named(self) -> Check:
        twice = sorted({name for name in self.names if self.names.count(name) > 1})
        clash = sorted(set(self.names) & {item.name for item in self.effect.search})
        faults = [f"the name {name} occurs twice" for name in [*twice, *clash]]
        if not self.names:
            faults.append("there is no coefficient")
        return _check("names of the coefficients", faults, ", ".join(self.names))

    def seen(self) -> Check:
        channels = sorted({name for name, _, _ in self._each()})
        faults = []
        if not channels:
            faults.append("neither capture_columns nor reference_columns returns columns")
        else:
            size = sum(np.abs(columns).max(axis=0) for _, _, columns in self._each())
            faults = [
                f"{name} is 0 in every row"
                for name, largest in zip(self.names, np.atleast_1d(size), strict=True)
                if largest == 0.0
            ]
        return _check(
            "shape and finite values", faults, f"seen in the {' and the '.join(channels)}"
        )

    def same_again(self) -> Check:
        faults = [
            f"{name}: a second call with the same rows returns different columns"
            for name, number, columns in self._each()
            if not _same(columns, self._columns(self.channels[name], self.places[number]))
        ]
        return _check("the same rows give the same columns", faults, "they do")

    def row_by_row(self) -> Check:
        """Check that the values in a row depend on this row only, because long captures are
        calculated in blocks."""
        faults = []
        for name, number, columns in self._each():
            rows = self.channels[name]
            part = slice(rows.run.size // 3, rows.run.size // 2)
            if not _same(columns[part], self._columns(rows.part(part), self.places[number])):
                faults.append(
                    f"{name}: the columns of some rows depend on the other rows; a mean, a "
                    "maximum or a first row of the rows passed to the method changes with the "
                    "block (run_start_s, set_start_s and reference_temperature_c do not)"
                )
                break
        return _check("each row by itself", faults, "the rows may come in blocks")

    def formula(self) -> Check:
        faults: list[str] = []
        compared: list[str] = []
        for name, number, columns in self._each():
            rows, place = self.channels[name], self.places[number]
            forward = self._forward(rows, place)
            if forward is None:
                continue
            compared.append(name)
            faults += [
                f"{name}_columns, {fault}" for fault in formula_faults(forward, self.names, columns)
            ]
            if faults:
                break
        question = "columns and formula"
        if not compared:
            return Check(
                question,
                "open",
                "the file has neither capture_formula nor reference_formula to compare with",
            )
        return _check(question, faults, f"equal in the {' and the '.join(dict.fromkeys(compared))}")

    def _forward(self, rows: Rows, place: Nonlinear) -> Callable[[dict[str, float]], Float] | None:
        def values(coefficients: dict[str, float]) -> Float | None:
            given = {**coefficients, **place}
            if isinstance(rows, CaptureRows):
                return self.effect.capture_formula(rows, given, self.context)
            return self.effect.reference_formula(rows, given, self.context)

        if values(dict.fromkeys(self.names, 0.0)) is None:
            return None

        def forward(coefficients: dict[str, float]) -> Float:
            found = values(coefficients)
            assert found is not None
            return found

        return forward

    def searched(self) -> Check:
        faults = []
        for item in self.effect.search:
            # The ends of the range are not used, because both ends of an angle's range may be the
            # same angle.
            low, high = _value(item, 0.3), _value(item, 0.9)
            # Of two parameters, one may be unused (a line has an order or a frequency): a parameter
            # passes if it changes a column at one of the tried values of the others.
            changes = any(
                not _same(columns, self._columns(rows, {**place, item.name: high}))
                for place in self.places[1:]
                for rows in self.channels.values()
                if (columns := self._columns(rows, {**place, item.name: low})) is not None
            )
            if not changes and self.effect.step_at is None:
                faults.append(f"{item.name} changes no column between {low:g} and {high:g}")
        words = ", ".join(item.name for item in self.effect.search)
        return _check("searched parameters", faults, words or "nothing is searched")

    def parameters(self) -> Check:
        ones = np.ones(len(self.names))
        units: dict[str, set[str]] = {}
        # The search parameters determine which parameters exist (a line in time has a frequency, a
        # line in the angle an order), so that the parameters of all tried values are collected.
        for place in self.places[1:] or self.places:
            derived_values = self.effect.parameters(ones, np.diag(ones), place, self.observations)
            derived_values = {
                **derived_values,
                **self.effect.derived(derived_values, place, self.observations),
            }
            for name, item in derived_values.items():
                units.setdefault(name, set()).add(item.unit)
        faults = [
            f"{name}: unit {unit!r} is not known to model files"
            for name, found in units.items()
            for unit in sorted(found)
            if not known_unit(unit)
        ]
        for name, unit in self.effect.parameter_units.items():
            given = set().union(*(found for key, found in units.items() if _stands_for(name, key)))
            if not given:
                faults.append(f"{name} is in parameter_units, but parameters does not return it")
            elif given != {unit}:
                other = ", ".join(sorted(given - {unit}))
                faults.append(f"{name}: parameter_units says {unit}, parameters {other}")
        return _check("fitted parameters", faults, ", ".join(units))

    def _stacked(self, terms: Sequence[Term]) -> Float:
        """Return one matrix of columns, arcseconds: rows of the capture, then of the reference."""
        blocks = [
            channel_columns(terms, self.observations, self.context, capture=name == "capture")
            for name in self.channels
        ]
        return np.vstack(blocks)

    def _model(self, others: Mapping[str, type[Effect]]) -> Float:
        """Return an orthonormal basis of ``graduation_harmonics`` and of all offsets."""
        columns = self._stacked([Term(others["graduation_harmonics"](), {})])
        offsets, start = [], 0
        for name, rows in self.channels.items():
            runs = rows.run if name == "capture" else np.zeros(rows.run.size, dtype=np.int64)
            for run in np.unique(runs):
                one = np.zeros(columns.shape[0])
                one[start : start + runs.size][runs == run] = 1.0
                offsets.append(one)
            start += runs.size
        return _basis(np.column_stack([columns, *offsets]))

    def _own(self, others: Mapping[str, type[Effect]]) -> tuple[Float, Float]:
        own = self._stacked([Term(self.effect, self.places[len(self.places) // 2])])
        model = self._model(others)
        return own, own - model @ (model.T @ own)

    def independent(self) -> Check:
        own, left = self._own(built_in())
        lengths = np.linalg.norm(own, axis=0)
        kept = np.linalg.norm(left, axis=0)
        faults = [
            f"{name} is already in graduation_harmonics or in the offset of a run"
            for name, whole, rest in zip(self.names, lengths, kept, strict=True)
            if whole > 0.0 and rest <= EXPLAINED * whole
        ]
        if not faults and _basis(left).shape[1] < len(self.names) and np.all(lengths > 0.0):
            faults.append("the columns depend on each other: one of them is a sum of the others")
        return _check("independence", faults, "of the model's columns and of each other")

    def look_alikes(self, others: Mapping[str, type[Effect]]) -> Check:
        """Find known effects (without search parameters) whose columns on this set can replace this
        effect's columns."""
        _, left = self._own(others)
        own = _basis(left)
        model = self._model(others)
        similar = []
        for name, kind in others.items():
            other = kind()
            if name in (self.effect.name, "graduation_harmonics") or other.search:
                continue
            if other.missing(self.observations) or other.depends_on_model:
                continue
            columns = self._stacked([Term(other, {})])
            theirs = _basis(columns - model @ (model.T @ columns))
            if theirs.shape[1] < own.shape[1]:
                continue
            values = np.linalg.svd(own.T @ theirs, compute_uv=False)
            if values.size and float(values.min()) > LOOK_ALIKE:
                similar.append(f"{name} (correlation {float(values.min()):.3f})")
        if not similar:
            return Check("look-alikes", "right", "no known effect without a search")
        names = ", ".join(similar)
        return Check("look-alikes", "open", f"this set cannot separate it from {names}")


def _stands_for(pattern: str, name: str) -> bool:
    """Tell whether a name fits a pattern: ``run_R_amplitude`` stands for ``run_0_amplitude`` and
    others."""
    words = [
        r"[\d.]+" if len(word) == 1 and word.isupper() else re.escape(word)
        for word in pattern.split("_")
    ]
    return re.fullmatch("_".join(words), name) is not None


def _value(item: SearchParameter, share: float) -> float:
    """Return the value at ``share`` of the range of a search parameter; an integer if the parameter
    is an integer."""
    value = item.low + share * (item.high - item.low)
    return float(round(value)) if item.integer else value


def _same(first: Float, second: Float | None) -> bool:
    if second is None or first.shape != second.shape:
        return False
    scale = max(float(np.abs(first).max()) if first.size else 0.0, 1e-300)
    return bool(np.abs(first - second).max() <= SAME * scale) if first.size else True


def _basis(columns: Float) -> Float:
    """Return an orthonormal basis of the columns' span, without directions due to rounding."""
    lengths = np.linalg.norm(columns, axis=0)
    scaled = columns[:, lengths > 0.0] / lengths[lengths > 0.0]
    if scaled.shape[1] == 0:
        return np.zeros((columns.shape[0], 0))
    left, values, _ = np.linalg.svd(scaled, full_matrices=False)
    return np.asarray(left[:, values > EXPLAINED * values[0]])
