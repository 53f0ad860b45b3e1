"""Fits disc, places, radii, motion of the axis and offsets of two to four heads together.

Every sample has an unknown true angle, so that only combinations of the readings whose weights have
the sum 0 contain information. The fit weights these combinations by their estimated covariance
(generalised least squares): if the axis also has motion that does not repeat, the parity of four
heads has the largest weight. If motion is unknown at every order, only the parity is used, because
it contains no translation of the axis. Prior knowledge enters as observations: the mounted places,
one place of the index mark for all heads, and the manufactured radii. The fit is refused if an
unknown remains undetermined.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from arctrue.base.units import ARCSEC_PER_RAD, RAD_PER_ARCSEC, arcsec_per_count
from arctrue.calibration.capture_check import WholeTurns
from arctrue.calibration.harmonics import unit_vectors
from arctrue.calibration.head_separation import BELIEVABLE_ARCSEC
from arctrue.calibration.head_weights import parity_weights
from arctrue.calibration.heads_columns import HeadSees, Layout, State
from arctrue.calibration.heads_data import HeadsData, HeadsSettings, late_beforehand, precision_of
from arctrue.calibration.heads_estimate import HeadsEstimate
from arctrue.calibration.heads_gain import order_gain
from arctrue.calibration.noise import ResidualSpectrum
from arctrue.generated.number_formats import HEADS_MAX

Float = NDArray[np.float64]
Integer = NDArray[np.int64]

LOW_MOTION_ORDERS = tuple(range(1, 9))
LOW_ORDERS = 24
"""Highest order of the disc in the first fit, if motion is unknown at every order; this fit
contains motion of the axis at LOW_MOTION_ORDERS only.
"""
SEARCH_SAMPLES = 36_000
"""Approximate number of samples used until places and weights have settled; in captures of at least
twice this number, every k-th sample is used."""
ROUNDS_MOST = 6
CONVERGED_ARCSEC = 1e-4
"""Largest change of any prediction, approximately, at which the iteration ends."""
LEAST_EIGENVALUE = 1e-11
"""Smallest eigenvalue of the normal matrix scaled to a diagonal of 1; a smaller eigenvalue is a
rounding error."""


class SingularHeadsError(ValueError):
    """These heads do not determine the requested unknowns."""


def heads_least_squares(
    turns: Sequence[WholeTurns],
    counts_per_rev: int,
    nominal_places_rad: Sequence[float],
    settings: HeadsSettings,
) -> HeadsEstimate:
    """Fit all ``turns`` together.

    Raises SingularHeadsError for unknowns that these heads do not determine, and ValueError for a
    run with another number of heads than places.
    """
    data = HeadsData(turns, counts_per_rev, np.asarray(nominal_places_rad, dtype=np.float64))
    _refuse_at_once(data, settings)
    thinned = data.thinned(SEARCH_SAMPLES, int(np.max(settings.orders)))
    state, combinations, known = _searched(thinned, settings)
    state, information = _converged(data, state, combinations, settings, known=known)
    return _estimate(data, state, combinations, information, settings)


def _searched(data: HeadsData, settings: HeadsSettings) -> tuple[State, Float, _Known | None]:
    """Return the state of all unknowns, and combinations of the readings with noise of variance 1.
    If the combinations do not contain order 1 of the disc, also return order 1 as a known value."""
    if settings.motion != "every":
        state, combinations = _first_fit(data, settings, tuple(settings.motion))
        return *_settled(data, state, combinations, settings), None
    # The parity contains neither order 1 nor the offsets; a first fit of low orders, with other
    # combinations, determines both.
    orders = np.asarray(settings.orders)
    low = replace(settings, orders=orders[orders <= LOW_ORDERS])
    state, combinations = _first_fit(data, low, LOW_MOTION_ORDERS)
    state, information = _converged(data, state, combinations, low)
    known = _Known.of_first_order(state, information)
    state = data.state_of(_seen_orders(data, settings), (), state)
    known = known.in_layout(state.layout)
    parity = parity_weights(state.places_rad(0), state.radius_ratios)[None, :]
    state, _ = _solved(data, state, parity, settings, with_geometry=False, known=known)
    parity = parity / np.sqrt(_residual_covariance(data, state, parity)[0, 0])
    return *_settled(data, state, parity, settings, known), known


def _settled(
    data: HeadsData,
    state: State,
    combinations: Float,
    settings: HeadsSettings,
    known: _Known | None = None,
) -> tuple[State, Float]:
    """Return the converged state for thinned data. For complete data return ``state`` unchanged,
    because the last fit iterates over the same data."""
    if data.part_of_all:
        state, _ = _converged(data, state, combinations, settings, known=known)
    return state, combinations


def _seen_orders(data: HeadsData, settings: HeadsSettings) -> Integer:
    """Return the requested orders that these heads determine. With three heads or more, order 1 is
    one of them, because the first fit determines it."""
    orders = np.asarray(settings.orders)
    seen = np.isfinite(order_gain(data.nominal_rad, orders, settings.motion))
    return np.asarray(orders[seen | ((orders == 1) & (data.heads > 2))])


def _first_fit(
    data: HeadsData, settings: HeadsSettings, motion_orders: tuple[int, ...]
) -> tuple[State, Float]:
    """Fit the disc with the places as mounted. Return the state, and combinations of the readings
    with noise of variance 1."""
    state = data.first_state(settings, _seen_orders(data, settings), motion_orders)
    # Without a disc error the derivatives by the places are 0, so places and radii are fitted from
    # the second round on.
    combinations = _combinations_of_rotation(data.heads)
    state, _ = _solved(data, state, combinations, settings, with_geometry=False)
    return state, _whitened(data, state, combinations)


@dataclass(frozen=True)
class _Known:
    """Values from another fit of the same data, with their information matrix."""

    columns: Integer
    values: Float
    precision: Float

    @classmethod
    def of_first_order(cls, state: State, information: Float) -> _Known:
        """Take order 1 of the disc from the first fit. The parity does not contain this order, but
        the fit of places and radii needs it."""
        orders = state.layout.orders
        first = np.flatnonzero(orders == 1)
        columns = np.concatenate((first, first + orders.size))
        shared = state.layout.size
        covariance = np.linalg.pinv(information)[:shared, :shared]
        precision = np.linalg.inv(covariance[np.ix_(columns, columns)])
        return cls(columns, state.values[columns], np.asarray(precision))

    def in_layout(self, layout: Layout) -> _Known:
        """Return the same values with their columns in another layout."""
        first = np.flatnonzero(layout.orders == 1)
        return replace(self, columns=np.concatenate((first, first + layout.orders.size)))


def _combinations_of_rotation(heads: int) -> Float:
    """Return orthonormal combinations of the readings, each with weights of sum 0, (heads − 1,
    heads)."""
    return np.asarray(np.linalg.svd(np.ones((1, heads)))[2][1:])


def _rows(
    data: HeadsData, state: State, combinations: Float
) -> Iterator[tuple[int, Float, list[Float]]]:
    """Yield for each block the run's index, residuals and derivatives.

    Residuals are (n, m); the derivatives of every combination are (n, columns).
    """
    for run, seen, apart in _seen(data, state):
        expected = np.stack([one.expected for one in seen])
        derivatives = []
        for weights in combinations:
            total = weights[0] * seen[0].columns
            for weight, one in zip(weights[1:], seen[1:], strict=True):
                total += weight * one.columns
            derivatives.append(total)
        yield run, (apart - expected).T @ combinations.T, derivatives


def _seen(data: HeadsData, state: State) -> Iterator[tuple[int, list[HeadSees], Float]]:
    """Yield for each block the run's index, the expected reading error of every head with its
    derivatives, and the readings minus head 1's reading and minus the offsets, (heads, n)."""
    unit = arcsec_per_count(data.counts_per_rev)
    for run, counts in data.blocks():
        offsets = state.offsets_rad[run] * ARCSEC_PER_RAD
        turned = [
            unit_vectors(one, data.counts_per_rev) * np.exp(1j * shift)
            for one, shift in zip(counts, state.late_rad, strict=True)
        ]
        # The differences are small, so that float64 is exact enough.
        apart = np.stack([(one - counts[0]) * unit for one in counts]) - offsets[:, None]
        angle = np.angle(turned[0])
        if state.layout.motion_orders:
            angle = angle - _disc_alone(state, turned[0]) * RAD_PER_ARCSEC
        yield (
            run,
            [state.of_head(head, run, turned[head], angle) for head in range(data.heads)],
            apart,
        )


def _disc_alone(state: State, turned: NDArray[np.complex128]) -> Float:
    layout = state.layout
    cosine, sine = np.split(state.values[layout.disc], 2)
    phase = np.multiply.outer(np.angle(turned), layout.orders)
    return np.asarray(np.cos(phase) @ cosine + np.sin(phase) @ sine)


def _solved(
    data: HeadsData,
    state: State,
    combinations: Float,
    settings: HeadsSettings,
    *,
    with_geometry: bool = True,
    known: _Known | None = None,
) -> tuple[State, Float]:
    """Return the state after one Gauss-Newton step, and the information about all unknowns."""
    layout, runs, further = state.layout, len(data.turns), data.heads - 1
    shared = layout.size
    size = shared + runs * further
    matrix, right = np.zeros((size, size)), np.zeros(size)
    for run, residual, derivatives in _rows(data, state, combinations):
        own = shared + run * further + np.arange(further)
        for index, (weights, part) in enumerate(zip(combinations, derivatives, strict=True)):
            matrix[:shared, :shared] += part.T @ part
            right[:shared] += part.T @ residual[:, index]
            of_offset = np.multiply.outer(part.sum(axis=0), weights[1:])
            matrix[:shared, own] += of_offset
            matrix[own, :shared] += of_offset.T
            matrix[np.ix_(own, own)] += residual.shape[0] * np.outer(weights[1:], weights[1:])
            right[own] += weights[1:] * residual[:, index].sum()
    beforehand, precision = late_beforehand(
        data.nominal_rad, state.offsets_rad.mean(axis=0), settings
    )
    late, radius = np.arange(size)[layout.late], np.arange(size)[layout.radius]
    matrix[late, late] += precision
    right[late] += precision * (beforehand - state.values[layout.late])
    of_radius = precision_of(settings.u_radius)
    matrix[radius, radius] += of_radius
    right[radius] -= of_radius * state.values[layout.radius]
    if known is not None:
        matrix[np.ix_(known.columns, known.columns)] += known.precision
        right[known.columns] += known.precision @ (known.values - state.values[known.columns])
    free = np.ones(size, dtype=bool)
    if not with_geometry:
        free[late] = free[radius] = False
    if settings.u_radius == 0.0:
        free[radius] = False
    if settings.u_place_arcsec == 0.0:
        free[late] = False
    if combinations.shape[0] == 1 and data.heads > 2:
        # A single combination determines one offset; the other offsets keep the values of the first
        # fit.
        free[shared:] = False
        free[shared + further - 1 :: further] = True
    step = np.zeros(size)
    step[free] = _least(matrix[np.ix_(free, free)], right[free])
    offsets = state.offsets_rad.copy()
    offsets[:, 1:] += step[shared:].reshape(runs, further) * RAD_PER_ARCSEC
    information = np.where(np.outer(free, free), matrix, 0.0)
    moved = replace(state, values=state.values + step[:shared], offsets_rad=offsets)
    return moved, information


def _least(matrix: Float, right: Float) -> Float:
    norms = np.sqrt(np.diag(matrix))
    norms[norms == 0.0] = 1.0
    scaled = matrix / np.outer(norms, norms)
    return np.asarray(np.linalg.lstsq(scaled, right / norms, rcond=LEAST_EIGENVALUE)[0] / norms)


def _converged(
    data: HeadsData,
    state: State,
    combinations: Float,
    settings: HeadsSettings,
    known: _Known | None = None,
) -> tuple[State, Float]:
    """Iterate until a step changes every prediction by less than CONVERGED_ARCSEC, at most
    ROUNDS_MOST times.

    Return the state, and the information matrix of the last step.
    """
    for _ in range(ROUNDS_MOST):
        before = state
        state, information = _solved(data, state, combinations, settings, known=known)
        moved = state.values - before.values
        disc = np.linalg.norm(before.values[before.layout.disc])
        # A change of a place or radius changes the prediction only in proportion to the disc's
        # error.
        geometry = disc * (
            np.linalg.norm(moved[before.layout.late]) * RAD_PER_ARCSEC
            + np.linalg.norm(moved[before.layout.radius])
        )
        if np.linalg.norm(moved[: before.layout.late.start]) + geometry < CONVERGED_ARCSEC:
            break
    return state, information


def _residual_covariance(data: HeadsData, state: State, combinations: Float) -> Float:
    """Return the covariance of the combinations about their expectation, arcseconds², (m, m)."""
    residual = np.concatenate(_residuals(data, state, combinations), axis=0)
    return np.asarray(residual.T @ residual / data.samples)


def _whitened(data: HeadsData, state: State, combinations: Float) -> Float:
    """Return the combinations rotated and scaled so that each has noise of variance 1."""
    covariance = _residual_covariance(data, state, combinations)
    # The small variance prevents a division by zero if the readings have no noise.
    covariance += 1e-18 * np.eye(covariance.shape[0])
    return np.asarray(np.linalg.solve(np.linalg.cholesky(covariance), combinations))


def _refuse_at_once(data: HeadsData, settings: HeadsSettings) -> None:
    if settings.motion == "every":
        if data.heads < 4:
            raise SingularHeadsError(
                f"{data.heads} heads cannot separate the disc from a motion of the axis that is "
                "unknown at every order: this needs four heads; with fewer, give the orders at "
                "which the "
                "axis moves"
            )
        if np.isinf(settings.u_place_arcsec):
            raise SingularHeadsError(
                "the places of the heads cannot be determined if the motion of the axis is "
                "unknown at every order: the orders of the disc fit any places. Give the places as "
                "mounted with their standard uncertainty, or the orders at which the axis moves"
            )
    elif np.isinf(settings.u_place_arcsec) and data.heads == 2 and settings.motion:
        raise SingularHeadsError("two heads cannot separate a motion of the axis from the disc")


def _estimate(
    data: HeadsData,
    state: State,
    combinations: Float,
    information: Float,
    settings: HeadsSettings,
) -> HeadsEstimate:
    layout = state.layout
    size = information.shape[0]
    free = np.diag(information) > 0.0
    norms = np.sqrt(np.diag(information)[free])
    scaled = information[np.ix_(free, free)] / np.outer(norms, norms)
    values, vectors = np.linalg.eigh(scaled)
    if values[0] < LEAST_EIGENVALUE:
        worst = int(np.flatnonzero(free)[np.argmax(np.abs(vectors[:, 0]))])
        raise SingularHeadsError(_undetermined(layout, worst))
    covariance = np.zeros((size, size))
    inverse = (vectors / values) @ vectors.T / np.outer(norms, norms)
    residuals = _residuals(data, state, combinations)
    spread = np.sqrt(np.mean(np.square(np.concatenate(residuals))))
    inverse *= max(float(spread), 1e-9) ** 2
    covariance[np.ix_(free, free)] = inverse
    stretch = np.ones(size)
    if layout.orders.size:
        colour = _colour(data, residuals, layout.orders)
        stretch[layout.disc] = np.tile(np.sqrt(colour), 2)
    covariance *= np.outer(stretch, stretch)
    u_late = np.sqrt(np.diag(covariance)[layout.late])
    if np.any(u_late > BELIEVABLE_ARCSEC):
        raise SingularHeadsError(
            "the data do not determine where the heads stand: the standard uncertainty of head "
            f"{int(np.argmax(u_late)) + 2} would be {u_late.max():.0f}″. Give the places as "
            "mounted with their standard uncertainty, or fewer orders at which the axis moves"
        )
    return HeadsEstimate(
        asked_orders=np.asarray(settings.orders),
        state=state,
        covariance=covariance,
        motion=settings.motion,
        combinations=combinations,
        samples=data.samples,
        turns=sum(part.turns for part in data.turns),
        noise_arcsec=_noise(data, state),
    )


def _residuals(data: HeadsData, state: State, combinations: Float) -> list[Float]:
    """Return the residuals of every run, each (samples of the run, m)."""
    by_run: list[list[Float]] = [[] for _ in data.turns]
    for run, seen, apart in _seen(data, state):
        expected = np.stack([one.expected for one in seen])
        by_run[run].append((apart - expected).T @ combinations.T)
    return [np.concatenate(parts) for parts in by_run]


def _colour(data: HeadsData, residuals: Sequence[Float], orders: Integer) -> Float:
    """Return the power of the residual near each order divided by the power of white noise of the
    same variance."""
    pairs = [(part, row) for part, one in zip(data.turns, residuals, strict=True) for row in one.T]
    sigmas = np.array([max(float(np.std(row)), 1e-18) for _, row in pairs])
    scaled = [row / sigma for (_, row), sigma in zip(pairs, sigmas, strict=True)]
    return ResidualSpectrum([part for part, _ in pairs], scaled, sigmas, orders).at(orders)


def _noise(data: HeadsData, state: State) -> float:
    """Return the standard deviation of one reading, from the residuals of the combinations that
    motion affects least."""
    combinations = _combinations_of_rotation(data.heads)
    if data.heads == HEADS_MAX:
        combinations = parity_weights(state.places_rad(0), state.radius_ratios)[None, :]
    residuals = np.concatenate(_residuals(data, state, combinations))
    return float(np.sqrt(np.mean(np.var(residuals, axis=0))))


def _undetermined(layout: Layout, column: int) -> str:
    if column < layout.disc.stop:
        what = f"order {layout.orders[column % layout.orders.size]} of the disc"
    elif column < layout.motion.stop:
        order, sense = layout.motion_parts[(column - layout.motion.start) // 2]
        circle = "forward" if sense == 1 else "backward"
        what = f"the {circle} circle of the axis at order {order}"
    elif column < layout.late.stop:
        what = f"the place of head {column - layout.late.start + 2}"
    elif column < layout.radius.stop:
        what = f"the radius of head {column - layout.radius.start + 2}"
    else:
        what = "the offset of a head"
    return (
        f"{layout.heads} heads do not determine {what} together with everything else that is "
        "unknown: leave out orders of motion or of the disc, or give places and radii with their "
        "standard uncertainty"
    )
