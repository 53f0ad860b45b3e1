"""Tests that counts that restart at each turn, and whole turns in errors, are corrected and
reported."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from sim.tests.workbench.small_sets import COUNTS_PER_REV, measurement_set

from arctrue.importing.motion import without_jumps
from arctrue.measurement import read_measurement_set, write_measurement_set
from arctrue.measurement.wraps import unwrapped_counts, without_wraps


def test_wrapped_counts_are_read_as_they_were_before(tmp_path: Path) -> None:
    made = measurement_set(runs=2, cycles=0, reference=False)
    assert made.capture is not None
    wrapped = replace(
        made.capture,
        head1_counts=np.mod(made.capture.head1_counts, COUNTS_PER_REV),
        head2_counts=np.mod(made.capture.head2_counts, COUNTS_PER_REV),
    )
    write_measurement_set(tmp_path, replace(made, capture=wrapped))
    read = read_measurement_set(tmp_path)
    assert read.capture is not None
    apart = made.capture.head2_counts - made.capture.head1_counts
    assert np.array_equal(read.capture.head2_counts - read.capture.head1_counts, apart)
    for run in (0, 1):
        rows = made.capture.run == run
        moved = np.diff(made.capture.head1_counts[rows])
        assert np.array_equal(np.diff(read.capture.head1_counts[rows]), moved)
    reported = [warning for warning in read.warnings if "starts anew" in warning]
    assert len(reported) == 2
    assert "head1_counts starts anew at 16777216 counts 6 times" in reported[0]


@pytest.mark.parametrize("decimals", [3, 4])
def test_an_angle_that_a_display_rounds_up_to_a_turn_is_continued(decimals: int) -> None:
    """At 3 and 4 decimals of a radian the last angle of a turn is 6.283 or 6.2832, which is 16,384
    counts (rounded) and more than 2π."""
    time_s = np.arange(0.0, 40.0, 0.003)
    true_turns = time_s / 12.00002
    shown_rad = np.round(2.0 * np.pi * np.mod(true_turns, 1.0), decimals)
    shown_turns = shown_rad / (2.0 * np.pi)
    counts = np.round(shown_turns * 16384).astype(np.int64)
    assert counts.max() == 16384
    run = np.zeros(counts.size, dtype=np.int64)
    continued, wraps = unwrapped_counts(counts, run, time_s, 16384)
    # Bound: half a step of the display and half a count.
    bound = 0.5 * 10.0**-decimals / (2.0 * np.pi)
    assert wraps == 3
    assert np.abs(continued / 16384 - true_turns).max() <= bound + 0.5 / 16384
    angles, jumps = without_jumps(shown_turns)
    assert jumps == 3
    assert np.abs(angles - true_turns).max() <= bound * (1.0 + 1e-6)


def test_a_gap_across_the_zero_is_counted_by_time(tmp_path: Path) -> None:
    """The reader finds the travel in a gap of 1.7 turns from the speed and the time stamps."""
    made = measurement_set(runs=1, reference=False)
    assert made.capture is not None
    left = np.ones(made.capture.run.size, dtype=bool)
    left[600 : 600 + 2040] = False
    gap = made.capture.where(left)
    wrapped = replace(
        gap,
        head1_counts=np.mod(gap.head1_counts, COUNTS_PER_REV),
        head2_counts=np.mod(gap.head2_counts, COUNTS_PER_REV),
    )
    write_measurement_set(tmp_path, replace(made, capture=wrapped))
    read = read_measurement_set(tmp_path)
    assert read.capture is not None
    assert np.ptp(read.capture.head1_counts) == np.ptp(gap.head1_counts)


@pytest.mark.parametrize("share", [0.01, 0.4, 0.6, 1.0])
@pytest.mark.parametrize("turn", [360.0, -360.0, 720.0])
def test_errors_whole_turns_off_come_back(tmp_path: Path, share: float, turn: float) -> None:
    made = measurement_set(cycles=4)
    assert made.reference is not None
    error = made.reference.error_arcsec.copy()
    off = np.random.default_rng(1).permutation(error.size) < share * error.size
    changed = replace(made.reference, error_arcsec=error + np.where(off, turn * 3600.0, 0.0))
    write_measurement_set(tmp_path, replace(made, capture=None, reference=changed))
    read = read_measurement_set(tmp_path)
    assert read.reference is not None
    # The file has six decimals of an arcsecond.
    assert np.abs(read.reference.error_arcsec - error).max() < 1e-6
    first = int(np.flatnonzero(off)[0]) + 2
    assert any(
        f"row {first}, column error_arcsec" in warning and f"{off.sum()} rows in all" in warning
        for warning in read.warnings
    )


def test_errors_of_some_degrees_are_no_wraps() -> None:
    error = np.linspace(-170.0, 170.0, 50) * 3600.0
    unchanged, wrapped = without_wraps(error)
    assert wrapped.size == 0
    assert np.array_equal(unchanged, error)
