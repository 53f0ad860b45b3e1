"""How a cause of the simulated table declares itself: its values, and how it is drawn."""

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
"""Travel after a reversal in which a bearing's friction goes over, where none is given."""
TURNS, NYQUIST_HZ, ROWS = 12, 125.0, 24_000
"""Turns, half the row rate and rows of the full experiment, through which a search goes."""

Random = np.random.Generator
Order = Annotated[int, Meta(ge=1)]
HeadNumber = Annotated[int, Meta(ge=1, le=4)]
Half = Annotated[float, Meta(ge=-0.5, le=0.5)]

Kind = Literal["catalogue", "parts", "stranger", "noise"]
"""An effect of the catalogue; a product of parts; neither of both; noise, which is no effect."""


class Given(Struct, frozen=True, forbid_unknown_fields=True):
    """Values of a cause, by their keys in a ``[[cause]]`` of a scenario."""

    name: str

    def physical(self, lines: int) -> Cause:
        """Return the cause on a disc of ``lines``; ValueError for values that do not agree."""
        raise NotImplementedError


@dataclass(frozen=True, slots=True)
class Occasion:
    """What a draw may know of the measurement: its runs."""

    starts_s: tuple[float, ...]
    durations_s: tuple[float, ...]
    """Of each run of the capture."""
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

A draw says what happens to the table, the counters or the instrument; it knows nothing of how the
workbench describes the same effect. Draws are not made easier: a gear may look like a polygon
error, an order may be one to which two heads are nearly blind.
"""


@dataclass(frozen=True, slots=True, kw_only=True)
class Recipe:
    """A range of sizes, as they have been seen on real tables, in which a cause is drawn."""

    name: str
    """Of the effect, as the catalogue has it."""
    unit: str
    """Of the size."""
    low: float
    high: float
    draw: Draw
    rank: int
    """Place in the pools from which the benchmark draws; a new recipe takes the next number."""
    coefficients: int = 0
    """Of the true form, for the ideal test; 0: noise, for which there is none."""
    places: float = 1
    """Orders, frequencies, instants, places on the disc or time constants to search through."""
    kind: Kind = "catalogue"
    parts: tuple[str, ...] = ()
    """Of a product of parts: its factors."""
    cause: str = ""
    """Name of the cause's file; the registry fills it in."""

    @property
    def in_catalogue(self) -> bool:
        """The workbench knows an effect of this name."""
        return self.kind == "catalogue"

    def draw_size(self, random: Random) -> float:
        """Draw a size between low and high, as likely in each octave."""
        return float(np.exp(random.uniform(np.log(self.low), np.log(self.high))))


@dataclass(frozen=True, slots=True)
class Declaration:
    """The constant ``DECLARATION`` at the end of a cause's file."""

    kind: type[Cause]
    values: type[Given] | None = None
    """Values that somebody may give; None: it is only drawn."""
    recipes: tuple[Recipe, ...] = ()


def rising(key: str, instants_s: tuple[float, ...], least: int) -> None:
    """Raise ValueError where fewer than ``least`` instants are given, or they do not rise."""
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
