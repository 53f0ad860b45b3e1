"""Compares readings between the knots with the table's geometry, and tests the statistics of the
noise."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from arctrue.instrument import ReadingNoise, TableCurves
from arctrue.instrument.curves import INTERPOLATION_TOLERANCE_COUNTS
from arctrue.table import (
    DISC_RADIUS_M,
    DiscEccentricity,
    Motion,
    RotaryTable,
    TableState,
    two_heads,
)
from arctrue.table.causes.signal_distortion import SignalDistortion
from arctrue.table.causes.thermal_centre import ThermalCentre
from arctrue.table.temperature import TemperatureCourse

COUNTS = 1 << 20
CLOCK_HZ = 1e6
SPEED = 2 * np.pi / COUNTS * CLOCK_HZ / 1.1
MOTION = Motion.steady(SPEED, 0.05, ramp_s=0.01, start_rad=-0.1, ripple_rad=0.002, ripple_order=7)
TABLE = RotaryTable(
    heads=two_heads(), causes=(DiscEccentricity(37.7e-6, 2.1),), counts_per_rev=COUNTS
)


def between(curve: np.ndarray, knot: int, clock: np.ndarray) -> np.ndarray:
    """Return the cubic through the four knots around each clock, computed with numpy's polynomials;
    clocks count from the start of the piece."""
    interval = clock // knot
    values = []
    for place, at in zip(interval.tolist(), (clock / knot - interval).tolist(), strict=True):
        through = np.polyfit([-1, 0, 1, 2], curve[place : place + 4] - curve[place + 1], 3)
        values.append(curve[place + 1] + np.polyval(through, at))
    return np.array(values)


def exact(table: RotaryTable, head: int, clock: np.ndarray) -> np.ndarray:
    state = MOTION.state(clock / CLOCK_HZ)
    return table.reading_rad(head, state) / table.count_rad


@pytest.mark.parametrize("first", [0, 20_000])
def test_cubic_between_knots_is_the_table(first: int) -> None:
    curves = TableCurves(TABLE, MOTION, CLOCK_HZ)
    knot, *readings, _ = curves.piece(first, 4096)
    assert knot > 1
    clock = np.random.default_rng(1).integers(1, 4000, 300)
    for head in (0, 1):
        off = between(readings[head], knot, clock) - exact(TABLE, head, first + clock)
        assert np.abs(off).max() < INTERPOLATION_TOLERANCE_COUNTS


def test_a_reading_that_bends_within_a_line_gets_nearer_knots() -> None:
    """For a subdivision error with a period of 16 counts, the knots are less than 16 counts apart;
    knots 16 counts apart would miss the error."""
    lines = COUNTS // 16
    distortion = SignalDistortion(head=0, lines=lines, cosine_offset=0.3)
    table = replace(TABLE, causes=(*TABLE.causes, distortion))
    curves = TableCurves(table, MOTION, CLOCK_HZ)
    smooth, *_ = TableCurves(TABLE, MOTION, CLOCK_HZ).piece(20_000, 4096)
    knot, head1, *_ = curves.piece(20_000, 4096)
    assert knot < smooth
    clock = np.arange(1, 2000, 7)
    off = between(head1, knot, clock) - exact(table, 0, 20_000 + clock)
    # Between these nearer knots the cubic agrees with the geometry.
    assert np.abs(off).max() < INTERPOLATION_TOLERANCE_COUNTS


def test_conditions_reach_the_table() -> None:
    """The temperature changes the reading: 20 K move the centre of this disc by 20 µm, which
    changes the reading by up to 20 µm divided by the disc's radius."""
    warm_disc = replace(TABLE, causes=(ThermalCentre(1e-6),))
    cold = TableCurves(warm_disc, MOTION, CLOCK_HZ, 16)
    warm = replace(MOTION, temperature=TemperatureCourse((0.0,), (40.0,)))
    heated = TableCurves(warm_disc, warm, CLOCK_HZ, 16)
    for clock in (0, 25_000):
        _, at_20, _, angle = cold.piece(clock, 64)
        _, at_40, _, _ = heated.piece(clock, 64)
        moved_rad = (at_40 - at_20) * TABLE.count_rad
        # The reading changes by offset / radius · sin θ, except for terms of order (offset /
        # radius)².
        ratio = 20e-6 / DISC_RADIUS_M
        assert np.abs(moved_rad - ratio * np.sin(angle)).max() < 2 * ratio**2


def test_noise_has_the_size_and_the_whiteness_that_it_says() -> None:
    noise = ReadingNoise(rms_rad=1e-6, correlation_s=1e-3, seed=4)
    at_samples = TableState.at_rest(np.zeros(40_000))
    state = replace(at_samples, time_s=np.arange(40_000) * 5e-3 + 0.37e-3)
    first, second = (noise.signal_error_rad(head, state.angle_rad, state) for head in (0, 1))
    everywhere = replace(state, time_s=np.linspace(0.0, 100.0, 40_000))
    spread = noise.signal_error_rad(0, state.angle_rad, everywhere).std()
    # A standard deviation from 40,000 values has a relative uncertainty of 0.35 %; the bound is 5
    # σ.
    assert spread == pytest.approx(1e-6, rel=0.018)
    for one, other in ((first[1:], first[:-1]), (first, second)):
        assert abs(np.corrcoef(one, other)[0, 1]) < 5 / np.sqrt(40_000)


def test_noise_refuses_what_is_none() -> None:
    with pytest.raises(ValueError, match="correlation time above 0"):
        ReadingNoise(1e-6, 0.0)


def test_noise_of_a_long_run_never_repeats_and_has_no_seams() -> None:
    knots, step_s, rms = 1 << 18, 1e-3, 1e-6
    none = np.zeros(2000)

    def read(noise: ReadingNoise, time_s: np.ndarray) -> np.ndarray:
        return np.asarray(noise.signal_error_rad(0, none, TableState(time_s, none, none)))

    noise = ReadingNoise(rms_rad=rms, correlation_s=step_s, seed=4)
    time_s = 5 * step_s * np.arange(2000)
    pieces = [read(noise, time_s + block * knots * step_s) for block in range(6)]
    found = np.corrcoef(pieces)
    # The pieces are independent and contain 2,000 independent readings each; the bound is five
    # standard deviations of 1/√2000.
    assert np.abs(found - np.eye(6)).max() < 5 / np.sqrt(2000)
    # The noise has the same values in any order of the queries, and also in a new object.
    again = ReadingNoise(rms_rad=rms, correlation_s=step_s, seed=4)
    np.testing.assert_array_equal(read(again, time_s + 5 * knots * step_s), pieces[5])
    np.testing.assert_array_equal(read(noise, time_s), pieces[0])
    # Between two knots, the cubic B-spline of normal numbers changes by at most 2·rms·√(315/151)·5,
    # if the numbers stay within five standard deviations.
    seam_s = knots * step_s + np.linspace(-2 * step_s, 2 * step_s, 2000)
    most = 2 * rms * np.sqrt(315 / 151) * 5 * (seam_s[1] - seam_s[0]) / step_s
    assert np.abs(np.diff(read(noise, seam_s))).max() < most
