"""Models the entity ``local_table``, which interpolates a correction between points of a turn."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from arctrue.gateware.extension import FRACTION_BITS, POINT_LIMIT, POINTS, WINDOW_EXPONENT_MOST
from arctrue.gateware.phase_lane import phase_lane
from arctrue.generated.number_formats import (
    LOCAL_INDEX_WIDTH,
    LOCAL_POINT_WIDTH,
    LOCAL_VALUE_FRACTION,
    LOCAL_WINDOWS,
    PHASE_STEP_WIDTH,
    PHASE_WIDTH,
)

if TYPE_CHECKING:
    from arctrue.gateware import extension

LINE_WIDTH = LOCAL_INDEX_WIDTH
"""Number of bits of the position between two points."""


@dataclass(frozen=True, eq=False)
class LocalTable:
    """One bank of the table in the words of the register map.

    ``starts``: first count of each of the one, two or four windows; ``width``: a window is 2^−width
    turn; ``fraction``: F, fraction bits of a point; ``points``: int64 (4096,).
    """

    counts_per_rev: int
    starts: tuple[int, ...]
    width: int
    fraction: int
    points: NDArray[np.int64]

    def __post_init__(self) -> None:
        """Raise ValueError for a table that the gateware cannot hold."""
        if len(self.starts) not in (1, 2, 4):
            raise ValueError(f"{len(self.starts)} windows; expected one, two or four")
        if any(not 0 <= start < self.counts_per_rev for start in self.starts):
            raise ValueError(
                f"starts {self.starts}: expected 0 to {self.counts_per_rev - 1} counts"
            )
        if not (0 <= self.width <= WINDOW_EXPONENT_MOST and self.fraction in FRACTION_BITS):
            raise ValueError(
                f"a window of 2^-{self.width} turn with {self.fraction} fraction bits: expected "
                f"2^-0 to 2^-{WINDOW_EXPONENT_MOST} turn and one of {FRACTION_BITS}"
            )
        if self.points.shape != (POINTS,) or np.abs(self.points + 0.5).max() > POINT_LIMIT:
            raise ValueError(f"points: expected {POINTS} words of {LOCAL_POINT_WIDTH} bits")

    @classmethod
    def of_file(cls, table: extension.LocalTable, counts_per_rev: int) -> LocalTable:
        """Return the bank for the table of a coefficient file; points that the file lacks are 0.

        Raises ValueError for a table that the gateware cannot hold.
        """
        points = np.zeros(POINTS, dtype=np.int64)
        points[: len(table.points)] = table.points
        return cls(
            counts_per_rev, table.starts_counts, table.width_exponent, table.fraction_bits, points
        )

    def place_words(self) -> list[int]:
        """Return the seven words of the register window ``local_place``, the choice first."""
        windows = len(self.starts)
        choice = (
            ((1 << windows) - 1)
            | (windows.bit_length() - 1) << 4
            | self.width << 8
            | FRACTION_BITS.index(self.fraction) << 12
        )
        starts = [*self.starts, *[0] * (LOCAL_WINDOWS - windows)]
        return [choice, *starts, self.step & 0xFFFF_FFFF, self.step >> 32]

    @property
    def step(self) -> int:
        """Return round(2⁴⁸·2^width / counts_per_rev), the part of a window that one count covers,
        u0.48."""
        turn = self.counts_per_rev
        return ((1 << (PHASE_STEP_WIDTH + self.width + 1)) + turn) // (2 * turn)


def line_bound(table: LocalTable) -> float:
    """Return the bound of the interpolation error, counts; the entity's header states its parts."""
    each = table.points.reshape(len(table.starts), -1)
    rise = np.abs(np.roll(each, -1, axis=1) - each).max() / 2.0**table.fraction
    places = 2.0**-13 + 2.0**-13 + (0.0 if len(table.starts) == 1 else 2.0**-12)
    return float(rise * places)


def local_table(angle: ArrayLike, table: LocalTable) -> NDArray[np.int64]:
    """Return the correction in 2⁻²² count for ``angle``, counts below counts_per_rev, (angles,); it
    is 0 outside all windows."""
    angles = np.asarray(angle, dtype=np.int64)
    offsets = (angles[:, np.newaxis] - np.array(table.starts)) % table.counts_per_rev
    inside = offsets << table.width < table.counts_per_rev
    window = np.argmax(inside, axis=1)
    place = phase_lane(offsets[np.arange(angles.size), window], table.step, 0).astype(np.int64)
    number = POINTS // len(table.starts)
    below = PHASE_WIDTH - (number - 1).bit_length()
    index = place >> below
    part = (place & ((1 << below) - 1)) >> (below - LINE_WIDTH)
    first = table.points[window * number + index]
    second = table.points[window * number + (index + 1) % number]
    line = (first << LINE_WIDTH) + (second - first) * part
    value = line << (LOCAL_VALUE_FRACTION - LINE_WIDTH - table.fraction)
    return np.where(inside.any(axis=1), value, 0)
