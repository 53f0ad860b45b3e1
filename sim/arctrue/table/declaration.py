"""Declaration of a cause of the simulated table: its values, and how it is drawn."""

from __future__ import annotations

import cmath
import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Annotated, Literal

import numpy as np
from msgspec import Meta, Struct

from arctrue.table.cause import Cause

MICROMETRE_M = 1e-6
STROKE_DEG = 1.0
"""Default stroke of travel after a reversal in which a bearing's friction changes over."""
TURNS, NYQUIST_HZ, ROWS = 12, 125.0, 24_000
"""Turns, half the row rate and rows of the full experiment: the range of a search."""

Random = np.random.Generator
Order = Annotated[int, Meta(ge=1)]
HeadNumber = Annotated[int, Meta(ge=1, le=4)]
Half = Annotated[float, Meta(ge=-0.5, le=0.5)]

Kind = Literal["catalogue", "parts", "stranger", "noise"]
"""Kinds of a cause: effect of the catalogue, product of parts, error that is neither, or noise,
which is no effect."""


class Given(Struct, frozen=True, forbid_unknown_fields=True):
    """Values of a cause, by their keys in a ``[[cause]]`` of a scenario."""

    name: str

    def physical(self, lines: int) -> Cause:
        """Return the cause on a disc of ``lines``; ValueError for values that do not agree."""
        raise NotImplementedError


@dataclass(frozen=True, slots=True)
class Occasion:
    """Facts about the runs of the measurement that a random draw may use."""

    starts_s: tuple[float, ...]
    durations_s: tuple[float, ...]
    """One entry per run of the capture."""
    speeds_rad_s: tuple[float, ...]

    @property
    def turns(self) -> float:
        """All runs together, in either direction."""
        travel = zip(self.durations_s, self.speeds_rad_s, strict=True)
        return sum(seconds * abs(speed) for seconds, speed in travel) / (2 * np.pi)

    @property
    def end_s(self) -> float:
        """End of the last run; 0 without one."""
        return self.starts_s[-1] + self.durations_s[-1] if self.starts_s else 0.0


Draw = Callable[[float, Random, Occasion], list[Cause]]
"""Draws a cause at random for a given size.

A draw describes the change of the table, the counters or the instrument; it does not depend on the
workbench's description of the same effect. Draws are not made easier: a gear may look like a
polygon error, an order may be one to which two heads are nearly blind.
"""


@dataclass(frozen=True, slots=True, kw_only=True)
class Recipe:
    """A range of sizes, as they have been seen on real tables, in which a cause is drawn."""

    name: str
    """Name of the effect in the catalogue."""
    unit: str
    """Unit of the size."""
    low: float
    high: float
    draw: Draw
    rank: int
    """Position in the pools from which the benchmark draws; a new recipe takes the next number."""
    coefficients: int = 0
    """Degrees of freedom of the true form, for the ideal test; 0 for noise."""
    places: float = 1
    """Orders, frequencies, instants, places on the disc or time constants to search through."""
    kind: Kind = "catalogue"
    parts: tuple[str, ...] = ()
    """Factors of a product of parts."""
    cause: str = ""
    """Name of the cause's file, set by the registry."""

    @property
    def in_catalogue(self) -> bool:
        """True if the workbench has an effect of this name."""
        return self.kind == "catalogue"

    def draw_size(self, random: Random) -> float:
        """Draw a size between low and high, log-uniformly."""
        return float(np.exp(random.uniform(np.log(self.low), np.log(self.high))))


@dataclass(frozen=True, slots=True)
class Declaration:
    """The constant ``DECLARATION`` at the end of a cause's file."""

    kind: type[Cause]
    values: type[Given] | None = None
    """Values that a scenario may give; None: the cause is only drawn."""
    recipes: tuple[Recipe, ...] = ()


def rising(key: str, instants_s: tuple[float, ...], least: int) -> None:
    """Raise ValueError for fewer than ``least`` instants, or instants that do not rise."""
    if len(instants_s) < least or list(instants_s) != sorted(set(instants_s)):
        expected = "rising instants" if least == 1 else "two or more rising instants"
        raise ValueError(f"{key}: expected {expected}, found {list(instants_s)}")


def ellipse(forward_um: float, backward_um: float, direction_deg: float) -> tuple[complex, complex]:
    """Return the forward and the backward circle of a motion, metres."""
    phase = math.radians(direction_deg)
    return (
        cmath.rect(forward_um * MICROMETRE_M, phase),
        cmath.rect(backward_um * MICROMETRE_M, phase),
    )
