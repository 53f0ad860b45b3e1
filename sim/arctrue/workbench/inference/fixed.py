"""A model with given coefficients on a set: only the set's own constants are fitted."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from arctrue.workbench.effects.base import FitContext
from arctrue.workbench.inference.normal import Term, capture_sums, reference_sums, term_widths
from arctrue.workbench.inference.solution import Solution, context_of
from arctrue.workbench.observations import Observations


def with_fixed_coefficients(
    terms: Sequence[Term], observations: Observations, coefficients: NDArray[np.float64]
) -> Solution:
    """The solution with these coefficients (of all terms, in their order).

    Run offsets and the constant a₀ are those of least squares; the noise is what is left.
    Raises ValueError when the number of coefficients does not fit.
    """
    widths = term_widths(terms, observations)
    shared = sum(widths)
    if coefficients.size != shared:
        raise ValueError(f"expected {shared} coefficients, found {coefficients.size}")
    draft = _solution(terms, observations, FitContext(), widths, coefficients)
    context = context_of(draft)
    capture = capture_sums(terms, observations, context, every_row=True)
    reference = reference_sums(terms, observations, context)
    offsets = np.zeros(observations.runs)
    capture_sigma = reference_sigma = None
    constant = 0.0
    if capture is not None:
        own = slice(shared, None)
        counts = np.diag(capture.gram)[own]
        moment = capture.moment[own] - capture.gram[own, :shared] @ coefficients
        offsets = moment / np.maximum(counts, 1.0)
        square = capture.residual_square(np.concatenate([coefficients, offsets]))
        capture_sigma = float(np.sqrt(square / max(capture.rows, 1)))
    if reference is not None:
        left = reference.moment[shared] - reference.gram[shared, :shared] @ coefficients
        constant = float(left / max(reference.gram[shared, shared], 1.0))
        square = reference.residual_square(np.append(coefficients, constant))
        reference_sigma = float(np.sqrt(square / max(reference.rows, 1)))
    return _solution(
        terms,
        observations,
        context,
        widths,
        coefficients,
        offsets=offsets,
        constant=constant,
        sigma=(capture_sigma, reference_sigma),
    )


def _solution(
    terms: Sequence[Term],
    observations: Observations,
    context: FitContext,
    widths: Sequence[int],
    coefficients: NDArray[np.float64],
    *,
    offsets: NDArray[np.float64] | None = None,
    constant: float = 0.0,
    sigma: tuple[float | None, float | None] = (None, None),
) -> Solution:
    size = coefficients.size
    return Solution(
        terms=tuple(terms),
        observations=observations,
        context=context,
        widths=tuple(widths),
        coefficients=coefficients,
        covariance=np.zeros((size, size)),
        run_offsets_arcsec=np.zeros(observations.runs) if offsets is None else offsets,
        reference_offset_arcsec=constant,
        capture_sigma_arcsec=sigma[0],
        reference_sigma_arcsec=sigma[1],
        log_likelihood=0.0,
        rank=0,
        condition=1.0,
        held=True,
    )
