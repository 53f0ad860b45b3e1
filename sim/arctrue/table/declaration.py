"""Defines how a cause of the simulated table declares its values and its random draws."""

from __future__ import annotations

import cmath
import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Annotated, Literal

import numpy as np
from msgspec import Meta, Struct

from arctrue.table.cause import Cause
from arctrue.table.head import Head
from arctrue.table.rotary_table import two_heads

MICROMETRE_M = 1e-6
STROKE_DEG = 1.0
"""Default travel after a reversal within which the friction of a bearing changes its sign."""
TURNS, NYQUIST_HZ, ROWS = 12, 125.0, 24_000
"""Turns, half the row rate (mean over the runs, Hz), and rows of the full experiment with the
benchmark's 6,000 samples per run; causes compute from them how many places a search tries.
"""

Random = np.random.Generator
Order = Annotated[int, Meta(ge=1)]
HeadNumber = Annotated[int, Meta(ge=1, le=4)]
Half = Annotated[float, Meta(ge=-0.5, le=0.5)]

Kind = Literal["catalogue", "parts", "stranger", "noise"]
"""Kinds of a cause: an effect of the workbench's catalogue; a product of parts (a condition times a
wave); a stranger, which is neither of these; and noise, which is no effect."""


class Given(Struct, frozen=True, forbid_unknown_fields=True):
    """Values of a cause, by the keys that a ``[[cause]]`` of a scenario file has."""

    name: str

    def physical(self, lines: int) -> Cause:
        """Return the cause on a disc with this number of lines. Raises ValueError if the values
        contradict each other."""
        raise NotImplementedError


@dataclass(frozen=True, slots=True)
class Occasion:
    """Facts about the runs of a measurement that a random draw may use."""

    starts_s: tuple[float, ...]
    durations_s: tuple[float, ...]
    """Duration of each run of the capture, seconds."""
    speeds_rad_s: tuple[float, ...]
    heads: tuple[Head, ...] = two_heads()
    """Heads on which a cause of one head may act."""

    @property
    def turns(self) -> float:
        """Number of turns of all runs together, in either direction."""
        travel = zip(self.durations_s, self.speeds_rad_s, strict=True)
        return sum(seconds * abs(speed) for seconds, speed in travel) / (2 * np.pi)

    @property
    def end_s(self) -> float:
        """End of the last run; 0 if there is no run."""
        return self.starts_s[-1] + self.durations_s[-1] if self.starts_s else 0.0


Draw = Callable[[float, Random, Occasion], list[Cause]]
"""Function that draws a random cause of a given size.

A draw describes the change of the table, the counters or the instrument; it does not depend on the
workbench's description of the same effect. Draws include hard cases: a gear may look like a polygon
error, and two heads may hardly determine the drawn order.
"""


@dataclass(frozen=True, slots=True, kw_only=True)
class Recipe:
    """A range of sizes that occur on real tables, and the function that draws a cause with such a
    size."""

    name: str
    """Name of the cause in commands and answers; for the kind ``catalogue``, the name of the
    workbench's effect.
    """
    unit: str
    """Unit of the size."""
    low: float
    high: float
    draw: Draw
    rank: int
    """Position in the pools from which the benchmark draws; a new recipe gets the next number."""
    coefficients: int = 0
    """Number of coefficients of the cause's true form, which the ideal test fits; 0 for noise."""
    coefficients_of_more_heads: int = 0
    """The same number if the capture has three or four heads, which show both directions in which
    the axis moves; 0: as with two heads."""
    places: float = 1
    """Number of orders, frequencies, instants, places on the disc or time constants that a search
    for the cause tries."""
    kind: Kind = "catalogue"
    parts: tuple[str, ...] = ()
    """Names of the factors of a product of parts."""
    cause: str = ""
    """Name of the file that defines the cause; the registry sets it."""

    @property
    def in_catalogue(self) -> bool:
        """True if the workbench has an effect of this name."""
        return self.kind == "catalogue"

    def draw_size(self, random: Random) -> float:
        """Draw a size between ``low`` and ``high``, uniform in its logarithm."""
        return float(np.exp(random.uniform(np.log(self.low), np.log(self.high))))


@dataclass(frozen=True, slots=True)
class Declaration:
    """Declares a cause: the constant ``DECLARATION`` at the end of the cause's file."""

    kind: type[Cause]
    values: type[Given] | None = None
    """Values that a scenario file may give; None: the cause is only drawn at random."""
    recipes: tuple[Recipe, ...] = ()


def rising(key: str, instants_s: tuple[float, ...], least: int) -> None:
    """Raise ValueError if there are fewer than ``least`` instants, or if they do not rise."""
    if len(instants_s) < least or list(instants_s) != sorted(set(instants_s)):
        expected = "rising instants" if least == 1 else "two or more rising instants"
        raise ValueError(f"{key}: expected {expected}, found {list(instants_s)}")


def ellipse(forward_um: float, backward_um: float, direction_deg: float) -> tuple[complex, complex]:
    """Return the complex factors of a motion's forward circle and backward circle, metres."""
    phase = math.radians(direction_deg)
    return (
        cmath.rect(forward_um * MICROMETRE_M, phase),
        cmath.rect(backward_um * MICROMETRE_M, phase),
    )
