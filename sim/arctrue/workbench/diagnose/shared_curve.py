"""States the curve of the angle that all passes over a short arc share in the model."""

from __future__ import annotations

from arctrue.workbench.inference.solution import Solution

SURE = 3.0
"""A curve is stated if its RMS exceeds this number of standard uncertainties; chance gives such a
size in 3 of 1,000 cases."""


def shared_curve(base: Solution | None) -> list[str]:
    """Return a sentence on the curve with its size; none without such a curve."""
    if base is None:
        return []
    found = []
    for index, term in enumerate(base.terms):
        if not term.effect.settings.get("arc_deg"):
            continue
        part = base.part(index)
        parameters = term.effect.parameters(
            base.coefficients[part],
            base.covariance[part, part],
            term.nonlinear,
            base.observations,
        )
        size = parameters["curve_rms"]
        if size.value > SURE * size.sigma:
            found.append(
                f"All passes over the arc share a smooth curve of the angle, {size.value:.3g}″ "
                "RMS: the model contains it as the error of the disc or of the reference's scale, "
                "which whole turns would separate."
            )
    return found
