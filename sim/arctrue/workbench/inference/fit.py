"""Fits a model to both channels: generalised least squares with the noise as a part of the model.

y = X·b + run offsets + noise. The offsets of the runs are random, and the repeatability of the
index mark determines their variance. The significance of an effect that differs only between runs
therefore follows from the scatter between runs. The noise of the rows has white and coloured parts
and may have a different size in different rows; it is estimated from the set
(:mod:`arctrue.workbench.noise`).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from arctrue.workbench.effects.base import FitContext
from arctrue.workbench.inference.design_matrix import (
    Term,
    channel_columns,
    channel_sums,
    every_row_sums,
    term_widths,
    whitened_rows,
)
from arctrue.workbench.inference.solution import Solution, context_of, solve
from arctrue.workbench.noise.fit import estimated_noise
from arctrue.workbench.noise.noise import Noise
from arctrue.workbench.numeric.least_squares import ChannelSums, Matrix, WhitenedRows
from arctrue.workbench.observations import Observations

INDEX_ROUNDS = 4
"""Number of rounds in which the variance of the run offsets is estimated and the fit is repeated;
each round changes only the weight of the run offsets."""


@dataclass(frozen=True)
class ModelDesign:
    """The design matrix of some terms, in the form that the estimate of the noise needs."""

    terms: Sequence[Term]
    observations: Observations
    context: FitContext

    @property
    def shared(self) -> int:
        """Number of coefficients of the terms."""
        return sum(term_widths(self.terms, self.observations))

    def columns(self, *, capture: bool) -> Matrix:
        """Return the columns of a channel, shape (rows, shared), arcseconds."""
        return channel_columns(self.terms, self.observations, self.context, capture=capture)

    def whitened(self, noise: Noise, *, capture: bool) -> WhitenedRows | None:
        """Return the columns of a channel, whitened by ``noise``; None if the set lacks that
        channel."""
        return whitened_rows(self.terms, self.observations, self.context, noise, capture=capture)

    def sums(self, noise: Noise, *, capture: bool) -> ChannelSums | None:
        """Return the sums of least squares over the rows of a channel; None if the set lacks that
        channel."""
        return channel_sums(self.terms, self.observations, self.context, noise, capture=capture)

    def residuals(
        self, noise: Noise
    ) -> tuple[NDArray[np.float64] | None, NDArray[np.float64] | None]:
        """Return the residuals of the fit with this noise, (capture, reference), arcseconds."""
        solution = fit(self.terms, self.observations, self.context, noise=noise)
        return solution.capture_residual_arcsec(), solution.reference_residual_arcsec()


def fit(
    terms: Sequence[Term],
    observations: Observations,
    context: FitContext | None = None,
    *,
    noise: Noise | None = None,
    every_row: bool = False,
) -> Solution:
    """Fit terms with given search parameters; repeat the fit if columns depend on the model.

    If ``noise`` is not given, it is estimated with the coefficients. ``every_row``: use all rows of
    a long set, not only the sample of rows that the statistics use.
    """
    index_rounds, unknown = 0, frozenset[str]()
    if noise is None:
        noise, unknown = estimated_noise(ModelDesign(terms, observations, context or FitContext()))
        index_rounds = INDEX_ROUNDS if observations.runs else 0
    present = context or FitContext()
    depends = any(term.effect.depends_on_model for term in terms)
    summed = every_row_sums if every_row else channel_sums
    for _ in range((3 if context is None else 2) if depends else 1):
        capture, reference = (
            summed(terms, observations, present, noise, capture=is_it) for is_it in (True, False)
        )
        solution = solve(terms, observations, present, noise, capture=capture, reference=reference)
        for _ in range(index_rounds):
            noise = noise.with_offsets(observations, solution.run_offsets_arcsec)
            solution = solve(
                terms, observations, present, noise, capture=capture, reference=reference
            )
        present = context_of(solution)
    # The next effect is tested with the error function ε of this model.
    return replace(solution, context=present, every_row=every_row, unknown_noise=unknown)
