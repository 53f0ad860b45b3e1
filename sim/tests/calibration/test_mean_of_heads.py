"""Tests of the weighted mean of heads and of the parity, a weighted sum that contains neither the
angle nor the axis' motion: geometry and closed forms give the expected weights and coefficients."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from arctrue.base.units import ARCSEC_PER_RAD, RAD_PER_ARCSEC
from arctrue.calibration.head_weights import (
    WeightsRefusedError,
    mean_weights,
    order_factor,
    parity_weights,
    weight_words,
    weights_without_each,
)
from arctrue.calibration.mean_banks import (
    HeadsOnDisc,
    mean_angle_counts,
    mean_bank,
    mean_banks,
)
from arctrue.gateware.capability import EVERYTHING
from arctrue.gateware.coefficient_file import read_coefficient_file, write_coefficient_file
from arctrue.gateware.coefficients import Coefficients
from arctrue.gateware.mean_set import MeanSet
from arctrue.table import (
    DISC_RADIUS_M,
    Cause,
    DiscEccentricity,
    GraduationHarmonics,
    Head,
    RotaryTable,
    TableState,
)
from arctrue.table.causes.radial_motion import RadialMotion

STATED_PLACES_DEG = (0.0, 33.0, 162.5, 300.5)
SPARE_PLACES_DEG = (0.0, 64.3, 177.0, 257.9)
"""Places of four heads; the mean of the other three exists if any single head fails."""
COUNTS = 1 << 24
QUANTISED_ARCSEC = 0.005
"""Largest error of quantised coefficients in arcseconds.

The error has four sources. Weights are rounded to 2⁻¹⁷ of readings that differ by 285″ (0.002″),
and offsets to 1/32 count per head (0.0024″). The lanes (one per harmonic), with 5″ at order 2, are
evaluated at the reading of the carrier, the head whose counts the output follows; this reading is
rounded to a count (10⁻⁶″). Each of the up to 12 lanes is rounded to 2⁻¹² count.
"""


def test_three_heads_have_the_weights_of_the_closed_form() -> None:
    # The weights are the barycentric coordinates of the centre in the triangle: w₁ ∝ sin(p₃ − p₂),
    # and so on.
    places = np.radians([0.0, 64.3, 177.0])
    shares = np.sin([places[2] - places[1], places[0] - places[2], places[1] - places[0]])
    np.testing.assert_allclose(
        mean_weights(places, noise_limit=9.0), shares / shares.sum(), atol=1e-12
    )


def test_equal_heads_have_equal_weights() -> None:
    for heads in (2, 3, 4):
        places = np.arange(heads) * 2.0 * np.pi / heads
        np.testing.assert_allclose(mean_weights(places), np.full(heads, 1.0 / heads), atol=1e-12)


def test_four_heads_take_the_weights_of_least_noise() -> None:
    places = np.radians(STATED_PLACES_DEG)
    weights, parity = mean_weights(places), parity_weights(places)
    assert np.linalg.norm(weights) == pytest.approx(0.5494, abs=5e-5)
    # All other weights of a mean differ by a multiple of the parity, so the weights with the least
    # norm are orthogonal to the parity.
    assert weights @ parity == pytest.approx(0.0, abs=1e-12)


def test_unequal_radii_keep_a_translation_out() -> None:
    places = np.radians(STATED_PLACES_DEG)
    ratios = 1.0 / (1.0 + np.array([1.0, -0.5, 0.2, -1.0]) * 1e-4 / DISC_RADIUS_M)
    for conditions in (mean_weights(places, ratios), parity_weights(places, ratios)):
        assert abs(np.sum(conditions * ratios * np.exp(1j * places))) < 1e-14
    equal = mean_weights(places)
    assert abs(np.sum(equal * ratios * np.exp(1j * places))) > 1e-4


def test_two_heads_off_the_diameter_are_refused() -> None:
    with pytest.raises(WeightsRefusedError, match="must stand at 180°"):
        mean_weights(np.radians([0.0, 33.0]))


def test_a_weight_outside_its_format_is_refused() -> None:
    without = weights_without_each(np.radians(STATED_PLACES_DEG), noise_limit=9.0)
    assert isinstance(without[2], WeightsRefusedError)
    assert "-2.45" in str(without[2])
    spare = weights_without_each(np.radians(SPARE_PLACES_DEG))
    noises = [np.linalg.norm(one) for one in spare if not isinstance(one, WeightsRefusedError)]
    assert len(noises) == 4
    assert max(noises) == pytest.approx(0.821, abs=5e-4)


def test_a_mean_that_is_noisier_than_one_head_is_refused() -> None:
    with pytest.raises(WeightsRefusedError, match="times the noise of one reading"):
        mean_weights(np.radians([0.0, 45.0, 130.0]))


def test_three_heads_have_no_parity() -> None:
    with pytest.raises(WeightsRefusedError, match="a parity needs four"):
        parity_weights(np.radians([0.0, 120.0, 240.0]))


@pytest.mark.parametrize("places_deg", [STATED_PLACES_DEG, SPARE_PLACES_DEG, (0.0, 119.0, 242.0)])
def test_words_have_the_sum_one_and_let_little_through(places_deg: tuple[float, ...]) -> None:
    places = np.radians(places_deg)
    weights = mean_weights(places)
    words = weight_words(weights, places)
    assert words.sum() == 1 << 16
    assert np.max(np.abs(words / 65536 - weights)) < 2.5 / 65536
    # The rounded weights let through a part of the axis' motion, which is 2 µm or 7.6″ in this
    # test.
    leak = abs(np.sum(words / 65536 * np.exp(1j * places)))
    assert leak * 7.64 < 2e-4


def weights_of(bank: Coefficients) -> np.ndarray:
    return np.array(mean_of(bank).weights) / 65536.0


def mean_of(bank: Coefficients) -> MeanSet:
    assert bank.extension is not None
    assert bank.extension.mean is not None
    return bank.extension.mean


def sets_of(disc: HeadsOnDisc, lanes: int = 32) -> list[Coefficients]:
    """Return the coefficients for the mean of all heads, then those for each mean that lacks one
    head."""
    every, _ = mean_banks(disc, COUNTS, lanes=lanes)
    assert every.extension is not None
    return [every, *every.extension.without]


def moved(angle: np.ndarray) -> np.ndarray:
    """Return the counts minus whole turns, between −½ turn and ½ turn."""
    return np.asarray((angle + COUNTS / 2) % COUNTS - COUNTS / 2)


def _table(
    causes: tuple[Cause, ...], places_deg: tuple[float, ...], radii_m: tuple[float, ...]
) -> RotaryTable:
    heads = tuple(
        Head.on_circle(radius, -place, late)
        for place, radius, late in zip(
            np.radians(places_deg), radii_m, (0, 430, -612, 205), strict=False
        )
    )
    return RotaryTable(heads=heads, causes=causes, rounding="nearest")


DISC = (
    DiscEccentricity(36e-6, 0.7),
    GraduationHarmonics(
        (2, 3, 7), tuple(a * RAD_PER_ARCSEC for a in (6.0, 3.0, 0.4)), (0.2, 1.1, -2.0)
    ),
)


def _known_disc(places_deg: tuple[float, ...], radii_m: tuple[float, ...]) -> HeadsOnDisc:
    """Return the true disc of the table: fit the readings of head 1 at known angles."""
    orders = np.arange(1, 13)
    table = _table(DISC, places_deg, radii_m)
    angle = np.arange(4096) * np.float64(2.0 * np.pi / 4096)
    reading = [table.reading_rad(head, TableState.at_rest(angle)) for head in range(len(radii_m))]
    phase = np.multiply.outer(reading[0], orders)
    design = np.hstack((np.cos(phase), np.sin(phase), np.ones((angle.size, 1))))
    values = np.linalg.lstsq(design, (reading[0] - angle) * ARCSEC_PER_RAD)[0][:-1]
    offsets = np.array([np.mean(one - angle) for one in reading])
    return HeadsOnDisc(
        orders,
        values,
        np.radians(places_deg),
        offsets - offsets[0],
        DISC_RADIUS_M / np.asarray(radii_m),
    )


EQUAL = (DISC_RADIUS_M,) * 4
UNEQUAL = tuple(DISC_RADIUS_M + d for d in (0.0, 1e-4, -1e-4, 0.7e-4))


@pytest.mark.parametrize("radii_m", [EQUAL, UNEQUAL])
@pytest.mark.parametrize("places_deg", [SPARE_PLACES_DEG, (0.0, 119.0, 242.0)])
def test_every_bank_gives_the_true_angle_wherever_the_axis_is(
    places_deg: tuple[float, ...], radii_m: tuple[float, ...]
) -> None:
    radii_m = radii_m[: len(places_deg)]
    disc = _known_disc(places_deg, radii_m)
    banks = sets_of(disc, 12)
    assert len(banks) == (5 if len(places_deg) == 4 else 1)
    wobble = RadialMotion(5, 0.3e-6 + 0.2e-6j, 0.4e-6)
    table = _table((*DISC, wobble), places_deg, radii_m)
    angle = np.linspace(0.1, 6.2, 997)
    state = TableState.at_rest(angle)
    exact = [table.reading_rad(head, state) / table.count_rad for head in range(len(places_deg))]
    counts = np.rint(exact).astype(np.int64)
    for bank in banks:
        # The test subtracts the rounding of the readings to counts, because the coefficients do not
        # cause this rounding.
        rounded = counts - exact
        own = weights_of(bank) @ rounded
        shown = mean_angle_counts(bank, counts) - own
        left = moved(shown - angle / table.count_rad) * 0.0772
        left -= left.mean()
        assert np.max(np.abs(left)) < QUANTISED_ARCSEC


def test_banks_share_one_zero() -> None:
    disc = _known_disc(SPARE_PLACES_DEG, EQUAL)
    table = _table(DISC, SPARE_PLACES_DEG, EQUAL)
    angle = np.linspace(0.1, 6.2, 499)
    counts = np.stack([table.counts(head, TableState.at_rest(angle)) for head in range(4)])
    shown = [
        moved(mean_angle_counts(bank, counts) - angle / table.count_rad).mean()
        for bank in sets_of(disc)
    ]
    # Two means are compared; in each, the rounding of four offsets to 1/32 count may move the zero
    # by up to 4/32 count.
    assert np.ptp(shown) < 2.0 * 4.0 / 32.0


def test_the_sets_come_back_from_a_coefficient_file(tmp_path: Path) -> None:
    every, refused = mean_banks(_known_disc(SPARE_PLACES_DEG, UNEQUAL), COUNTS)
    assert refused == ()
    write_coefficient_file(tmp_path / "mean.toml", every)
    assert read_coefficient_file(tmp_path / "mean.toml", EVERYTHING) == every
    _, refused = mean_banks(_known_disc(STATED_PLACES_DEG, EQUAL), COUNTS)
    assert ["-2.45" in str(one) for one in refused] == [True]


@pytest.mark.parametrize(
    "shift", [RadialMotion(0, 2e-6 + 0j), DiscEccentricity(2e-6, 0.0)], ids=["axis", "disc"]
)
def test_a_moved_carrier_shows_only_through_the_slope_of_the_lanes(shift: Cause) -> None:
    # Goal of docs/heads.md: if the centre moves by 2 µm and nothing is calibrated again, the angle
    # changes by at most 0.002″ RMS.
    disc = _known_disc(STATED_PLACES_DEG, EQUAL)
    bank = mean_bank(disc, COUNTS, lanes=12)
    angle = np.linspace(0.0, 6.28, 600)
    shown = []
    for causes in (DISC, (*DISC, shift)):
        table = _table(causes, STATED_PLACES_DEG, EQUAL)
        state = TableState.at_rest(angle)
        exact = np.array([table.reading_rad(h, state) for h in range(4)]) / table.count_rad
        counts = np.rint(exact).astype(np.int64)
        shown.append(mean_angle_counts(bank, counts) - weights_of(bank) @ (counts - exact))
    change = moved(shown[1] - shown[0]) * 0.0772
    # The bound is the motion, 7.6″ = 3.7e-5 rad, times Σ n·E_n over the corrected orders of the
    # mean (15″). The second-order effect of the changed eccentricity adds 150″·7.6″.
    slope = 3.7e-5 * sum(
        n * a * 0.0772 for n, a in zip(bank.orders, bank.amplitudes_counts, strict=True)
    )
    assert np.max(np.abs(change)) < slope + 150.0 * 7.64 * RAD_PER_ARCSEC
    assert round(float(np.sqrt(np.mean(change**2))), 3) in (0.001, 0.002)


def test_the_order_factor_is_what_the_mean_sees_of_a_pure_order() -> None:
    places = np.radians(STATED_PLACES_DEG)
    weights = mean_weights(places)
    angle = np.linspace(0.0, 6.0, 50)
    for order in (1, 2, 55):
        seen = sum(w * np.cos(order * (angle + p)) for w, p in zip(weights, places, strict=True))
        factor = order_factor(weights, places, [order])[0]
        np.testing.assert_allclose(seen, np.real(factor * np.exp(1j * order * angle)), atol=1e-12)
    assert abs(order_factor(weights, places, [1])[0]) < 1e-12
