"""Which cause is hidden in a table that is drawn by a seed."""

from __future__ import annotations

import numpy as np

from arctrue.studies.simulate.experiment import Experiment
from arctrue.table.registry import RECIPES


def hidden_effect(seed: int, experiment: Experiment) -> str:
    """One cause of the catalogue that acts on a channel of the experiment.

    Its own stream: the seed of the table must not tell it.
    """
    names = sorted(
        recipe.name
        for recipe in RECIPES.values()
        if recipe.in_catalogue and experiment.can_honour(recipe)
    )
    random = np.random.default_rng([seed, len(names)])
    return names[int(random.integers(len(names)))]
