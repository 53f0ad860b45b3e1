"""Defines the input quantities of the calibration, and draws each from its distribution."""

from __future__ import annotations

import cmath
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from arctrue.generated.number_formats import LANES_DEFAULT

Random = np.random.Generator
Values = Mapping[str, float]

NOISE_ARCSEC = (0.05, 0.3)
SEPARATION_ARCSEC = 50.0
"""Tolerance of the places of the heads (docs/architecture.md) and of their index sensors."""
INDEX_COUNTS = 1
RIPPLE_PERCENT = (0.1, 5.0)
RIPPLE_ORDERS = (1, 8)
RADIAL_MOTION_UM = (0.01, 0.1)
RADIAL_MOTION_ORDERS = (2, 8)
WARMING_K = 0.5
HUB_UM_PER_K = (0.1, 0.9)
BRACKET_ARCSEC_PER_K = (0.1, 1.0)
LANES = (4, 8, 16, 32)

QUIET: Values = {
    "noise_arcsec": 0.0,
    "separation_arcsec": 0.0,
    "detection_arcsec": 0.0,
    "u_detection_arcsec": 0.0,
    "index_counts": 0.0,
    "ripple_percent": 0.0,
    "ripple_order": 1.0,
    "ripple_phase_rad": 0.0,
    "motion_order": 2.0,
    "forward_um": 0.0,
    "forward_rad": 0.0,
    "backward_um": 0.0,
    "backward_rad": 0.0,
    "warming_k": 0.0,
    "hub_um_per_k": 0.0,
    "hub_rad": 0.0,
    "bracket_arcsec_per_k": 0.0,
    "lanes": float(LANES_DEFAULT),
}
"""Value of each quantity at which the quantity has no effect."""


def _log_uniform(random: Random, limits: tuple[float, float]) -> float:
    return float(np.exp(random.uniform(*np.log(limits))))


def _turn(random: Random) -> float:
    return float(random.uniform(0.0, 2.0 * np.pi))


def _noise(random: Random) -> dict[str, float]:
    return {"noise_arcsec": _log_uniform(random, NOISE_ARCSEC)}


def _separation(random: Random) -> dict[str, float]:
    mounting, detection = random.uniform(-SEPARATION_ARCSEC, SEPARATION_ARCSEC, 2)
    return {
        "separation_arcsec": float(mounting),
        "detection_arcsec": float(detection),
        "u_detection_arcsec": SEPARATION_ARCSEC / math.sqrt(3.0),
        "index_counts": float(INDEX_COUNTS),
    }


def _ripple(random: Random) -> dict[str, float]:
    return {
        "ripple_percent": _log_uniform(random, RIPPLE_PERCENT),
        "ripple_order": float(random.integers(RIPPLE_ORDERS[0], RIPPLE_ORDERS[1] + 1)),
        "ripple_phase_rad": _turn(random),
    }


def _radial_motion(random: Random) -> dict[str, float]:
    size_um, share = _log_uniform(random, RADIAL_MOTION_UM), float(random.uniform())
    return {
        "motion_order": float(
            random.integers(RADIAL_MOTION_ORDERS[0], RADIAL_MOTION_ORDERS[1] + 1)
        ),
        "forward_um": size_um * share,
        "forward_rad": _turn(random),
        "backward_um": size_um * (1.0 - share),
        "backward_rad": _turn(random),
    }


def _temperature(random: Random) -> dict[str, float]:
    return {
        "warming_k": float(random.uniform(-WARMING_K, WARMING_K)),
        "hub_um_per_k": _log_uniform(random, HUB_UM_PER_K),
        "hub_rad": _turn(random),
        "bracket_arcsec_per_k": _log_uniform(random, BRACKET_ARCSEC_PER_K),
    }


def _lanes(random: Random) -> dict[str, float]:
    return {"lanes": float(random.choice(LANES))}


@dataclass(frozen=True, slots=True)
class Input:
    """Input quantity, or group of related input quantities."""

    title: str
    """Name of the input on the page."""
    distribution: str
    """Description of the distribution on the page."""
    draw: Callable[[Random], dict[str, float]]


def _between(limits: tuple[float, float]) -> str:
    return f"{limits[0]:g} … {limits[1]:g}"


INPUTS: dict[str, Input] = {
    "noise": Input(
        "noise of each head",
        f"white; standard deviation {_between(NOISE_ARCSEC)}″, log-uniform",
        _noise,
    ),
    "separation": Input(
        "α and index",
        f"error of the heads' mounting and error of the index sensors' place: each rectangular, "
        f"±{SEPARATION_ARCSEC:g}″; each index mark repeats within ±{INDEX_COUNTS} count",
        _separation,
    ),
    "ripple": Input(
        "ripple of the speed",
        f"{_between(RIPPLE_PERCENT)} %, log-uniform; "
        f"{RIPPLE_ORDERS[0]} … {RIPPLE_ORDERS[1]} periods per turn",
        _ripple,
    ),
    "radial_motion": Input(
        "radial motion of the axis",
        f"ellipse of {_between(RADIAL_MOTION_UM)} µm, log-uniform; "
        f"{RADIAL_MOTION_ORDERS[0]} … {RADIAL_MOTION_ORDERS[1]} revolutions per turn",
        _radial_motion,
    ),
    "temperature": Input(
        "temperature during the capture",
        f"changes by up to ±{WARMING_K:g} K, rectangular; the disc's centre moves by "
        f"{_between(HUB_UM_PER_K)} µm/K and the bracket of head 2 by "
        f"{_between(BRACKET_ARCSEC_PER_K)}″/K, both log-uniform",
        _temperature,
    ),
    "lanes": Input("lanes of the gateware", f"one of {', '.join(map(str, LANES))}", _lanes),
}
"""Inputs by name; their order determines their streams of random numbers."""

CASES: dict[str, tuple[str, ...]] = {
    "quantisation": (),
    "noise": ("noise",),
    **{name: ("noise", name) for name in INPUTS if name != "noise"},
    "all": tuple(INPUTS),
}
"""Names of the active inputs, by case. Quantisation of counts and words is always active; in the
case ``quantisation`` no other input is active."""


def drawn(seed: int, case: str) -> dict[str, float]:
    """Draw the quantities of a trial: the inputs of the case are random, all others have no effect.

    Each input has its own stream of random numbers, so that its values in a trial are the same in
    every case. Raises KeyError for an unknown case.
    """
    found = dict(QUIET)
    for number, (name, item) in enumerate(INPUTS.items()):
        if name in CASES[case]:
            found |= item.draw(np.random.default_rng([seed, 1, number]))
    return found


def ellipse_m(values: Values) -> tuple[complex, complex]:
    """Return the radii, as complex numbers in metres, of the forward and the backward circle of the
    radial motion."""
    return (
        cmath.rect(values["forward_um"] * 1e-6, values["forward_rad"]),
        cmath.rect(values["backward_um"] * 1e-6, values["backward_rad"]),
    )
