"""Tests of sine errors that a drive in front of the table causes; the firmware gets their phase
from the drive's index at the pin probe_in."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from arctrue.studies.hidden_effect.cases import CASES, MESH_WOBBLE_RAD
from arctrue.studies.hidden_effect.drive import TURN_RAD, and_back, times_at, turning

from .small import INTERPOLATION, LINES, run_small

COUNTS = LINES * INTERPOLATION
SIZE_COUNTS = (1 << 24) / COUNTS * COUNTS / 1_296_000
"""Amplitude of the sine error in counts: 1″ with 2²⁴ counts per turn. The amplitude in arcseconds
grows in proportion to the size of a count, so that it is 12.9 counts at every scale."""
MOST_LEFT_COUNTS = 1.0
"""Largest amplitude that may remain, in counts."""


@pytest.mark.large
@pytest.mark.parametrize(
    ("name", "shares"),
    [
        ("belt", [1.0]),
        # The shares are the Bessel functions J₁, J₀, J₁ of the wobble, to second order.
        (
            "drive_gear_error",
            [MESH_WOBBLE_RAD / 2.0, 1.0 - MESH_WOBBLE_RAD**2 / 4.0, MESH_WOBBLE_RAD / 2.0],
        ),
    ],
)
def test_lines_of_the_drive_are_taken_away_forwards_and_backwards(
    tmp_path: Path, name: str, shares: list[float]
) -> None:
    result = run_small(name, tmp_path)
    left = {key: np.array(counts) for key, counts in result.lines_counts.items()}
    # Without their correction all sines are in the output. A fit over two turns separates the sines
    # with an error of at most a twentieth.
    assert left["without"] == pytest.approx(SIZE_COUNTS * np.array(shares), rel=0.05)
    for way in ("forwards", "backwards"):
        assert left[way].max() <= MOST_LEFT_COUNTS, (way, left[way])
    assert len(result.export.real) == len(shares)


def test_the_pulses_come_where_the_table_passes_the_index() -> None:
    drive = and_back(turning(0.5, 3.0, ripple_rad=0.002, ripple_order=7), 2.0)
    probe = CASES["drive_gear_error"].probe
    assert probe is not None
    places = TURN_RAD * (probe.first_turns + np.arange(0, 10) / probe.per_turn)
    times = times_at(drive, places)
    passed = (drive.state(times).angle_rad / TURN_RAD - probe.first_turns) * probe.per_turn
    assert np.abs(passed - np.rint(passed)).max() < 1e-4
    # The table goes forward over all ten edges of the index, and back over the edges of the last
    # two turns.
    top = drive.knot_times_s[3]
    assert np.count_nonzero(times < top) == 10
    assert 6 <= np.count_nonzero(times > top) <= 8
