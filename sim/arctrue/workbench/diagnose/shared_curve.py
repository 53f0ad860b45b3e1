"""States the curve of the angle that all passes over a short arc share in the model."""

from __future__ import annotations

import numpy as np
from scipy.special import chdtrc

from arctrue.workbench.inference.solution import Solution

CHANCE = 0.0027
"""A curve is stated if the χ² test of all its coefficients gives at most this p: the probability
that a normal value is more than three standard uncertainties away."""


def shared_curve(base: Solution | None) -> list[str]:
    """Return a sentence on the curve with its size; none without such a curve."""
    if base is None:
        return []
    found = []
    for index, term in enumerate(base.terms):
        if not term.effect.settings.get("arc_deg"):
            continue
        part = base.part(index)
        coefficients, covariance = base.coefficients[part], base.covariance[part, part]
        square = float(coefficients @ np.linalg.pinv(covariance, hermitian=True) @ coefficients)
        if float(chdtrc(coefficients.size, square)) > CHANCE:
            continue
        size = term.effect.parameters(coefficients, covariance, term.nonlinear, base.observations)[
            "curve_rms"
        ]
        found.append(
            f"All passes over the arc share a smooth curve of the angle, {size.value:.3g}″ RMS: "
            "the model contains it as the error of the disc or of the reference's scale, which "
            "whole turns would separate."
        )
    return found
