"""Tests effects that the offsets of a capture's runs show against noise slower than the runs.

The fit treats the offsets as independent, with the variance of the index. Noise slower than the
runs continues over the pauses and gives the runs nearly equal offsets, as a wrong angle between the
heads does. The test adds the covariance of this noise to that of the index. The runs do not
determine level and exponent of this noise: p is a mean over both, weighted by the restricted
likelihood of the offsets with the effect in the model (Patterson and Thompson, Biometrika 58 (1971)
545).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.special import fdtrc

from arctrue.base.runs import run_spans
from arctrue.workbench.effects.base import Effect, Nonlinear
from arctrue.workbench.inference.residuals import Residuals
from arctrue.workbench.inference.significance import MANY
from arctrue.workbench.noise.slower_noise import correlation_of_means, slower_noise
from arctrue.workbench.numeric.least_squares import Matrix
from arctrue.workbench.numeric.symmetric import log_determinant, solve_symmetric
from arctrue.workbench.observations.rows import CaptureRows

EXPONENTS = (0.0, 0.5, 1.0, 1.5, 2.0)
"""Equally probable exponents of the spectrum below the runs' frequency: from white noise (0) over
flicker noise (1) to a random walk (2)."""
LEVELS = 5
"""Number of levels of the noise, the nodes of a Gauss–Hermite quadrature: exact for polynomials of
the logarithm up to order 9."""
OFFSETS_DECIDE = 0.5
"""Smallest share of the offsets in the variance of an effect's size at which the offsets decide;
with a smaller share the rows decide."""


@dataclass(frozen=True)
class _System:
    """Normal equations of run offsets and an effect; the model's other unknowns are eliminated."""

    normal: Matrix
    """Normal matrix of the offsets, without the information of the index, (runs, runs)."""
    moment: Matrix
    cross: Matrix
    """Products of the offsets with the effect's columns, (runs, k)."""
    information: Matrix
    """Normal matrix of the effect's columns, (k, k)."""
    effect_moment: Matrix
    offsets: Matrix
    """Offsets of the solution, arcseconds, (runs,)."""


def p_in_slower_noise(base: Residuals, effect: Effect, nonlinear: Nonlinear) -> float:
    """Return p of an effect that the offsets of the runs decide; 0 if they do not decide, or if the
    capture shows no slow noise.

    ``base``: the model without the effect, whitened with the noise of the model with the effect.
    """
    rows, noise = base.observations.capture, base.solution.noise
    if rows is None or rows.runs == 0 or noise.capture is None or noise.capture.weightless:
        return 0.0
    first, last = _times(rows)
    slow = slower_noise(noise, float(last.max() - first.min()))
    if slow is None or base.score(effect, nonlinear).rank == 0:
        return 0.0
    system = _system(base, effect, nonlinear)
    shapes = [
        _of_offsets(base, correlation_of_means(first, last, constant))
        for constant in slow.constants_s.tolist()
    ]
    known = noise.index_variance * np.eye(rows.runs)
    nodes, shares = np.polynomial.hermite_e.hermegauss(LEVELS)
    found = []
    for exponent in EXPONENTS:
        variances = slow.variances(exponent)
        spread = sum(one * shape for one, shape in zip(variances, shapes, strict=True))
        for node, share in zip(nodes.tolist(), shares.tolist(), strict=True):
            level = float(np.exp(slow.deviation * node))
            case = _tested(system, known + level * spread, base)
            found.append((float(np.log(share)) + case[0], *case[1:]))
    logs, p_values, decided = np.array(found).T
    weights = np.exp(logs - logs.max())
    weights /= weights.sum()
    return float(weights @ p_values) if weights @ decided >= OFFSETS_DECIDE else 0.0


def _times(rows: CaptureRows) -> tuple[Matrix, Matrix]:
    """Return the times of the first and last row of each recorded run, seconds."""
    first, last = np.zeros(rows.runs), np.zeros(rows.runs)
    for start, end in run_spans(rows.run):
        first[rows.run[start]], last[rows.run[start]] = rows.time_s[start], rows.time_s[end - 1]
    return first[:: rows.channels], last[:: rows.channels]


def _of_offsets(base: Residuals, correlation: Matrix) -> Matrix:
    """Return the covariance of the offsets from the correlation between the recorded runs.

    The noise of different channels is independent, and each run has the scale of its noise.
    """
    rows, law = base.observations.capture, base.solution.noise.capture_law
    assert rows is not None
    found = np.kron(correlation, np.eye(rows.channels))
    if law is not None and law.runs.size == rows.runs:
        found *= np.outer(law.run_scale, law.run_scale)
    weights = rows.offset_weights
    if weights is not None:
        back = np.kron(np.eye(correlation.shape[0]), np.linalg.inv(weights))
        found = back @ found @ back.T
    return np.asarray(found)


def _system(base: Residuals, effect: Effect, nonlinear: Nonlinear) -> _System:
    layout, normal, moment = base.joint_system
    solution, cross = base.solution, base.score(effect, nonlinear).cross
    offsets = np.arange(layout.shared, layout.shared + layout.runs)
    others = np.setdiff1d(np.arange(layout.size), offsets)
    known = 1.0 / solution.noise.index_variance
    _, inverse, _, _ = solve_symmetric(normal[np.ix_(others, others)], np.zeros(others.size))
    back = inverse @ normal[np.ix_(others, offsets)]
    of_cross = inverse @ cross[others]
    information = -cross[others].T @ of_cross
    of_effect = -of_cross.T @ moment[others]
    for columns, left in zip(
        base.whitened_columns(effect, nonlinear),
        (base.capture_whitened, base.reference_whitened),
        strict=True,
    ):
        if columns is not None and left is not None:
            information = information + columns.T @ columns
            of_effect = of_effect + columns.T @ left
    of_offsets = normal[np.ix_(offsets, offsets)] - known * np.eye(offsets.size)
    return _System(
        of_offsets - normal[np.ix_(offsets, others)] @ back,
        moment[offsets] + known * solution.run_offsets_arcsec - back.T @ moment[others],
        cross[offsets] - back.T @ cross[others],
        information,
        of_effect,
        solution.run_offsets_arcsec,
    )


def _tested(system: _System, covariance: Matrix, base: Residuals) -> tuple[float, float, float]:
    """Return the restricted log likelihood with the effect in the model, p of the effect, and the
    share of the offsets in the variance of its size."""
    noise = base.solution.noise
    precision = np.linalg.inv(covariance)
    normal = system.normal + precision
    inverse = np.linalg.inv(normal)
    pull = precision @ system.offsets
    moment = system.moment - pull
    information = system.information - system.cross.T @ inverse @ system.cross
    of_effect = system.effect_moment - system.cross.T @ (inverse @ moment)
    size, _, rank, _ = solve_symmetric(information, of_effect)
    gain = max(float(of_effect @ size), 1e-300)
    left = float(system.offsets @ pull) - float(moment @ inverse @ moment) - gain
    logs = float(np.linalg.slogdet(covariance)[1] + np.linalg.slogdet(normal)[1])
    logs += log_determinant(information)
    moved = inverse @ (system.cross @ size)
    of_index = noise.index_variance * float(np.sum((precision @ moved) ** 2)) / gain
    known = noise.index_freedom + moved.size
    freedom = min(known / max(of_index**2, 1e-12), MANY)
    p_value = float(fdtrc(rank, freedom, gain / rank)) if rank else 1.0
    return -0.5 * (left + logs), p_value, float(moved @ precision @ moved) / gain


__all__ = ["p_in_slower_noise"]
