"""Holds the results of the tests of one effect on the residuals of a model."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from arctrue.workbench.diagnose.detections import RegularCause
from arctrue.workbench.effects.base import Effect, Nonlinear, Parameter
from arctrue.workbench.effects.product_of_parts import ProductOfParts
from arctrue.workbench.inference.block_share import BlockShare
from arctrue.workbench.inference.design_matrix import Term
from arctrue.workbench.inference.held_out import HeldOut, Improvement
from arctrue.workbench.inference.likelihood_ratio import Evidence
from arctrue.workbench.inference.search_parameters import refined
from arctrue.workbench.inference.solution import Solution

ACTING_SHARE = 0.05
"""An effect acts on a row if it changes the prediction there by at least this share of its largest
change."""
RUNS_ARE_THE_SAMPLE = 0.5
"""If the index repeatability causes this share or more of the variance of an effect's size, the
runs, not the rows, count as the sample."""
MOVED_SHARE = 0.02
"""A change of a channel's prediction counts if it exceeds this share of the channel's noise."""


@dataclass(frozen=True, eq=False)
class SecondRunEffect:
    """The other effect with which an effect explains the offsets of the runs."""

    effect: Effect
    coefficient: float
    """Size of the other effect, fitted to the offsets together with the first effect."""
    p_value: float
    """p of the first effect with the other effect in the model, corrected for the number of effects
    that were tried as the other effect."""
    zero: tuple[Effect, float] | None = None
    """Constant of a head, and its size, that the unknown zero of one of the two effects causes;
    None if the offsets need no such constant."""

    @property
    def words(self) -> str:
        """Name of the other effect, or its parts in words."""
        effect = self.effect
        return effect.condition.words if isinstance(effect, ProductOfParts) else effect.name


@dataclass(frozen=True, eq=False)
class Candidate:
    """Results of search, fit and statistics for one effect."""

    effect: Effect
    nonlinear: Nonlinear
    gain: float
    rank: int
    trials: float
    solution: Solution
    delta_bic: float
    """BIC without the effect minus BIC with it, minus a penalty for the search, 2·log(trials);
    above 0 the effect improves the model."""
    size_arcsec: dict[str, float]
    """RMS of the effect's change of the prediction where the effect acts, by channel."""
    p_corrected: float
    rows: int
    """Number of rows of the channels that the effect changes; only these rows determine its
    size."""
    lacking_variety: list[str] = field(default_factory=list)
    level_trials: float | None = None
    """Number of trials by which p is corrected, if the trials have unequal shares of the
    false-alarm probability; otherwise None."""
    asked: Effect | None = None
    """The effect with all its settings, before the search restricted them to the form that the
    residuals show; None for a product of parts."""
    evidence: Evidence | None = None
    """Evidence with newly estimated noise; None if the noise was not estimated anew."""
    regular: RegularCause | None = None
    """Lines of a forward search that the effect explains; None if the effect was found without a
    forward search."""
    held_out: HeldOut | None = None
    improvement: dict[str, Improvement] = field(default_factory=dict)
    share: BlockShare | None = None
    """Share of the effect's fitted error that other blocks of the rows predict; None where it is
    not known."""
    second_of_runs: SecondRunEffect | None = None
    """The other effect that was subtracted from the rows, if only both together explain the offsets
    of the runs."""
    with_further: Solution | None = None
    """Model with this effect and the effects that the diagnosis finds after it; None without such
    effects."""

    @property
    def name(self) -> str:
        """Name of the effect."""
        return self.effect.name

    @property
    def freedom(self) -> float:
        """Degrees of freedom of the noise variance in the test of the effect."""
        return float("inf") if self.evidence is None else self.evidence.freedom

    @property
    def charged_trials(self) -> float:
        """Number of trials by which the effect's p is corrected."""
        return self.trials if self.level_trials is None else self.level_trials

    @cached_property
    def moved_arcsec(self) -> dict[str, float]:
        """RMS of the effect's change of the prediction over all rows, by channel.

        Without evidence, it is ``size_arcsec``, over the rows where the effect acts.
        """
        if self.evidence is None:
            return self.size_arcsec
        before = self.evidence.base.solution
        return {
            channel: float(np.sqrt(np.mean(change**2)))
            for channel, change in changes_arcsec(before, self.solution).items()
        }

    @cached_property
    def at_maximum(self) -> Solution:
        """Solution with refined search parameters, which may lie between the values that the search
        tried.

        Tests with this effect in the model use it in place of ``solution``, which is not changed.
        If a line were not exactly at its order or frequency, other effects would explain the
        remaining error.
        """
        return refined(self.solution)

    @property
    def term(self) -> Term:
        """The effect as a term of a model."""
        return Term(self.effect, self.nonlinear)

    def parameters(self) -> dict[str, Parameter]:
        """Return the fitted parameters of this effect.

        They are those of the model that also has the further effects: two effects whose columns
        resemble each other change each other's size by more than the uncertainty of each alone.
        """
        place = len(self.solution.terms) - 1
        return (self.with_further or self.solution).parameters()[place]


ONCE = frozenset({"time", "settling", "run"})
"""Conditions that depend on the time alone. Drifts and settlings change in one direction with time;
the condition ``run`` changes once, between two runs."""


def happens_once(item: Candidate) -> bool:
    """Tell whether the candidate is a drift or a single event, which the report lists apart from
    repeating effects."""
    parts = set(item.effect.in_parts) | set(item.effect.parts)
    return item.effect.step_at is not None or bool(parts & ONCE)


def is_line(item: Candidate) -> bool:
    """Tell whether the candidate is a line of a search, or a regular cause, which consists of
    lines."""
    return item.regular is not None or item.effect.search_kind == "line"


def explained_arcsec(item: Candidate) -> float:
    """Return the RMS of the error that the candidate explains in the channel where this RMS is
    largest."""
    if item.regular is not None:
        return item.regular.taken_arcsec
    return max(item.size_arcsec.values(), default=0.0)


def changes_arcsec(before: Solution, after: Solution) -> dict[str, NDArray[np.float64]]:
    """Return the change of the prediction of every row, by channel; for the reference, the mean is
    subtracted."""
    found: dict[str, NDArray[np.float64]] = {}
    if before.observations.capture is not None:
        found["capture"] = after.capture_prediction_arcsec(
            False
        ) - before.capture_prediction_arcsec(False)
    if before.observations.reference is not None:
        change = after.reference_prediction_arcsec() - before.reference_prediction_arcsec()
        found["reference"] = change - change.mean()
    return found


SAME_SIZE = 0.8
"""An amplitude is stated unchanged if the largest change of the prediction is at least this share
of it. Rows that miss the peak of a wave by a tenth of its period reach 0.81."""


def within_the_record(item: Candidate) -> dict[str, Parameter]:
    """Return the parameters of a product of parts, with the largest change of the prediction of the
    reference in place of a larger amplitude.

    The amplitude of a settling exp(−t/τ) is its size at t = 0. The model explains a part of the
    product, and the first rows may come later; possibly no row changes by this amplitude. A
    settling without orders only falls: its largest change is the difference between its first and
    last row. An amplitude per unit of a condition is not a size and is not changed. The amplitude
    of a change between two runs is not changed either: it is the difference of two states, and the
    model explains their mean.
    """
    found = item.parameters()
    if isinstance(item.effect, ProductOfParts) and item.effect.condition.from_run is not None:
        return found
    if item.evidence is None or item.evidence.base.observations.capture is not None:
        return found
    before = item.evidence.base.solution
    if item.solution.observations is not before.observations:
        return found
    change = changes_arcsec(before, item.solution)["reference"]
    effect = item.effect
    one_sided = isinstance(effect, ProductOfParts) and (
        effect.condition.part == "settling" and not effect.orders
    )
    largest = float(np.ptp(change) if one_sided else np.abs(change).max(initial=0.0))
    for name in ("amplitude", "size"):
        size = found.get(name)
        if size is not None and size.unit == "arcsec" and largest < SAME_SIZE * abs(size.value):
            found[name] = replace(size, value=largest, sigma=size.sigma * largest / abs(size.value))
    return found


def sizes_arcsec(before: Solution, after: Solution) -> dict[str, float]:
    """Return the RMS change of the prediction by channel, over the rows where the effect acts."""
    return {
        channel: _acting_rms(change) for channel, change in changes_arcsec(before, after).items()
    }


def _acting_rms(change: NDArray[np.float64]) -> float:
    largest = float(np.abs(change).max(initial=0.0))
    if largest == 0.0:
        return 0.0
    acting = np.abs(change) >= ACTING_SHARE * largest
    return float(np.sqrt(np.mean(change[acting] ** 2)))


def rows_moved(size_arcsec: Mapping[str, float], base: Solution) -> int:
    """Return the number of rows in channels that the effect changes: other rows do not determine
    its size.

    For example, only the 480 reference rows determine the errors of a polygon's faces, however long
    the capture is. If the effect changes no channel, all rows count.
    """
    channels = (
        ("capture", base.observations.capture, base.capture_sigma_arcsec),
        ("reference", base.observations.reference, base.reference_sigma_arcsec),
    )
    moved = sum(
        rows.run.size
        for name, rows, sigma in channels
        if rows is not None
        and sigma is not None
        and size_arcsec.get(name, 0.0) > MOVED_SHARE * sigma
    )
    return moved or base.observations.rows


def delta_bic(gain: float, rank: int, trials: float, rows: int) -> float:
    """Return ΔBIC: ``gain`` minus log(rows) for each coefficient and minus 2·log(trials) for the
    search. ``gain`` is twice the rise of the log likelihood, ``trials`` the number of independent
    values of the search parameters that were tried.
    """
    return float(gain - rank * np.log(rows) - 2.0 * np.log(max(trials, 1.0)))
