"""Tests the uncertainty budget of docs/heads.md against a Monte Carlo in plain numpy.

The simulation shares no code with the budget: it has its own weights (from the pseudoinverse), its
own rounding to words, and the exact angle of a head's place as seen from the disc's centre. Each
cause is drawn alone.
"""

from __future__ import annotations

import json
from collections.abc import Callable
from itertools import product
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from arctrue.base.json_text import plain
from arctrue.studies.heads.budget import budget
from arctrue.studies.heads.self_calibrated_table import SelfCalibratedTable

Float = NDArray[np.float64]
ROOT = Path(__file__).resolve().parents[4]
COMMITTED = json.loads((ROOT / "docs" / "data" / "heads.json").read_text(encoding="utf-8"))
PLACES = np.radians([0.0, 64.3, 177.0, 257.9])
RADIUS_M = 53.975e-3
ARCSEC = 206_264.806_247
COUNT_ARCSEC = 1_296_000.0 / 2**24
DRAWS = 200_000
"""The standard deviation of N draws scatters by √((κ − 1)/4N), with a kurtosis κ of at most 4.5
here (a rectangular error times a wave): 0.2 %."""
BOUND = 0.03
"""Largest relative deviation of a simulated entry. Besides the scatter of 0.2 % it covers the
mounting of the budget's heads within ± 50″, which changes the weights by up to 0.1 %, and the
budget's own draws of the mounting for the weights, 1.3 %."""


def least_norm(places: Float) -> Float:
    """Return the weights (…, 4) of least norm with Σw = 1, Σw·cos p = 0 and Σw·sin p = 0."""
    rows = np.stack((np.ones_like(places), np.cos(places), np.sin(places)), axis=-2)
    return np.asarray(np.linalg.pinv(rows)[..., :, 0])


WEIGHTS = least_norm(PLACES)


def uniform(random: np.random.Generator, half: float, heads: int = 4) -> Float:
    return random.uniform(-half, half, (DRAWS, heads))


def seen(centre_m: NDArray[np.complex128], radius_m: Float, places: Float) -> Float:
    """Return the change of each reading, ″, if the disc's centre stands at ``centre_m`` (n,) from
    the axis: the angle of the head's place as seen from the centre."""
    head = np.exp(1j * places)
    return np.angle(head.conj() * (head - centre_m[:, None] / radius_m)) * ARCSEC


def circle(random: np.random.Generator, size_m: float) -> NDArray[np.complex128]:
    return size_m * np.exp(1j * random.uniform(0.0, 2.0 * np.pi, DRAWS))


def of_noise(random: np.random.Generator) -> Float:
    return random.normal(0.0, 0.1, (DRAWS, 4)) @ WEIGHTS


def of_readings(random: np.random.Generator) -> Float:
    true = uniform(random, 1e6)
    return np.asarray((np.rint(true) - true) @ WEIGHTS * COUNT_ARCSEC)


def of_output(random: np.random.Generator) -> Float:
    mean = uniform(random, 1e6, 1)[:, 0]
    return np.asarray((np.rint(mean) - mean) * COUNT_ARCSEC)


def of_weights(random: np.random.Generator) -> Float:
    """Round the weights of random mountings to words with the sum 2¹⁶, move the axis, and return
    the error of the mean. Of all words within two units, the function takes those that let through
    least of the motion."""
    mounted = PLACES + random.uniform(-50.0, 50.0, (20_000, 4)) / ARCSEC
    exact = least_norm(mounted) * 65_536.0
    nearest, turned = np.rint(exact), np.exp(1j * mounted)
    best, least = np.zeros_like(exact), np.full(len(exact), np.inf)
    for steps in product((-2, -1, 0, 1, 2), repeat=3):
        words = nearest + np.array([*steps, 0])
        words[:, 3] = 65_536.0 - words[:, :3].sum(axis=1)
        leak = np.abs(np.sum(words * turned, axis=1))
        leak[np.abs(words[:, 3] - exact[:, 3]) > 2.5] = np.inf
        better = leak < least
        best[better], least[better] = words[better], leak[better]
    moved = 2e-6 * np.exp(1j * random.uniform(0.0, 2.0 * np.pi, len(best)))
    # The wave of 7.6″ has no term of second order, because that term, 0.0003″, would hide this
    # small cause.
    wave = -np.imag(moved[:, None] * turned.conj()) / RADIUS_M * ARCSEC
    return np.asarray(np.sum(best / 65_536.0 * wave, axis=1))


def of_offsets(random: np.random.Generator) -> Float:
    true = uniform(random, 1e5)
    return np.asarray((np.rint(16.0 * true) / 16.0 - true) @ WEIGHTS * COUNT_ARCSEC)


def of_zero(random: np.random.Generator) -> Float:
    return np.asarray(uniform(random, 1.0) @ WEIGHTS * COUNT_ARCSEC)


def against_ideal(centre_m: NDArray[np.complex128], radius_m: Float, places: Float) -> Float:
    """Return the mean's error minus its error with nominal radii and places."""
    ideal = seen(centre_m, np.full(4, RADIUS_M), PLACES)
    return np.asarray((seen(centre_m, radius_m, places) - ideal) @ WEIGHTS)


def of_places(random: np.random.Generator) -> Float:
    off = random.normal(0.0, 10.0, (DRAWS, 4)) / ARCSEC
    return against_ideal(circle(random, 2e-6), np.full(4, RADIUS_M), PLACES + off)


def of_radii(size_m: float) -> Callable[[np.random.Generator], Float]:
    def drawn(random: np.random.Generator) -> Float:
        radius = RADIUS_M + uniform(random, 1e-4)
        return against_ideal(circle(random, size_m), radius, PLACES)

    return drawn


def of_skew(random: np.random.Generator) -> Float:
    late_s = random.normal(0.0, 10e-9, (DRAWS, 4))
    return np.asarray(-late_s @ WEIGHTS * 90.0 * 3600.0)


CAUSES: dict[str, Callable[[np.random.Generator], Float]] = {
    "noise": of_noise,
    "readings": of_readings,
    "output": of_output,
    "weights": of_weights,
    "offsets": of_offsets,
    "zero": of_zero,
    "places": of_places,
    "radii_axis": of_radii(2e-6),
    "radii_disc": of_radii(37.7e-6),
    "skew": of_skew,
}


@pytest.fixture(scope="module", params=["small", "committed"])
def rows(request: pytest.FixtureRequest) -> dict[str, float]:
    """Return the uncertainties of a budget that is computed now, and of the page."""
    found = COMMITTED["budget"]
    if request.param == "small":
        found = plain(budget(SelfCalibratedTable(samples_a_turn=4000, seed=2), 2e-6, 1e-4))
    return {one["name"]: one["u_arcsec"] for one in found}


def test_every_cause_is_simulated(rows: dict[str, float]) -> None:
    assert set(rows) == set(CAUSES)


@pytest.mark.parametrize("cause", CAUSES)
def test_the_monte_carlo_agrees(rows: dict[str, float], cause: str) -> None:
    """The standard deviation of the simulated mean equals the entry of the budget within 3 %."""
    drawn = CAUSES[cause](np.random.default_rng([27, list(CAUSES).index(cause)]))
    assert float(np.std(drawn)) == pytest.approx(rows[cause], rel=BOUND)
