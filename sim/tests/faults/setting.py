"""Defines one small instrument for all fault tests. Its table has errors of the same kind as the
paper's table, ten times as large."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from arctrue.gateware.correction_ramp import ramp_arcsec_s
from arctrue.table import (
    DiscEccentricity,
    GraduationHarmonics,
    Motion,
    RotaryTable,
    TableState,
    two_heads,
)

COUNTS = 1 << 14
ARCSEC_A_COUNT = 1_296_000 / COUNTS
CLOCKS_A_COUNT = 6
"""Clocks per count at the speed of the table, enough for the test of every fault. The paper's table
has 71.5."""
PERIOD_COUNTS = 4
"""Counts in a period of A and B; no flag shows the loss of a whole period."""
TURN_RAD = 2 * np.pi
TURN_CLOCKS = COUNTS * CLOCKS_A_COUNT
SPEED_RAD_S = float(np.deg2rad(30.0))
TURN_S = TURN_RAD / SPEED_RAD_S
START_RAD = -float(np.deg2rad(35.0))
"""Table angle at the start; head 2 reaches its index later, at −33°."""
RUN_UP_S = 0.1

SAMPLES = 600
OUTPUT_SPACING_CLOCKS = 2
MINIMUM_EDGE_SPACING_CLOCKS = 3
RAMP_RATE = 80_000_000
"""Rate of a ramp, 0.0023 count per clock: the largest correction decays within 30° of rotation, as
with the paper's preset."""
FOLLOWING_LIMIT_COUNTS = 6
POLL_CLOCKS = 500
PARAMETERS: dict[str, float] = {
    "counts_per_rev": COUNTS,
    "sample_period": TURN_CLOCKS // SAMPLES,
    "output_spacing": OUTPUT_SPACING_CLOCKS,
    "minimum_edge_spacing": MINIMUM_EDGE_SPACING_CLOCKS,
    "ramp_arcsec_s": ramp_arcsec_s(RAMP_RATE, COUNTS),
    # A turn is so short here that the soft start of a ramp would last longer than the ramp.
    "ramp_arcsec_s2": 0,
    "orders": 8,
    # With counts of 79″, the rounding of each head is 23″ RMS; the preset is for counts of 0.08″.
    "alarm_noise_arcsec": 100,
    "alarm_error_arcsec": 200,
    "alarm_separation_arcsec": 300,
}

_ARCSEC_RAD = np.pi / 648_000
SEPARATION_RAD = float(np.deg2rad(33.0)) + 50 * _ARCSEC_RAD


def table() -> RotaryTable:
    """Return a table with an error of ±1500″, which is ±19 counts here."""
    return RotaryTable(
        heads=two_heads(separation_rad=SEPARATION_RAD),
        causes=(
            DiscEccentricity(37.7e-5, 2.1),
            GraduationHarmonics(
                (2, 3, 4),
                (60 * _ARCSEC_RAD, 12 * _ARCSEC_RAD, 7 * _ARCSEC_RAD),
                (4.2, 3.1, 4.1),
            ),
        ),
        counts_per_rev=COUNTS,
    )


def steady(turns: float = 30.0) -> Motion:
    """Return a motion at one speed."""
    return Motion.steady(SPEED_RAD_S, turns * TURN_S, ramp_s=RUN_UP_S, start_rad=START_RAD)


def legs(*speeds_and_turns: tuple[float, float], change_s: float = 0.002) -> Motion:
    """Return a motion with these legs. Each leg is a pair of a speed, relative to the usual speed,
    and a duration in turns at the usual speed."""
    times, speeds = [0.0], [0.0]
    for speed, turns in speeds_and_turns:
        begin = times[-1] + (RUN_UP_S if len(times) == 1 else change_s)
        times += [begin, begin + turns * TURN_S]
        speeds += [speed * SPEED_RAD_S] * 2
    return Motion(tuple(times), tuple(speeds), START_RAD)


def true_error_counts(angle_rad: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the error ε of head 1 at a true angle, computed from the geometry; its mean is not
    0."""
    made = table()
    reading = made.reading_rad(0, TableState.at_rest(angle_rad))
    error: NDArray[np.float64] = (reading - angle_rad) / made.count_rad
    return error
