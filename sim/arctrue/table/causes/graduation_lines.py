"""Each line has an error of its own."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from arctrue.table.causes.base import PhysicalEffect
from arctrue.table.state import TableState


@dataclass(frozen=True, slots=True)
class GraduationLines(PhysicalEffect):
    """Errors of single lines, evenly spread from disc angle 0; straight between neighbours.

    ``errors_rad`` has the shape ``(lines,)``. A head sees many lines at once, so the errors of
    ``lines_seen`` neighbours are averaged.
    """

    errors_rad: NDArray[np.float64]
    lines_seen: int = 1

    def __post_init__(self) -> None:
        """Refuse what cannot be built."""
        if self.errors_rad.ndim != 1 or self.errors_rad.size < 2:
            raise ValueError(
                f"line errors must be one row, found the shape {self.errors_rad.shape}"
            )
        if not 1 <= self.lines_seen <= self.errors_rad.size:
            raise ValueError(f"a head cannot see {self.lines_seen} of {self.errors_rad.size} lines")

    def seen_errors_rad(self) -> NDArray[np.float64]:
        """The errors as a head sees them: the mean of ``lines_seen`` lines about each line."""
        around = np.arange(self.lines_seen) - (self.lines_seen - 1) // 2
        lines = np.arange(self.errors_rad.size)
        seen = np.zeros_like(self.errors_rad)
        for shift in around:
            seen += self.errors_rad[(lines + shift) % lines.size]
        return seen / self.lines_seen

    def graduation_error_rad(
        self, disc_angle_rad: NDArray[np.float64], state: TableState
    ) -> NDArray[np.float64]:
        """Straight interpolation between the lines, shape ``(n,)``."""
        lines_rad = np.arange(self.errors_rad.size) * (2 * np.pi / self.errors_rad.size)
        return np.interp(disc_angle_rad, lines_rad, self.seen_errors_rad(), period=2 * np.pi)
