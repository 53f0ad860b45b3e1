"""Computes noise gain and sensitivity to α for many α and orders, and finds the best α. Blind
orders are orders that two heads at an α cannot determine.

For orders 1 to N, the largest gain of any α is at least 1/(2 sin(π/(N + 1))). Proof: the N + 1
points e^{jnα}, n = 0 … N, lie on a circle. Therefore two of the points, n₁ and n₂, are at most as
far apart as neighbours among N + 1 evenly spaced points. The closer these two are, the larger is
the gain of order |n₁ − n₂|. α = 360°·k/(N + 1) reaches this bound for every k without a common
divisor with N + 1.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from arctrue.base.units import RAD_PER_ARCSEC
from arctrue.calibration.head_separation import U_NOMINAL_RAD
from arctrue.calibration.transfer_function import noise_gain
from arctrue.studies.revolution import GRADUATION_ARCSEC, GRADUATION_ORDERS

Float = NDArray[np.float64]
Integer = NDArray[np.int64]

PAPER_DEG = 33.0
ECCENTRICITY_ARCSEC = 144.0
"""Amplitude of order 1 of the simulated table, whose error has the paper's range."""
TOLERANCE_ARCSEC = 50.0


def gain_map(alpha_deg: Float, orders: Integer) -> Float:
    """Return |TF(n)|, the noise of ε divided by the noise of R₂ − R₁, ``(angles, orders)``; inf for
    an order that the heads cannot determine."""
    return np.array([noise_gain(orders, math.radians(alpha)) for alpha in alpha_deg])


def sensitivity_map(alpha_deg: Float, orders: Integer) -> Float:
    """Return n·|TF(n)|: relative error of order n per radian of error in α, ``(angles,
    orders)``."""
    return gain_map(alpha_deg, orders) * orders


def least_worst_gain(most_order: int) -> float:
    """Return the lower bound 1/(2 sin(π/(N + 1))) of the largest gain for orders 1 to N =
    ``most_order``."""
    return 1.0 / (2.0 * math.sin(math.pi / (most_order + 1)))


def blind_orders(alpha_deg: float, most_order: int) -> list[int]:
    """Return the orders up to ``most_order`` that two heads at this α cannot determine."""
    orders = np.arange(1, most_order + 1)
    return [int(n) for n in orders[~np.isfinite(noise_gain(orders, math.radians(alpha_deg)))]]


@dataclass(frozen=True)
class Disc:
    """Amplitudes of the disc's errors, arcseconds."""

    orders: Integer
    amplitude_arcsec: Float

    @classmethod
    def of_paper(cls) -> Disc:
        """Return the disc of ``arctrue revolution``, whose error has the paper's range."""
        return cls(
            np.array([1, *GRADUATION_ORDERS]), np.array([ECCENTRICITY_ARCSEC, *GRADUATION_ARCSEC])
        )


@dataclass(frozen=True)
class AlphaChoice:
    """Properties of a separation α for orders 1 to ``most_order``."""

    alpha_deg: float
    most_order: int
    worst_gain: float
    worst_order: int
    rms_gain: float
    gain_first: float
    noise_arcsec: float
    """RMS error over the turn that the noise of one captured turn causes."""
    by_mounting_arcsec: float
    """RMS error over the turn if the nominal α is used (its error is within ± 50″, rectangular
    distribution)."""
    blind: tuple[int, ...]
    """Orders up to 128 that two heads at this α cannot determine."""

    @property
    def total_arcsec(self) -> float:
        """Return the root sum of squares of the errors from noise and from α."""
        return math.hypot(self.noise_arcsec, self.by_mounting_arcsec)


def judged(
    alpha_deg: float,
    most_order: int,
    disc: Disc,
    *,
    noise_arcsec: float = 0.1,
    samples: int = 12_000,
    u_alpha_rad: float = U_NOMINAL_RAD,
) -> AlphaChoice:
    """Compute the properties of an α. With white noise s of each head and K samples, a component of
    ε has the variance 4|TF|²s²/K."""
    alpha = math.radians(alpha_deg)
    orders = np.arange(1, most_order + 1)
    gain = noise_gain(orders, alpha)
    slope = disc.orders * noise_gain(disc.orders, alpha) * disc.amplitude_arcsec
    worst = int(np.argmax(gain))
    return AlphaChoice(
        alpha_deg,
        most_order,
        float(gain[worst]),
        worst + 1,
        float(np.sqrt(np.mean(gain**2))),
        float(gain[0]),
        float(noise_arcsec * np.sqrt(4.0 / samples * np.sum(gain**2))),
        float(u_alpha_rad * np.sqrt(0.5 * np.sum(slope[disc.orders <= most_order] ** 2))),
        tuple(blind_orders(alpha_deg, 128)),
    )


def candidates_deg(most_order: int) -> Float:
    """List the α up to 180° that reach the lower bound of the largest gain, in rising order."""
    points = most_order + 1
    return np.array(
        [360.0 * k / points for k in range(1, points // 2 + 1) if math.gcd(k, points) == 1]
    )


def best_choices(most_order: int, disc: Disc, least_deg: float = 20.0) -> list[AlphaChoice]:
    """List the α that reach the lower bound of the largest gain; the α with the smallest total
    error comes first.

    ``least_deg``: smallest angle between two read heads of the paper's size; a smaller α is left
    out.
    """
    found = [
        judged(alpha, most_order, disc)
        for alpha in candidates_deg(most_order).tolist()
        if alpha >= least_deg
    ]
    return sorted(found, key=lambda one: one.total_arcsec)


def detuned(alpha_deg: float, most_order: int) -> float:
    """Return the largest gain if the heads stand at the less favourable end of the mounting
    tolerance."""
    orders = np.arange(1, most_order + 1)
    ends = [
        noise_gain(orders, math.radians(alpha_deg) + side * TOLERANCE_ARCSEC * RAD_PER_ARCSEC)
        for side in (-1.0, 1.0)
    ]
    return float(np.max(ends))
