"""Scans the search parameters of an effect with the kind of search that the effect declares."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from arctrue.workbench.effects.base import Effect, SearchKind
from arctrue.workbench.inference.line_search import line_scan
from arctrue.workbench.inference.residuals import Residuals
from arctrue.workbench.inference.scan.disc import bump_scan, disc_order_scan
from arctrue.workbench.inference.scan.grid import grid_scan
from arctrue.workbench.inference.scan.places import Place
from arctrue.workbench.inference.scan.steps import step_scan
from arctrue.workbench.inference.scan.waves import frequency_scan, unwrapped_order_scan

SCANS: Mapping[SearchKind, Callable[[Effect, Residuals], list[Place]]] = {
    "grid": grid_scan,
    "disc_order": disc_order_scan,
    "unwrapped_order": unwrapped_order_scan,
    "frequency": frequency_scan,
    "line": line_scan,
    "step": step_scan,
    "disc_place": bump_scan,
}


def places_of(effect: Effect, residuals: Residuals) -> list[Place]:
    """Return the values of the search parameters with which the effect fits the residuals best.

    Each place is one set of values; the best comes first.
    """
    return SCANS[effect.search_kind](effect, residuals)
