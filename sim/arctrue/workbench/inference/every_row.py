"""Fits a model to every row of a set if searches and statistics use only a part of the rows."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from arctrue.base.progress import rows_done
from arctrue.workbench.inference.design_matrix import (
    block_columns,
    row_blocks,
)
from arctrue.workbench.inference.fit import fit
from arctrue.workbench.inference.search_parameters import refined, with_steps_on_every_row
from arctrue.workbench.inference.solution import Solution
from arctrue.workbench.observations import ReferenceRows


@dataclass(frozen=True)
class ChannelFigures:
    """RMS and peak of the residuals of a model in one channel."""

    rows: int
    rms_arcsec: float
    peak_arcsec: float


def on_every_row(solution: Solution) -> Solution:
    """Fit the same terms to every row, search parameters included, block by block.

    If the solution already uses every row of the set, or its coefficients were given, it is
    returned unchanged.
    """
    observations = solution.observations
    part_only = observations.stored is not None or observations.stored_reference is not None
    if not part_only or solution.every_row or solution.held:
        return solution
    terms = with_steps_on_every_row(solution)
    tried = fit(terms, observations, solution.context, noise=solution.noise, every_row=True)
    return refined(tried)


def channel_figures(solution: Solution, channel: str) -> ChannelFigures | None:
    """Return RMS and peak of the residuals of every row of a channel; None if the set lacks that
    channel.

    The mean of the reference's residuals is subtracted, because the constant a₀ is not observable.
    With slow noise, the constant of generalised least squares may be far from the mean of the rows,
    so that a better model could have the larger RMS.
    """
    observations = solution.observations
    capture = channel == "capture"
    stored = observations.stored if capture else observations.stored_reference
    if stored is None:
        values = (
            solution.capture_residual_arcsec() if capture else solution.reference_residual_arcsec()
        )
        return None if values is None else _figures(_extent(values), centred=not capture)
    total, size = _extent(np.zeros(0)), int(stored.run.size)
    for block in row_blocks(size):
        rows = stored.part(block) if isinstance(stored, ReferenceRows) else stored.rows(block)
        columns = block_columns(solution.terms, solution.widths, rows, solution.context)
        left = rows.measured_arcsec - columns @ solution.coefficients
        if isinstance(rows, ReferenceRows):
            left -= solution.reference_offset_arcsec
        else:
            left -= rows.offsets_of_rows(solution.run_offsets_arcsec)
        total = total.joined(_extent(left))
        rows_done(block.stop, size)
    return _figures(total, centred=not capture)


@dataclass(frozen=True)
class _Extent:
    """Number, sum, sum of squares, smallest and largest of residuals."""

    rows: int
    total: float
    square: float
    low: float
    high: float

    def joined(self, other: _Extent) -> _Extent:
        return _Extent(
            self.rows + other.rows,
            self.total + other.total,
            self.square + other.square,
            min(self.low, other.low),
            max(self.high, other.high),
        )


def _extent(values: NDArray[np.float64]) -> _Extent:
    low, high = float(values.min(initial=np.inf)), float(values.max(initial=-np.inf))
    return _Extent(values.size, float(values.sum()), float(values @ values), low, high)


def _figures(found: _Extent, *, centred: bool) -> ChannelFigures:
    rows = max(found.rows, 1)
    mean = found.total / rows if centred else 0.0
    peak = max(found.high - mean, mean - found.low, 0.0)
    variance = max(found.square / rows - mean**2, 0.0)
    return ChannelFigures(found.rows, float(np.sqrt(variance)), peak)
