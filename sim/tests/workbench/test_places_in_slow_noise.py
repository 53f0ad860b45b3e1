"""Tests the comparison of passes over equal places whose neighbours have similar noise."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.signal import lfilter

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
