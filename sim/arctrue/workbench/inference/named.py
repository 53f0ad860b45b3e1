"""Calculates the parameters of a model, each under one name: ``hysteresis.reversal_error``.

The second occurrence of an effect has ``#2`` after its name: ``periodic_error#2.amplitude``.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from arctrue.workbench.effects.base import Parameter
from arctrue.workbench.inference.design_matrix import Term
from arctrue.workbench.observations import Observations

Float = NDArray[np.float64]


def labels(terms: Sequence[Term]) -> list[str]:
    """Return the name of each term; from the second occurrence of an effect on, ``#`` and the
    number of the occurrence follow the name."""
    names = [term.effect.name for term in terms]
    found = []
    for place, name in enumerate(names):
        number = names[: place + 1].count(name)
        found.append(name if number == 1 else f"{name}#{number}")
    return found


def term_parameters(
    term: Term, coefficients: Float, covariance: Float, sigmas: Mapping[str, float],
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
    every = parameters_of(terms, widths, coefficients, observations, wanted)
    return {name: item.value for name, item in every.items()}


def parameters_of(
    terms: Sequence[Term],
    widths: Sequence[int],
    coefficients: Float,
    observations: Observations,
    wanted: Collection[int] | None = None,
) -> dict[str, Parameter]:
    """Return every parameter without its uncertainty; ``wanted`` as in :func:`values_of`."""
    found: dict[str, Parameter] = {}
    start = 0
    for number, (label, term, width) in enumerate(zip(labels(terms), terms, widths, strict=True)):
        part = slice(start, start + width)
        start += width
        if wanted is None or number in wanted:
            none = np.zeros((width, width))
            own = term_parameters(term, coefficients[part], none, {}, observations)
            found |= {f"{label}.{name}": item for name, item in own.items()}
    return found
