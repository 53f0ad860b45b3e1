"""Calibrates by the paper's method: two heads and a discrete Fourier transform, with the
approximation that ε(R) equals ε(θ)."""

from __future__ import annotations

import numpy as np

from arctrue.calibration.capture_check import WholeTurns
from arctrue.calibration.estimate import Estimate
from arctrue.calibration.fourier import fourier
from arctrue.calibration.head_separation import Choice
from arctrue.calibration.least_squares import least_squares
from arctrue.calibration.selection import GAIN_LIMIT_DEFAULT
from arctrue.studies.methods.method import Method, of_harmonics
from arctrue.studies.methods.world import Output, World

SEPARATION_RAD = float(np.radians(33.0))


def captured(world: World) -> WholeTurns:
    """Return all turns, read by two heads 33° apart, as one capture."""
    counts = np.concatenate(list(world.turns([0.0, -SEPARATION_RAD])), axis=1)
    step = world.settings.counts_per_rev / world.settings.samples_a_turn
    return WholeTurns(0, world.settings.turns, counts[0], counts[1], step)


def _fourier(world: World, choice: Choice) -> Output:
    estimate, _ = fourier(
        [captured(world)],
        world.settings.counts_per_rev,
        SEPARATION_RAD,
        world.settings.orders,
        choice,
    )
    return _applied(estimate)


def _applied(estimate: Estimate) -> Output:
    """Return the output corrected by the orders whose gain is within the limit of ``arctrue
    calibrate``."""
    kept = estimate.noise_gain <= GAIN_LIMIT_DEFAULT
    return of_harmonics(estimate.orders[kept], estimate.values[np.tile(kept, 2)])


def _least_squares(world: World) -> Output:
    estimate, _ = least_squares(
        [captured(world)],
        world.settings.counts_per_rev,
        SEPARATION_RAD,
        world.settings.orders,
        "measured",
    )
    return _applied(estimate)


NOT_CORRECTED = (
    "orders 120, 240, …; high noise at orders 11, 22, …; attributes radial motion and unequal "
    "radii to the disc"
)
PAPER_DFT = Method(
    "two_heads_dft",
    "Two heads, DFT, α nominal (the paper)",
    "Geckeler et al. [8]; equations (1) to (8)",
    2,
    "two heads, mounted at α within ± 50″; constant speed",
    NOT_CORRECTED,
    lambda world: _fourier(world, "nominal"),
)
MEASURED_DFT = Method(
    "two_heads_dft_measured",
    "Two heads, DFT, α measured by the index",
    "Geckeler et al. [8]; equations (1) to (8) with α from mean(R₂ − R₁)",
    2,
    "two heads, one index mark; constant speed",
    NOT_CORRECTED,
    lambda world: _fourier(world, "measured"),
)
TWO_HEADS_LEAST_SQUARES = Method(
    "two_heads_least_squares",
    "Two heads, least squares",
    "arctrue calibrate",
    2,
    "two heads, one index mark; any speed",
    NOT_CORRECTED,
    _least_squares,
)
