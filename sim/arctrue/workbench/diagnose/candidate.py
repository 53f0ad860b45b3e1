"""One effect tried against what a model leaves."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from arctrue.workbench.diagnose.evidence import Evidence
from arctrue.workbench.diagnose.heldout import HeldOut, Improvement
from arctrue.workbench.effects.base import Effect, Nonlinear, Parameter
from arctrue.workbench.inference.normal_equations import Term
from arctrue.workbench.inference.search_parameters import refined
from arctrue.workbench.inference.solution import Solution

ACTING_SHARE = 0.05
"""An effect acts on the rows where it moves the prediction by this share of its largest move."""


@dataclass
class Candidate:
    """What the search, the fit and the statistics say of one effect."""

    effect: Effect
    nonlinear: Nonlinear
    gain: float
    rank: int
    trials: float
    solution: Solution
    delta_bic: float
    """BIC before less BIC after, each place that was searched charged for: above 0 is better."""
    size_arcsec: dict[str, float]
    """RMS by which it moves the prediction where it acts, by channel."""
    p_corrected: float
    rows: int
    """Rows of the channels that it moves: what its size is known from."""
    lacking_variety: list[str] = field(default_factory=list)
    level_trials: float | None = None
    """Places that its p pays for, where the level is not shared out evenly among them."""
    asked: Effect | None = None
    """The effect before it was narrowed to what is there; None for a product of parts."""
    evidence: Evidence | None = None
    """With the noise estimated anew; None where the first test tells enough."""
    held_out: HeldOut | None = None
    held_out_before: HeldOut | None = None
    """Of the model without it, with the same noise and the same rows left out."""
    improvement: dict[str, Improvement] = field(default_factory=dict)

    @property
    def name(self) -> str:
        """Name of the effect."""
        return self.effect.name

    @property
    def freedom(self) -> float:
        """Degrees of freedom with which the noise of its size is known."""
        return float("inf") if self.evidence is None else self.evidence.freedom

    @cached_property
    def at_maximum(self) -> Solution:
        """Its solution with the search parameters between the places that were tried.

        For what is asked of a candidate once it is judged; its solution stays where it is. A line
        beside its place leaves a rest that others would take.
        """
        return refined(self.solution)

    @property
    def term(self) -> Term:
        """The effect as a term of a model."""
        return Term(self.effect, self.nonlinear)

    def parameters(self) -> dict[str, Parameter]:
        """The fitted parameters of this effect, the last term of its solution."""
        return self.solution.parameters()[-1]


def sizes_arcsec(before: Solution, after: Solution) -> dict[str, float]:
    """RMS of the change of the prediction over the rows where it changes, by channel."""
    found: dict[str, float] = {}
    if before.observations.capture is not None:
        change = after.capture_prediction_arcsec(False) - before.capture_prediction_arcsec(False)
        found["capture"] = _acting_rms(change)
    if before.observations.reference is not None:
        change = after.reference_prediction_arcsec() - before.reference_prediction_arcsec()
        found["reference"] = _acting_rms(change - change.mean())
    return found


def _acting_rms(change: NDArray[np.float64]) -> float:
    largest = float(np.abs(change).max(initial=0.0))
    if largest == 0.0:
        return 0.0
    acting = np.abs(change) >= ACTING_SHARE * largest
    return float(np.sqrt(np.mean(change[acting] ** 2)))
