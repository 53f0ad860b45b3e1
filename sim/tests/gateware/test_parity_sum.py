"""Tests the weights of the parity, and the model's decision which head has stepped."""

from __future__ import annotations

import numpy as np
import pytest

from arctrue.gateware.head_watch import STEP_COUNTS, stepped_head
from arctrue.gateware.mean_set import WEIGHT_ONE
from arctrue.gateware.parity_sum import PARITY_LSB_COUNTS, parity_sum, parity_weights

PLACES = np.deg2rad([0.0, 64.3, 177.0, 257.9])


def test_parity_holds_no_motion() -> None:
    """For random motions of the axis with 54 counts (2 µm at a radius of 100 mm) RMS in each
    direction, the parity contains only the rounding of readings and weights."""
    weights = parity_weights(PLACES)
    assert weights.sum() == 0
    assert np.abs(weights).max() <= WEIGHT_ONE
    rng = np.random.default_rng(1)
    x, y = rng.normal(0.0, 54.0, (2, 500, 1))
    readings = np.rint(16.0 * (x * np.cos(PLACES) + y * np.sin(PLACES)))
    counts = parity_sum(readings - readings[:, [0]], weights) * PARITY_LSB_COUNTS
    rounding = np.abs(weights).sum() / WEIGHT_ONE * 0.5 / 16.0
    assert np.abs(counts).max() <= rounding + 4 * 4 * 54.0 * 0.5 / WEIGHT_ONE + PARITY_LSB_COUNTS
    assert np.abs(counts).max() > 0


def test_three_heads_have_no_parity() -> None:
    with pytest.raises(ValueError, match="three have no parity"):
        parity_weights(PLACES[:3])


def test_a_motion_of_half_a_micrometre_is_no_step_and_64_counts_are() -> None:
    """A motion of the axis of 13.4 counts (0.5 µm at a radius of 100 mm) and an eccentricity of 1.9
    counts, each in a random direction, are not a step. An additional step of one head by at least
    2·STEP_COUNTS is attributed to this head."""
    rng = np.random.default_rng(2)
    for _ in range(2000):
        way = rng.uniform(0.0, 2.0 * np.pi)
        moved = 13.4 * np.cos(PLACES - way)
        moved += 1.9 * np.cos(PLACES - rng.uniform(0.0, 2.0 * np.pi))
        rounded = np.rint(moved).astype(np.int64)
        assert stepped_head(rounded, STEP_COUNTS) is None
        head = int(rng.integers(0, 4))
        rounded[head] += int(rng.choice([-1, 1])) * (2 * STEP_COUNTS + int(rng.integers(0, 4000)))
        assert stepped_head(rounded, STEP_COUNTS) == head
        # For a step between the limit and twice the limit the model finds the right head or no
        # head.
        small = np.rint(moved).astype(np.int64)
        small[head] += int(rng.integers(STEP_COUNTS, 2 * STEP_COUNTS))
        assert stepped_head(small, STEP_COUNTS) in (None, head)
