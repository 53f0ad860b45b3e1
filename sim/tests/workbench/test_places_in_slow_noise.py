"""Tests the comparison of passes over equal places whose neighbours have similar noise."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.signal import lfilter
from scipy.stats import chi2, ncx2

from arctrue.workbench.inference.same_place import Visits

Float = NDArray[np.float64]
PLACES, PASSES, NOISE_ARCSEC = 72, 6, 0.2
ANGLE = 2.0 * np.pi * np.arange(PLACES) / PLACES


def _visits(seed: int, rho: float, of_place: Float) -> Visits:
    """Return passes over the same places, in noise with the correlation ``rho`` between neighbours
    (AR(1) along each pass); ``of_place``: error of each place."""
    random = np.random.default_rng([31, seed])
    drive = random.normal(0.0, NOISE_ARCSEC, (PASSES, PLACES))
    drive[:, 1:] *= np.sqrt(1.0 - rho**2)
    cells = (lfilter([1.0], [1.0, -rho], drive, axis=1) + of_place).ravel()
    one_pass = np.repeat(np.arange(PASSES), PLACES)
    constant = np.full((PLACES, 1), PLACES**-0.5)
    visits = Visits(
        of_row=np.arange(cells.size),
        place=np.tile(np.arange(PLACES), PASSES),
        one_pass=one_pass,
        angle_rad=ANGLE,
        bases=tuple((np.flatnonzero(one_pass == number), constant) for number in range(PASSES)),
        left=np.zeros(0),
        stations=True,
        over_travel=False,
        side=np.zeros(cells.size, dtype=np.int64),
        mean_square=1.0,
    )
    return replace(visits, left=visits.without_curves(cells))


@pytest.mark.parametrize(("rho", "least"), [(0.0, 18), (0.8, 18), (0.9, 16)])
def test_a_single_place_is_found_in_slow_noise(rho: float, least: int) -> None:
    """One place is wrong by 1.5″, 18 times the noise of the mean of its six passes (0.2″/√6).

    Another place is found too in 1 % of sets (FAMILY_WISE): in more than two of 20 with the
    probability 0.001 (binomial). At ρ = 0.9, Σ ρ^(2k) = 9.5 leaves about 7 degrees of freedom of
    the places and 36 of the passes: F ≈ 1 + 6·1.5²/(71·0.2²) = 5.8 has p = 1.5e-4 and is not always
    sure (SURE_P).
    """
    off = np.zeros(PLACES)
    off[30] = 1.5
    found = [_visits(seed, rho, off).repeated() for seed in range(20)]
    right = [
        item is not None and [round(spot.angle_deg) for spot in item.spots] == [150]
        for item in found
    ]
    assert sum(right) >= least


OWN_ARCSEC, SETS = 0.15, 80


def _p_of_order_3(seed: int, rho: float, size: float) -> float:
    """Return p of the fitted order 3 among places with white errors of 0.15″ of their own."""
    own = np.random.default_rng([32, seed]).normal(0.0, OWN_ARCSEC, PLACES)
    visits = _visits(seed, rho, own + size * np.cos(3.0 * ANGLE))
    waves = np.stack([np.cos(3.0 * ANGLE), np.sin(3.0 * ANGLE)], axis=1)[visits.place]
    return visits.p_of(waves @ np.linalg.lstsq(waves, visits.left, rcond=None)[0], 2)


@pytest.mark.parametrize("rho", [0.5, 0.8])
def test_an_effect_among_places_is_not_refused_in_slow_noise(rho: float) -> None:
    """An order of 0.12″ among the places is significant about as often as in the exact test.

    The exact test knows the power of the places' errors and of the noise at order 3, the spectrum
    of AR(1); its χ² has the noncentrality a²·n/(2·power). The bound is three standard deviations of
    the share in 80 sets below the exact share.
    """
    at_the_order = np.abs(1.0 - rho * np.exp(-3.0j * ANGLE[1])) ** 2
    power = OWN_ARCSEC**2 + NOISE_ARCSEC**2 / PASSES * (1.0 - rho**2) / at_the_order
    exact = float(ncx2.sf(chi2.isf(0.01, 2), 2, 0.12**2 * PLACES / 2.0 / power))
    kept = np.mean([_p_of_order_3(seed, rho, 0.12) < 0.01 for seed in range(SETS)])
    assert kept >= exact - 3.0 * np.sqrt(exact * (1.0 - exact) / SETS)


@pytest.mark.parametrize("rho", [0.0, 0.5, 0.9])
def test_no_effect_among_places_is_significant_in_slow_noise(rho: float) -> None:
    """Without an order, p < 0.01 occurs in 1 % of the sets in which the test counts (p > 0), with
    a standard deviation of 0.8 % in about 160 sets; the bound is three of them above 1 %."""
    found = np.array([_p_of_order_3(seed, rho, 0.0) for seed in range(2 * SETS)])
    assert np.mean(found[found > 0.0] < 0.01) <= 0.01 + 3.0 * 0.008
