"""Fits the error function by least squares at the measured readings.

Let g(R) = ε(θ) be the error as a function of the *reading*. Then each head gives the disc angle
under it without approximation: θ = R₁ − g(R₁) and θ + α = R₂ − g(R₂). The difference is

    R₂ − R₁ = α + g(R₂) − g(R₁).

This equation is linear in the harmonics of g and in α, and it is exact for any steps, speed and
number of samples. The gateware subtracts g(R₁), equation (8). Only the zero of head 2 needs
iteration: the index repeats within a count from run to run, so that each run has its own constant.
R₂ is shifted by the difference between this constant and α until the result no longer changes.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from arctrue.base.units import ARCSEC_PER_RAD, arcsec_per_count
from arctrue.calibration import head_separation
from arctrue.calibration.capture_check import WholeTurns
from arctrue.calibration.combine import combined_estimate
from arctrue.calibration.estimate import Estimate
from arctrue.calibration.harmonics import powers, unit_vectors
from arctrue.calibration.transfer_function import noise_gain

Float = NDArray[np.float64]

ROUNDS_MOST = 10
CONVERGED_ARCSEC = 1e-4
"""Largest change of ε in a round at which the iteration ends."""
_BLOCK = 1 << 15


@dataclass(frozen=True)
class _Normal:
    """XᵀX, Xᵀy and yᵀy of one run; the last column is the run's constant."""

    matrix: Float
    right: Float
    square: float
    samples: int


def least_squares(
    turns: Sequence[WholeTurns],
    counts_per_rev: int,
    nominal_separation_rad: float,
    orders: Sequence[int] | NDArray[np.int64],
    separation: head_separation.Choice | None = None,
    *,
    index_detection_arcsec: float = 0.0,
    index_repeatability_counts: float | None = None,
    by_harmonics: head_separation.Separation | None = None,
) -> tuple[Estimate, list[str]]:
    """Fit ε as a function of the reading to all turns together.

    Runs are weighted by the noise of their residuals.

    Parameters
    ----------
    turns : sequence of WholeTurns
        Samples of the runs.
    counts_per_rev : int
        Counts of one turn.
    nominal_separation_rad : float
        Nominal angle α from head 1 to head 2, radians.
    orders : array_like of int, shape (orders,)
        Orders that are fitted.
    separation : str, optional
        Source of the α that sets the zero of head 2; default: the measured separation if the index
        is plausible and not less certain than the nominal value, otherwise the nominal value;
        ``harmonics`` needs ``by_harmonics``.
    index_detection_arcsec : float, optional
        Standard uncertainty of the distance between the places where the heads detect the index
        mark, arcseconds.
    index_repeatability_counts : float, optional
        Standard deviation of one head's index from run to run, counts.
    by_harmonics : Separation, optional
        Separation that was estimated from the harmonics.

    Returns
    -------
    estimate : Estimate
        The error with every order and its covariance.
    warnings : list of str
        Warnings for the user, one sentence each.
    """
    orders = np.asarray(orders, dtype=np.int64)
    unit = arcsec_per_count(counts_per_rev)
    turn_arcsec = unit * counts_per_rev
    nominal = nominal_separation_rad * ARCSEC_PER_RAD
    # The heads' counters may differ by any number of whole turns, which is subtracted.
    whole = [
        round((float(np.mean(p.head2_counts - p.head1_counts)) * unit - nominal) / turn_arcsec)
        for p in turns
    ]
    # An order that the heads do not determine at the nominal or at the measured α would make the
    # matrix singular.
    raw_rad = float(np.mean(turns[0].head2_counts - turns[0].head1_counts)) * unit / ARCSEC_PER_RAD
    hidden = ~np.isfinite(noise_gain(orders, nominal_separation_rad))
    seen = orders[~hidden & np.isfinite(noise_gain(orders, raw_rad))]
    shifts = np.zeros(len(turns))
    u_index = head_separation.u_index_rad(
        counts_per_rev, index_detection_arcsec, index_repeatability_counts
    )
    choice: head_separation.Choice = separation or "measured"
    warnings: list[str] = []
    iterations = 0
    while True:
        iterations += 1
        normals = [
            _accumulate(part, counts_per_rev, seen, nominal + turn_arcsec * k, shift)
            for part, k, shift in zip(turns, whole, shifts, strict=True)
        ]
        by_run = [_solve_one(normal) for normal in normals]
        sigmas = [_noise(normal, own) for normal, own in zip(normals, by_run, strict=True)]
        values, constants = _solve_together(normals, sigmas)
        u_constants = [s / np.sqrt(n.samples) for s, n in zip(sigmas, normals, strict=True)]
        weights = np.array([1.0 / u**2 for u in u_constants])
        measured = float(np.average(constants, weights=weights))
        if iterations == 1:
            choice, warnings = head_separation.judge(
                nominal_separation_rad,
                [(nominal + c) / ARCSEC_PER_RAD for c in constants],
                [u / ARCSEC_PER_RAD for u in u_constants],
                (nominal + measured) / ARCSEC_PER_RAD,
                counts_per_rev,
                separation,
                index_detection_arcsec,
                index_repeatability_counts,
            )
        alpha = head_separation.chosen(
            choice,
            nominal_separation_rad,
            head_separation.Separation((nominal + measured) / ARCSEC_PER_RAD, u_index),
            by_harmonics,
        )
        used = alpha.value_rad * ARCSEC_PER_RAD - nominal
        moved = constants - used - shifts
        slope = np.hypot(*np.split(values, 2)) @ seen / ARCSEC_PER_RAD
        if np.max(np.abs(moved)) * slope < CONVERGED_ARCSEC or iterations == ROUNDS_MOST:
            break
        shifts = constants - used
    own_residuals = [
        _residual(part, counts_per_rev, seen, nominal + turn_arcsec * k, shift, own)
        for part, k, shift, own in zip(turns, whole, shifts, by_run, strict=True)
    ]
    common_rms = [
        float(np.sqrt(_square_left(normal, np.append(values, constant)) / normal.samples))
        for normal, constant in zip(normals, constants, strict=True)
    ]
    estimate = combined_estimate(
        function_of="reading",
        turns=turns,
        orders=orders,
        seen=seen,
        values=values,
        information=[_without_constant(normal) for normal in normals],
        by_run=[own[:-1] for own in by_run],
        own_residuals=own_residuals,
        residual_rms_by_run=common_rms,
        used_separation_rad=alpha.value_rad,
        measured_separation_rad=(nominal + measured) / ARCSEC_PER_RAD,
        separation_by_run_rad=[(nominal + float(c)) / ARCSEC_PER_RAD for c in constants],
        separation_choice=choice,
        u_used_separation_rad=alpha.u_rad,
        u_index_rad=u_index,
        iterations=iterations,
    )
    return estimate, warnings


def _design(
    head1: NDArray[np.int64],
    head2: NDArray[np.int64],
    counts_per_rev: int,
    orders: NDArray[np.int64],
    shift_arcsec: float,
) -> Float:
    """Return the columns cos nR₂ − cos nR₁ of all orders, then the sines, then 1: (n, 2·orders +
    1)."""
    turned = np.exp(-1j * shift_arcsec / ARCSEC_PER_RAD)
    difference = powers(unit_vectors(head2, counts_per_rev) * turned, orders)
    difference -= powers(unit_vectors(head1, counts_per_rev), orders)
    number = orders.size
    design = np.empty((head1.size, 2 * number + 1), order="F")
    design[:, :number], design[:, number:-1], design[:, -1] = difference.real, difference.imag, 1.0
    return design


def _accumulate(
    part: WholeTurns,
    counts_per_rev: int,
    orders: NDArray[np.int64],
    constant_arcsec: float,
    shift_arcsec: float,
) -> _Normal:
    size = 2 * orders.size + 1
    matrix, right, square = np.zeros((size, size)), np.zeros(size), 0.0
    for start in range(0, part.samples, _BLOCK):
        block = slice(start, start + _BLOCK)
        head1, head2 = part.head1_counts[block], part.head2_counts[block]
        design = _design(head1, head2, counts_per_rev, orders, shift_arcsec)
        y = (head2 - head1) * arcsec_per_count(counts_per_rev) - constant_arcsec
        matrix += design.T @ design
        right += design.T @ y
        square += float(y @ y)
    return _Normal(matrix, right, square, part.samples)


def _residual(
    part: WholeTurns,
    counts_per_rev: int,
    orders: NDArray[np.int64],
    constant_arcsec: float,
    shift_arcsec: float,
    values: Float,
) -> Float:
    residual = np.empty(part.samples)
    for start in range(0, part.samples, _BLOCK):
        block = slice(start, start + _BLOCK)
        head1, head2 = part.head1_counts[block], part.head2_counts[block]
        design = _design(head1, head2, counts_per_rev, orders, shift_arcsec)
        y = (head2 - head1) * arcsec_per_count(counts_per_rev) - constant_arcsec
        residual[block] = y - design @ values
    return residual


def _square_left(normal: _Normal, x: Float) -> float:
    """Return |y − Xx|² of a run."""
    left = normal.square - 2.0 * x @ normal.right + x @ normal.matrix @ x
    return max(float(left), 0.0)


def _noise(normal: _Normal, own: Float) -> float:
    """Return the standard deviation of a run's noise, from the residual after a fit of this run
    alone."""
    free = max(normal.samples - own.size, 1)
    # The lower limit prevents a division by zero if the residual is exactly zero.
    return float(np.sqrt(max(_square_left(normal, own) / free, 1e-18)))


def _solve(matrix: Float, right: Float) -> Float:
    norms = np.sqrt(np.diag(matrix))
    solution = np.linalg.lstsq(matrix / np.outer(norms, norms), right / norms)[0]
    return np.asarray(solution / norms)


def _solve_one(normal: _Normal) -> Float:
    """Solve one run alone; its constant is the last value."""
    return _solve(normal.matrix, normal.right)


def _solve_together(normals: Sequence[_Normal], sigmas: Sequence[float]) -> tuple[Float, Float]:
    """Solve for the runs' common harmonics (2·orders,) and a constant for each run, arcseconds."""
    runs = len(normals)
    shared = normals[0].right.size - 1
    matrix, right = np.zeros((shared + runs,) * 2), np.zeros(shared + runs)
    for run, (normal, sigma) in enumerate(zip(normals, sigmas, strict=True)):
        own = np.append(np.arange(shared), shared + run)
        matrix[np.ix_(own, own)] += normal.matrix / sigma**2
        right[own] += normal.right / sigma**2
    solution = _solve(matrix, right)
    return solution[:shared], solution[shared:]


def _without_constant(normal: _Normal) -> Float:
    """Return the information about the harmonics if the run's constant is unknown: the Schur
    complement of XᵀX."""
    last = normal.matrix[:-1, -1]
    return np.asarray(normal.matrix[:-1, :-1] - np.outer(last, last) / normal.matrix[-1, -1])
