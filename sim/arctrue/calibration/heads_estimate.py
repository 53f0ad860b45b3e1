"""Describes the result of a calibration of several heads, with its covariance."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from arctrue.base.units import RAD_PER_ARCSEC
from arctrue.calibration.head_weights import order_factor
from arctrue.calibration.heads_columns import State
from arctrue.calibration.heads_gain import MotionOrders, order_gain
from arctrue.calibration.mean_banks import HeadsOnDisc

Float = NDArray[np.float64]
Integer = NDArray[np.int64]


@dataclass(frozen=True)
class AxisCircle:
    """One circle of the axis' motion at one order, arcseconds at the disc's radius."""

    order: int
    sense: int
    """+1: forward, with the table; −1: backward."""
    value_arcsec: complex
    u_arcsec: float
    """Standard uncertainty of a component."""


@dataclass(frozen=True)
class HeadsEstimate:
    """Values of ``state`` with their ``covariance``, (size, size), in the units of its layout.

    The columns of the covariance after the layout's columns belong to the offsets of heads 2, 3 and
    4 in arcseconds, run after run. A value that was held fixed has variance 0.
    """

    asked_orders: Integer
    state: State
    covariance: Float
    motion: MotionOrders
    combinations: Float
    """Weights of the readings in each fitted combination, (m, heads); each combination has noise of
    variance 1.
    """
    samples: int
    turns: int
    noise_arcsec: float
    """Standard deviation of one reading."""

    @property
    def orders(self) -> Integer:
        """Orders of the disc that the readings of these heads determine, (N,)."""
        return self.state.layout.orders

    @property
    def unseen_orders(self) -> Integer:
        """Requested orders that heads at these places do not determine."""
        return np.setdiff1d(self.asked_orders, self.orders)

    @property
    def values(self) -> Float:
        """g(R) of the disc in arcseconds, (2N,), cosines before sines."""
        return np.asarray(self.state.values[self.state.layout.disc])

    @property
    def disc_covariance(self) -> Float:
        """Covariance of ``values``, arcseconds², (2N, 2N)."""
        part = self.state.layout.disc
        return np.asarray(self.covariance[part, part])

    @property
    def offsets_rad(self) -> Float:
        """Mean of R_i − R_1 over a turn, averaged over the runs, (heads,)."""
        return np.asarray(self.state.offsets_rad.mean(axis=0))

    @property
    def places_rad(self) -> Float:
        """Places: angles from head 1 to each head, (heads,)."""
        return self.offsets_rad + self.state.late_rad

    @property
    def u_places_arcsec(self) -> Float:
        """Standard uncertainty of the places, (heads,); the entry of head 1 is 0."""
        part = self.state.layout.late
        return np.concatenate(([0.0], np.sqrt(np.diag(self.covariance)[part])))

    @property
    def radius_ratios(self) -> Float:
        """Ratio of the disc's nominal radius to the radius of each head, (heads,)."""
        return self.state.radius_ratios

    @property
    def u_radius_ratios(self) -> Float:
        """Standard uncertainty of the radius ratios, (heads,)."""
        part = self.state.layout.radius
        return np.concatenate(([0.0], np.sqrt(np.diag(self.covariance)[part])))

    @property
    def noise_gain(self) -> Float:
        """Ratio of the noise of every order of the disc to the noise of one head, (N,)."""
        return order_gain(self.places_rad, self.orders, self.motion)

    @property
    def axis_motion(self) -> tuple[AxisCircle, ...]:
        """Motion of the axis: one entry for each fitted circle."""
        layout = self.state.layout
        variance = np.diag(self.covariance)[layout.motion]
        moved = self.state.values[layout.motion]
        return tuple(
            AxisCircle(
                order,
                sense,
                complex(moved[2 * i], moved[2 * i + 1]),
                float(np.sqrt(variance[2 * i : 2 * i + 2].mean())),
            )
            for i, (order, sense) in enumerate(layout.motion_parts)
        )

    def on_disc(self) -> HeadsOnDisc:
        """Return the disc's orders and the heads' geometry, from which the gateware's coefficients
        are calculated."""
        return HeadsOnDisc(
            self.orders, self.values, self.places_rad, self.offsets_rad, self.radius_ratios
        )

    def mean_orders(self, weights: Float) -> tuple[NDArray[np.complex128], Float]:
        """Return the disc's orders in the mean, cosine − j·sine, (N,), and u of a component.

        u contains the noise of the disc's orders and the uncertainties of places and radii.
        """
        layout, number = self.state.layout, self.orders.size
        cosine, sine = np.split(self.values, 2)
        disc = cosine - 1j * sine
        at = np.exp(1j * np.multiply.outer(self.orders, self.places_rad)) * weights
        factor = order_factor(weights, self.places_rad, self.orders, self.radius_ratios)
        slopes = np.zeros((number, layout.size), dtype=np.complex128)
        index = np.arange(number)
        slopes[index, index] = factor
        slopes[index, index + number] = -1j * factor
        turn = 1j * self.orders[:, None] * disc[:, None] * at * RAD_PER_ARCSEC
        slopes[:, layout.late] = turn[:, 1:]
        first = self.orders == 1
        slopes[first, layout.radius] = (disc[:, None] * at)[first, 1:]
        shared = self.covariance[: layout.size, : layout.size]
        variance = np.einsum("ij,jk,ik->i", slopes, shared, slopes.conj()).real
        return disc * factor, np.asarray(np.sqrt(np.maximum(variance, 0.0) / 2.0))
