"""Computes the residuals of a model with one more effect, as ``arctrue add`` would show them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property

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
    """Stored results, by the effect's name and settings."""

    @property
    def base(self) -> Solution:
        """The fit of the model's terms."""
        return self.residuals.solution

    @cached_property
    def before(self) -> Left:
        """Residual of the model without a further effect."""
        return left_by(settled(self.base))

    def after(self, name: str, form: Effect | None = None) -> Left | None:
        """Return the residual of the model with the effect of this name; None where that effect
        cannot be added.

        ``form`` is the effect with the settings that a survey found, such as the multiples of a
        tooth count. An effect with a search is searched anew, with its default settings.
        """
        kind = self.effects.get(name)
        effect = None if kind is None else kind()
        if effect is not None and form is not None and not effect.search:
            effect = form
        key = name if effect is None else f"{name} {sorted(effect.settings.items())}"
        if key not in self.found:
            solution = None if effect is None else added(effect, self.residuals)
            self.found[key] = None if solution is None else left_by(solution)
        return self.found[key]
