"""A model on every row of a capture of which searches and statistics see only a part."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from arctrue.workbench.inference.normal_equations import row_blocks, stored_columns
from arctrue.workbench.inference.search_parameters import refined, with_steps_on_every_row
from arctrue.workbench.inference.solution import Solution, fit


@dataclass(frozen=True)
class CaptureFigures:
    """How far a model is from the capture."""

    rows: int
    rms_arcsec: float
    peak_arcsec: float


def on_every_row(solution: Solution) -> Solution:
    """The same terms fitted to every row, search parameters included; streamed, block by block.

    A capture that is worked on as a whole is left as it is.
    """
    observations = solution.observations
    if observations.stored is None or solution.every_row or solution.held:
        return solution
    terms = with_steps_on_every_row(solution)
    tried = fit(terms, observations, solution.context, noise=solution.noise, every_row=True)
    return refined(tried)


def capture_figures(solution: Solution) -> CaptureFigures | None:
    """Of the residuals of every capture row; None without a capture."""
    stored = solution.observations.stored
    if stored is None:
        values = solution.capture_residual_arcsec()
        if values is None:
            return None
        return CaptureFigures(
            values.size,
            float(np.sqrt(np.mean(values**2))) if values.size else 0.0,
            float(np.abs(values).max(initial=0.0)),
        )
    square, peak = 0.0, 0.0
    for block in row_blocks(stored.size):
        rows = stored.rows(block)
        columns = stored_columns(solution.terms, solution.widths, rows, solution.context)
        left = rows.difference_arcsec - columns @ solution.coefficients
        left -= solution.run_offsets_arcsec[rows.run]
        square += float(left @ left)
        peak = max(peak, float(np.abs(left).max(initial=0.0)))
        solution.observations.report(block.stop, stored.size)
    return CaptureFigures(stored.size, float(np.sqrt(square / stored.size)), peak)
