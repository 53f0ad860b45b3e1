"""Defines optional parts of the coefficients: conditions, phase of orders that are not integers,
local table."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import permutations
from typing import Final

import numpy as np

from arctrue.generated.number_formats import (
    ANGLE_WIDTH,
    DEAD_ZONE_WIDTH,
    LOCAL_INDEX_WIDTH,
    LOCAL_POINT_WIDTH,
    ORDER_WIDTH,
    PHASE_WIDTH,
    STOP_FRACTION,
    STOP_WIDTH,
)

MODULATORS: Final = ("one", "direction", "speed", "speed_squared", "word_a", "word_b")
"""Factors of a lane's amplitude; a lane's word contains the index of its factor."""
PHASE_SOURCES: Final = ("operator", "heads", "probe")
"""Origins of the phase of a lane whose order is not an integer (a real order); the index of an
origin is its number in the device."""
POINTS: Final = 1 << LOCAL_INDEX_WIDTH
"""Number of points of a local table."""
POINT_LIMIT: Final = 1 << (LOCAL_POINT_WIDTH - 1)
"""Limit of a point's word: from −POINT_LIMIT to POINT_LIMIT − 1."""
FOLLOWED_LANES_MOST: Final = 8
"""Largest number of lanes with a modulator in the firmware."""
REAL_LANES_MOST: Final = 8
"""Largest number of lanes with real orders in the firmware."""
FRACTION_BITS: Final = (4, 6, 8, 10)
WINDOW_EXPONENT_MOST: Final = 6
WIDTH_ONE: Final = 1 << STOP_FRACTION
"""Word of a width of one count, u20.4 counts."""
DEAD_ZONE_MOST: Final = (1 << DEAD_ZONE_WIDTH) - 1
"""Largest dead zone, counts."""


@dataclass(frozen=True)
class Conditions:
    """Parameters with which the gateware measures direction and speed: width W (``width``, u20.4
    counts), dead zone in counts, and nominal speed. The direction h changes from −1 to 1 within a
    travel of 2·W."""

    width: int
    dead_zone_counts: int
    nominal_deg_per_s: float

    def __post_init__(self) -> None:
        """Raise ValueError for values outside the registers' range."""
        if not 1 <= self.width < 1 << STOP_WIDTH:
            raise ValueError(
                f"width: word {self.width}, expected 1 to 2^{STOP_WIDTH} - 1 (1/{WIDTH_ONE} count)"
            )
        if not 0 <= self.dead_zone_counts <= DEAD_ZONE_MOST:
            raise ValueError(
                f"dead_zone_counts: {self.dead_zone_counts}, expected 0 to {DEAD_ZONE_MOST}"
            )
        if not 0.0 < self.nominal_deg_per_s <= 36_000.0:
            raise ValueError(
                f"nominal_deg_per_s: {self.nominal_deg_per_s:g}, expected above 0, up to 36000"
            )


@dataclass(frozen=True)
class LocalTable:
    """A table of corrections at equal angles, for one, two or four windows of the turn.

    ``points``: up to 4,096 words in 2⁻ᶠ count, F = ``fraction_bits``, divided evenly among the
    windows that begin at ``starts_counts`` (one, two or four), each 2^-``width_exponent`` turn.
    """

    points: tuple[int, ...]
    starts_counts: tuple[int, ...]
    width_exponent: int
    fraction_bits: int

    def __post_init__(self) -> None:
        """Raise ValueError for values outside the gateware's range."""
        if self.fraction_bits not in FRACTION_BITS:
            raise ValueError(f"fraction_bits: {self.fraction_bits}, expected 4, 6, 8 or 10")
        if len(self.starts_counts) not in (1, 2, 4):
            raise ValueError(f"starts_counts: expected 1, 2 or 4, found {len(self.starts_counts)}")
        if not 0 <= self.width_exponent <= WINDOW_EXPONENT_MOST:
            raise ValueError(f"width_turn: expected 1, 1/2, to 1/{1 << WINDOW_EXPONENT_MOST}")
        if any(not 0 <= start < 1 << ANGLE_WIDTH for start in self.starts_counts):
            raise ValueError(f"starts_counts: {self.starts_counts}, expected counts of one turn")
        if len(self.points) > POINTS:
            raise ValueError(f"points: {len(self.points)}, the table has {POINTS}")
        for number, point in enumerate(self.points):
            if not -POINT_LIMIT <= point < POINT_LIMIT:
                raise ValueError(
                    f"points[{number}]: {point}, expected {-POINT_LIMIT} to {POINT_LIMIT - 1}; "
                    "choose fewer fraction_bits"
                )

    def steepest(self, counts_per_rev: int) -> float:
        """Return a bound of the table's |dε/dR|, as the firmware computes it.

        At the start of a window shorter than a turn the value steps from 0 to the first point,
        which counts as a slope over one count. The last interval leads back to the first point, so
        that the step to 0 at the end differs from the step at the start by at most the change
        within one count.
        """
        windows = len(self.starts_counts)
        words = np.zeros(POINTS)
        words[: len(self.points)] = self.points
        each = words.reshape(windows, -1) / float(1 << self.fraction_bits)
        between = counts_per_rev / float(2**self.width_exponent * each.shape[1])
        rise = float(np.abs(np.roll(each, -1, axis=1) - each).max()) / between
        leap = float(np.abs(each[:, 0]).max()) if self.width_exponent else 0.0
        return rise + leap

    def overlap(self, counts_per_rev: int) -> tuple[int, int] | None:
        """Return the starts of two windows that overlap or touch, or None. A window with the same
        start as an earlier window is never used."""
        for one, other in permutations(self.starts_counts, 2):
            away = (other - one) % counts_per_rev
            if away and (away - 1) << self.width_exponent < counts_per_rev:
                return one, other
        return None


@dataclass(frozen=True)
class PhaseSource:
    """Origin from which the device gets the phase of a lane of a real order.

    ``heads``: the harmonic is fixed to the disc, and the difference of the heads shows it.
    ``probe``: at each rising edge of ``probe_in``, an index of the drive, the harmonic has the
    phase ``probe_phase`` (u0.24 turn) plus ``side`` times the table's angle.
    """

    source: str
    side: int = 0
    probe_phase: int = 0

    def __post_init__(self) -> None:
        """Raise ValueError for an unknown origin or a word outside its format."""
        if self.source not in PHASE_SOURCES[1:]:
            raise ValueError(
                f"phase_from: {self.source!r}, expected one of {', '.join(PHASE_SOURCES[1:])}"
            )
        if self.source != "probe" and (self.side or self.probe_phase):
            raise ValueError(f"probe_side, probe_phase: expected none with {self.source!r}")
        if not 0 <= self.probe_phase < 1 << PHASE_WIDTH or abs(self.side) >= 1 << ORDER_WIDTH:
            raise ValueError(
                f"probe_phase: {self.probe_phase}, probe_side: {self.side}; expected 0 to "
                f"2^{PHASE_WIDTH} - 1, and less than 2^{ORDER_WIDTH}"
            )

    @property
    def numbers(self) -> list[int]:
        """Return the numbers with which the device's console describes this origin."""
        return [PHASE_SOURCES.index(self.source), self.side, self.probe_phase]
