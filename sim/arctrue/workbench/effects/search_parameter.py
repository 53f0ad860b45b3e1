"""Declares the parameters that a search finds, and the kinds of search."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

SearchKind = Literal[
    "grid", "disc_order", "unwrapped_order", "frequency", "line", "step", "disc_place"
]
"""Kinds of search for the parameters of an effect. In this order, they search: every point of the
declared ranges; a whole order of the disc; an order over the unwrapped angle; a frequency in time;
a line, which is an order or a frequency in either channel; the instant of a step in a run; place
and width of a bump on the disc."""

SEARCHED: Mapping[SearchKind, frozenset[str]] = {
    "disc_order": frozenset({"order"}),
    "unwrapped_order": frozenset({"order"}),
    "frequency": frozenset({"frequency"}),
    "line": frozenset({"order", "frequency", "in_time", "in_capture"}),
    "step": frozenset({"run", "instant"}),
    "disc_place": frozenset({"place", "width"}),
}
"""Names of the search parameters that each kind of search finds; a grid search finds all that an
effect declares."""


@dataclass(frozen=True, slots=True)
class SearchParameter:
    """A parameter that enters the columns nonlinearly and is therefore searched."""

    name: str
    unit: str
    low: float
    high: float
    meaning: str
    steps: int = 64
    """Number of points of the grid that the default scan tries."""
    integer: bool = False
    """True if only integers have a meaning; the search does not refine such a parameter between its
    grid points."""
