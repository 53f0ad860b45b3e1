"""Applies a model with given coefficients to a set; fits only the offset of each run of the capture
and the constant a₀ of the reference.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from arctrue.workbench.effects.base import FitContext
from arctrue.workbench.inference.design_matrix import Term, term_widths
from arctrue.workbench.inference.fit import ModelDesign
from arctrue.workbench.inference.solution import Solution, context_of
from arctrue.workbench.noise.fit import estimated_noise, white_noise
from arctrue.workbench.noise.row_noise import RowNoise
from arctrue.workbench.numeric.least_squares import WhitenedRows
from arctrue.workbench.observations import Observations


def with_fixed_coefficients(
    terms: Sequence[Term], observations: Observations, coefficients: NDArray[np.float64]
) -> Solution:
    """Return the solution with these coefficients (of all terms, in their order).

    Run offsets and the constant a₀ are fitted by least squares; the noise is estimated from the
    residuals. Raises ValueError if the number of coefficients is wrong.
    """
    widths = term_widths(terms, observations)
    shared = sum(widths)
    if coefficients.size != shared:
        raise ValueError(f"expected {shared} coefficients, found {coefficients.size}")
    draft = _solution(terms, observations, FitContext(), widths, coefficients)
    context = context_of(draft)
    draft = replace(draft, context=context)
    left = draft.capture_residual_arcsec(), draft.reference_residual_arcsec()
    # The given coefficients use no degree of freedom of this set, because only the run offsets and
    # a₀ are fitted to its rows.
    noise, unknown = estimated_noise(ModelDesign((), _leaving(observations, left), FitContext()))
    sums = [
        _constants(None if values is None else of_rows, values, run, offsets, prior, mixed)
        for values, of_rows, run, offsets, prior, mixed in (
            (
                left[0], noise.capture,
                None if observations.capture is None else observations.capture.run,
                observations.runs, 1.0 / noise.index_variance,
                None if observations.capture is None else observations.capture.offset_weights,
            ),
            (
                left[1], noise.reference,
                None if left[1] is None else np.zeros(left[1].size, dtype=np.int64), 1, 0.0, None,
            ),
        )
    ]  # fmt: skip
    return replace(
        draft,
        run_offsets_arcsec=sums[0] if observations.runs else np.zeros(0),
        reference_offset_arcsec=float(sums[1][0]) if sums[1].size else 0.0,
        noise=noise,
        unknown_noise=unknown,
    )


def _leaving(
    observations: Observations, left: tuple[NDArray[np.float64] | None, NDArray[np.float64] | None]
) -> Observations:
    """Return the observations with these residuals as the measured values; the mean of the
    reference's residuals is subtracted."""
    capture, reference = observations.capture, observations.reference
    return replace(
        observations,
        capture=None
        if capture is None or left[0] is None
        else replace(capture, difference_arcsec=left[0]),
        reference=None
        if reference is None or left[1] is None
        else replace(reference, error_arcsec=left[1] - float(np.mean(left[1]))),
    )


def _constants(
    noise: RowNoise | None,
    values: NDArray[np.float64] | None,
    run: NDArray[np.int64] | None,
    offsets: int,
    prior: float,
    mixed: NDArray[np.float64] | None,
) -> NDArray[np.float64]:
    """Fit the constants of one channel by least squares: the offset of each run of the capture, or
    a₀ of the reference."""
    if noise is None or values is None or run is None:
        return np.zeros(offsets)
    ones, whitened = noise.whiten(np.ones(values.size)), noise.whiten(values)
    if mixed is not None:
        rows = WhitenedRows(np.zeros((values.size, 0)), ones, run, offsets, mixed)
        return np.asarray(
            np.linalg.solve(rows.gram + prior * np.eye(offsets), rows.moment(whitened))
        )
    information = np.bincount(run, ones**2, offsets) + prior
    return np.asarray(np.bincount(run, ones * whitened, offsets) / np.maximum(information, 1e-300))


def _solution(
    terms: Sequence[Term],
    observations: Observations,
    context: FitContext,
    widths: Sequence[int],
    coefficients: NDArray[np.float64],
) -> Solution:
    size = coefficients.size
    return Solution(
        terms=tuple(terms),
        observations=observations,
        context=context,
        widths=tuple(widths),
        coefficients=coefficients,
        covariance=np.zeros((size, size)),
        run_offsets_arcsec=np.zeros(observations.runs),
        reference_offset_arcsec=0.0,
        noise=white_noise(observations, (1.0, 1.0)),
        log_likelihood=0.0,
        rank=0,
        condition=1.0,
        held=True,
    )
