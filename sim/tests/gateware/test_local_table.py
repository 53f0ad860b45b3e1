"""The local table against straight lines in float64, and what it takes away."""

from __future__ import annotations

import numpy as np
import pytest

from arctrue.gateware.local_table import POINTS, VALUE_FRACTION, LocalTable, line_bound, local_table

TURN = 2**24


def lines_counts(angle: np.ndarray, table: LocalTable) -> np.ndarray:
    """The same in float64: lines through the points of each window, which closes on itself."""
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
    """Random points; the bound is derived in the head of the entity."""
    random = np.random.default_rng(windows + 10 * width)
    starts = tuple(
        int(counts_per_rev * (0.9 + n / windows)) % counts_per_rev for n in range(windows)
    )
    points = random.integers(-(2**17), 2**17, POINTS)
    table = LocalTable(counts_per_rev, starts, width, 8, points)
    angle = random.integers(0, counts_per_rev, 50_000)
    found = local_table(angle, table) * 2.0**-VALUE_FRACTION
    off = np.abs(found - lines_counts(angle, table)).max()
    assert off <= line_bound(table)
    assert np.abs(found).max() > 400
    share = np.count_nonzero(found) / angle.size
    assert share == pytest.approx(windows / 2**width, rel=0.1)


def test_a_scratch_is_taken_away() -> None:
    """A hill of 20 arcsec, 0.2 degrees wide, in a window of 1/64: less than a tenth is left."""
    counts_arcsec = TURN / 1_296_000
    start, centre = int(0.3 * TURN), int(0.3 * TURN) + TURN // 128
    wide = 0.2 / 360 * TURN

    def scratch(angle: np.ndarray) -> np.ndarray:
        return 20 * counts_arcsec * np.exp(-0.5 * ((angle - centre) / (wide / 2.355)) ** 2)

    places = start + np.arange(POINTS) * TURN / 64 / POINTS
    points = np.round(scratch(places) * 2**8).astype(np.int64)
    table = LocalTable(TURN, (start,), 6, 8, points)
    angle = np.arange(0, TURN, 101)
    left = scratch(angle) - local_table(angle, table) * 2.0**-VALUE_FRACTION
    # Half a unit of a point, and the lines; in all far below a tenth of 259 counts.
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
