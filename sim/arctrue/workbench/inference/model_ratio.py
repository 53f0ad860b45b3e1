"""Calculates the likelihood ratio of two models of one set, if one of the models contains the
other."""

from __future__ import annotations

from collections.abc import Hashable
from dataclasses import dataclass, replace

from arctrue.workbench.inference.design_matrix import Term
from arctrue.workbench.inference.fit import fit
from arctrue.workbench.inference.likelihood_ratio import restricted_likelihood, under
from arctrue.workbench.inference.residuals import Residuals
from arctrue.workbench.inference.significance import single_p_value
from arctrue.workbench.inference.solution import Solution
from arctrue.workbench.noise.noise import Noise


@dataclass(frozen=True)
class ModelRatio:
    """The likelihood ratio of a smaller and a larger model.

    Parameters
    ----------
    gain : float
        Twice the rise of the log likelihood; each model has its own noise estimate.
    parameters : int
        Number of parameters that only the larger model has, search parameters included.
    p_value : float
        Probability of such a gain by chance if the smaller model is true. This probability is too
        small if a search found parameters of the larger model: only :func:`arctrue.diagnose` counts
        the values that the search tried.
    larger : int
        Number of the larger model, 1 or 2.
    """

    gain: float
    parameters: int
    p_value: float
    larger: int


def model_ratio(one: Solution, other: Solution) -> ModelRatio | None:
    """Compare two models; return None if neither model has all terms of the other model."""
    if _contains(other, one):
        return _ratio(one, other, 2)
    if _contains(one, other):
        return _ratio(other, one, 1)
    return None


def _key(term: Term) -> Hashable:
    return term.effect.name, repr(sorted(term.effect.settings.items()))


def _contains(large: Solution, small: Solution) -> bool:
    left = [_key(term) for term in large.terms]
    for term in small.terms:
        if _key(term) not in left:
            return False
        left.remove(_key(term))
    return True


def _ratio(small: Solution, large: Solution, larger: int) -> ModelRatio:
    """Compute the ratio from the rows that the statistics use, even if the models were fitted to
    every row of a long set.

    Both noises are estimated with the restricted likelihood of the smaller model's columns, so that
    the likelihoods can be compared.
    """
    at_small = restricted_likelihood(Residuals(_with_noise(small, small.noise)))
    noise = under(large, small)
    both = [_with_noise(item, noise) for item in (small, large)]
    at_large = restricted_likelihood(Residuals(both[0]))
    rise = both[1].log_likelihood - both[0].log_likelihood
    gain = 2.0 * max(at_large + rise - max(at_small, at_large), 0.0)
    more = large.rank - small.rank + large.searched - small.searched
    freedom = float(max(large.observations.rows - large.rank, 1))
    return ModelRatio(gain, more, single_p_value(gain, more, freedom), larger)


def _with_noise(solution: Solution, noise: Noise) -> Solution:
    """Fit the same terms to the rows that the statistics use, with this noise."""
    again = fit(solution.terms, solution.observations, solution.context, noise=noise)
    return replace(again, unknown_noise=solution.unknown_noise)
