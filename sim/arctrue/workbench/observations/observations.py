"""Defines the observations that models are fitted to: both channels of a measurement set."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from arctrue.base.runs import run_spans
from arctrue.base.units import ARCSEC_PER_TURN
from arctrue.workbench.observations.file_lines import file_line
from arctrue.workbench.observations.outliers.masked_row import MaskedRow
from arctrue.workbench.observations.rows import CaptureRows, ReferenceRows
from arctrue.workbench.observations.stored import StoredCapture

INDEX_SCATTER_COUNTS = 1.0
"""Repeatability of the index of each head from run to run, ±1 count, if the set does not state it.
"""


@dataclass(frozen=True, eq=False)
class Observations:
    """Measured rows of a set, and the properties of its table that the set states."""

    title: str
    """Title of the set."""
    capture: CaptureRows | None
    """Every row of the capture or, for a long capture, the part that searches and statistics
    use."""
    reference: ReferenceRows | None
    """Every row of the reference or, for a long reference, the part that statistics use."""
    counts_per_rev: int | None
    """Number of counts per turn; None if the set does not state it."""
    grating_lines: int | None
    """Number of lines of the disc; None if the set does not state it."""
    head_separation_rad: float
    """Nominal angle from head 1 to head 2, radians."""
    drive_gear_teeth: float | None
    """Number of teeth of the gear that drives the table; None if the set does not state it."""
    disc_diameter_mm: float | None
    """Diameter of the graduation, millimetres; None if the set does not state it."""
    heads: int = 2
    """Number of heads of the capture."""
    stored: StoredCapture | None = None
    """Every row of the capture, if ``capture`` is only a part."""
    stored_reference: ReferenceRows | None = field(default=None, repr=False)
    """Every row of the reference, if ``reference`` is only a part."""
    masked: tuple[MaskedRow, ...] = ()
    """Rows that are not used, in the order of the files."""
    left_out: tuple[str, ...] = ()
    """Sentences on the runs that are left out."""
    may_mask: bool = True
    """True if single wrong rows may be left out; False if the set, or the caller that reads the
    set, decides which rows are used."""
    outlying_share: Mapping[str, float] = field(default_factory=dict)
    """Share of outliers among the rows of each channel; if the share is above a limit, no outlier
    is masked."""
    used_capture_rows: NDArray[np.int64] | None = field(default=None, repr=False, compare=False)
    """Numbers in the file (0, 1, …) of the used samples; None if all samples are used."""
    capture_sample: NDArray[np.int64] | None = field(default=None, repr=False, compare=False)
    """Number of the sample of each capture row; None if row k is sample k."""
    used_reference_rows: NDArray[np.int64] | None = field(default=None, repr=False, compare=False)
    """Numbers in the file (0, 1, …) of the reference rows that are used; None if all rows are
    used."""
    index_repeatability_counts: float | None = None
    """Standard deviation of one head's index from run to run, as the set states it."""
    reference_uncertainty_arcsec: float | None = None
    """Standard uncertainty of the reference, as the set states it."""

    @property
    def rows(self) -> int:
        """Number of rows that the statistics use, of both channels together."""
        capture = 0 if self.capture is None else self.capture.run.size
        return capture + (0 if self.reference is None else self.reference.run.size)

    def sample_line(self, sample: int) -> int:
        """Find the line in the file of a sample that is used.

        Parameters
        ----------
        sample : int
            Number of the sample among the samples that are used, from 0.

        Returns
        -------
        int
            Number of the line; the header is line 1.
        """
        return file_line(self.used_capture_rows, sample)

    def reference_line(self, row: int) -> int:
        """Find the line in the file of a reference row that is used.

        Parameters
        ----------
        row : int
            Number of the row among the rows that are used, from 0.

        Returns
        -------
        int
            Number of the line; the header is line 1.
        """
        return file_line(self.used_reference_rows, row)

    @property
    def every_reference_row(self) -> ReferenceRows | None:
        """Every row of the reference, even if ``reference`` is only a part."""
        return self.reference if self.stored_reference is None else self.stored_reference

    @property
    def capture_rows(self) -> int:
        """Number of rows of the whole capture."""
        if self.stored is not None:
            return self.stored.size
        return 0 if self.capture is None else self.capture.run.size

    @property
    def runs(self) -> int:
        """Number of runs of the capture; with three or four heads each channel of a run counts as
        one run."""
        return 0 if self.capture is None else self.capture.runs

    @property
    def recorded_runs(self) -> int:
        """Number of runs of the capture as they were recorded, whatever the number of heads."""
        return self.runs // self.channels_of_capture

    def run_words(self, run: int) -> str:
        """Name a run of the capture as it was recorded: ``run 3``, or ``run 1 head 4``.

        Parameters
        ----------
        run : int
            Number of the run in the rows of the capture.

        Returns
        -------
        str
            The recorded run, and the head of its channel if a sample has more than one row.
        """
        return f"run {run}" if self.capture is None else self.capture.run_words(run)

    @property
    def channels_of_capture(self) -> int:
        """Number of rows of each sample of the capture."""
        return 1 if self.capture is None else self.capture.channels

    def pairs(self) -> list[CaptureRows | StoredCapture]:
        """Return the rows of Rᵢ − R₁ of every sample, separately for each head i after head 1.

        Returns
        -------
        list of CaptureRows or StoredCapture
            One entry for each head from head 2 on; empty without a capture.
        """
        if self.stored is not None:
            return [self.stored.of_head(head) for head in range(2, self.heads + 1)]
        rows = self.capture
        if rows is None or rows.channel is None:
            return [] if rows is None else [rows]
        once = rows.part(rows.channel == 0)
        return [once.as_recorded(head) for head in range(2, self.heads + 1)]

    @property
    def faces(self) -> int | None:
        """Number of faces of the polygon, if the reference is a polygon."""
        return None if self.reference is None else self.reference.faces

    @property
    def reference_temperature_c(self) -> float:
        """T₀ of the temperature effects, °C."""
        for rows in (self.capture, self.reference):
            if rows is not None:
                return rows.reference_temperature_c
        return 0.0

    @property
    def channels(self) -> list[str]:
        """Names of the channels that were measured: capture, reference, or both."""
        there = {"capture": self.capture, "reference": self.reference}
        return [name for name, rows in there.items() if rows is not None]

    @property
    def has_temperature(self) -> bool:
        """True if a temperature was recorded with either channel."""
        channels = (self.capture, self.reference)
        return any(rows is not None and rows.temperature_c is not None for rows in channels)

    @property
    def count_arcsec(self) -> float | None:
        """Size of one count in arcseconds."""
        return None if self.counts_per_rev is None else ARCSEC_PER_TURN / self.counts_per_rev

    @property
    def index_sigma_arcsec(self) -> float:
        """Standard deviation of the offset of R₂ − R₁ that both heads' indexes cause in a run.

        The unit is arcseconds. Each index repeats as the set states; without a statement, its error
        is −1, 0 or 1 count with equal probability.
        """
        count = self.count_arcsec or 0.0
        if self.index_repeatability_counts is not None:
            return max(self.index_repeatability_counts * count * float(np.sqrt(2.0)), 1e-6)
        return max(INDEX_SCATTER_COUNTS * count * float(np.sqrt(4.0 / 3.0)), 1e-6)

    @property
    def longest_run_turns(self) -> float:
        """Number of turns of the longest run of the capture."""
        return max((span / (2.0 * np.pi) for span in self._run_spans("angle_rad")), default=0.0)

    @property
    def longest_run_s(self) -> float:
        """Duration of the longest run of the capture."""
        return max(self._run_spans("time_s"), default=0.0)

    @property
    def order_resolution(self) -> float:
        """Smallest difference of two orders that the rows resolve: 1/(2·turns of all runs)."""
        turns = sum(span / (2.0 * np.pi) for span in self._run_spans("angle_rad"))
        turns /= self.channels_of_capture
        return 0.5 / turns if turns > 0.0 else float("inf")

    @property
    def sample_period_s(self) -> float:
        """Median time between two samples of the capture."""
        if self.capture is None or self.capture.time_s.size < 2:
            return 0.0
        return float(np.median(np.abs(np.diff(self.capture.time_s))))

    def _run_spans(self, column: str) -> list[float]:
        rows = self.capture
        if rows is None:
            return []
        values = getattr(rows, column)
        return [float(abs(values[end - 1] - values[start])) for start, end in run_spans(rows.run)]
