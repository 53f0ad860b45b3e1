"""Compares two fitted models of one set."""

from __future__ import annotations

import html
from dataclasses import dataclass

import numpy as np

from arctrue.api.fit_result import FitResult
from arctrue.base.figures import figure, probability, with_uncertainty
from arctrue.workbench.inference.model_ratio import ModelRatio, model_ratio


@dataclass(frozen=True, eq=False)
class ModelTest:
    """Comparison of two models of one set.

    Parameters
    ----------
    bic_difference : float
        BIC of the first model minus BIC of the second model: above 0 the second model is better,
        above 10 it is much better.
    ratio : ModelRatio or None
        Likelihood ratio, difference between the numbers of parameters, and p value; None if neither
        model contains the other.
    held_out_fall_arcsec : dict of str to (float, float)
        Decrease of the error on held-out rows from the first model to the second, by channel, and
        its standard error.
    """

    bic_difference: float
    ratio: ModelRatio | None
    held_out_fall_arcsec: dict[str, tuple[float, float]]

    def __str__(self) -> str:
        """Return one line of text for each comparison."""
        lines = [
            f"BIC of the first model minus that of the second: {figure(self.bic_difference, 2)}"
        ]
        if self.ratio is not None:
            lines.append(
                f"likelihood ratio {figure(self.ratio.gain, 2)} with {self.ratio.parameters} "
                f"parameters, p {probability(self.ratio.p_value)}"
            )
        lines += [
            f"{channel}: held-out error falls by {with_uncertainty(fall, error, 'arcsec')}"
            for channel, (fall, error) in self.held_out_fall_arcsec.items()
        ]
        return "\n".join(lines)

    def _repr_html_(self) -> str:
        return "".join(f"<p>{html.escape(line)}</p>" for line in str(self).splitlines())


def compare_models(one: FitResult, other: FitResult) -> ModelTest:
    """Compare two fits of the same set by BIC, likelihood ratio and error on held-out rows.

    Parameters
    ----------
    one : FitResult
        Fit of the first, usually the smaller model.
    other : FitResult
        Fit of the second model.

    Returns
    -------
    ModelTest
        Difference of BIC; likelihood ratio with p if one model contains the other; error on
        held-out rows.

    Raises
    ------
    ValueError
        The two fits use different rows.
    """
    first, second = one.solution, other.solution
    for channel in ("capture", "reference"):
        mine, theirs = getattr(first.observations, channel), getattr(second.observations, channel)
        if (mine is None) != (theirs is None) or (
            mine is not None and not np.array_equal(mine.measured_arcsec, theirs.measured_arcsec)
        ):
            raise ValueError(
                f"the two fits use different rows of the {channel}: fit both models to one set"
            )
    falls = other.left.fall_from(one.left)
    return ModelTest(
        first.bic - second.bic,
        model_ratio(first, second),
        {name: (fall.fall_arcsec, fall.standard_error_arcsec) for name, fall in falls.items()},
    )
