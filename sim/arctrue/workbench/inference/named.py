"""Collects the fitted parameters of a model, each under one name: ``hysteresis.reversal_error``.

The second occurrence of an effect has ``#2`` after its name: ``periodic_error#2.amplitude``.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from arctrue.workbench.effects.base import Parameter
from arctrue.workbench.inference.design_matrix import Term
from arctrue.workbench.inference.solution import Solution, joint_uncertainty
from arctrue.workbench.inference.tangents import refined_names
from arctrue.workbench.observations import Observations

Float = NDArray[np.float64]


def labels(terms: Sequence[Term]) -> list[str]:
    """Return the name of each term; ``#`` and the number follow from the second occurrence of an
    effect on."""
    names = [term.effect.name for term in terms]
    found = []
    for place, name in enumerate(names):
        number = names[: place + 1].count(name)
        found.append(name if number == 1 else f"{name}#{number}")
    return found


def term_parameters(
    term: Term, coefficients: Float, covariance: Float, sigmas: dict[str, float],
    observations: Observations,
) -> dict[str, Parameter]:  # fmt: skip
    """Return the parameters of one term that reports show; ``sigmas`` are the standard
    uncertainties of its search parameters."""
    own = term.effect.parameters(coefficients, covariance, term.nonlinear, observations)
    for name, sigma in sigmas.items():
        if name in own:
            own[name] = replace(own[name], sigma=sigma)
    return own | term.effect.derived(own, term.nonlinear, observations)


def values_of(
    terms: Sequence[Term],
    widths: Sequence[int],
    coefficients: Float,
    observations: Observations,
    wanted: Collection[int] | None = None,
) -> dict[str, float]:
    """Return the value of every parameter; ``wanted`` limits the result to the terms with these
    numbers."""
    found: dict[str, float] = {}
    start = 0
    for number, (label, term, width) in enumerate(zip(labels(terms), terms, widths, strict=True)):
        part = slice(start, start + width)
        start += width
        if wanted is None or number in wanted:
            none = np.zeros((width, width))
            own = term_parameters(term, coefficients[part], none, {}, observations)
            found |= {f"{label}.{name}": item.value for name, item in own.items()}
    return found


def named_parameters(solution: Solution, covariance: Float | None = None) -> dict[str, Parameter]:
    """Return every parameter with its standard uncertainty and unit.

    ``covariance``: covariance of all coefficients and, after them, of the continuous search
    parameters of each term; by default the covariance of the solution.
    """
    own, sigmas = joint_uncertainty(solution)
    if covariance is not None:
        spread = np.sqrt(np.maximum(np.diag(covariance), 0.0))
        place = sum(solution.widths)
        for term, of_term in zip(solution.terms, sigmas, strict=True):
            for name in refined_names(term.effect):
                if term.effect.step_at is None or name != term.effect.step_at[1]:
                    of_term[name] = float(spread[place])
                place += 1
        own = covariance
    found: dict[str, Parameter] = {}
    named = zip(labels(solution.terms), solution.terms, strict=True)
    for number, (label, term) in enumerate(named):
        part = solution.part(number)
        parameters = term_parameters(
            term, solution.coefficients[part], own[part, part], sigmas[number],
            solution.observations,
        )  # fmt: skip
        found |= {f"{label}.{name}": item for name, item in parameters.items()}
    return found
