"""All rows of a long capture, kept small: conditions are worked out for a stretch at a time."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from math import gcd

import numpy as np
from numpy.typing import NDArray

from arctrue.base.runs import run_spans
from arctrue.base.units import ARCSEC_PER_RAD
from arctrue.measurement import Table
from arctrue.workbench.observations.rows import CaptureRows, Float, Integer
from arctrue.workbench.observations.run_speed import RunSpeeds

Small = NDArray[np.int32]


@dataclass(frozen=True)
class RunFacts:
    """What is one value a run, arrays of shape (runs,)."""

    start_s: Float
    direction: Float
    """+1 or −1."""


@dataclass(frozen=True)
class StoredCapture:
    """Every row in 48 bytes; :class:`CaptureRows` takes 112 and is made a part at a time."""

    table: Table
    run: Small
    """0 … runs − 1, in the order of the file."""
    revolution: Small
    """Number of the revolution, counted over all runs; an unfinished rest has its own."""
    time_s: Float
    temperature_c: Float | None
    head1_counts: Integer
    head2_counts: Integer
    angle_rad: Float
    speed: RunSpeeds
    run_facts: RunFacts
    set_start_s: float
    head_separation_rad: float
    reference_temperature_c: float
    u_arcsec: Float | None = None
    conditions: Mapping[str, Float] = field(default_factory=dict)
    reference_in_time: bool = False

    @property
    def size(self) -> int:
        """Rows."""
        return int(self.run.size)

    @property
    def runs(self) -> int:
        """Runs."""
        return int(self.run_facts.start_s.size)

    def difference_rad(self, rows: slice | Integer) -> Float:
        """R₂ − R₁ − α (nominal) of some rows."""
        assert self.table.counts_per_rev is not None
        apart = (self.head2_counts[rows] - self.head1_counts[rows]).astype(np.float64)
        apart *= 2.0 * np.pi / self.table.counts_per_rev
        apart -= self.head_separation_rad
        return np.asarray(apart)

    def run_spans(self) -> list[tuple[int, int]]:
        """First row and row after the last of each stretch of one run, in the order of the file."""
        return run_spans(self.run)

    def rows(self, rows: slice | Integer) -> CaptureRows:
        """Some rows with all their conditions."""
        assert self.table.counts_per_rev is not None
        count_rad = 2.0 * np.pi / self.table.counts_per_rev
        reading1 = self.head1_counts[rows].astype(np.float64) * count_rad
        difference = self.difference_rad(rows)
        run = self.run[rows].astype(np.int64)
        angle = self.angle_rad[rows]
        return CaptureRows(
            run=run,
            revolution=self.revolution[rows].astype(np.int64),
            time_s=self.time_s[rows],
            temperature_c=None if self.temperature_c is None else self.temperature_c[rows],
            direction=self.run_facts.direction[run],
            speed_rad_s=self.speed.of(run, rows),
            angle_rad=angle,
            disc1_rad=angle,
            disc2_rad=angle + self.head_separation_rad,
            line1_rad=reading1,
            line2_rad=reading1 + difference + self.head_separation_rad,
            electrical1_rad=electrical_rad(self.head1_counts[rows], self.table),
            electrical2_rad=electrical_rad(self.head2_counts[rows], self.table),
            run_start_s=self.run_facts.start_s[run],
            set_start_s=self.set_start_s,
            runs=self.runs,
            head_separation_rad=self.head_separation_rad,
            reference_temperature_c=self.reference_temperature_c,
            difference_arcsec=difference * ARCSEC_PER_RAD,
            u_arcsec=None if self.u_arcsec is None else self.u_arcsec[rows],
            conditions={name: column[rows] for name, column in self.conditions.items()},
            reference_in_time=self.reference_in_time,
        )


def electrical_rad(counts: Integer | None, table: Table) -> Float | None:
    """2π·frac(counts·lines/counts_per_rev), by whole numbers: no count is rounded."""
    if counts is None or table.grating_lines is None or table.counts_per_rev is None:
        return None
    # In lowest terms, so that the product stays within 64 bits.
    common = gcd(table.counts_per_rev, table.grating_lines)
    period, multiple = table.counts_per_rev // common, table.grating_lines // common
    within = (counts % period) * (multiple % period) % period
    return within.astype(np.float64) * (2.0 * np.pi / period)
