"""Tests the detection of changes since the calibration, with complex numbers and simulated
noise."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from arctrue.device.changes import (
    FALSE_CHANGES_A_TURN,
    calibration_turn,
    changes_since,
    order_change,
)

U = 0.05
ORDERS = 8


def turn_of(
    vectors: np.ndarray, separation_arcsec: float = 0.0, number: int = 1, **fields: Any
) -> dict[str, Any]:
    harmonics = [
        [order, abs(vector), float(np.angle(vector)), U, 1] for order, vector in enumerate(vectors)
    ]
    made = {"turn": number, "harmonics": harmonics, "u_separation_arcsec": U}
    return made | {"separation_deg": 33.0 + separation_arcsec / 3600.0} | fields


def noisy(rng: np.random.Generator, vectors: np.ndarray) -> np.ndarray:
    """Return the vectors with added noise, whose standard deviation is U in cosine and sine."""
    shape = vectors.shape
    return np.asarray(vectors + rng.normal(0.0, U, shape) + 1j * rng.normal(0.0, U, shape))


def test_a_change_of_phase_alone_is_a_change() -> None:
    size, u = order_change([3, 2.0, 0.1, 0.03, 1], [3, 2.0, 0.1 + np.pi, 0.04, 1])
    assert size == pytest.approx(4.0)
    assert u == pytest.approx(0.05)


def test_an_unchanged_table_rarely_shows_a_change() -> None:
    """A turn of an unchanged table shows a change with at most the probability
    FALSE_CHANGES_A_TURN: at most 4 are expected in 4,000 turns. The test accepts up to 11, the 99.9
    % point of Poisson(4)."""
    rng = np.random.default_rng(1)
    true = rng.normal(0.0, 20.0, ORDERS) + 1j * rng.normal(0.0, 20.0, ORDERS)
    turns, found = 4_000, 0
    assert turns * FALSE_CHANGES_A_TURN == 4.0
    for _ in range(turns):
        before, now = (turn_of(noisy(rng, true), rng.normal(0.0, U)) for _ in range(2))
        found += any(change.significant for change in changes_since(before, now))
    assert 0 < found <= 11


def test_the_changed_order_and_the_moved_head_are_named() -> None:
    true = np.full(ORDERS, 5.0 + 0.0j)
    moved = true.copy()
    moved[3] += 0.6j  # 8.5 standard uncertainties of the difference
    found = changes_since(turn_of(true), turn_of(moved, separation_arcsec=-0.6))
    assert [change.quantity for change in found if change.significant] == [
        "head separation",
        "order 3",
    ]
    assert found[0].size_arcsec == pytest.approx(-0.6, abs=1e-6)
    assert found[4].size_arcsec == pytest.approx(0.6)
    assert found[4].u_arcsec == pytest.approx(U * np.sqrt(2.0))


@pytest.mark.parametrize(
    ("numbers", "swaps", "first"),
    [
        ([5], [0], 0),
        ([5, 6, 7], [2, 2, 2], 0),
        ([5, 6, 7, 8], [1, 1, 2, 2], 2),
        ([5, 6, 0, 1], [1, 1, 1, 1], 2),  # the board started again
        ([5, 6, 7], [None, None, None], 0),
    ],
)
def test_a_calibration_begins_with_a_swap(
    numbers: list[int], swaps: list[int | None], first: int
) -> None:
    turns = [{"turn": n, "swaps": s} for n, s in zip(numbers, swaps, strict=True)]
    assert calibration_turn(turns) == first
