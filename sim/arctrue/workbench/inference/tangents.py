"""Computes tangents of a model along its search parameters, as further columns of the model."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from arctrue.workbench.effects.base import Columns, Effect, FitContext, Nonlinear
from arctrue.workbench.inference.design_matrix import Term
from arctrue.workbench.inference.fitted import Fitted
from arctrue.workbench.observations import CaptureRows, Observations, ReferenceRows

Float = NDArray[np.float64]

PROBE_ROWS = 4096
"""The step of the difference quotient is calculated from evenly spread rows of a longer capture;
their number is at least this value and less than twice this value. Without a capture, all rows of
the reference are used."""
RELATIVE_CHANGE = 1e-4
"""Relative change of the prediction that a step of the difference quotient should cause; the cubic
term is then about 1e-8 of the linear term."""


def refined_names(effect: Effect) -> list[str]:
    """Return the names of the continuous search parameters."""
    return [item.name for item in effect.search if not item.integer]


class Tangent(Effect):
    """∂(X(η)·b)/∂η of one term, by central differences; one column for each parameter."""

    name = "tangent"
    depends_on_model = True

    def __init__(self, term: Term, coefficients: Float, observations: Observations) -> None:
        """Prepare the tangents at the term's own search parameters and these coefficients."""
        super().__init__()
        self.term = term
        self.coefficients = coefficients
        self.names = refined_names(term.effect)
        self.context = FitContext()
        self.widths = {name: self._width(name, observations) for name in self.names}

    def column_names(self, observations: Observations) -> list[str]:
        """Return the names of the parameters."""
        return list(self.names)

    def capture_columns(
        self, rows: CaptureRows, nonlinear: Nonlinear, context: FitContext
    ) -> Columns | None:
        """Return the tangents in R₂ − R₁."""
        return self._differences(self.term.effect.capture_columns, rows, context)

    def reference_columns(
        self, rows: ReferenceRows, nonlinear: Nonlinear, context: FitContext
    ) -> Columns | None:
        """Return the tangents in ε of head 1."""
        return self._differences(self.term.effect.reference_columns, rows, context)

    def _differences(
        self, columns_of: Callable[..., Columns | None], rows: Any, context: FitContext
    ) -> Columns | None:
        found = []
        for name in self.names:
            here, width = self.term.nonlinear[name], self.widths[name]
            above = columns_of(rows, {**self.term.nonlinear, name: here + width}, context)
            below = columns_of(rows, {**self.term.nonlinear, name: here - width}, context)
            if above is None or below is None:
                return None
            found.append((above - below) @ self.coefficients / (2.0 * width))
        return np.stack(found, axis=1) if found else None

    def _width(self, name: str, observations: Observations) -> float:
        """Return the step of the difference quotient, so small that the prediction is linear over
        it."""
        rows = observations.capture
        probe: Any
        columns_of: Callable[..., Columns | None]
        if rows is not None:
            probe = rows.part(slice(None, None, max(rows.run.size // PROBE_ROWS, 1)))
            columns_of = self.term.effect.capture_columns
        else:
            probe = observations.reference
            columns_of = self.term.effect.reference_columns
        here = self.term.nonlinear[name]
        parameter = next(item for item in self.term.effect.search if item.name == name)
        width = 1e-7 * max(abs(here), 1e-3 * min(parameter.high - parameter.low, 1e3))
        for _ in range(3):
            now = columns_of(probe, self.term.nonlinear, self.context)
            moved = columns_of(probe, {**self.term.nonlinear, name: here + width}, self.context)
            if now is None or moved is None:
                return width
            size = float(np.linalg.norm(now @ self.coefficients))
            change = float(np.linalg.norm((moved - now) @ self.coefficients))
            if size == 0.0 or change == 0.0:
                width *= 100.0
                continue
            width *= RELATIVE_CHANGE * size / change
        return width


def tangent_terms(solution: Fitted) -> list[Term]:
    """Return the terms of a solution and, after them, the tangents of each term."""
    tangents = [
        Term(Tangent(term, solution.coefficients[solution.part(index)], solution.observations), {})
        for index, term in enumerate(solution.terms)
        if refined_names(term.effect)
    ]
    return [*solution.terms, *tangents]
