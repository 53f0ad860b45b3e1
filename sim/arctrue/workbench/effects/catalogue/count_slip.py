"""One head loses or gains counts at one instant."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtr

from arctrue.workbench.effects.base import (
    CONTRADICTED_P,
    Columns,
    Effect,
    FitContext,
    Nonlinear,
    Parameter,
    SearchParameter,
)
from arctrue.workbench.observations import CaptureRows, Observations


class CountSlip(Effect):
    """Adds a step to R₂ − R₁, from one instant to the end of that run."""

    name = "count_slip"
    physics = (
        "A burst of noise or an edge that is too fast makes one decoder lose or gain counts. "
        "From then until the next index pass, the reading of this head is wrong by a whole "
        "number of counts."
    )
    equation = "δ₂₁ = m·(one count) after the instant, m an integer"
    source = "incremental counting"
    capture_sees = "a step between two samples"
    reference_sees = "a step if head 1 lost the counts"
    separated_by = (
        "the number of counts between two index passes differs from counts_per_rev by the step"
    )
    next_measurement = "a capture across several index passes, with the index counts recorded"
    plausible = "1 to 1,000 counts, often a multiple of 4"
    parameter_units = {"run": "1", "instant": "s", "step": "arcsec", "counts": "counts"}
    step_at = ("run", "instant")
    compensation_note = "count again from the index"
    search_kind = "step"
    search = (
        SearchParameter("run", "1", -1e12, 1e12, "run in which the step happens", integer=True),
        SearchParameter("instant", "s", -1e12, 1e12, "time of the step", integer=True),
    )

    def missing(self, observations: Observations) -> list[str]:
        return [] if observations.capture is not None else ["a capture of both heads"]

    def column_names(self, observations: Observations) -> list[str]:
        return ["step"]

    def capture_columns(
        self, rows: CaptureRows, nonlinear: Nonlinear, context: FitContext
    ) -> Columns:
        run = round(nonlinear["run"])
        # A step of head 1 appears in the differences of all other heads; the search marks such a
        # step by a run number −1, −2, …
        of_run = rows.run == run if run >= 0 else rows.run // (rows.heads - 1) == -run - 1
        after = of_run & (rows.time_s >= nonlinear["instant"])
        return np.asarray(after, dtype=np.float64)[:, np.newaxis]

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
        count = observations.count_arcsec
        if count is not None:
            found["counts"] = Parameter(step / count, sigma / count, "counts")
        return found
