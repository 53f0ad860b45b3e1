"""Describes the noise of one channel by a law, from which the noise of any rows of the channel can
be computed."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from arctrue.workbench.noise.row_noise import RowNoise
from arctrue.workbench.noise.spectrum import Spectrum
from arctrue.workbench.observations.rows import CaptureRows, ReferenceRows

Float = NDArray[np.float64]
Integer = NDArray[np.int64]

ANGLE_BINS = 36
"""Number of parts of the turn, 10° each, in which the noise may have a scale of its own."""
SAME_STEP = 1.25
"""Largest ratio of the clock steps of two runs that share a spectrum."""


@dataclass(frozen=True)
class NoiseLaw:
    """Spectrum and scale of every run, and the scale at every angle."""

    spectra: tuple[Spectrum, ...]
    """Spectrum of each run; the first spectrum also applies to runs that were not measured."""
    runs: Integer
    """Names of the runs, in increasing order."""
    run_scale: Float
    """Standard deviation of each run divided by the standard deviation of its spectrum, shape
    (runs,)."""
    angle_scale: Float | None = None
    """Standard deviation in equal parts of the turn, divided by the standard deviation of the
    spectrum, shape (ANGLE_BINS,)."""
    weightless: bool = False

    def on(self, rows: CaptureRows | ReferenceRows) -> RowNoise:
        """Return the noise of some rows of the channel."""
        goes_on = isinstance(rows, ReferenceRows)
        clock = reference_clock(rows) if isinstance(rows, ReferenceRows) else rows.time_s
        return self.of(clock, rows.run, rows.angle_rad, stated_scale(rows), goes_on=goes_on)

    def white_part(self) -> NoiseLaw:
        """Return the law without its coloured parts."""
        return replace(self, spectra=tuple(Spectrum(item.white) for item in self.spectra))

    def of(
        self, clock: Float, run: Integer, angle_rad: Float, stated: Float, *, goes_on: bool
    ) -> RowNoise:
        """Return the noise of rows with this clock, run, angle and stated scale, each (rows,).

        ``goes_on``: the noise of a run continues in the next run, because no index separates the
        runs.
        """
        starts = stretch_starts(clock, run)
        place = np.minimum(np.searchsorted(self.runs, run), self.runs.size - 1)
        index = np.where(self.runs[place] == run, place, 0)
        scale = stated * self.run_scale[index]
        if self.angle_scale is not None:
            scale = scale * self.angle_scale[angle_bins(angle_rad)]
        if goes_on:
            starts = self._joined(starts, clock, run, index)
        spectra = tuple(self.spectra[index[start]] for start in starts)
        return RowNoise(clock, starts, spectra, scale, self.weightless)

    def _joined(self, starts: Integer, clock: Float, run: Integer, index: Integer) -> Integer:
        """Return the starts of stretches, without the starts at which the noise of the previous
        stretch continues.

        The noise continues if the clock does not go back, both stretches have one spectrum, and the
        pause is no longer than the longer stretch. Over a longer pause, stretches of this length do
        not show how the noise continues.
        """
        if starts.size < 2:
            return starts
        number = {
            name: group for group, names in enumerate(like_steps(clock, run)) for name in names
        }
        last_rows = np.concatenate([starts[1:], [clock.size]]) - 1
        length = clock[last_rows] - clock[starts]
        pause = clock[starts[1:]] - clock[last_rows[:-1]]
        short = (pause >= 0.0) & (pause <= np.maximum(length[1:], length[:-1]))
        kept = [int(starts[0])]
        for place in range(1, starts.size):
            before, here = int(starts[place - 1]), int(starts[place])
            group = number.get(int(run[here]))
            same = group is not None and group == number.get(int(run[before]))
            one, other = self.spectra[index[before]], self.spectra[index[here]]
            if not (short[place - 1] and same and one.equals(other)):
                kept.append(here)
        return np.array(kept, dtype=np.int64)


def like_steps(clock: Float, run: Integer) -> list[list[int]]:
    """Return the names of the runs in groups with similar clock steps; runs of single rows are in
    no group."""
    starts = stretch_starts(clock, run)
    ends = [*starts[1:].tolist(), clock.size]
    steps: dict[int, float] = {}
    for start, end in zip(starts.tolist(), ends, strict=True):
        if end - start > 1:
            steps.setdefault(int(run[start]), float(np.median(np.diff(clock[start:end]))))
    found: list[tuple[float, list[int]]] = []
    for name in sorted(steps):
        step = steps[name]
        for typical, members in found:
            if max(step, typical) <= SAME_STEP * min(step, typical):
                members.append(name)
                break
        else:
            found.append((step, [name]))
    return [members for _, members in found]


def angle_bins(angle_rad: Float) -> Integer:
    """Return, for each row, the number of its part of the turn."""
    place = np.floor(np.mod(angle_rad / (2.0 * np.pi), 1.0) * ANGLE_BINS)
    return np.asarray(np.minimum(place.astype(np.int64), ANGLE_BINS - 1))


def stretch_starts(clock: Float, run: Integer) -> Integer:
    """Return the first rows of stretches; a stretch is a part of one run in which the clock does
    not go back."""
    if run.size == 0:
        return np.zeros(0, dtype=np.int64)
    new = (np.diff(run) != 0) | (np.diff(clock) < 0.0)
    return np.asarray(np.concatenate([[0], np.flatnonzero(new) + 1]))


def reference_clock(rows: ReferenceRows) -> Float:
    """Return the time of each reference row; if the file has no times or only one, return the
    number of each row.
    """
    if rows.time_s is not None and rows.time_s.size > 1 and float(np.ptp(rows.time_s)) > 0.0:
        return rows.time_s
    if rows.row is not None:
        return rows.row.astype(np.float64)
    return np.arange(rows.run.size, dtype=np.float64)


def stated_scale(rows: CaptureRows | ReferenceRows) -> Float:
    """Return the stated standard uncertainty of each row divided by its root mean square; 1 if no
    uncertainty is stated."""
    stated = getattr(rows, "u_arcsec", None)
    if stated is None or not np.all(stated > 0.0):
        return np.ones(rows.run.size)
    return np.asarray(stated / np.sqrt(np.mean(stated**2)))
