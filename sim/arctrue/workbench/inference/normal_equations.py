"""Normal equations of both channels, on whitened rows: their noise is one and uncorrelated.

The offsets of the runs are columns of ones that are never written out: of a run they are its
whitened ones, and their sums are sums over the rows of each run. A long capture is gone through
block by block; a block's columns live no longer than the block.
"""

from __future__ import annotations

from collections.abc import Hashable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from arctrue.runs import run_spans
from arctrue.workbench.effects.base import Effect, FitContext, Nonlinear
from arctrue.workbench.noise.noise import Noise
from arctrue.workbench.noise.row_noise import RowNoise
from arctrue.workbench.observations import Observations
from arctrue.workbench.observations.rows import CaptureRows, ReferenceRows

BLOCK_ROWS = 1 << 15
MOST_RECENT = 4
"""Blocks of columns that are kept of terms that come and go: a scan asks for the same again."""
Matrix = NDArray[np.float64]
Whole = NDArray[np.int64]


@dataclass(frozen=True)
class Term:
    """One effect of a model, with the values of its search parameters."""

    effect: Effect
    nonlinear: Nonlinear


@dataclass(frozen=True)
class WhitenedRows:
    """One channel: columns (rows, k), the constant (rows,), the offset's number (rows,)."""

    columns: Matrix
    ones: Matrix
    offset: Whole
    offsets: int

    def moment(self, whitened: Matrix) -> Matrix:
        """Columns and constants times whitened values, shape (k + offsets,) or (…, m)."""
        two = whitened[:, np.newaxis] if whitened.ndim == 1 else whitened
        found = np.concatenate([self.columns.T @ two, self._times_ones(two)])
        return found[:, 0] if whitened.ndim == 1 else found

    @cached_property
    def _spans(self) -> list[tuple[int, int]]:
        """Rows of each offset; they lie together."""
        return run_spans(self.offset)

    def _times_ones(self, values: Matrix) -> Matrix:
        """Each offset's constant times values (rows, k): shape (offsets, k)."""
        total = np.zeros((self.offsets, values.shape[1]))
        for start, end in self._spans:
            total[self.offset[start]] += self.ones[start:end] @ values[start:end]
        return total

    @cached_property
    def gram(self) -> Matrix:
        """All columns and constants times themselves."""
        shared = self.columns.shape[1]
        found = np.zeros((shared + self.offsets,) * 2)
        found[:shared, :shared] = self.columns.T @ self.columns
        found[shared:, :shared] = self._times_ones(self.columns)
        found[:shared, shared:] = found[shared:, :shared].T
        places = np.arange(shared, shared + self.offsets)
        found[places, places] = np.bincount(self.offset, self.ones**2, self.offsets)
        return found

    def model(self, coefficients: Matrix) -> Matrix:
        """Whitened prediction of coefficients (k + offsets,) or (k + offsets, m)."""
        shared = self.columns.shape[1]
        constants = coefficients[shared:][self.offset]
        own = (constants.T * self.ones).T
        return np.asarray(self.columns @ coefficients[:shared] + own)


@dataclass(frozen=True)
class ChannelSums:
    """Of whitened rows: Gram matrix, right-hand side, sum of squares; columns, then constants."""

    gram: Matrix
    moment: Matrix
    square: float
    rows: int
    log_determinant: float
    """Of the covariance of the rows."""

    def residual_square(self, coefficients: Matrix) -> float:
        """χ² of these coefficients, without going over the rows again."""
        explained = 2.0 * self.moment @ coefficients - coefficients @ self.gram @ coefficients
        return max(float(self.square - explained), 0.0)

    def __add__(self, other: ChannelSums) -> ChannelSums:
        """Of the rows of both."""
        return ChannelSums(
            self.gram + other.gram,
            self.moment + other.moment,
            self.square + other.square,
            self.rows + other.rows,
            self.log_determinant + other.log_determinant,
        )


def row_blocks(rows: int) -> Iterator[slice]:
    """Slices of at most BLOCK_ROWS rows."""
    for start in range(0, rows, BLOCK_ROWS):
        yield slice(start, min(start + BLOCK_ROWS, rows))


def term_widths(terms: Sequence[Term], observations: Observations) -> list[int]:
    """Number of coefficients of each term."""
    return [len(term.effect.column_names(observations)) for term in terms]


def term_columns(
    term: Term, observations: Observations, context: FitContext, *, capture: bool
) -> Matrix | None:
    """What each coefficient of a term adds to the rows of a channel, arcseconds."""
    rows = observations.capture if capture else observations.reference
    assert rows is not None
    of = term.effect.capture_columns if capture else term.effect.reference_columns
    if term.effect.depends_on_model:
        return of(rows, term.nonlinear, context)  # type: ignore[arg-type]
    channel = "capture" if capture else "reference"
    if _keepable(term):
        key, kept = (*_key(term), channel), observations.kept_columns
        if key not in kept:
            kept[key] = of(rows, term.nonlinear, context)  # type: ignore[arg-type]
        return kept[key]
    place, recent = (_identity(term), channel), observations.recent_columns
    if place not in recent:
        while len(recent) >= MOST_RECENT:
            del recent[next(iter(recent))]
        # With the effect: while it is kept, no other one has its id.
        recent[place] = (term.effect, of(rows, term.nonlinear, context))  # type: ignore[arg-type]
    return recent[place][1]


def _keepable(term: Term) -> bool:
    """Wide, linear terms stay as they are from fit to fit."""
    effect = term.effect
    return bool(effect.disc_orders(term.nonlinear)) and not (
        effect.search or effect.depends_on_model
    )


def _key(term: Term) -> tuple[str, ...]:
    return (term.effect.name, repr(sorted(term.effect.settings.items())))


def _identity(term: Term) -> Hashable:
    """The same for terms with the same columns, while their effects live."""
    if _keepable(term):
        return _key(term)
    return (id(term.effect), tuple(sorted(term.nonlinear.items())))


def channel_columns(
    terms: Sequence[Term], observations: Observations, context: FitContext, *, capture: bool
) -> Matrix:
    """Columns of all terms for the rows of a channel: shape (rows, Σ widths), arcseconds."""
    rows = observations.capture if capture else observations.reference
    assert rows is not None
    widths = term_widths(terms, observations)
    return _side_by_side(
        [term_columns(term, observations, context, capture=capture) for term in terms],
        widths,
        rows.run.size,
    )


def channel_prediction(
    terms: Sequence[Term],
    coefficients: Matrix,
    observations: Observations,
    context: FitContext,
    *,
    capture: bool,
) -> Matrix:
    """Sum of all terms for the rows of a channel: shape (rows,), arcseconds."""
    rows = observations.capture if capture else observations.reference
    assert rows is not None
    total, start = np.zeros(rows.run.size), 0
    for term, width in zip(terms, term_widths(terms, observations), strict=True):
        columns = term_columns(term, observations, context, capture=capture)
        if columns is not None:
            total += columns @ coefficients[start : start + width]
        start += width
    return total


def _side_by_side(blocks: Sequence[Matrix | None], widths: Sequence[int], rows: int) -> Matrix:
    if len(blocks) == 1 and blocks[0] is not None:
        return blocks[0]
    matrix = np.zeros((rows, sum(widths)))
    start = 0
    for columns, width in zip(blocks, widths, strict=True):
        if columns is not None:
            matrix[:, start : start + width] = columns
        start += width
    return matrix


def stored_columns(
    terms: Sequence[Term], widths: Sequence[int], rows: CaptureRows, context: FitContext
) -> Matrix:
    """Columns for rows of a long capture that is not worked on as a whole."""
    blocks = [term.effect.capture_columns(rows, term.nonlinear, context) for term in terms]
    return _side_by_side(blocks, widths, rows.run.size)


def reference_block(
    terms: Sequence[Term], widths: Sequence[int], rows: ReferenceRows, context: FitContext
) -> Matrix:
    """Columns for rows of a long reference that is not worked on as a whole."""
    blocks = [term.effect.reference_columns(rows, term.nonlinear, context) for term in terms]
    return _side_by_side(blocks, widths, rows.run.size)


def whitened_rows(
    terms: Sequence[Term],
    observations: Observations,
    context: FitContext,
    noise: Noise,
    *,
    capture: bool,
) -> WhitenedRows | None:
    """The columns of one channel with its noise made one; None without that channel."""
    rows = observations.capture if capture else observations.reference
    of_rows = noise.capture if capture else noise.reference
    if rows is None or of_rows is None:
        return None
    if any(term.effect.depends_on_model for term in terms):
        return _whitened(terms, observations, context, of_rows, capture=capture)
    key = tuple(_identity(term) for term in terms)
    kept = of_rows.whitened.under(observations.kept_columns).designs
    if key not in kept:
        # With the terms: while they are kept, no other effect has the id of one of theirs.
        kept[key] = (
            tuple(terms),
            _whitened(terms, observations, context, of_rows, capture=capture),
        )
    found: WhitenedRows = kept[key][1]
    return found


def _whitened(
    terms: Sequence[Term],
    observations: Observations,
    context: FitContext,
    of_rows: RowNoise,
    *,
    capture: bool,
) -> WhitenedRows:
    widths, size = term_widths(terms, observations), of_rows.rows
    blocks = [
        _whitened_term(term, observations, context, of_rows, capture=capture) for term in terms
    ]
    columns, start = _side_by_side(blocks, widths, size), 0
    kept = of_rows.whitened.under(observations.kept_columns).terms
    for term, block, width in zip(terms, blocks, widths, strict=True):
        if block is not None and _keepable(term):
            # The same numbers, and no second copy of them.
            kept[_key(term)] = columns[:, start : start + width]
        start += width
    ones = of_rows.whitened_ones
    if capture:
        return WhitenedRows(columns, ones, observations.capture.run, observations.runs)  # type: ignore[union-attr]
    return WhitenedRows(columns, ones, np.zeros(size, dtype=np.int64), 1)


def _whitened_term(
    term: Term,
    observations: Observations,
    context: FitContext,
    of_rows: RowNoise,
    *,
    capture: bool,
) -> Matrix | None:
    kept = of_rows.whitened.under(observations.kept_columns).terms
    if _keepable(term) and _key(term) in kept:
        return kept[_key(term)]
    columns = term_columns(term, observations, context, capture=capture)
    return None if columns is None else of_rows.whiten(columns)


def channel_sums(
    terms: Sequence[Term],
    observations: Observations,
    context: FitContext,
    noise: Noise,
    *,
    capture: bool,
) -> ChannelSums | None:
    """Sums over the rows of a channel: the terms' columns, then run offsets (or a₀)."""
    rows = whitened_rows(terms, observations, context, noise, capture=capture)
    of_rows = noise.capture if capture else noise.reference
    if rows is None or of_rows is None or of_rows.rows == 0:
        return None
    measured = of_rows.whiten(measured_arcsec(observations, capture=capture))
    return _sums(rows, measured, of_rows)


def _sums(rows: WhitenedRows, measured: Matrix, of_rows: RowNoise) -> ChannelSums:
    return ChannelSums(
        rows.gram,
        rows.moment(measured),
        float(measured @ measured),
        0 if of_rows.weightless else of_rows.rows,
        0.0 if of_rows.weightless else of_rows.log_determinant,
    )


def measured_arcsec(observations: Observations, *, capture: bool) -> Matrix:
    """R₂ − R₁ − α of every capture row, or ε of every reference row."""
    if capture:
        assert observations.capture is not None
        return observations.capture.difference_arcsec
    assert observations.reference is not None
    return observations.reference.error_arcsec


def every_row_sums(
    terms: Sequence[Term],
    observations: Observations,
    context: FitContext,
    noise: Noise,
    *,
    capture: bool,
) -> ChannelSums | None:
    """Sums over all rows of a long channel, block by block; of one that is worked on whole, as is.

    The correlation is cut between blocks, which loses about a time constant in a block's length
    of what slow noise tells.
    """
    law = noise.capture_law if capture else noise.reference_law
    stored = observations.stored if capture else observations.stored_reference
    if stored is None or law is None:
        return channel_sums(terms, observations, context, noise, capture=capture)
    widths = term_widths(terms, observations)
    total: ChannelSums | None = None
    size = int(stored.run.size)
    for block in row_blocks(size):
        if isinstance(stored, ReferenceRows):
            stations = stored.part(block)
            of_rows, run = law.on_reference(stations), np.zeros(stations.run.size, dtype=np.int64)
            columns = reference_block(terms, widths, stations, context)
            measured, offsets = stations.error_arcsec, 1
        else:
            rows = stored.rows(block)
            of_rows, run = law.on_capture(rows), rows.run
            columns = stored_columns(terms, widths, rows, context)
            measured, offsets = rows.difference_arcsec, observations.runs
        ones = of_rows.whiten(np.ones(run.size))
        if len(terms) == 1:
            # Of one effect they are its own array, which it may keep.
            columns = of_rows.whiten(columns)
        else:
            of_rows.whiten_in_place(columns)
        inside = WhitenedRows(columns, ones, run, offsets)
        sums = _sums(inside, of_rows.whiten(measured), of_rows)
        total = sums if total is None else total + sums
        observations.report(block.stop, size)
    return total
