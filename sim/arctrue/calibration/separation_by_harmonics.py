"""Estimates α from the harmonics that both the two heads and the reference determine.

An α that is wrong by Δα makes the two-head estimate of order n wrong by dE_n/dα · Δα. The reference
shows this error, so that each order determines Δα; orders with a large n·|TF(n)|·A_n determine it
best. Each order is weighted by the inverse of its variance. The reference's own standard
uncertainty applies in full to every order and is not divided by the number of its rows. Otherwise a
first order that only the reference has (``polygon_eccentricity``) would be attributed to an error
of α.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from arctrue.base.units import RAD_PER_ARCSEC
from arctrue.calibration.comparison import reading_counts
from arctrue.calibration.estimate import Estimate
from arctrue.calibration.harmonics import powers, unit_vectors
from arctrue.calibration.head_separation import BELIEVABLE_ARCSEC, Separation
from arctrue.calibration.transfer_function import separation_slope
from arctrue.measurement.measurement_set import Reference

Float = NDArray[np.float64]

LARGEST_CONDITION = 1e4
"""Largest accepted condition number of the reference's normal matrix; stations that are spread
evenly over the turn have about 1."""
_BLOCK = 1 << 15


def separation_by_harmonics(
    estimate: Estimate, reference: Reference, counts_per_rev: int
) -> Separation:
    """Return the α at which the two heads agree best with the reference, by weighted least squares.

    ``estimate`` is a function of the reading. If α cannot be determined, the standard uncertainty
    is infinite and the note states the reason.
    """
    u_reference = reference.standard_uncertainty_arcsec
    if u_reference is None:
        return _none("reference.standard_uncertainty_arcsec is not given")
    places = np.unique(np.round(np.remainder(reference.target_deg, 360.0), 3)).size
    most = min((places - 1) // 2, int(estimate.orders.max()))
    orders = np.arange(1, most + 1)
    orders = orders[np.isin(orders, estimate.orders[np.isfinite(estimate.noise_gain)])]
    if orders.size == 0:
        return _none(f"the reference has {places} stations")
    solved = _left_in_reference(estimate, reference, counts_per_rev, orders)
    if solved is None:
        return _none("the reference's stations do not lie all round the turn")
    left, variance = solved

    alpha = estimate.head_separation_rad
    both = np.concatenate((orders - 1, orders - 1 + estimate.orders.size))
    slope = separation_slope(orders, estimate.values[both], alpha)
    # The part of the estimate's variance that α causes is subtracted, because α is the unknown
    # here.
    of_alpha = np.abs(slope) ** 2 / 2.0 * estimate.u_head_separation_rad**2
    of_heads = np.maximum(estimate.u_component_arcsec[orders - 1] ** 2 - of_alpha, 0.0)
    weight = 1.0 / (u_reference**2 + variance + of_heads)
    information = float(weight @ np.abs(slope) ** 2)
    if information == 0.0:
        return _none("there is no order")
    off = float(weight @ (slope.conj() * left).real) / information
    if abs(off) > BELIEVABLE_ARCSEC * RAD_PER_ARCSEC:
        return _none("heads and reference differ by more than any mounting of the heads explains")
    square = float(weight @ np.abs(left - slope * off) ** 2) / max(2 * orders.size - 1, 1)
    return Separation(alpha + off, float(np.sqrt(max(square, 1.0) / information)))


def _none(note: str) -> Separation:
    return Separation(np.nan, np.inf, note)


def _left_in_reference(
    estimate: Estimate, reference: Reference, counts_per_rev: int, orders: NDArray[np.int64]
) -> tuple[NDArray[np.complex128], Float] | None:
    """Fit the orders to the reference's error minus the estimate. Return cosine − j·sine,
    (orders,), and the variance of a component from the scatter of the rows; None if the stations do
    not determine the orders."""
    counts = reading_counts(reference, counts_per_rev)
    reading = np.remainder(counts, counts_per_rev) * (2.0 * np.pi / counts_per_rev)
    y = reference.error_arcsec - estimate.error_arcsec(reading)
    size = 2 * orders.size + 1
    gram, moment = np.zeros((size, size)), np.zeros(size)
    for start in range(0, counts.size, _BLOCK):
        part = slice(start, start + _BLOCK)
        vectors = powers(unit_vectors(counts[part], counts_per_rev), orders)
        design = np.column_stack((vectors.real, vectors.imag, np.ones(vectors.shape[0])))
        gram += design.T @ design
        moment += design.T @ y[part]
    scale = np.sqrt(np.diag(gram))
    if not scale.all() or np.linalg.cond(gram / np.outer(scale, scale)) > LARGEST_CONDITION:
        return None
    found = np.linalg.solve(gram, moment)
    square = max(float(y @ y - found @ moment), 0.0) / max(y.size - size, 1)
    variance = np.diag(np.linalg.inv(gram))[:-1].reshape(2, -1).mean(axis=0) * square
    number = orders.size
    return found[:number] - 1j * found[number:-1], variance
