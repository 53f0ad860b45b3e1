"""Tests whether the capture changes evenly and with the same slope in every run, unlike slow noise.

The noise of a run is estimated from the run itself, so that an even change within a run counts as
slow noise. Noise differs from run to run; the slopes of all runs then scatter about 0.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from arctrue.workbench.inference.residuals import Residuals
from arctrue.workbench.numeric.distributions import student_upper_p
from arctrue.workbench.observations import CaptureRows

Float = NDArray[np.float64]

LEAST_RUNS = 4
"""Smallest number of runs. With three, the mean slope would have to exceed its standard error a
hundred times (Student's t of two degrees of freedom at SAME_P)."""
SAME_P = 1e-4
"""Largest p, over all coordinates and channels, of a mean slope that is stated; it equals the limit
of a sure lack of fit."""
WORDS = {
    "angle": "with the angle since the start of the run (a cable or hose that winds up and pulls, "
    "or counts that are lost in every turn)",
    "way": "with the way since the start of the run, in both directions alike (friction that warms "
    "a part)",
    "time": "with the time since the start of the run (a settling or warming after each start)",
    "time and direction": "with the time since the start of the run and the sign of the direction "
    "(a part that creeps under the force of the motion)",
}
"""Coordinates over which the change may be even, each with its possible causes."""


@dataclass(frozen=True)
class SameRamp:
    """An even change within every run, with the same slope in all runs."""

    head: int
    arcsec: float
    """Change of the reading of the head against head 1 over the mean length of a run."""
    rms_arcsec: float
    coordinates: tuple[str, ...]
    """Keys of WORDS: coordinates over which the mean slope is significant, the most significant
    first."""

    def words(self) -> str:
        """Return the detection in words, with the alternatives that these runs cannot separate."""
        causes = " or ".join(WORDS[item] for item in self.coordinates)
        return (
            f"the reading of head {self.head} minus that of head 1 changes evenly within every "
            f"run, by {self.arcsec:.2g}″ a run, {causes}"
        )


def same_ramp(residuals: Residuals) -> SameRamp | None:
    """Return the even change that all runs of the capture share; None if the runs share no such
    change.

    The sample of Student's t is the slopes of the runs, so that any noise within a run is allowed.
    """
    rows, left = residuals.observations.capture, residuals.capture_arcsec
    if rows is None or left is None:
        return None
    found: list[tuple[float, SameRamp]] = []
    for channel in range(rows.channels):
        runs = [run for run in np.unique(rows.run) if run % rows.channels == channel]
        if len(runs) < LEAST_RUNS:
            continue
        tests = len(WORDS) * rows.channels
        tried = {name: _slopes(rows, left, runs, name) for name in WORDS}
        p_values = {name: tests * _p_of(slopes) for name, (slopes, _) in tried.items()}
        names = sorted((name for name in WORDS if p_values[name] < SAME_P), key=p_values.get)  # type: ignore[arg-type]
        if names:
            slopes, lengths = tried[names[0]]
            change = float(np.mean(slopes)) * float(np.mean(lengths))
            # A ramp of unit length has the standard deviation 1/√12.
            ramp = SameRamp(channel + 2, abs(change), abs(change) / np.sqrt(12.0), tuple(names))
            found.append((p_values[names[0]], ramp))
    return min(found, key=lambda item: item[0], default=(1.0, None))[1]


def _slopes(rows: CaptureRows, left: Float, runs: list[np.int64], name: str) -> tuple[Float, Float]:
    """Return slope of the residual over a coordinate, and length of the coordinate, of each run."""
    slopes, lengths = np.zeros(len(runs)), np.zeros(len(runs))
    for number, run in enumerate(runs):
        own = rows.run == run
        angle = rows.angle_rad[own] - rows.angle_rad[own][0]
        time = rows.time_s[own] - rows.time_s[own][0]
        sign = float(np.sign(angle[-1])) or 1.0
        place = {
            "angle": angle,
            "way": sign * angle,
            "time": time,
            "time and direction": sign * time,
        }[name]
        away = place - place.mean()
        square = float(away @ away)
        slopes[number] = float(away @ left[own]) / square if square > 0.0 else 0.0
        lengths[number] = float(np.ptp(place))
    return slopes, lengths


def _p_of(slopes: Float) -> float:
    """Return p of Student's t test of the mean slope: noise alone gives slopes that scatter about
    0."""
    error = float(np.std(slopes, ddof=1)) / np.sqrt(slopes.size)
    if error == 0.0:
        return 1.0
    return 2.0 * student_upper_p(abs(float(np.mean(slopes))) / error, slopes.size - 1)
