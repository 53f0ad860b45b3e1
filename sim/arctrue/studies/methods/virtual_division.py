"""Virtual equal division (VEDA): sums of the difference of two heads replace N heads.

With the heads m/N of a turn apart, δ(θ) = ε(θ + 2πm/N) − ε(θ). Its sum over k steps is
ε(θ + k·2πm/N) − ε(θ), the difference of the k-th virtual head; the mean over N virtual heads is
−ε(θ) and the orders that are multiples of N. 33° is 11/120 of a turn: 120 virtual heads.
"""

from __future__ import annotations

from fractions import Fraction

import numpy as np
from numpy.typing import NDArray

from arctrue.base.units import ARCSEC_PER_RAD
from arctrue.studies.methods.method import Method, of_harmonics
from arctrue.studies.methods.world import Correction, World

Float = NDArray[np.float64]

SEPARATION = Fraction(33, 360)
"""Of a turn, in lowest terms 11/120."""


def virtual_average(difference: Float, separation: Fraction) -> Float:
    """ε without the multiples of N from δ at equal steps of a turn, both ``(steps,)``.

    Raises ValueError where N steps of the separation do not fit the grid.
    """
    heads = separation.denominator
    if difference.size % heads:
        raise ValueError(f"steps a turn: expected a multiple of {heads}, found {difference.size}")
    step = difference.size * separation.numerator // heads
    at = (np.arange(difference.size) + step * np.arange(heads)[:, None]) % difference.size
    of_head = np.cumsum(difference[at], axis=0)
    # Virtual head 0 is head 1 itself, whose difference is 0; the closing one is left out.
    return -np.asarray(of_head[:-1].sum(axis=0) / heads)


def _run(world: World) -> Correction:
    given = world.settings
    steps = given.samples_a_turn - given.samples_a_turn % SEPARATION.denominator
    grid = np.arange(steps) * (given.counts_per_rev / steps)
    difference = np.zeros(steps)
    for head1, head2 in world.turns([0.0, -2.0 * np.pi * float(SEPARATION)]):
        place = head1 % given.counts_per_rev
        difference += np.interp(grid, place, head2 - head1, period=given.counts_per_rev)
    difference /= given.turns
    difference = (difference - difference.mean()) * (world.count_rad * ARCSEC_PER_RAD)
    lines = np.fft.rfft(virtual_average(difference, SEPARATION)) * (2.0 / steps)
    orders = given.orders[given.orders % SEPARATION.denominator != 0]
    return of_harmonics(orders, np.concatenate((lines[orders].real, -lines[orders].imag)))


VIRTUAL_DIVISION = Method(
    "virtual_division",
    "Virtual equal division, 2 heads (VEDA)",
    "Ishii et al. [7], as the paper describes it",
    2,
    "two heads 11/120 of a turn apart, placed to the tolerance: α is not measured",
    "orders 120, 240, …; radial motion counts as disc",
    _run,
)
