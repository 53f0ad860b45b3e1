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
    channel."""
    observations = solution.observations
    capture = channel == "capture"
    stored = observations.stored if capture else observations.stored_reference
    if stored is None:
        values = (
            solution.capture_residual_arcsec() if capture else solution.reference_residual_arcsec()
        )
        return None if values is None else _figures(values.size, *_sums(values))
    square, peak, size = 0.0, 0.0, int(stored.run.size)
    for block in row_blocks(size):
        rows = stored.part(block) if isinstance(stored, ReferenceRows) else stored.rows(block)
        columns = block_columns(solution.terms, solution.widths, rows, solution.context)
        left = rows.measured_arcsec - columns @ solution.coefficients
        if isinstance(rows, ReferenceRows):
            left -= solution.reference_offset_arcsec
        else:
            left -= solution.run_offsets_arcsec[rows.run]
        of_block, highest = _sums(left)
        square, peak = square + of_block, max(peak, highest)
        rows_done(block.stop, size)
    return _figures(size, square, peak)


def _sums(values: NDArray[np.float64]) -> tuple[float, float]:
    return float(values @ values), float(np.abs(values).max(initial=0.0))


def _figures(rows: int, square: float, peak: float) -> ChannelFigures:
    return ChannelFigures(rows, float(np.sqrt(square / max(rows, 1))), peak)
