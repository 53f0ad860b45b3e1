"""Draws the hidden cause of a table from a seed."""

from __future__ import annotations

import numpy as np

from arctrue.studies.simulate.experiment import Experiment
from arctrue.table.registry import RECIPES


def hidden_effect(seed: int, experiment: Experiment) -> str:
    """Draw one cause of the catalogue that acts on a channel of the experiment.

    The draw uses its own random stream, not the stream that draws the properties of the table.
    """
    names = sorted(
        recipe.name
        for recipe in RECIPES.values()
        if recipe.in_catalogue and experiment.can_honour(recipe)
    )
    random = np.random.default_rng([seed, len(names)])
    return names[int(random.integers(len(names)))]
