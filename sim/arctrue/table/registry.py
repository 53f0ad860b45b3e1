"""Registers every cause of the simulated table; it finds the causes by their files in
:mod:`arctrue.table.causes`.

Captures, edges, polygon runs, scenarios, hidden effects, ``simulate`` and the benchmark take their
causes from this registry. Each of them refuses causes that it does not simulate, see
:func:`arctrue.table.cause.refuse_unhonoured`.
"""

from __future__ import annotations

import pkgutil
from dataclasses import replace
from importlib import import_module
from itertools import pairwise

from arctrue.table import causes
from arctrue.table.declaration import Declaration, Recipe


def declared() -> dict[str, Declaration]:
    """Import every file of the folder, and return the declarations by the names of their files."""
    names = sorted(module.name for module in pkgutil.iter_modules(causes.__path__))
    return {name: import_module(f"{causes.__name__}.{name}").DECLARATION for name in names}


def ranked(found: dict[str, Declaration]) -> dict[str, Recipe]:
    """Return the recipes of all causes in order of rank. Raises ValueError if two recipes share a
    name or a rank."""
    recipes = [
        replace(recipe, cause=name) for name, cause in found.items() for recipe in cause.recipes
    ]
    recipes.sort(key=lambda recipe: recipe.rank)
    for before, after in pairwise(recipes):
        if before.rank == after.rank or before.name == after.name:
            raise ValueError(
                f"the causes {before.cause} and {after.cause} declare the same name or rank: "
                f"{before.name} {before.rank}, {after.name} {after.rank}"
            )
    return {recipe.name: recipe for recipe in recipes}


CAUSES = declared()
"""Declarations of all causes, by the names of their files."""
REGISTRY = ranked(CAUSES)
"""All recipes by their names, in order of rank."""
RECIPES = {name: item for name, item in REGISTRY.items() if item.kind in ("catalogue", "parts")}
STRANGERS = {name: item for name, item in REGISTRY.items() if item.kind == "stranger"}
NOISES = {name: item for name, item in REGISTRY.items() if item.kind == "noise"}
