"""The fit of a model beside noise that is known but for the scatter of the runs' offsets."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from arctrue.workbench.effects.base import FitContext
from arctrue.workbench.inference.normal_equations import Term, channel_sums, every_row_sums
from arctrue.workbench.inference.solution import Solution, context_of, solve
from arctrue.workbench.noise.index_offsets import index_variance
from arctrue.workbench.noise.noise import Noise
from arctrue.workbench.observations import Observations


def fit_with_noise(
    terms: Sequence[Term],
    observations: Observations,
    context: FitContext | None,
    noise: Noise,
    *,
    every_row: bool = False,
    index_rounds: int = 0,
) -> Solution:
    """Fit terms as :func:`arctrue.workbench.inference.fit.fit` does, with noise that is given.

    ``index_rounds``: how often the variance of the index is estimated again from the offsets of the
    runs. ``every_row``: all rows of a long set, not only the part that the statistics work on.
    """
    present = context or FitContext()
    depends = any(term.effect.depends_on_model for term in terms)
    rounds = (3 if context is None else 2) if depends else 1
    for _ in range(rounds):
        summed = every_row_sums if every_row else channel_sums
        sums = {
            name: summed(terms, observations, present, noise, capture=name == "capture")
            for name in ("capture", "reference")
        }
        solution = solve(terms, observations, present, noise, **sums)
        for _ in range(index_rounds if observations.runs else 0):
            variance, freedom = index_variance(observations, solution.run_offsets_arcsec)
            noise = replace(noise, index_variance=variance, index_freedom=freedom)
            solution = solve(terms, observations, present, noise, **sums)
        present = context_of(solution)
    # The next effect is judged with what this model says of ε.
    return replace(solution, context=present, every_row=every_row)
