"""Stores all rows of a long capture in little memory; columns that follow from the stored columns
are calculated for the requested rows only.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from math import gcd

import numpy as np
from numpy.typing import NDArray

from arctrue.base.runs import run_spans
from arctrue.base.units import ARCSEC_PER_RAD
from arctrue.measurement import Table
from arctrue.workbench.observations.contrasts import contrast_weights
from arctrue.workbench.observations.head_noise import HeadNoise
from arctrue.workbench.observations.rows import CaptureRows, Float, Integer
from arctrue.workbench.observations.run_speed import RunSpeeds

Small = NDArray[np.int32]


@dataclass(frozen=True)
class RunFacts:
    """Values that are constant within a run: arrays of shape (runs,)."""

    start_s: Float
    direction: Float
    """Direction of each run, +1 or −1."""


@dataclass(frozen=True)
class StoredCapture:
    """Stores a capture with two heads and a temperature in 48 bytes per row, without further
    columns. A row in :class:`CaptureRows` takes 112 bytes, but exists only for a part of the
    capture at a time.

    With three or four heads each sample has one row per channel, as :class:`CaptureRows` describes.
    The counts are stored once per sample: row k belongs to sample ``sample[k]``.
    """

    table: Table
    run: Small
    """Number of the run, 0 … runs − 1, in the order of the file."""
    revolution: Small
    """Number of the revolution, counted over all runs; an unfinished revolution has a number of its
    own."""
    time_s: Float
    temperature_c: Float | None
    head1_counts: Integer
    head2_counts: Integer
    angle_rad: Float
    speed: RunSpeeds
    run_facts: RunFacts
    set_start_s: float
    session_start_s: float
    head_separation_rad: float
    reference_temperature_c: float
    u_arcsec: Float | None = None
    conditions: Mapping[str, Float] = field(default_factory=dict)
    reference_in_time: bool = False
    further_counts: tuple[Integer, ...] = ()
    """Counts of heads 3 and 4, in the same form as the counts of heads 1 and 2."""
    sample: Integer | None = None
    """Number of the sample of each row; None if row k is sample k."""
    channel: Integer | None = None
    """Channel of each row, as in :class:`CaptureRows`."""
    head: int = 2
    """Number of the head whose counts are ``head2_counts``, as in :class:`CaptureRows`."""
    head_noise: HeadNoise | None = None
    """Noise of the heads, as in :class:`CaptureRows`."""

    @property
    def size(self) -> int:
        """Number of rows."""
        return int(self.run.size)

    @property
    def runs(self) -> int:
        """Number of runs."""
        return int(self.run_facts.start_s.size)

    @property
    def further_places_rad(self) -> tuple[float, ...]:
        """Angles of heads 3 and 4 relative to head 1."""
        places = self.table.head_places_deg or ()
        return tuple(float(np.radians(place)) for place in places[2 : 2 + len(self.further_counts)])

    def samples(self, rows: slice | Integer) -> slice | Integer:
        """Return the numbers of the samples of the given rows."""
        return rows if self.sample is None else self.sample[rows]

    def difference_rad(self, rows: slice | Integer) -> Float:
        """Return R₂ − R₁ − α (nominal) of the given rows, or the contrast of their channels."""
        samples = self.samples(rows)
        apart = self._apart_rad(self.head2_counts, samples, self.head_separation_rad)
        if self.channel is None:
            return apart
        covariance = None if self.head_noise is None else self.head_noise.covariance
        weights = contrast_weights(2 + len(self.further_counts), covariance)[self.channel[rows]]
        apart = weights[:, 0] * apart
        for number, counts in enumerate(self.further_counts):
            place_rad = self.further_places_rad[number]
            apart += weights[:, number + 1] * self._apart_rad(counts, samples, place_rad)
        return apart

    def _apart_rad(self, counts: Integer, samples: slice | Integer, place_rad: float) -> Float:
        """Return Rᵢ − R₁ minus the nominal angle from head 1 to head i."""
        assert self.table.counts_per_rev is not None
        apart = (counts[samples] - self.head1_counts[samples]).astype(np.float64)
        apart *= 2.0 * np.pi / self.table.counts_per_rev
        apart -= place_rad
        return np.asarray(apart)

    def of_head(self, head: int) -> StoredCapture:
        """Return every sample once, with the counts of head ``head`` in place of the counts of head
        2."""
        if self.channel is None or self.sample is None:
            return self
        first = np.flatnonzero(self.channel == 0)
        channels = len(self.further_counts) + 1
        counts = (self.head2_counts, *self.further_counts)[head - 2]
        place_rad = (self.head_separation_rad, *self.further_places_rad)[head - 2]
        return replace(
            self,
            run=self.run[first] // np.int32(channels),
            revolution=self.revolution[first] // np.int32(channels),
            time_s=self.time_s[first],
            temperature_c=None if self.temperature_c is None else self.temperature_c[first],
            head2_counts=counts,
            angle_rad=self.angle_rad[first],
            speed=self.speed.every(channels, first),
            run_facts=RunFacts(
                self.run_facts.start_s[::channels], self.run_facts.direction[::channels]
            ),
            head_separation_rad=place_rad,
            u_arcsec=None if self.u_arcsec is None else self.u_arcsec[first],
            conditions={name: column[first] for name, column in self.conditions.items()},
            further_counts=(),
            sample=None,
            channel=None,
            head=head,
            head_noise=None,
        )

    def run_spans(self) -> list[tuple[int, int]]:
        """Return the first row and the row after the last row of each run, in the order of the
        file."""
        return run_spans(self.run)

    def rows(self, rows: slice | Integer) -> CaptureRows:
        """Return the given rows with all their conditions."""
        assert self.table.counts_per_rev is not None
        count_rad = 2.0 * np.pi / self.table.counts_per_rev
        samples = self.samples(rows)
        reading1 = self.head1_counts[samples].astype(np.float64) * count_rad
        apart = self._apart_rad(self.head2_counts, samples, self.head_separation_rad)
        further = [counts[samples] for counts in self.further_counts]
        phases = [electrical_rad(counts, self.table) for counts in further]
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
            line2_rad=reading1 + apart + self.head_separation_rad,
            electrical1_rad=electrical_rad(self.head1_counts[samples], self.table),
            electrical2_rad=electrical_rad(self.head2_counts[samples], self.table),
            run_start_s=self.run_facts.start_s[run],
            set_start_s=self.set_start_s,
            session_start_s=self.session_start_s,
            runs=self.runs,
            head_separation_rad=self.head_separation_rad,
            reference_temperature_c=self.reference_temperature_c,
            difference_arcsec=self.difference_rad(rows) * ARCSEC_PER_RAD,
            u_arcsec=None if self.u_arcsec is None else self.u_arcsec[rows],
            conditions={name: column[rows] for name, column in self.conditions.items()},
            reference_in_time=self.reference_in_time,
            channel=None if self.channel is None else self.channel[rows],
            further_places_rad=self.further_places_rad,
            further_line_rad=np.stack([counts * count_rad for counts in further], axis=1)
            if further
            else None,
            further_electrical_rad=np.stack([item for item in phases if item is not None], axis=1)
            if further and phases[0] is not None
            else None,
            head=self.head,
            head_noise=self.head_noise,
        )


def electrical_rad(counts: Integer | None, table: Table) -> Float | None:
    """Return 2π·frac(counts·lines/counts_per_rev), calculated in integers without rounding."""
    if counts is None or table.grating_lines is None or table.counts_per_rev is None:
        return None
    # The ratio is in lowest terms, so that the product fits into 64 bits.
    common = gcd(table.counts_per_rev, table.grating_lines)
    period, multiple = table.counts_per_rev // common, table.grating_lines // common
    within = (counts % period) * (multiple % period) % period
    return within.astype(np.float64) * (2.0 * np.pi / period)
