"""Compares the local table's model with float64, and tests the local table of a coefficient
file."""

from __future__ import annotations

import numpy as np
import pytest

from arctrue.gateware import extension
from arctrue.gateware.coefficient_bounds import slope_and_amplitude
from arctrue.gateware.coefficients import Coefficients, Extension
from arctrue.gateware.extension import POINTS
from arctrue.gateware.local_table import LocalTable, line_bound, local_table
from arctrue.generated.number_formats import LOCAL_VALUE_FRACTION

TURN = 2**24


def lines_counts(angle: np.ndarray, table: LocalTable) -> np.ndarray:
    """Return the linear interpolation between the points of each window, in float64. From the last
    point of a window the line leads to its first point."""
    total = np.zeros(angle.size)
    number = POINTS // len(table.starts)
    for window, start in enumerate(table.starts):
        words = table.points[window * number : (window + 1) * number]
        counts = np.append(words, words[0]) / 2.0**table.fraction
        place = (angle - start) % table.counts_per_rev * 2.0**table.width / table.counts_per_rev
        inside = (place < 1) & (total == 0)
        total[inside] = np.interp(place[inside] * number, np.arange(number + 1), counts)
    return total


@pytest.mark.parametrize("counts_per_rev", [TURN, 1_234_567, 9_999])
@pytest.mark.parametrize(("windows", "width"), [(1, 0), (1, 6), (2, 1), (4, 2), (4, 6)])
def test_lines_within_the_bound(windows: int, width: int, counts_per_rev: int) -> None:
    """The error of the interpolation between random points stays within the bound in the header of
    the entity."""
    random = np.random.default_rng(windows + 10 * width)
    starts = tuple(
        int(counts_per_rev * (0.9 + n / windows)) % counts_per_rev for n in range(windows)
    )
    points = random.integers(-(2**17), 2**17, POINTS)
    table = LocalTable(counts_per_rev, starts, width, 8, points)
    angle = random.integers(0, counts_per_rev, 50_000)
    found = local_table(angle, table) * 2.0**-LOCAL_VALUE_FRACTION
    off = np.abs(found - lines_counts(angle, table)).max()
    assert off <= line_bound(table)
    assert np.abs(found).max() > 400
    share = np.count_nonzero(found) / angle.size
    assert share == pytest.approx(windows / 2**width, rel=0.1)


def test_a_scratch_is_taken_away() -> None:
    """A table with a window of 1/64 turn reduces a bump of 20 arcsec, 0.2 degrees wide, to less
    than 0.05 counts."""
    counts_arcsec = TURN / 1_296_000
    start, centre = int(0.3 * TURN), int(0.3 * TURN) + TURN // 128
    wide = 0.2 / 360 * TURN

    def scratch(angle: np.ndarray) -> np.ndarray:
        return 20 * counts_arcsec * np.exp(-0.5 * ((angle - centre) / (wide / 2.355)) ** 2)

    places = start + np.arange(POINTS) * TURN / 64 / POINTS
    points = np.round(scratch(places) * 2**8).astype(np.int64)
    table = LocalTable(TURN, (start,), 6, 8, points)
    angle = np.arange(0, TURN, 101)
    left = scratch(angle) - local_table(angle, table) * 2.0**-LOCAL_VALUE_FRACTION
    # The bump has 259 counts; only the errors of the rounded points and of the interpolation
    # remain.
    assert np.abs(left).max() < 0.05
    assert scratch(angle).max() > 250


@pytest.mark.parametrize(
    ("changed", "message"),
    [
        ({"starts": (1, 2, 3)}, "expected one, two or four"),
        ({"starts": (TURN,)}, "expected 0 to"),
        ({"width": 7}, "expected 2"),
        ({"fraction": 5}, "expected 2"),
        ({"points": np.full(POINTS, 2**17)}, "words of 18 bits"),
    ],
)
def test_what_the_gateware_cannot_hold_is_refused(changed: dict, message: str) -> None:
    values = {
        "counts_per_rev": TURN,
        "starts": (0,),
        "width": 0,
        "fraction": 4,
        "points": np.zeros(POINTS, dtype=np.int64),
    }
    with pytest.raises(ValueError, match=message):
        LocalTable(**(values | changed))


def test_words_of_a_file_become_a_bank() -> None:
    """The part of a file becomes the words of a bank: points that the file lacks become 0, and the
    words of ``local_place`` have the layout of the register map."""
    of_file = extension.LocalTable((7, -8), (5, TURN - 1), 3, 6)
    table = LocalTable.of_file(of_file, TURN)
    assert table.points[:3].tolist() == [7, -8, 0]
    assert table.points.shape == (POINTS,)
    # The word `choice` contains enable 0b11, two windows (code 1), width 3 and fraction 6 (code 1);
    # the step is 2^48 * 2^3 / 2^24.
    choice = 0b11 | 1 << 4 | 3 << 8 | 1 << 12
    assert table.place_words() == [choice, 5, TURN - 1, 0, 0, 1 << 27, 0]


@pytest.mark.parametrize(("width", "leaps"), [(0, 0.0), (4, 2.0)])
def test_the_slope_of_a_table_counts_with_that_of_the_lanes(width: int, leaps: float) -> None:
    """The steepest slope of a local table is added to that of the lanes. It is 2π·300 / (length of
    the window) for a sine of 300 counts over the window, and 2 more for a table that steps by 2
    counts at the ends of its window."""
    place = 2.0 * np.pi * np.arange(POINTS) / POINTS
    points = tuple(np.rint((300.0 * np.sin(place) + leaps) * 2**6).astype(int).tolist())
    table = extension.LocalTable(points, (0,), width, 6)
    slope = 2.0 * np.pi * 300.0 / (TURN / 2**width)
    # The points are rounded to 2⁻⁶ count, so the error of the slope between two points is up to 2⁻⁶
    # count divided by their distance.
    rounding = 2.0**-6 / (TURN / 2**width / POINTS)
    assert table.steepest(TURN) == pytest.approx(slope + leaps, abs=rounding)
    lane = Coefficients.from_harmonics([40], [1000.0], [0.0], TURN, 1)
    plain, _ = slope_and_amplitude(lane)
    with_table = Coefficients(
        lane.phase_steps,
        lane.phase_offsets,
        lane.amplitudes,
        0,
        TURN,
        None,
        Extension(local_table=table),
    )
    assert slope_and_amplitude(with_table)[0] == pytest.approx(
        plain + table.steepest(TURN), rel=1e-12
    )
