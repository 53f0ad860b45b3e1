"""Describes the progress of a run for the user."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

from arctrue.base.printable import time_left


@dataclass(frozen=True, slots=True)
class RunProgress:
    """Progress of a run: clocks, true angle of the table, and remaining time."""

    stage: str
    """Name of the part of the run that is in progress."""
    clock: int
    """Number of clocks since power-on."""
    clocks_per_s: float
    """Simulated clocks per second of wall time since the previous report."""
    true_angle_rad: float
    """True angle of the table; NaN without a table."""
    share: float = math.nan
    """Fraction of the present motion that is completed; NaN without a motion."""
    seconds_left: float = math.nan
    """Remaining wall time in seconds until the present motion ends, at the present speed of the
    run."""

    @property
    def words(self) -> str:
        """Return the progress as one line of text for the user."""
        table = ""
        if math.isfinite(self.true_angle_rad):
            table = f"table at {self.true_angle_rad / (2 * math.pi):.2f} turns, "
        share = ""
        if math.isfinite(self.share):
            left = time_left(self.seconds_left)
            share = f"{100.0 * self.share:.0f} % of this motion, {left} left; "
        return (
            f"{self.stage}: {share}{table}{self.clock / 1e6:,.1f} million clocks, "
            f"{self.clocks_per_s / 1e3:,.0f} thousand a second"
        )


ReportRun = Callable[[RunProgress], None]
"""Type of the function that receives the progress of a run every few seconds."""
