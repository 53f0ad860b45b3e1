"""Scan of every point of a grid, for effects without another kind of scan."""

from __future__ import annotations

from itertools import product

import numpy as np

from arctrue.workbench.effects.base import Effect
from arctrue.workbench.inference.residuals import Residuals
from arctrue.workbench.inference.scan.maximum import moved_to_maximum
from arctrue.workbench.inference.scan.places import Place, scored


def grid_scan(effect: Effect, residuals: Residuals) -> list[Place]:
    """Score every point of the grid over the declared ranges, for effects without another kind of
    scan."""
    axes = []
    for parameter in effect.search:
        low, high = effect.search_range(parameter.name)
        points = np.linspace(low, high, parameter.steps)
        axes.append(np.unique(np.round(points)) if parameter.integer else points)
    names = [parameter.name for parameter in effect.search]
    if not names:
        return scored(effect, residuals, [{}], 1.0)
    places = [dict(zip(names, map(float, values), strict=True)) for values in product(*axes)]
    found = scored(effect, residuals, places, float(len(places)))
    for parameter in effect.search:
        if not parameter.integer:
            low, high = effect.search_range(parameter.name)
            step = (high - low) / max(parameter.steps - 1, 1)
            found = moved_to_maximum(effect, residuals, found, parameter.name, step)
    return found
