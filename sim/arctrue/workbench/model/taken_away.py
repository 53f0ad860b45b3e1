"""Finds how each effect of an exported model is corrected, and the error that remains."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from arctrue.base.units import RAD_PER_ARCSEC
from arctrue.calibration.head_weights import WeightsRefusedError, mean_weights
from arctrue.gateware.coefficients import Coefficients
from arctrue.measurement import MeasurementSet
from arctrue.workbench.effects.axis_motion import SEPARATING_HEADS
from arctrue.workbench.effects.base import (
    ConditionedLane,
    Effect,
    FitContext,
    LocalError,
    RealLane,
)
from arctrue.workbench.inference.design_matrix import Term
from arctrue.workbench.inference.solution import context_of_terms
from arctrue.workbench.model.export import THERMAL_SPAN_K, without_plain_lanes
from arctrue.workbench.model.followed_lanes import lanes_by_condition, lanes_of_real_orders
from arctrue.workbench.model.local_errors import local_errors, part_of_table, taken_off_arcsec
from arctrue.workbench.model.model import Model, ModelEffect
from arctrue.workbench.model.reading_harmonics import CorrectableLanes, correctable_lanes
from arctrue.workbench.observations import Observations
from arctrue.workbench.observations.rows import ReferenceRows

Float = NDArray[np.float64]

Taker = Literal[
    "lanes", "lanes by condition", "lanes of real orders", "local table", "firmware's model",
    "the mean", "nothing", "not in the output", "reference",
]  # fmt: skip
"""Kind of the correction of an effect. "lanes by condition" follow direction, speed or a column;
"lanes of real orders" have orders that are not whole; "firmware's model" are lanes whose values the
firmware computes for the table's temperature; "the mean" is the weighted mean of three or four
heads, as ``arctrue calibrate --angle mean`` writes it. "not in the output": only other heads than
head 1 have the error; "reference": the error is an error of the reference, not of the table."""


@dataclass(frozen=True, slots=True)
class TakenAway:
    """One effect of the model and its correction by the exported coefficients."""

    effect: str
    by: Taker
    part_arcsec: float
    """RMS of the effect in the error of head 1, under the conditions of the set; if the effect is
    an error of the reference, RMS in the reference run."""
    left_arcsec: float
    """RMS of the effect that remains with the coefficients in use; if the mean corrects the effect,
    RMS in the mean."""
    note: str


@dataclass(frozen=True)
class Outcome:
    """All effects of a model, in the order of the model, and the remaining error of the table."""

    effects: list[TakenAway]
    left_arcsec: float
    """RMS of the sum of the remaining errors of all effects in head 1, without a mean of heads."""

    @property
    def of_the_reference(self) -> list[TakenAway]:
        """Return the errors of the reference, which do not belong to the table."""
        return [item for item in self.effects if item.by == "reference"]


def outcome(
    model: Model,
    observations: Observations,
    effects: Mapping[str, type[Effect]],
    coefficients: Coefficients,
    *,
    temperature_c: float | None,
) -> Outcome:
    """Compute how far ``coefficients``, which were exported from the model, correct each of its
    effects.

    The figures are calculated from the model, not measured: on the rows of the capture or, without
    a capture, on the rows of the reference. ``temperature_c`` is the temperature of the export.
    """
    table_rows, reference_rows = _rows_of_head1(observations), observations.every_reference_row
    assert table_rows is not None
    context = _context(model, effects)
    found: list[TakenAway] = []
    together = np.zeros(table_rows.run.size)
    has_mean = _has_mean(observations)
    followed: dict[int, list[ConditionedLane]] = {}
    if coefficients.extension is not None and coefficients.extension.modulators:
        followed = lanes_by_condition(model, observations, effects)
    real: dict[int, list[RealLane]] = {}
    if coefficients.extension is not None and coefficients.extension.turn_steps:
        real = lanes_of_real_orders(model, observations, effects)
    local: dict[int, LocalError] = {}
    table = None if coefficients.extension is None else coefficients.extension.local_table
    if table is not None:
        local = local_errors(model, effects)
    taken = without_plain_lanes(model, effects, followed) | {*local, *real}
    lanes = _LanesOf.of_model(model, observations, effects, coefficients, temperature_c, taken)
    # The lanes act at the reading, which is the true angle plus the error of the model.
    reading_rad = table_rows.angle_rad.copy()
    for entry in model.effects:
        effect = entry.effect(effects)
        if effect.compensation != "reference":
            values = _values(entry, effect, table_rows, context)
            reading_rad += 0.0 if values is None else values * RAD_PER_ARCSEC
    for index, entry in enumerate(model.effects):
        effect = entry.effect(effects)
        if effect.compensation == "reference":
            size = _rms(_values(entry, effect, reference_rows, context))
            found.append(TakenAway(entry.name, "reference", size, size, effect.compensation_note))
            continue
        values = _values(entry, effect, table_rows, context)
        if values is None or not values.any():
            note = effect.compensation_note or "head 1 does not have it"
            found.append(TakenAway(entry.name, "not in the output", 0.0, 0.0, note))
            continue
        by: Taker = "nothing"
        left = values
        if index in followed:
            left = values - _followed_arcsec(followed[index], table_rows, reading_rad)
            if index not in taken:
                left = left - lanes.correction_arcsec(index, table_rows, reading_rad)
            by = "lanes by condition"
        elif table is not None and index in local:
            counts_per_rev = coefficients.counts_per_rev
            held = part_of_table(table, local[index], counts_per_rev)
            left = values - taken_off_arcsec(held, counts_per_rev, table_rows.line_rad)
            by = "local table"
        elif index in real:
            left = values - _real_arcsec(real[index], reading_rad)
            by = "lanes of real orders"
        elif effect.compensation == "lanes":
            left = values - lanes.correction_arcsec(index, table_rows, reading_rad)
            if lanes.orders(index):
                by = "firmware's model" if lanes.following(index) else "lanes"
        together += left
        if effect.moves_axis and has_mean:
            by, left = "the mean", np.zeros_like(left)
        found.append(TakenAway(entry.name, by, _rms(values), _rms(left), effect.compensation_note))
    return Outcome(found, _rms(together))


def _has_mean(observations: Observations) -> bool:
    """Tell whether three or four heads have such angles that their mean excludes motion of the
    axis."""
    rows = observations.capture
    if rows is None or rows.heads < SEPARATING_HEADS:
        return False
    try:
        mean_weights((0.0, rows.head_separation_rad, *rows.further_places_rad))
    except WeightsRefusedError:
        return False
    return True


def reference_error_arcsec(
    model: Model, observations: Observations, effects: Mapping[str, type[Effect]]
) -> Float:
    """Return the error of the reference itself in the model, at each reference row in use, (rows,).

    Raises ValueError for a set without a reference.
    """
    rows = observations.every_reference_row
    if rows is None:
        raise ValueError("the set has no reference")
    context = _context(model, effects)
    total = np.zeros(rows.run.size)
    for entry in model.effects:
        effect = entry.effect(effects)
        if effect.compensation == "reference":
            values = _values(entry, effect, rows, context)
            total += 0.0 if values is None else values
    return total


def without_reference_errors(
    measurement: MeasurementSet,
    model: Model,
    observations: Observations,
    effects: Mapping[str, type[Effect]],
) -> MeasurementSet:
    """Return the set without the errors of its reference, which a correction cannot remove."""
    reference = measurement.reference
    if reference is None or observations.every_reference_row is None:
        return measurement
    errors = reference_error_arcsec(model, observations, effects)
    used = observations.used_reference_rows
    error_arcsec = reference.error_arcsec.copy()
    error_arcsec[slice(None) if used is None else used] -= errors
    return replace(measurement, reference=replace(reference, error_arcsec=error_arcsec))


@dataclass(frozen=True)
class _LanesOf:
    """The harmonics of the reading of each effect at three temperatures: the temperature of the
    export, and THERMAL_SPAN_K below and above it."""

    lanes: tuple[CorrectableLanes, ...]
    """The effects at the three temperatures, in ascending order."""
    parts: tuple[list[dict[int, Float]], ...]
    """Cosine and sine of every order of the reading, arcseconds, by temperature and effect."""
    coefficients: Coefficients
    export_c: float

    @classmethod
    def of_model(
        cls,
        model: Model,
        observations: Observations,
        effects: Mapping[str, type[Effect]],
        coefficients: Coefficients,
        temperature_c: float | None,
        taken: frozenset[int],
    ) -> _LanesOf:
        """Convert the effects that plain lanes correct; ``taken``: indices of other effects."""
        export_c = observations.reference_temperature_c if temperature_c is None else temperature_c
        below, at, above = (
            correctable_lanes(
                model, observations, effects, temperature_c=export_c + step, taken=taken
            )
            for step in (-THERMAL_SPAN_K, 0.0, THERMAL_SPAN_K)
        )
        middle = at.of_reading()
        if coefficients.thermal is None:
            return cls((below, at, above), (middle,) * 3, coefficients, export_c)
        parts = below.of_reading(), middle, above.of_reading()
        return cls((below, at, above), parts, coefficients, export_c)

    def _place(self, index: int) -> int:
        return [number for number, _, _ in self.lanes[1].entries].index(index)

    @property
    def _there(self) -> set[int]:
        return set(self.coefficients.orders[self.coefficients.amplitudes != 0].tolist())

    def orders(self, index: int) -> list[int]:
        """Return the orders of the effect ``index`` of the model that have a lane."""
        there = self._there
        return [order for order in self.lanes[1].own_orders(self._place(index)) if order in there]

    def following(self, index: int) -> list[int]:
        """Return this effect's orders whose lanes follow the temperature."""
        thermal, place = self.coefficients.thermal, self._place(index)
        values = np.array(self.lanes[1].entries[place][1].coefficients)
        _, cold, warm = (lanes.components(place, values) for lanes in self.lanes)
        return [
            order
            for order in self.orders(index)
            if thermal is not None
            and order in thermal.orders
            and not np.array_equal(cold[order], warm[order])
        ]

    def correction_arcsec(self, index: int, rows: ReferenceRows, reading_rad: Float) -> Float:
        """Return the lanes' correction of an effect at every row, (rows,), at the temperature of
        the row.

        A lane that follows the temperature is a polynomial through three temperatures, as the
        firmware computes it.
        """
        below, at, above = (parts[self._place(index)] for parts in self.parts)
        thermal, there = self.coefficients.thermal, self._there
        total = np.zeros(rows.run.size)
        for order in sorted(there & at.keys()):
            pair = at[order][:, np.newaxis]
            follows = thermal is not None and order in thermal.orders
            if follows and rows.temperature_c is not None:
                warmth = (rows.temperature_c - self.export_c) / THERMAL_SPAN_K
                slope = np.outer(0.5 * (above[order] - below[order]), warmth)
                curve = 0.5 * (above[order] + below[order] - 2.0 * at[order])
                pair = pair + slope + np.outer(curve, warmth**2)
            phase = order * reading_rad
            total += pair[0] * np.cos(phase) + pair[1] * np.sin(phase)
        return total


def _followed_arcsec(
    lanes: Sequence[ConditionedLane], rows: ReferenceRows, reading_rad: Float
) -> Float:
    """Return the correction that lanes with a condition make at every row, (rows,)."""
    speed = np.zeros(rows.run.size) if rows.speed_rad_s is None else rows.speed_rad_s
    direction = np.sign(speed) if rows.direction is None else rows.direction
    values = {"direction": direction, "speed": speed, "speed_squared": speed**2}
    total = np.zeros(rows.run.size)
    for one in lanes:
        if one.condition == "column":
            column = rows.conditions.get(one.column, np.full(rows.run.size, one.column_zero))
            values["column"] = column - one.column_zero
        phase = one.lane.order * reading_rad
        wave = one.lane.cosine_arcsec * np.cos(phase) + one.lane.sine_arcsec * np.sin(phase)
        total += values[one.condition] * wave
    return total


def _real_arcsec(lanes: Sequence[RealLane], reading_rad: Float) -> Float:
    """Return the correction that lanes of real orders make at every reading, (rows,)."""
    total = np.zeros(reading_rad.size)
    for lane in lanes:
        phase = lane.order * reading_rad
        total += lane.cosine_arcsec * np.cos(phase) + lane.sine_arcsec * np.sin(phase)
    return total


def _rms(values: Float | None) -> float:
    """Return the RMS about the mean; the mean depends only on the zero of the angle."""
    return 0.0 if values is None or not values.size else float(values.std())


def _context(model: Model, effects: Mapping[str, type[Effect]]) -> FitContext:
    terms = [Term(entry.effect(effects), entry.search) for entry in model.effects]
    return context_of_terms(terms, [np.array(entry.coefficients) for entry in model.effects])


def _values(
    entry: ModelEffect, effect: Effect, rows: ReferenceRows | None, context: FitContext
) -> Float | None:
    """Return the contribution of an effect to the error of head 1 at these rows, or to the measured
    error of the reference, (rows,), arcseconds; None if the effect makes no contribution."""
    if rows is None:
        return None
    columns = effect.reference_columns(rows, entry.search, context)
    return None if columns is None else np.asarray(columns @ np.array(entry.coefficients))


def _rows_of_head1(observations: Observations) -> ReferenceRows | None:
    """Return rows for the error of head 1: the rows of the capture or, without a capture, the rows
    of the reference."""
    rows = observations.capture
    if rows is None:
        return observations.every_reference_row
    return ReferenceRows(
        run=rows.run,
        cycle=None,
        time_s=rows.time_s,
        temperature_c=rows.temperature_c,
        direction=rows.direction,
        target_rad=rows.angle_rad,
        angle_rad=rows.angle_rad,
        line_rad=rows.line1_rad,
        face=None,
        faces=None,
        electrical1_rad=rows.electrical1_rad,
        teeth=observations.drive_gear_teeth,
        speed_rad_s=rows.speed_rad_s,
        run_start_s=rows.run_start_s,
        set_start_s=rows.set_start_s,
        session_start_s=rows.session_start_s,
        middle_time_s=float(rows.time_s.mean()),
        reference_temperature_c=rows.reference_temperature_c,
        error_arcsec=np.zeros(rows.run.size),
        heads=rows.heads,
        conditions=rows.conditions,
    )
