"""Finds the worlds of the independent generator (this package): each file in ``worlds`` defines one
world."""

from __future__ import annotations

import importlib
import pkgutil
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache

import numpy as np

from arctrue.studies.benchmark.independent import worlds as folder
from arctrue.studies.benchmark.independent.scene import Scene

Draw = Callable[[np.random.Generator, bool, int], Scene]
NOTHING, HIDDEN = "nothing", "hidden"


@dataclass(frozen=True, slots=True)
class World:
    """World: a kind of measurement from which sets are drawn."""

    name: str
    about: str
    """Description of the measurement and of what may be hidden: the first paragraph of the world's
    file."""
    draw: Draw
    """Function that draws a scene. Its arguments are a random generator, whether a cause is hidden,
    and the largest number of rows in a run or a log."""
    contents: tuple[str, ...]
    """Contents that sets of the world may have: ``nothing`` (no cause), ``hidden`` (at least one
    cause)."""


@cache
def independent_worlds() -> dict[str, World]:
    """Return every world by the name of its file, in alphabetical order."""
    found = {}
    for item in pkgutil.iter_modules(folder.__path__):
        module = importlib.import_module(f"{folder.__name__}.{item.name}")
        about = " ".join((module.__doc__ or "").split("\n\n")[0].split())
        contents = getattr(module, "CONTENTS", (NOTHING, HIDDEN))
        found[item.name] = World(item.name, about, module.draw, contents)
    return dict(sorted(found.items()))
