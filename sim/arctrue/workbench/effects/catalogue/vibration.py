"""A head's bracket or the building vibrates at a fixed frequency in time."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from arctrue.workbench.effects.base import (
    Columns,
    Effect,
    FitContext,
    Nonlinear,
    Parameter,
    SearchParameter,
)
from arctrue.workbench.effects.conditions import one_speed
from arctrue.workbench.effects.missing import lacking_capture
from arctrue.workbench.observations import CaptureRows, Observations, ReferenceRows


class Vibration(Effect):
    """Adds cosine and sine of 2πft to R₂ − R₁, with a free phase in every run; if head 1 shakes,
    also to ε."""

    name = "vibration"
    physics = (
        "A head's bracket vibrates at its own frequency, or at a frequency of the floor. The "
        "phase does not depend on the angle and differs between runs."
    )
    equation = (
        "δ₂₁ = c_r cos 2πft + s_r sin 2πft in run r, t since the run's start; "
        "ε₁ = c cos 2πft + s sin 2πft, t since the set's start; the fit searches for f"
    )
    source = "forced oscillation of one head"
    capture_sees = "an oscillation in time, with the same frequency at every speed"
    reference_sees = "scatter; if the time steps are constant, a slow oscillation, the alias of f"
    separated_by = (
        "the frequency is the same at another speed; the frequency of an order changes with the "
        "speed"
    )
    next_measurement = "a capture at a speed that this set does not have, or at standstill"
    plausible = "0.05 to 2″, 5 to 300 Hz"
    parameter_units = {
        "frequency": "Hz",
        "amplitude": "arcsec",
        "run_R_amplitude": "arcsec",
        "reference_amplitude": "arcsec",
    }
    search_kind = "frequency"
    search = (SearchParameter("frequency", "Hz", 0.1, 2000.0, "frequency of the oscillation"),)

    def missing(self, observations: Observations) -> list[str]:
        return [] if observations.capture is not None else [lacking_capture()]

    def variety(self, observations: Observations) -> list[str]:
        return one_speed(observations)

    def column_names(self, observations: Observations) -> list[str]:
        runs = [
            f"{kind} {observations.run_words(run)}"
            for run in range(observations.runs)
            for kind in ("cos", "sin")
        ]
        rows = observations.reference
        seen = rows is not None and rows.time_s is not None
        return [*runs, "cos reference", "sin reference"] if seen else runs

    def column_runs(self, observations: Observations) -> tuple[int | None, ...]:
        runs = [run for run in range(observations.runs) for _ in ("cos", "sin")]
        shared = len(self.column_names(observations)) - len(runs)
        return (*runs, *[None] * shared)

    def capture_columns(
        self, rows: CaptureRows, nonlinear: Nonlinear, context: FitContext
    ) -> Columns:
        # The time counts from the start of the run, since each run has a phase of its own.
        since_s = rows.time_s - rows.run_start_s
        phase = 2.0 * np.pi * nonlinear["frequency"] * since_s
        columns = np.zeros((phase.size, 2 * (rows.runs + rows.reference_in_time)))
        index = np.arange(phase.size)
        columns[index, 2 * rows.run] = np.cos(phase)
        columns[index, 2 * rows.run + 1] = np.sin(phase)
        return columns

    def reference_columns(
        self, rows: ReferenceRows, nonlinear: Nonlinear, context: FitContext
    ) -> Columns | None:
        if rows.time_s is None or rows.capture_runs is None:
            return None
        phase = 2.0 * np.pi * nonlinear["frequency"] * (rows.time_s - rows.set_start_s)
        columns = np.zeros((phase.size, 2 * rows.capture_runs + 2))
        columns[:, -2], columns[:, -1] = np.cos(phase), np.sin(phase)
        return columns

    def parameters(
        self,
        coefficients: NDArray[np.float64],
        covariance: NDArray[np.float64],
        nonlinear: Nonlinear,
        observations: Observations,
    ) -> dict[str, Parameter]:
        each = np.hypot(coefficients[0::2], coefficients[1::2])
        amplitudes = each[: observations.runs]
        spread = np.sqrt(np.maximum(np.diag(covariance), 0.0))
        sigma = spread[: 2 * observations.runs]
        found = {
            "frequency": Parameter(nonlinear["frequency"], float("nan"), "Hz"),
            "amplitude": Parameter(
                float(np.sqrt(np.mean(amplitudes**2))),
                float(np.sqrt(np.mean(sigma**2) / max(amplitudes.size, 1))),
                "arcsec",
                "amplitude",
            ),
        }
        for run, amplitude in enumerate(amplitudes):
            name = observations.run_words(run).replace(" ", "_")
            found[f"{name}_amplitude"] = Parameter(
                float(amplitude),
                float(np.mean(sigma[2 * run : 2 * run + 2])),
                "arcsec",
                "amplitude",
            )
        if each.size > amplitudes.size:
            found["reference_amplitude"] = Parameter(
                float(each[-1]), float(np.mean(spread[-2:])), "arcsec", "amplitude"
            )
        return found
