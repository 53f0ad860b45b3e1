"""Computes the residuals of a model with one more effect, as ``arctrue add`` would show them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from arctrue.workbench.effects.base import Effect
from arctrue.workbench.inference.added import added, settled
from arctrue.workbench.inference.left import Left, left_by
from arctrue.workbench.inference.residuals import Residuals
from arctrue.workbench.inference.solution import Solution


@dataclass(frozen=True, eq=False)
class Adding:
    """Adds single effects to a fitted model and stores the residual of the model with each of
    them."""

    residuals: Residuals
    """Residuals of the model; a survey of the same model uses the same object with its stored
    results."""
    effects: Mapping[str, type[Effect]]
    found: dict[str, Left | None] = field(default_factory=dict)

    @property
    def base(self) -> Solution:
        """The fit of the model's terms."""
        return self.residuals.solution

    @cached_property
    def before(self) -> Left:
        """Residual of the model without a further effect."""
        return left_by(settled(self.base))

    def after(self, name: str) -> Left | None:
        """Return the residual of the model with the effect of this name; None where that effect
        cannot be added."""
        if name not in self.found:
            effect = self.effects[name]() if name in self.effects else None
            if effect is not None and not effect.search and not has_columns(effect, self.residuals):
                effect = None
            solution = None if effect is None else added(effect, self.residuals)
            self.found[name] = None if solution is None else left_by(solution)
        return self.found[name]


def has_columns(effect: Effect, residuals: Residuals) -> bool:
    """Tell whether the columns of the effect, without search parameters, can be calculated on these
    rows.

    An effect, possibly a user's own, may raise one of several exceptions if a column that it needs
    is missing.
    """
    try:
        columns = residuals.whitened_columns(effect, {})
    except (TypeError, AttributeError, AssertionError, KeyError, ValueError, IndexError):
        return False
    return any(item is not None and np.all(np.isfinite(item)) for item in columns)
