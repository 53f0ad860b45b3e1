"""Writes the periodic error correction table of OnStepX for the worm of a telescope mount."""

from __future__ import annotations

import re
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from arctrue.base.units import ARCSEC_PER_DEG, RAD_PER_ARCSEC
from arctrue.metrology.controllers.table_format import TableFormat
from arctrue.metrology.controllers.table_of_command import wanted_deg
from arctrue.metrology.correction import Correction

Float = NDArray[np.float64]

SECONDS_A_TURN = 86_400
"""Sidereal seconds in which a mount that follows the stars makes one turn."""
LEAST_WORM_S = 61
"""Shortest turn of a worm that OnStepX accepts, sidereal seconds."""
MOST_STEPS = 127
"""Largest table entry: OnStepX stores an entry as a signed byte."""
PLAYED_LATER_S = 1
"""Delay of the playback in seconds: OnStepX plays entry n during second n + 1 of the worm's
turn."""

ENTRY = re.compile(r":WR(\d+),([+-]\d+)#")


@dataclass(frozen=True)
class OnStep(TableFormat):
    """List of commands ``:WRn,s#``: motor steps that are added to the tracking in each sidereal
    second of the worm's turn.

    The table corrects a rate only: a constant error remains, and the alignment of the mount removes
    it. The sum of the steps is rounded, so that the table never differs from the error by more than
    half a step.
    """

    teeth: float | None = None
    """Number of teeth of the worm wheel; the worm turns once in 86,400 / teeth sidereal seconds."""
    steps_per_second: float | None = None
    """Motor steps per sidereal second; the mount reports this number in answer to ``:VS#``."""

    name = "onstep"
    file_name = "pec.onstep"
    points = SECONDS_A_TURN
    least_points = SECONDS_A_TURN
    most_points = SECONDS_A_TURN
    knows_direction = False

    def for_axis(self, teeth: float | None, steps_per_second: float | None) -> OnStep:
        if teeth is None:
            raise ValueError(
                "--format onstep corrects a worm: expected drive_gear_teeth in [table] of "
                "measurement.toml, found none"
            )
        if steps_per_second is None:
            raise ValueError(
                "--format onstep: expected --steps-per-second, the mount's answer to :VS#"
            )
        seconds = SECONDS_A_TURN / teeth
        if abs(seconds - round(seconds)) > 1e-9 or seconds < LEAST_WORM_S:
            raise ValueError(
                f"--format onstep: the worm of {teeth:g} teeth turns once in {seconds:.2f} "
                f"sidereal seconds, expected a whole number of at least {LEAST_WORM_S}"
            )
        return replace(self, teeth=teeth, steps_per_second=steps_per_second)

    def part_of(self, correction: Correction) -> Correction:
        """Return the part of the correction in harmonics of the worm; list the other orders as left
        out."""
        assert self.teeth is not None
        harmonic = np.mod(correction.orders, self.teeth) == 0
        others = ", ".join(map(str, correction.orders[~harmonic]))
        plural = "s" if np.count_nonzero(~harmonic) > 1 else ""
        reason = f"order{plural} {others}: the table holds harmonics of the worm only"
        return replace(
            correction,
            orders=correction.orders[harmonic],
            components_arcsec=correction.components_arcsec[harmonic],
            left_out=correction.left_out + ((reason,) if others else ()),
        )

    def text(self, correction: Correction, points: int, title: str) -> str:
        seconds = np.arange(self._worm_s() + 1, dtype=np.float64)
        # The worm motor is at its zero in second 0, and then tracks so that the reading R satisfies
        # R(t) − ε(R(t)) = t − ε(0).
        start_deg = float(correction.error_arcsec(np.zeros(1), None)[0]) / ARCSEC_PER_DEG
        wanted = wanted_deg(correction, seconds * (360.0 / SECONDS_A_TURN) - start_deg, 0)
        steps = np.rint((wanted - wanted[0]) / self._step_deg()).astype(np.int64)
        entries = np.diff(steps)
        largest = int(np.abs(entries).max())
        most = min(MOST_STEPS, int(self.steps_per_second or 0))
        if largest > most:
            raise ValueError(
                f"--format onstep: {largest} steps in one second, expected at most {most}: the "
                "correction must not stop or reverse the tracking"
            )
        played = np.roll(entries, -PLAYED_LATER_S)
        return "".join(f":WR{n},{s:+d}#\n" for n, s in enumerate(played)) + ":$QZ!#\n"

    def angle_error_arcsec(
        self, text: str, correction: Correction, angle_rad: Float, direction: int
    ) -> Float:
        entries = np.array([int(match[2]) for match in ENTRY.finditer(text)], dtype=np.int64)
        sums = np.concatenate([[0], np.cumsum(np.roll(entries, PLAYED_LATER_S))])
        second = np.mod(np.degrees(angle_rad) * (SECONDS_A_TURN / 360.0), entries.size)
        added = (
            np.interp(second, np.arange(entries.size + 1), sums) * self._step_deg() * ARCSEC_PER_DEG
        )
        error = added - correction.error_arcsec(angle_rad + added * RAD_PER_ARCSEC, None)
        return np.asarray(error - error.mean())

    def _worm_s(self) -> int:
        assert self.teeth is not None
        return round(SECONDS_A_TURN / self.teeth)

    def _step_deg(self) -> float:
        assert self.steps_per_second is not None
        return 360.0 / SECONDS_A_TURN / self.steps_per_second
