"""Normal equations of both channels, accumulated over blocks of rows.

Time is linear in the rows, memory does not grow with them: a block's columns live no longer
than the block. The run offsets are columns of ones that are never written out: their sums are
sums over the rows of each run.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from arctrue.workbench.effects.base import Effect, FitContext, Nonlinear
from arctrue.workbench.observations import Observations
from arctrue.workbench.observations.rows import CaptureRows

BLOCK_ROWS = 1 << 15
KEEP_ROWS = 300_000
"""Sets up to this size keep the columns of linear terms: 100 MB at 40 columns."""
UNNAMED = "product_of_parts"
"""Products of parts share a name but not their columns."""
Matrix = NDArray[np.float64]
Whole = NDArray[np.int64]


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


class RunningSums:
    """Sums of a channel while its rows come in; ``offsets`` constants follow the columns."""

    def __init__(self, shared: int, offsets: int) -> None:
        """All zero, for ``shared`` columns and ``offsets`` runs (1 in the reference: a₀)."""
        self._shared = shared
        self._offsets = offsets
        size = shared + offsets
        self._gram = np.zeros((size, size))
        self._moment = np.zeros(size)
        self._square = 0.0
        self._rows = 0

    def add(self, columns: Matrix, run: Whole, measured: Matrix) -> None:
        """Rows more: columns (rows, shared), number of the offset and measured value (rows,)."""
        shared = self._shared
        self._gram[:shared, :shared] += columns.T @ columns
        self._gram[shared:, :shared] += sums_by_run(columns, run, self._offsets)
        self._moment[:shared] += columns.T @ measured
        self._moment[shared:] += np.bincount(run, measured, self._offsets)
        places = np.arange(shared, shared + self._offsets)
        self._gram[places, places] += np.bincount(run, minlength=self._offsets)
        self._square += float(measured @ measured)
        self._rows += measured.size

    def sums(self) -> ChannelSums:
        """What has come in so far."""
        gram = self._gram.copy()
        gram[: self._shared, self._shared :] = gram[self._shared :, : self._shared].T
        return ChannelSums(gram, self._moment.copy(), self._square, self._rows)


def sums_by_run(columns: Matrix, run: Whole, runs: int) -> Matrix:
    """Sums of the rows of each run: shape (runs, columns). Rows of a run lie together."""
    total = np.zeros((runs, columns.shape[1]))
    if run.size and columns.shape[1]:
        starts = np.concatenate([[0], np.flatnonzero(np.diff(run)) + 1])
        np.add.at(total, run[starts], np.add.reduceat(columns, starts, axis=0))
    return total


def row_blocks(rows: int) -> Iterator[slice]:
    """Slices of at most BLOCK_ROWS rows."""
    for start in range(0, rows, BLOCK_ROWS):
        yield slice(start, min(start + BLOCK_ROWS, rows))


def term_widths(terms: Sequence[Term], observations: Observations) -> list[int]:
    """Number of coefficients of each term."""
    return [len(term.effect.column_names(observations)) for term in terms]


def capture_columns(
    terms: Sequence[Term],
    widths: Sequence[int],
    observations: Observations,
    block: slice,
    context: FitContext,
) -> tuple[Matrix, CaptureRows]:
    """Columns of all terms for a block of capture rows, shape (rows, Σ widths), and the rows."""
    capture = observations.capture
    assert capture is not None
    rows = capture.part(block)

    def columns_of(term: Term) -> Matrix | None:
        return _kept_columns(term, observations, block, rows, context)

    return _side_by_side(terms, widths, rows, columns_of), rows


def stored_columns(
    terms: Sequence[Term], widths: Sequence[int], rows: CaptureRows, context: FitContext
) -> Matrix:
    """The same for rows that are not a block of the part that is worked on."""

    def columns_of(term: Term) -> Matrix | None:
        return term.effect.capture_columns(rows, term.nonlinear, context)

    return _side_by_side(terms, widths, rows, columns_of)


def _side_by_side(
    terms: Sequence[Term],
    widths: Sequence[int],
    rows: CaptureRows,
    columns_of: Callable[[Term], Matrix | None],
) -> Matrix:
    if len(terms) == 1:
        only = columns_of(terms[0])
        if only is not None:
            return only
    matrix = np.zeros((rows.run.size, sum(widths)))
    start = 0
    for term, width in zip(terms, widths, strict=True):
        columns = columns_of(term)
        if columns is not None:
            matrix[:, start : start + width] = columns
        start += width
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


def reference_columns(
    terms: Sequence[Term],
    widths: Sequence[int],
    observations: Observations,
    block: slice,
    context: FitContext,
) -> Matrix:
    """Columns of all terms for a block of reference rows: shape (rows, Σ widths)."""
    reference = observations.reference
    assert reference is not None
    rows = reference.part(block)
    matrix = np.zeros((rows.run.size, sum(widths)))
    start = 0
    for term, width in zip(terms, widths, strict=True):
        columns = term.effect.reference_columns(rows, term.nonlinear, context)
        if columns is not None:
            matrix[:, start : start + width] = columns
        start += width
    return matrix


def capture_sums(
    terms: Sequence[Term],
    observations: Observations,
    context: FitContext,
    keep: NDArray[np.bool_] | None = None,
    *,
    every_row: bool = False,
) -> ChannelSums | None:
    """Sums over the capture rows; the last columns are the run offsets. None: no capture.

    ``keep`` leaves rows out (held-out error); ``every_row`` goes over the whole of a capture of
    which only a part is worked on.
    """
    rows = observations.capture
    if rows is None:
        return None
    widths = term_widths(terms, observations)
    sums = RunningSums(sum(widths), observations.runs)
    stored = observations.stored if every_row else None
    if stored is not None:
        for block in row_blocks(stored.size):
            part = stored.rows(block)
            sums.add(stored_columns(terms, widths, part, context), part.run, part.difference_arcsec)
            observations.report(block.stop, stored.size)
        return sums.sums()
    for block in row_blocks(rows.angle_rad.size):
        matrix, part = capture_columns(terms, widths, observations, block, context)
        run, measured = part.run, part.difference_arcsec
        if keep is not None:
            kept = keep[block]
            matrix, run, measured = matrix[kept], run[kept], measured[kept]
        sums.add(matrix, run, measured)
    return sums.sums()


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
    sums = RunningSums(sum(widths), 1)
    for block in row_blocks(rows.target_rad.size):
        matrix = reference_columns(terms, widths, observations, block, context)
        measured = rows.error_arcsec[block]
        if keep is not None:
            matrix, measured = matrix[keep[block]], measured[keep[block]]
        sums.add(matrix, np.zeros(measured.size, dtype=np.int64), measured)
    return sums.sums()
