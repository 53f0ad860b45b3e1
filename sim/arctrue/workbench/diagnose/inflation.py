"""How much more the noise itself takes part in a gain than white noise would."""

from __future__ import annotations

import numpy as np

from arctrue.workbench.diagnose.candidate import Candidate
from arctrue.workbench.diagnose.surrogates import (
    capture_groups,
    mean_square_moment,
    reference_groups,
)
from arctrue.workbench.inference.residuals import Residuals


def noise_inflation(item: Candidate, best: Candidate) -> float:
    """Ratio ≥ 1 of the mean gain on surrogates to that of white noise, over all surrogates.

    Surrogates are made of what the *best* candidate leaves: the noise, not the effect.
    A searched effect is judged at its own place, as its noise may be of another strength there
    than elsewhere: a line at one order says nothing of the noise at another.
    """
    if item.effect.run_level or item.rank == 0:
        # Judged against the runs' random offsets, whose scatter is a prior, not in these rows.
        return 1.0
    noise = Residuals(best.solution)
    without = _model_without(best)
    columns = without.weighted_columns(item.effect, item.nonlinear)
    rows = noise.observations
    square = np.zeros((len(item.effect.column_names(rows)),) * 2)
    if rows.capture is not None and noise.capture_arcsec is not None and columns[0] is not None:
        groups = capture_groups(rows.capture)
        square += mean_square_moment(groups, noise.capture_arcsec, columns[0])
    if rows.reference is not None and noise.reference_arcsec is not None and columns[1] is not None:
        groups = reference_groups(rows.reference)
        square += mean_square_moment(groups, noise.reference_arcsec, columns[1])
    covariance = without.score(item.effect, item.nonlinear).covariance
    # The gain of a surrogate is mᵀ·C·m.
    return max(1.0, float(np.sum(square * covariance)) / item.rank)


def _model_without(best: Candidate) -> Residuals:
    """Residuals of the base model: what both were tried against."""
    from dataclasses import replace

    base_terms = best.solution.terms[:-1]
    width = best.solution.widths[-1]
    keep = slice(0, best.solution.coefficients.size - width)
    base = replace(
        best.solution,
        terms=base_terms,
        widths=best.solution.widths[:-1],
        coefficients=best.solution.coefficients[keep],
        covariance=best.solution.covariance[keep, keep],
    )
    return Residuals(base)
