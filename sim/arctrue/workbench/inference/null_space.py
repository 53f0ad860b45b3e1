"""Finds the combinations of a model's coefficients that no row of a set determines."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from arctrue.workbench.effects.base import FitContext, Parameter
from arctrue.workbench.inference.design_matrix import Term, channel_sums
from arctrue.workbench.noise.noise import Noise
from arctrue.workbench.numeric.symmetric import RANK_TOLERANCE
from arctrue.workbench.observations import Observations

Float = NDArray[np.float64]

MOST_UNDETERMINED = 1e-3
"""Largest permitted share of a combination of coefficients that no row of the set determines. The
covariance contains no uncertainty for this share; directions count as undetermined above a
condition number of 3e4 (RANK_TOLERANCE), so that small positioning errors of the targets leave a
share below 1e-4."""
UNSEEN_WEIGHT = 1e-9
"""A column counts as rounding if its weight in the rows is at most this share of the largest
weight, the root of ``UNSEEN`` in :mod:`arctrue.workbench.numeric.symmetric`."""
ALL_CONSTANT = 1e-12
"""A column counts as a constant if, without its mean, at most this share of its sum of squares
remains. The subtraction leaves rounding of about 1e-16 times the root of the number of rows."""
SMALL_STEP = 1e-4
"""Step of a coefficient in arcseconds from which the slope of a parameter is computed: far below
the errors that the rows show, and far above rounding."""


def normal_matrix(
    terms: Sequence[Term], observations: Observations, context: FitContext, noise: Noise, size: int
) -> Float:
    """Return the normal matrix of the terms' columns over both channels, (size, size); every
    constant (of the runs, and a₀) is fitted too."""
    normal, before = np.zeros((size, size)), np.zeros(size)
    for is_capture in (True, False):
        sums = channel_sums(terms, observations, context, noise, capture=is_capture)
        if sums is None:
            continue
        # Constants (of the runs, or a₀) can replace a part of the columns, so that this part is
        # subtracted.
        own, cross = sums.gram[:size, :size], sums.gram[:size, size:]
        constants = np.diag(sums.gram)[size:]
        shrunk = np.where(constants > 0.0, constants, 1.0)
        if is_capture:
            shrunk = shrunk + 1.0 / noise.index_variance
        normal += own - (cross / shrunk) @ cross.T
        before += np.diag(own)
    constant = np.diag(normal) <= ALL_CONSTANT * before
    normal[constant, :] = 0.0
    normal[:, constant] = 0.0
    return normal


def scaled_normal(normal: Float) -> tuple[Float, Float]:
    """Return the weight of each unknown in the rows, (size,), 1 for an unknown that no row shows,
    and the normal matrix in units of these weights."""
    weight = np.sqrt(np.maximum(np.diag(normal), 0.0))
    seen = weight > UNSEEN_WEIGHT * float(weight.max(initial=0.0))
    scale = np.where(seen, weight, 1.0)
    return scale, np.where(seen[:, None] & seen[None, :], normal / np.outer(scale, scale), 0.0)


def is_null(values: Float) -> NDArray[np.bool_]:
    """Return True for eigenvalues of a scaled normal matrix whose directions are undetermined."""
    return np.asarray(values <= RANK_TOLERANCE * max(float(values.max(initial=0.0)), 1e-300))


def null_space(
    terms: Sequence[Term], observations: Observations, context: FitContext, noise: Noise, size: int
) -> tuple[Float, Float]:
    """Return the scale of each coefficient, (size,), and orthonormal directions of the scaled
    coefficients that no row of either channel shows, (size, directions)."""
    scale, scaled = scaled_normal(normal_matrix(terms, observations, context, noise, size))
    values, vectors = np.linalg.eigh(scaled)
    return scale, vectors[:, is_null(values)]


def share_of_null_space(space: tuple[Float, Float], columns: Float) -> Float:
    """Return, for each combination of the coefficients, the share that no row determines, (n,).

    ``space``: result of :func:`null_space`. ``columns`` (n, coefficients): factors of the
    coefficients in each combination, for example the model's columns at an angle. The share is the
    length of the part in the null space divided by the length of the combination, each coefficient
    in units of its weight in the rows.
    """
    scale, null = space
    scaled = columns / scale
    length = np.linalg.norm(scaled, axis=1)
    return np.asarray(np.linalg.norm(scaled @ null, axis=1) / np.where(length > 0.0, length, 1.0))


def with_undetermined(
    made: Callable[[Float], Mapping[str, Parameter]],
    coefficients: Float,
    space: tuple[Float, Float],
) -> dict[str, Parameter]:
    """Return the parameters of a term without an uncertainty (NaN) where the rows do not determine
    them.

    ``made`` calculates the parameters from the coefficients of the term, and ``space`` has the rows
    of these coefficients only. The covariance is that of the shortest solution, so that its
    uncertainties would hold only for the determined combinations of coefficients.
    """
    found = dict(made(coefficients))
    slopes = np.zeros((len(found), coefficients.size))
    for place in range(coefficients.size):
        moved = coefficients.copy()
        moved[place] += SMALL_STEP
        there = made(moved)
        slopes[:, place] = [there[name].value - item.value for name, item in found.items()]
    shares = share_of_null_space(space, slopes)
    return {
        name: replace(item, sigma=float("nan")) if share > MOST_UNDETERMINED else item
        for (name, item), share in zip(found.items(), shares, strict=True)
    }
