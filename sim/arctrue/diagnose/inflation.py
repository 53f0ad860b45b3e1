"""How much more the noise itself takes part in a gain than white noise would."""

from __future__ import annotations

import numpy as np

from arctrue.diagnose.candidate import Candidate
from arctrue.diagnose.surrogates import capture_surrogates, reference_surrogates
from arctrue.fit.residuals import Residuals

SURROGATES = 99


def noise_inflation(item: Candidate, best: Candidate, random: np.random.Generator) -> float:
    """Ratio ≥ 1 of the gains on surrogates to those of white noise.

    Surrogates are made of what the *best* candidate leaves: the noise, not the effect.
    A searched effect is judged at its own place, as its noise may be of another strength there
    than elsewhere: a line at one order says nothing of the noise at another.
    """
    if item.effect.run_level:
        # Judged against the runs' random offsets, whose scatter is a prior, not in these rows.
        return 1.0
    residuals = Residuals(best.solution)
    observations = residuals.observations
    captures = (
        capture_surrogates(observations.capture, residuals.capture_arcsec, SURROGATES, random)
        if observations.capture is not None and residuals.capture_arcsec is not None
        else None
    )
    references = (
        reference_surrogates(observations.reference, residuals.reference_arcsec, SURROGATES, random)
        if observations.reference is not None and residuals.reference_arcsec is not None
        else None
    )
    without = _model_without(item, best)
    gains = without.surrogate_gains(item.effect, item.nonlinear, captures, references, SURROGATES)
    return max(1.0, float(np.mean(gains)) / max(item.rank, 1))


def _model_without(item: Candidate, best: Candidate) -> Residuals:
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
