"""Calibrates two to four heads in numpy with the equations of the firmware.

The unknowns of :mod:`heads_least_squares` are split into three parts. Each pass solves each part
with the present values of the other parts, so that the device stores only one triangular matrix,
for the disc's orders:

- the disc's orders, from the combinations that no rotation changes: with four heads the parity,
  which no motion of the axis changes either; with three heads both combinations, if the axis is at
  rest at these orders; with two heads the only combination;
- the offsets aᵢ, for which the residual of every head has the mean 0;
- with three and four heads: order 1 of the disc, the backward circle of the axis, and the angle
  dᵢ and radius ratio ρᵢ of each head, from the readings' lines at order 1 and from the priors.

The firmware solves the same equations, but computes the normal matrix from a part of the samples
and forms the sums differently: firmware/calibration/heads_estimate.c.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from arctrue.base.units import ARCSEC_PER_RAD, RAD_PER_ARCSEC, arcsec_per_count
from arctrue.calibration.axis_asynchronous import AxisTurn, turn_shares
from arctrue.calibration.capture_check import WholeTurns
from arctrue.calibration.harmonics import unit_vectors
from arctrue.calibration.head_separation import (
    BELIEVABLE_ARCSEC,
    U_DETECTION_DEFAULT_ARCSEC,
)
from arctrue.calibration.head_weights import order_factor, parity_weights
from arctrue.calibration.heads_data import U_PLACE_DEFAULT_ARCSEC, U_RADIUS_DEFAULT
from arctrue.calibration.heads_gain import UNSEEN_GAIN
from arctrue.calibration.mean_banks import HeadsOnDisc, mean_error_arcsec
from arctrue.calibration.noise import NEIGHBOURS

Float = NDArray[np.float64]
Complex = NDArray[np.complex128]

CIRCLE_ORDERS = 4
LEAST_VARIANCE = 1e-6
"""Smallest variance of a reading, arcsec²; it prevents a division by zero if there is no noise."""
ROUNDS_MOST = 60
UNCHANGED_SHARE = 3e-12
READINGS = 1024


@dataclass(frozen=True)
class OnDevice:
    """The result of one turn in the firmware's quantities; lists over heads are (heads,).

    ``disc``: complex amplitudes cosine − j·sine of orders 1 to N, arcseconds, 0 for an order that
    the heads do not determine; ``variances`` (2, N) of cosine and sine;
    ``circles`` (orders, 2): radii of the forward and the backward circle, arcseconds; ``axis``:
    the turn for :mod:`axis_asynchronous`, None if there are not four heads.
    """

    disc: Complex
    seen: NDArray[np.bool_]
    gain: Float
    variances: Float
    offsets_rad: Float
    late_rad: Float
    ratios: Float
    u_late_arcsec: Float
    u_ratios: Float
    noise_arcsec: float
    residuals_arcsec: Float
    circles: Float
    axis: AxisTurn | None

    @property
    def heads_on_disc(self) -> HeadsOnDisc:
        """The disc and the heads as :mod:`mean_banks` needs them."""
        orders = np.arange(1, self.disc.size + 1)
        values = np.concatenate((self.disc.real, -self.disc.imag))
        return HeadsOnDisc(
            orders, values, self.offsets_rad + self.late_rad, self.offsets_rad, self.ratios
        )


class _Fit:
    """The present values of all unknowns, with the residuals and derivatives of the readings."""

    def __init__(
        self,
        counts: NDArray[np.int64],
        counts_per_rev: int,
        places_rad: Float,
        orders: int,
        u_place_arcsec: float,
        u_index_arcsec: float,
        u_radius: float,
    ) -> None:
        self.heads, self.samples = counts.shape
        self.places = places_rad
        self.orders = np.arange(1, orders + 1)
        self.u_radius = max(u_radius, 1e-6)
        unit = arcsec_per_count(counts_per_rev)
        whole = np.rint(
            ((counts - counts[0]).mean(axis=1) * unit * RAD_PER_ARCSEC - places_rad) / (2 * np.pi)
        ).astype(np.int64)
        self.apart = ((counts - counts[0]) - counts_per_rev * whole[:, None]) * unit
        self.offsets = self.apart.mean(axis=1) * RAD_PER_ARCSEC
        if np.abs(self.offsets - places_rad).max() > BELIEVABLE_ARCSEC * RAD_PER_ARCSEC:
            raise ValueError("a head is far from its place")
        mounting, index = (1.0 / max(u, 1e-6) ** 2 for u in (u_place_arcsec, u_index_arcsec))
        self.precision_late = mounting + index
        self.share = mounting / (mounting + index)
        self.turned = np.stack([unit_vectors(one, counts_per_rev) for one in counts])
        self.late = self.late_beforehand()
        self.ratios = np.ones(self.heads)
        self.disc = np.zeros(orders, dtype=np.complex128)
        self.backward = 0j
        first = 2 if self.heads > 2 else 1
        seen = self.gains() < UNSEEN_GAIN
        self.fitted = np.flatnonzero(seen & (self.orders >= first))

    def late_beforehand(self) -> Float:
        """Return the prior dᵢ in radians: the weighted mean of the mounting's value pᵢ − aᵢ and the
        index's value 0."""
        return np.asarray((self.places - self.offsets) * self.share)

    @property
    def sight(self) -> Complex:
        """Factor ρᵢ·e^{jpᵢ} of each head for order 1 of the disc, (heads,)."""
        return np.asarray(self.ratios * np.exp(1j * (self.offsets + self.late)))

    @property
    def combinations(self) -> Float:
        if self.heads == 4:
            return parity_weights(self.offsets + self.late, self.ratios)[None, :]
        if self.heads == 3:
            # Each row is the difference of a head and the mean of the heads before it; only the
            # first row enters the spectrum.
            return np.array([[-1.0, 1.0, 0.0], [-1.0, -1.0, 2.0]]) / np.sqrt([[2.0], [6.0]])
        return np.asarray(np.array([[-1.0, 1.0]]) / np.sqrt(2.0))

    def gains(self) -> Float:
        at = np.exp(1j * np.multiply.outer(self.orders, self.offsets + self.late))
        with np.errstate(divide="ignore"):
            return np.asarray(1.0 / np.linalg.norm(at @ self.combinations.T, axis=1))

    def waves(self) -> Complex:
        """Return e^{jny}, (heads, samples, N)."""
        y = np.angle(self.turned * np.exp(1j * self.late)[:, None])
        return np.asarray(np.exp(1j * y[..., None] * self.orders))

    def residuals(self, waves: Complex) -> Float:
        """Return the residuals of every head minus the residuals of head 1, arcseconds, (heads,
        samples)."""
        factors = np.ones((self.heads, self.orders.size))
        factors[:, 0] = self.ratios
        error = np.einsum("hsn,hn->hs", waves, factors * self.disc).real
        against = self.backward * self.turned[0].conj() * self.sight[:, None]
        left = self.apart - self.offsets[:, None] * ARCSEC_PER_RAD - error - against.imag
        return np.asarray(left - left[0])

    def columns(self, waves: Complex) -> Float:
        """Return the derivatives of all combinations by cosines and sines, (rows · samples, 2 ·
        fitted)."""
        found = np.einsum("rh,hsn->rsn", self.combinations, waves[..., self.fitted])
        return np.concatenate((found.real, found.imag), axis=2).reshape(-1, 2 * self.fitted.size)

    def lines(self, residuals: Float, order: int) -> Complex:
        """Return the amplitude A of the line Re(A·e^{jkR₁}) in each head's residual, minus the mean
        amplitude of all heads."""
        found = residuals @ (self.turned[0].conj() ** order) * (2.0 / self.samples)
        return np.asarray(found - found.mean())

    def means_and_lines(self, residuals: Float) -> tuple[Float, Complex]:
        """Return the mean and the line at order 1 of each head's residual; with three and four
        heads one fit gives both."""
        if self.heads == 2:
            return residuals.mean(axis=1), self.lines(residuals, 1)
        first = self.turned[0]
        design = np.stack((np.ones(self.samples), first.real, first.imag), axis=1)
        mean, cosine, sine = np.linalg.lstsq(design, residuals.T)[0]
        found = cosine - 1j * sine
        return mean, np.asarray(found - found.mean())

    def by_circles(self) -> Complex:
        """Return the lines that order 1 of the disc and the backward circle cause, (heads, 4)."""
        sight = self.sight
        columns = np.stack((sight, -1j * sight, 1j * sight.conj(), sight.conj()), axis=1)
        return np.asarray(columns - columns.mean(axis=0))

    def by_places(self) -> Complex:
        """Return the lines that dᵢ (arcseconds) and ρᵢ of heads 2, 3 and 4 cause, (heads, 2·(heads
        − 1))."""
        seen = self.sight * self.disc[0]
        columns = np.concatenate(
            (np.diag(1j * seen * RAD_PER_ARCSEC)[:, 1:], np.diag(seen / self.ratios)[:, 1:]), axis=1
        )
        return np.asarray(columns - columns.mean(axis=0))

    def places_equations(self, variance: float) -> tuple[Float, Float]:
        """Return the design matrix (rows, unknowns) and the right-hand side of its last rows, the
        priors.

        Every row is scaled to variance 1.
        """
        columns = np.concatenate((self.by_circles(), self.by_places()), axis=1)
        scale = np.sqrt(self.samples / (2.0 * variance))
        further = self.heads - 1
        known = np.concatenate(
            (np.full(further, np.sqrt(self.precision_late)), np.full(further, 1.0 / self.u_radius))
        )
        priors = np.concatenate((np.zeros((2 * further, 4)), np.diag(known)), axis=1)
        off = np.concatenate(
            (
                (self.late_beforehand() - self.late)[1:] * ARCSEC_PER_RAD,
                1.0 - self.ratios[1:],
            )
        )
        design = np.concatenate((columns.real * scale, columns.imag * scale, priors))
        return design, known * off

    def pass_once(self) -> float:
        """Make one pass; return the largest change of a prediction, arcseconds."""
        waves = self.waves()
        residuals = self.residuals(waves)
        combined = (self.combinations @ residuals).ravel()
        step = np.linalg.lstsq(self.columns(waves), combined)[0]
        change = float(np.abs(step).max(initial=0.0))
        offsets, lines = self.means_and_lines(residuals)
        moved = np.zeros(4 + 2 * (self.heads - 1))
        if self.heads > 2:
            variance = max(float(np.mean(np.square(combined))), LEAST_VARIANCE)
            design, known = self.places_equations(variance)
            scale = np.sqrt(self.samples / (2.0 * variance))
            right = np.concatenate((lines.real * scale, lines.imag * scale, known))
            norms = np.linalg.norm(design, axis=0)
            moved = np.linalg.lstsq(design / norms, right, rcond=1e-15)[0] / norms
        cosine, sine = np.split(step, 2)
        size = abs(self.disc[0])
        self.disc[self.fitted] += cosine - 1j * sine
        self.offsets = self.offsets + offsets * RAD_PER_ARCSEC
        self.disc[0] += moved[0] - 1j * moved[1]
        self.backward += complex(moved[2], moved[3])
        late, ratios = np.split(moved[4:], 2)
        self.late[1:] += late * RAD_PER_ARCSEC
        self.ratios[1:] += ratios
        geometry = size * (np.abs(late).max() * RAD_PER_ARCSEC + np.abs(ratios).max())
        return float(max(change, np.abs(offsets).max(), np.abs(moved[:4]).max(), geometry))


def heads_on_device(
    turn: WholeTurns,
    counts_per_rev: int,
    places_rad: Float,
    orders: int,
    *,
    u_place_arcsec: float = U_PLACE_DEFAULT_ARCSEC,
    u_index_arcsec: float = U_DETECTION_DEFAULT_ARCSEC,
    u_radius: float = U_RADIUS_DEFAULT,
) -> OnDevice:
    """Solve one turn. Raises ValueError for a head far from its place."""
    counts = np.stack([np.asarray(head, dtype=np.int64) for head in turn.heads])
    fit = _Fit(counts, counts_per_rev, places_rad, orders, u_place_arcsec, u_index_arcsec, u_radius)
    for _ in range(ROUNDS_MOST):
        if fit.pass_once() < UNCHANGED_SHARE * max(1.0, float(np.abs(fit.disc).max())):
            break
    waves = fit.waves()
    residuals = fit.residuals(waves)
    combined = fit.combinations @ residuals
    seen = np.zeros(orders, dtype=bool)
    seen[fit.fitted] = True
    used = 1 + 2 * fit.fitted.size
    variance = float(np.sum(np.square(combined))) / fit.combinations.shape[0]
    variance /= fit.samples - used
    covariance = np.linalg.inv(fit.columns(waves).T @ fit.columns(waves))
    colour = _colour(combined[0], seen, variance)
    covariance *= variance * colour
    seen[0] = seen[0] or fit.heads > 2
    variances = np.zeros((2, orders))
    variances[:, fit.fitted] = np.diag(covariance).reshape(2, -1)
    u_late, u_ratios = np.zeros(fit.heads), np.zeros(fit.heads)
    circles = np.zeros((CIRCLE_ORDERS, 2))
    gain = fit.gains()
    gain[~seen] = np.inf
    if fit.heads > 2:
        power = max(float(np.mean(np.square(combined))), LEAST_VARIANCE)
        design, _ = fit.places_equations(power)
        norms = np.linalg.norm(design, axis=0)
        of_places = np.linalg.inv((design / norms).T @ (design / norms)) / np.outer(norms, norms)
        # Like the firmware, assume for order 1 the mean noise of all orders, not the noise near
        # order 1.
        variances[:, 0] = np.diag(of_places)[:2]
        further = fit.heads - 1
        u_late[1:] = np.sqrt(np.diag(of_places)[4 : 4 + further])
        u_ratios[1:] = np.sqrt(np.diag(of_places)[4 + further :])
        gain[0] = 1.0
        circles[0, 1] = abs(fit.backward)
    for order in range(2, CIRCLE_ORDERS + 1) if fit.heads == 4 else ():
        lines = fit.lines(residuals, order)
        columns = fit.by_circles()
        found = np.linalg.lstsq(
            np.concatenate((columns.real, columns.imag)), np.concatenate((lines.real, lines.imag))
        )[0]
        circles[order - 1] = np.hypot(*found[:2]), np.hypot(*found[2:])
    return OnDevice(
        fit.disc,
        seen,
        gain,
        variances,
        fit.offsets,
        fit.late,
        fit.ratios,
        u_late,
        u_ratios,
        float(np.sqrt(variance)),
        np.sqrt(np.mean(np.square(residuals - residuals.mean(axis=0)), axis=1)),
        circles,
        _axis_turn(fit, counts_per_rev, counts[0], residuals, gain, variance, colour)
        if fit.heads == 4
        else None,
    )


def _axis_turn(
    fit: _Fit,
    counts_per_rev: int,
    counts1: NDArray[np.int64],
    residuals: Float,
    gain: Float,
    variance: float,
    colour: float,
) -> AxisTurn:
    apart = fit.offsets - fit.places
    return AxisTurn(
        fit.turned[0],
        turn_shares(counts1, counts_per_rev),
        residuals,
        fit.offsets + fit.late,
        fit.sight,
        np.angle(np.exp(1j * apart)) * ARCSEC_PER_RAD,
        complex(1j * fit.disc[0]),
        fit.backward,
        gain,
        variance,
        colour,
    )


def _colour(residual: Float, seen: NDArray[np.bool_], variance: float) -> float:
    """Return the mean power of lines near the fitted orders divided by the power of white noise."""
    power = np.abs(np.fft.fft(residual)[1:]) ** 2 / residual.size
    most = min(seen.size + NEIGHBOURS, (residual.size - 1) // 2)
    free = np.ones(most, dtype=bool)
    free[: seen.size] &= ~seen[:most]
    return float(power[:most][free][:NEIGHBOURS].mean() / variance)


def mean_orders(
    found: OnDevice, weights: Float, offsets_rad: Float, carrier: int = 0
) -> tuple[Complex, float, Float, Float]:
    """Return the orders of the mean's error as a function of the reading of the head ``carrier``,
    arcseconds, (N,).

    The further results are the error's constant, the variance of a component of each order due to
    the noise, and the variance of each order due to the uncertainties of places and radii.
    """
    disc = found.heads_on_disc
    places = offsets_rad + found.late_rad
    disc = HeadsOnDisc(disc.orders, disc.values, places, offsets_rad, found.ratios)
    reading = np.arange(READINGS, dtype=np.float64) * (2.0 * np.pi / READINGS)
    error = mean_error_arcsec(disc, weights, carrier, reading)
    lines = np.fft.rfft(error) * (2.0 / READINGS)
    factor = np.abs(order_factor(weights, places, disc.orders, found.ratios))
    amplitude = np.abs(found.disc)[:, None] * weights
    by_place = disc.orders[:, None] * amplitude * found.u_late_arcsec * RAD_PER_ARCSEC
    square = np.sum(by_place**2, axis=1)
    square[0] += np.sum((amplitude[0] * found.u_ratios) ** 2)
    return (
        np.asarray(lines[disc.orders]),
        float(error.mean()),
        factor**2 * found.variances.mean(axis=0),
        0.5 * square,
    )
