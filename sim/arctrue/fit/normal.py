"""Normal equations of both channels, accumulated over blocks of rows.

Time is linear in the rows, memory does not grow with them: a block's columns live no longer
than the block.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from arctrue.effects.base import Effect, FitContext, Nonlinear
from arctrue.observations import Observations
from arctrue.observations.rows import CaptureRows

BLOCK_ROWS = 1 << 15
KEEP_ROWS = 300_000
"""Sets up to this size keep the columns of linear terms: 100 MB at 40 columns."""
UNNAMED = "product_of_parts"
"""Products of parts share a name but not their columns."""
Matrix = NDArray[np.float64]


@dataclass(frozen=True)
class Term:
    """One effect of a model, with the values of its search parameters."""

    effect: Effect
    nonlinear: Nonlinear


@dataclass(frozen=True)
class ChannelSums:
    """Gram matrix, right-hand side, sum of squares and number of rows of one channel."""

    gram: Matrix
    moment: Matrix
    square: float
    rows: int

    def residual_square(self, coefficients: Matrix) -> float:
        """Sum of squared residuals of these coefficients, without going over the rows again."""
        explained = 2.0 * self.moment @ coefficients - coefficients @ self.gram @ coefficients
        return max(float(self.square - explained), 0.0)


def row_blocks(rows: int) -> Iterator[slice]:
    """Slices of at most BLOCK_ROWS rows."""
    for start in range(0, rows, BLOCK_ROWS):
        yield slice(start, min(start + BLOCK_ROWS, rows))


def term_widths(terms: Sequence[Term], observations: Observations) -> list[int]:
    """Number of coefficients of each term."""
    return [len(term.effect.column_names(observations)) for term in terms]


def capture_block(
    terms: Sequence[Term],
    widths: Sequence[int],
    observations: Observations,
    block: slice,
    context: FitContext,
) -> Matrix:
    """Columns of all terms, then run offsets, for a block of capture rows.

    Shape (rows, Σ widths + runs).
    """
    capture = observations.capture
    assert capture is not None
    rows = capture.part(block)
    count = rows.run.size
    shared = sum(widths)
    matrix = np.zeros((count, shared + observations.runs))
    start = 0
    for term, width in zip(terms, widths, strict=True):
        columns = _kept_columns(term, observations, block, rows, context)
        if columns is not None:
            matrix[:, start : start + width] = columns
        start += width
    matrix[np.arange(count), shared + rows.run] = 1.0
    return matrix


def _kept_columns(
    term: Term,
    observations: Observations,
    block: slice,
    rows: CaptureRows,
    context: FitContext,
) -> Matrix | None:
    """Columns of a term; those of the wide, linear terms are kept while the set is small."""
    keepable = not term.effect.search and not term.effect.depends_on_model
    if not keepable or observations.rows > KEEP_ROWS:
        return term.effect.capture_columns(rows, term.nonlinear, context)
    key = (term.effect.name, repr(sorted(term.effect.settings.items())), block.start)
    if key not in observations.kept_columns:
        columns = term.effect.capture_columns(rows, term.nonlinear, context)
        if term.effect.name == UNNAMED:
            return columns
        observations.kept_columns[key] = columns
    return observations.kept_columns[key]


def reference_block(
    terms: Sequence[Term],
    widths: Sequence[int],
    observations: Observations,
    block: slice,
    context: FitContext,
) -> Matrix:
    """Columns of all terms, then the constant a₀, for a block of reference rows.

    Shape (rows, Σ widths + 1).
    """
    reference = observations.reference
    assert reference is not None
    rows = reference.part(block)
    matrix = np.zeros((rows.run.size, sum(widths) + 1))
    start = 0
    for term, width in zip(terms, widths, strict=True):
        columns = term.effect.reference_columns(rows, term.nonlinear, context)
        if columns is not None:
            matrix[:, start : start + width] = columns
        start += width
    matrix[:, -1] = 1.0
    return matrix


def capture_sums(
    terms: Sequence[Term],
    observations: Observations,
    context: FitContext,
    keep: NDArray[np.bool_] | None = None,
) -> ChannelSums | None:
    """Sums over the capture rows; the last columns are the run offsets. None: no capture.

    ``keep`` leaves rows out (held-out error).
    """
    rows = observations.capture
    if rows is None:
        return None
    widths = term_widths(terms, observations)
    size = sum(widths) + observations.runs
    gram, moment, square, count = np.zeros((size, size)), np.zeros(size), 0.0, 0
    for block in row_blocks(rows.angle_rad.size):
        matrix = capture_block(terms, widths, observations, block, context)
        measured = rows.difference_arcsec[block]
        if keep is not None:
            matrix, measured = matrix[keep[block]], measured[keep[block]]
        gram += matrix.T @ matrix
        moment += matrix.T @ measured
        square += float(measured @ measured)
        count += measured.size
    return ChannelSums(gram, moment, square, count)


def reference_sums(
    terms: Sequence[Term],
    observations: Observations,
    context: FitContext,
    keep: NDArray[np.bool_] | None = None,
) -> ChannelSums | None:
    """Sums over the reference rows; the last column is the constant a₀. None: no reference."""
    rows = observations.reference
    if rows is None:
        return None
    widths = term_widths(terms, observations)
    size = sum(widths) + 1
    gram, moment, square, count = np.zeros((size, size)), np.zeros(size), 0.0, 0
    for block in row_blocks(rows.target_rad.size):
        matrix = reference_block(terms, widths, observations, block, context)
        measured = rows.error_arcsec[block]
        if keep is not None:
            matrix, measured = matrix[keep[block]], measured[keep[block]]
        gram += matrix.T @ matrix
        moment += matrix.T @ measured
        square += float(measured @ measured)
        count += measured.size
    return ChannelSums(gram, moment, square, count)
