"""Tests which errors a turn of three and of four heads determines at an order, and which no method
can separate.

At order n the reading of head i has the complex line

    θ + g·e^{jnp_i} + x·cos p_i + y·sin p_i,

with the table's motion θ, the disc g, and the axis' motion (x, y). Because x and y are real
functions of time, their two complex lines describe the forward and the backward circle of the
order. Three heads give three lines for four unknowns.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray
from sim.tests.firmware.test_heads import PLACES, World

from arctrue.calibration.head_weights import mean_weights, order_factor
from arctrue.calibration.heads_on_device import heads_on_device, mean_orders

Complex = NDArray[np.complex128]

THREE = np.radians(PLACES[3])
FOUR = np.radians(PLACES[4])


def lines(places_rad: NDArray[np.float64], order: int) -> Complex:
    """Return the matrix with the columns of θ, g, x and y, in which each head has one row."""
    return np.stack(
        (
            np.ones(places_rad.size, dtype=np.complex128),
            np.exp(1j * order * places_rad),
            np.cos(places_rad).astype(np.complex128),
            np.sin(places_rad).astype(np.complex128),
        ),
        axis=1,
    )


@pytest.mark.parametrize("order", [1, 2, 3, 5, 12, 40, 64, 128])
def test_three_heads_see_no_order_of_the_disc_where_the_axis_moves(order: int) -> None:
    """Three heads cannot show an order of the disc, because the motions of table and axis can
    together produce the readings that the disc produces."""
    columns = lines(THREE, order)
    others = columns[:, [0, 2, 3]]
    assert np.linalg.matrix_rank(columns) == 3
    made = np.linalg.solve(others, columns[:, 1])
    assert np.abs(others @ made - columns[:, 1]).max() < 1e-12


@pytest.mark.parametrize("order", [2, 3, 5, 12, 40, 64])
def test_four_heads_see_every_order_but_the_first(order: int) -> None:
    """Four heads show an order of the disc by the parity, which is the part of the disc's column
    that is orthogonal to all other columns."""
    assert np.linalg.matrix_rank(lines(FOUR, order), tol=1e-3) == 4
    assert np.linalg.matrix_rank(lines(FOUR, 1), tol=1e-9) == 3


def test_two_tables_that_three_heads_cannot_tell_apart() -> None:
    """One table has a disc of order 5 and an axis at rest; the other has a perfect disc, and its
    axis and drive move.

    All differences between three heads are equal within 1e-12″ at every sample; a fourth head
    separates the two cases by 0.4″.
    """
    theta = 2.0 * np.pi * np.arange(720) / 720
    wave = 0.2 * np.exp(1j * (5 * theta + 0.7))
    turn, x, y = np.linalg.solve(lines(THREE, 5)[:, [0, 2, 3]], np.exp(5j * THREE))

    def with_disc(place: float) -> NDArray[np.float64]:
        return np.real(wave * np.exp(5j * place))

    def with_axis(place: float) -> NDArray[np.float64]:
        return np.real(wave * (turn + x * np.cos(place) + y * np.sin(place)))

    for place in THREE[1:]:
        first = with_disc(place) - with_disc(0.0)
        second = with_axis(place) - with_axis(0.0)
        assert np.abs(first - second).max() < 1e-12
    fourth = float(np.radians(330.0))
    apart = (with_disc(fourth) - with_disc(0.0)) - (with_axis(fourth) - with_axis(0.0))
    assert np.abs(apart).max() > 0.4


@pytest.mark.parametrize(("order", "share"), [(2, 0.02), (3, 10.4), (5, 0.05), (6, 5.2)])
def test_what_three_heads_take_for_the_disc_stays_in_their_mean(order: int, share: float) -> None:
    """An axis that moves by 0.2″ along x looks like an error of the disc, so that the correction
    adds a share of the motion to the mean of the heads.

    The share follows from the two contrasts and the weights of the mean alone; the device's
    calibration in numpy makes this error too. Heads about 120° apart hardly observe the orders 3,
    6, …, which the mean contains in full.
    """
    places = np.radians(PLACES[3])
    contrasts = np.array([[-1.0, 1.0, 0.0], [-1.0, -1.0, 2.0]]) / np.sqrt([[2.0], [6.0]])
    columns = contrasts @ lines(places, order)
    taken = np.linalg.lstsq(columns[:, 1:2], columns[:, 2])[0][0]
    left = abs(order_factor(mean_weights(places), places, [order])[0] * taken)
    assert left == pytest.approx(share, rel=0.2)

    # In World a circle c adds Im(c·e^{jp}) to the reading of the head at p. These two circles
    # together add size·cos(order·θ)·cos p, which is a motion along x.
    size = 0.2
    straight = ((order, 0.5j * size, 0.5j * size),)
    still = World(heads=3, off_arcsec=(0.0,) * 4, late_arcsec=(0.0,) * 4)
    values = []
    for world in (still, replace(still, axis=straight)):
        found = heads_on_device(world.turns(), 1 << 24, world.nominal_rad, 12)
        weights = mean_weights(found.offsets_rad + found.late_rad, found.ratios)
        values.append(mean_orders(found, weights, found.offsets_rad)[0][order - 1])
    assert abs(values[1] - values[0]) == pytest.approx(size * left, rel=0.05, abs=5e-4)
