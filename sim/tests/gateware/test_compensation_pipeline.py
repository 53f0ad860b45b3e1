"""Compares the model of the pipeline with equations (8) and (9) in double precision."""

from __future__ import annotations

import numpy as np
import pytest
from sim.tests.gateware.equation_9 import correction_bound_counts

from arctrue.gateware.coefficients import Coefficients
from arctrue.gateware.compensation_pipeline import compensate, compensate_clocks
from arctrue.gateware.error_compensation import correction_limit

ANGLES = 12_000


def random_bank(seed: int, counts_per_rev: int, sum_counts: float, lanes: int = 32) -> Coefficients:
    rng = np.random.default_rng(seed)
    weights = rng.random(lanes) * rng.choice([-1, 1], lanes)
    orders = rng.integers(0, 65536, lanes)
    orders[0] = 16_384
    return Coefficients.from_harmonics(
        orders,
        np.clip(sum_counts * weights / np.abs(weights).sum(), -8191, 8191),
        rng.uniform(-np.pi, np.pi, lanes),
        counts_per_rev,
        lanes,
        float(rng.uniform(-0.1, 0.1) * min(sum_counts, 8191.0)),
    )


@pytest.mark.filterwarnings("ignore:order")
@pytest.mark.parametrize("arcsec", [1.0, 250.0, 12_000.0])
@pytest.mark.parametrize("counts_per_rev", [5000, 65_536, 12_345_677, 2**24])
def test_equals_equation_8_and_9(counts_per_rev: int, arcsec: float) -> None:
    bank = random_bank(counts_per_rev, counts_per_rev, arcsec / 1_296_000 * counts_per_rev)
    rng = np.random.default_rng(1)
    angle = rng.integers(0, counts_per_rev, ANGLES)
    position = angle + rng.integers(-100, 100, ANGLES) * counts_per_rev
    found = compensate(angle, position, bank)
    error = position - found.corrected_position - bank.error_counts(angle)
    assert np.max(np.abs(error)) <= correction_bound_counts(bank)
    if arcsec <= 250.0:
        assert np.max(np.abs(error)) <= 1.0
    assert found.corrected_angle.min() >= 0
    assert found.corrected_angle.max() < counts_per_rev
    assert not np.any((found.corrected_position - found.corrected_angle) % counts_per_rev)


@pytest.mark.filterwarnings("ignore:order")
@pytest.mark.parametrize("counts_per_rev", [4, 5, 7, 1001])
def test_angle_stays_in_the_turn_whatever_the_coefficients(counts_per_rev: int) -> None:
    bank = random_bank(2, counts_per_rev, 30_000.0)
    angle = np.arange(ANGLES) % counts_per_rev
    found = compensate(angle, angle, bank)
    assert found.corrected_angle.min() >= 0
    assert found.corrected_angle.max() < counts_per_rev
    assert np.max(np.abs(found.correction)) == correction_limit(counts_per_rev) * 2048


def test_clocks_settle_to_the_steady_outputs() -> None:
    """After the ramp, the outputs of compensate_clocks, which models every clock, equal those of
    compensate, which models the settled state."""
    banks = [random_bank(seed, 2**24, 30.0, lanes=4) for seed in (4, 5)]
    angle = np.arange(3000, dtype=np.int64) * 997 % 2**24
    swapped = angle.size // 2
    bank = (np.arange(angle.size) >= swapped).astype(np.int64)
    marker = np.arange(angle.size) == swapped
    apply = np.ones(angle.size, dtype=bool)
    found = compensate_clocks(angle, angle, banks, bank, marker, apply, 2**32 - 1)
    for part, entry in ((slice(1000, swapped), banks[0]), (slice(2500, None), banks[1])):
        assert not found.ramp_busy[part].any()
        expected = compensate(angle[part], angle[part], entry)
        assert np.array_equal(found.corrected_angle[part], expected.corrected_angle)
        assert np.array_equal(found.correction[part], expected.correction)
    assert found.ramp_busy[swapped]
    assert found.correction[swapped] == found.correction[swapped - 1]


@pytest.mark.parametrize(
    ("angle", "position", "message"),
    [
        ([1000], [0], r"angle\[0\]: 1000, expected 0 to 999 counts"),
        ([0, -1], [0, 0], r"angle\[1\]: -1"),
        ([0, 1], [0], "expected one angle and one position per reading"),
    ],
)
def test_readings_outside_the_turn_are_refused(
    angle: list[int], position: list[int], message: str
) -> None:
    with pytest.raises(ValueError, match=message):
        compensate(angle, position, Coefficients.zero(1000, 2))


def test_banks_for_different_turns_are_refused() -> None:
    banks = [Coefficients.zero(1000, 2), Coefficients.zero(1001, 2)]
    with pytest.raises(ValueError, match="banks"):
        compensate_clocks([0], [0], banks, [0], [False], [True], 0)
