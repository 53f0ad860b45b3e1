"""One head loses or gains counts at one instant."""

from __future__ import annotations

from typing import ClassVar

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtr

from arctrue.workbench.effects.base import (
    CONTRADICTED_P,
    Columns,
    Effect,
    FitContext,
    Leftover,
    Nonlinear,
    Parameter,
    SearchParameter,
)
from arctrue.workbench.effects.missing import lacking_capture
from arctrue.workbench.observations import CaptureRows, Observations
from arctrue.workbench.observations.outliers.excursions import step_scatter

STAYS = 10.0
"""Smallest difference of the gains at which a step counts as lasting in the runs after its own. The
odds of the two forms are e^(difference/2): 150 to 1 at ten, which is strong evidence."""

AROUND_ROWS = 8
"""Number of rows before and after a step from which the even motion of a head is calculated."""
CLEAR_SIGMA = 6.0
"""Smallest jump of a head in standard deviations of the noise of a step; normal noise exceeds it
with a probability of 2·10⁻⁹."""
MOST_OF_THE_OTHER = 0.25
"""Largest jump of the other head, as a share of the jump: a table that jerks moves both heads
alike."""


def _jump_of_a_head(nonlinear: Nonlinear, observations: Observations) -> tuple[int, float] | None:
    """Return the head that jumps at a step, and its jump in counts.

    R₂ − R₁ alone cannot show which head slips, but the table turns evenly from one sample to the
    next, so that the count of the other head continues as before. The result is None with more than
    two heads, without counts, or if the motion hides the jump.
    """
    rows, counts_per_rev = observations.capture, observations.counts_per_rev
    if rows is None or counts_per_rev is None or rows.heads > 2:
        return None
    of_run = np.flatnonzero(rows.run == round(nonlinear["run"]))
    at = int(np.searchsorted(rows.time_s[of_run], nonlinear["instant"]))
    around = of_run[max(at - AROUND_ROWS, 0) : at + AROUND_ROWS]
    number = min(at, AROUND_ROWS) - 1
    if around.size < AROUND_ROWS or not 0 <= number < around.size - 1:
        return None
    jumps, noise = [], []
    for reading in (rows.line1_rad, rows.line2_rad):
        steps = np.diff(reading[around]) * counts_per_rev / (2.0 * np.pi)
        jumps.append(float(steps[number] - np.median(steps)))
        noise.append(step_scatter(steps))
    head = int(np.argmax(np.abs(jumps)))
    far, near = abs(jumps[head]), abs(jumps[1 - head])
    if far < CLEAR_SIGMA * max(noise) or near > MOST_OF_THE_OTHER * far:
        return None
    return head + 1, jumps[head]


class CountSlip(Effect):
    """Adds a step to R₂ − R₁, from one instant to the end of that run, or of all runs."""

    name = "count_slip"
    physics = (
        "A burst of noise or an edge that is too fast makes one decoder lose or gain counts. "
        "From then until the next index pass, the reading of this head is wrong by a whole "
        "number of counts."
    )
    equation = (
        "δ₂₁ = m·(one count) after the instant, m an integer; with the setting stays, also in the "
        "following runs"
    )
    source = "incremental counting"
    capture_sees = "a step between two samples"
    reference_sees = "a step if head 1 lost the counts"
    separated_by = (
        "the number of counts between two index passes differs from counts_per_rev by the step"
    )
    next_measurement = "a capture across several index passes, with the index counts recorded"
    plausible = "1 to 1,000 counts, often a multiple of 4"
    parameter_units = {"run": "1", "instant": "s", "step": "arcsec", "counts": "counts"}
    defaults: ClassVar[dict[str, object]] = {"stays": False}
    step_at = ("run", "instant")
    compensation_note = "count again from the index"
    search_kind = "step"
    search = (
        SearchParameter("run", "1", -1e12, 1e12, "run in which the step happens", integer=True),
        SearchParameter("instant", "s", -1e12, 1e12, "time of the step", integer=True),
    )

    @property
    def _stays(self) -> bool:
        return bool(self.settings["stays"])

    def at_place(
        self, residuals: Leftover, nonlinear: Nonlinear
    ) -> tuple[Effect, dict[str, float]]:
        """Return the effect with a step that stays in the runs after its own if these runs show
        it, otherwise with a step that ends with its run."""
        ends, stays = CountSlip(), CountSlip(stays=True)
        gained = [residuals.score(form, nonlinear).gain for form in (ends, stays)]
        return stays if gained[1] - gained[0] > STAYS else ends, dict(nonlinear)

    def missing(self, observations: Observations) -> list[str]:
        return [] if observations.capture is not None else [lacking_capture()]

    def column_names(self, observations: Observations) -> list[str]:
        return ["step"]

    def capture_columns(
        self, rows: CaptureRows, nonlinear: Nonlinear, context: FitContext
    ) -> Columns:
        run, channels = round(nonlinear["run"]), rows.heads - 1
        # A step of head 1 appears in the differences of all other heads; the search marks such a
        # step by a run number −1, −2, …
        own_run = run // channels if run >= 0 else -run - 1
        seen = rows.run % channels == run % channels if run >= 0 else np.ones(rows.run.size, bool)
        after = (rows.run // channels == own_run) & (rows.time_s >= nonlinear["instant"])
        if self._stays:
            after |= rows.run // channels > own_run
        after &= seen
        return np.asarray(after, dtype=np.float64)[:, np.newaxis]

    def describe_data(self, nonlinear: Nonlinear, observations: Observations) -> str:
        said = []
        jump = _jump_of_a_head(nonlinear, observations)
        if jump is not None:
            head, counts = jump
            said.append(
                f"Head {head} {'gains' if counts > 0.0 else 'loses'} counts there, and head "
                f"{3 - head} moves on evenly."
            )
        if self._stays:
            said.append(
                "The step stays in the following runs: the head did not search its index between "
                "them."
            )
        return " ".join(said)

    def contradiction(
        self,
        coefficients: NDArray[np.float64],
        covariance: NDArray[np.float64],
        nonlinear: Nonlinear,
        observations: Observations,
    ) -> str | None:
        """Refuse a step that is not a whole number of counts, such as 7.4 ± 0.1."""
        count = observations.count_arcsec
        if count is None:
            return None
        counts = float(coefficients[0]) / count
        sigma = float(np.sqrt(max(covariance[0, 0], 0.0))) / count
        away = abs(counts - round(counts))
        if sigma <= 0.0 or 2.0 * float(ndtr(-away / sigma)) > CONTRADICTED_P:
            return None
        return f"the step of {counts:.2f} ± {sigma:.2f} counts is not a whole number of counts"

    def parameters(
        self,
        coefficients: NDArray[np.float64],
        covariance: NDArray[np.float64],
        nonlinear: Nonlinear,
        observations: Observations,
    ) -> dict[str, Parameter]:
        sigma = float(np.sqrt(max(covariance[0, 0], 0.0)))
        step = float(coefficients[0])
        run, channels = round(nonlinear["run"]), observations.channels_of_capture
        found = {
            "run": Parameter(float(run // channels if run >= 0 else -run - 1), 0.0, "1"),
            # The step lies somewhere between the last row before it and the first row after it.
            "instant": Parameter(
                nonlinear["instant"] - 0.5 * observations.sample_period_s, float("nan"), "s"
            ),
            "step": Parameter(step, sigma, "arcsec"),
        }
        if channels > 1:
            found["head"] = Parameter(float(run % channels + 2 if run >= 0 else 1), 0.0, "1")
        elif (jump := _jump_of_a_head(nonlinear, observations)) is not None:
            found["head"] = Parameter(float(jump[0]), 0.0, "1")
        count = observations.count_arcsec
        if count is not None:
            found["counts"] = Parameter(step / count, sigma / count, "counts")
        return found
