"""The fit of a model to both channels: generalised least squares with the noise as a part of it.

y = X·b + run offsets + noise. The offsets of the runs are random with the index repeatability as
their variance, so that what lives on the level of runs is judged against the runs; the noise of
the rows is white, coloured and uneven as the set shows it (:mod:`arctrue.workbench.noise`).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from arctrue.workbench.effects.base import FitContext
from arctrue.workbench.inference.known_noise import fit_with_noise
from arctrue.workbench.inference.noise_fit import estimated_noise
from arctrue.workbench.inference.normal_equations import Term
from arctrue.workbench.inference.solution import Solution
from arctrue.workbench.noise.noise import Noise
from arctrue.workbench.observations import Observations

INDEX_ROUNDS = 4


def fit(
    terms: Sequence[Term],
    observations: Observations,
    context: FitContext | None = None,
    *,
    noise: Noise | None = None,
    every_row: bool = False,
) -> Solution:
    """Fit terms whose search parameters are settled; columns that depend on the model iterate.

    Without ``noise`` it is estimated with the coefficients. ``every_row``: all rows of a long
    set, not only the part that the statistics work on.
    """
    if noise is not None:
        return fit_with_noise(terms, observations, context, noise, every_row=every_row)
    noise, unknown = estimated_noise(terms, observations, context or FitContext())
    found = fit_with_noise(
        terms, observations, context, noise, every_row=every_row, index_rounds=INDEX_ROUNDS
    )
    return replace(found, unknown_noise=unknown)
