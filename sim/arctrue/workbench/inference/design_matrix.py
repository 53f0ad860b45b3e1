"""Computes the design matrix of a model: the columns of its terms, raw and whitened by the noise.

Columns of effects that do not depend on the model are kept in memory while the rows exist. All
columns of linear terms that consist of orders of the disc are kept; for other terms, only the last
MOST_RECENT blocks of columns are kept. Whitened columns are kept while the noise exists. A long
channel is processed block by block; the columns of a block are released with the block.
"""

from __future__ import annotations

from collections.abc import Hashable, Iterator, Sequence
from dataclasses import dataclass, field
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray

from arctrue.base.progress import rows_done
from arctrue.workbench.effects.base import Effect, FitContext, Nonlinear
from arctrue.workbench.effects.capture_block import capture_block
from arctrue.workbench.noise.noise import Noise
from arctrue.workbench.noise.row_noise import RowNoise
from arctrue.workbench.numeric.least_squares import ChannelSums, Matrix, WhitenedRows
from arctrue.workbench.observations import Observations
from arctrue.workbench.observations.rows import CaptureRows, ReferenceRows

BLOCK_ROWS = 1 << 15
"""Number of rows of one matrix product; it limits memory only: 32,768 rows of 100 columns are 26
MB."""
MOST_RECENT = 4
"""Number of blocks of columns that are kept for terms whose columns change from fit to fit: a scan
uses the same blocks again."""
Rows = CaptureRows | ReferenceRows


@dataclass(frozen=True)
class Term:
    """One effect of a model, with the values of its search parameters."""

    effect: Effect
    nonlinear: Nonlinear

    @property
    def searched(self) -> int:
        """Number of parameters of the model that a search found.

        A flag (a search parameter with the values 0 and 1) is not counted. The order and the
        frequency of a line count as one parameter, because a line has only one of them.
        """
        values = [item for item in self.effect.search if not (item.integer and item.high <= 1.0)]
        return len(values) - (self.effect.search_kind == "line")


@dataclass
class _Kept:
    """Columns that are kept for a set of rows, with the effects that they belong to."""

    linear: dict[Hashable, Matrix | None] = field(default_factory=dict)
    """Columns of linear terms that consist of orders of the disc; they are equal in all fits."""
    recent: dict[Hashable, tuple[Effect, Matrix | None]] = field(default_factory=dict)
    """Columns of terms that change from fit to fit: a scan uses the same columns again."""


@dataclass
class _KeptWhitened:
    """Columns whitened by one noise, and the whitened columns of whole models."""

    rows: Rows
    linear: dict[Hashable, Matrix] = field(default_factory=dict)
    designs: dict[Hashable, tuple[tuple[Term, ...], WhitenedRows]] = field(default_factory=dict)


_KEPT: WeakKeyDictionary[Rows, _Kept] = WeakKeyDictionary()
_WHITENED: WeakKeyDictionary[RowNoise, _KeptWhitened] = WeakKeyDictionary()


def _kept_of(rows: Rows) -> _Kept:
    return _KEPT.setdefault(rows, _Kept())


def _whitened_of(rows: Rows, noise: RowNoise) -> _KeptWhitened:
    found = _WHITENED.get(noise)
    if found is None or found.rows is not rows:
        found = _WHITENED[noise] = _KeptWhitened(rows)
    return found


def keep_part(whole: Rows, part: Rows, kept: NDArray[np.bool_]) -> None:
    """Store the columns of ``part``, the rows of ``whole`` where ``kept`` is True; they are
    selected from the stored columns of ``whole``."""
    _kept_of(part).linear = {
        key: None if columns is None else columns[kept]
        for key, columns in _kept_of(whole).linear.items()
    }


def row_blocks(rows: int) -> Iterator[slice]:
    """Yield slices of at most BLOCK_ROWS rows."""
    for start in range(0, rows, BLOCK_ROWS):
        yield slice(start, min(start + BLOCK_ROWS, rows))


def term_widths(terms: Sequence[Term], observations: Observations) -> list[int]:
    """Return the number of coefficients of each term."""
    return [len(term.effect.column_names(observations)) for term in terms]


def _rows_of(observations: Observations, *, capture: bool) -> Rows:
    rows = observations.capture if capture else observations.reference
    assert rows is not None
    return rows


def _columns_of(term: Term, rows: Rows, context: FitContext) -> Matrix | None:
    if isinstance(rows, ReferenceRows):
        return term.effect.reference_columns(rows, term.nonlinear, context)
    return capture_block(term.effect, rows, term.nonlinear, context)


def term_columns(
    term: Term, observations: Observations, context: FitContext, *, capture: bool
) -> Matrix | None:
    """Return the contribution of each coefficient of a term to the rows of a channel,
    arcseconds."""
    rows = _rows_of(observations, capture=capture)
    if term.effect.depends_on_model:
        return _columns_of(term, rows, context)
    kept, place = _kept_of(rows), _identity(term)
    if _keepable(term):
        if place not in kept.linear:
            kept.linear[place] = _columns_of(term, rows, context)
        return kept.linear[place]
    if place not in kept.recent:
        while len(kept.recent) >= MOST_RECENT:
            del kept.recent[next(iter(kept.recent))]
        # The effect is kept too: while it exists, no other effect gets its id.
        kept.recent[place] = (term.effect, _columns_of(term, rows, context))
    return kept.recent[place][1]


def _keepable(term: Term) -> bool:
    """Tell whether a term is linear and consists of orders of the disc, so that its columns are
    equal in all fits."""
    effect = term.effect
    return bool(effect.disc_orders(term.nonlinear)) and not (
        effect.search or effect.depends_on_model
    )


def _key(term: Term) -> tuple[type[Effect], str]:
    return (type(term.effect), repr(sorted(term.effect.settings.items())))


def _identity(term: Term) -> Hashable:
    """Return a key that terms with the same columns share; it is valid while their effects
    exist."""
    if _keepable(term):
        return _key(term)
    return (id(term.effect), tuple(sorted(term.nonlinear.items())))


def channel_columns(
    terms: Sequence[Term], observations: Observations, context: FitContext, *, capture: bool
) -> Matrix:
    """Return the columns of all terms for the rows of a channel: shape (rows, Σ widths),
    arcseconds."""
    rows = _rows_of(observations, capture=capture)
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
    """Return the prediction of all terms, the sum of their columns times coefficients, for the rows
    of a channel: shape (rows,), arcseconds."""
    rows = _rows_of(observations, capture=capture)
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


def block_columns(
    terms: Sequence[Term], widths: Sequence[int], rows: Rows, context: FitContext
) -> Matrix:
    """Return the columns for a block of rows of a long channel."""
    blocks = [_columns_of(term, rows, context) for term in terms]
    return _side_by_side(blocks, widths, rows.run.size)


def whitened_rows(
    terms: Sequence[Term],
    observations: Observations,
    context: FitContext,
    noise: Noise,
    *,
    capture: bool,
) -> WhitenedRows | None:
    """Return the columns of one channel, whitened by its noise; None if the set lacks that
    channel."""
    rows = observations.capture if capture else observations.reference
    of_rows = noise.capture if capture else noise.reference
    if rows is None or of_rows is None:
        return None
    if any(term.effect.depends_on_model for term in terms):
        return _whitened(terms, observations, context, of_rows, capture=capture)
    key = tuple(_identity(term) for term in terms)
    kept = _whitened_of(rows, of_rows).designs
    if key not in kept:
        # The terms are kept too: while they exist, no other effect gets the id of one of their
        # effects.
        kept[key] = (
            tuple(terms),
            _whitened(terms, observations, context, of_rows, capture=capture),
        )
    return kept[key][1]


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
    rows = _rows_of(observations, capture=capture)
    kept = _whitened_of(rows, of_rows).linear
    for term, block, width in zip(terms, blocks, widths, strict=True):
        if block is not None and _keepable(term):
            # This is a view of the same numbers, not a second copy.
            kept[_key(term)] = columns[:, start : start + width]
        start += width
    ones = of_rows.whitened_ones
    if capture:
        captured = observations.capture
        assert captured is not None
        return WhitenedRows(columns, ones, captured.run, observations.runs, captured.offset_weights)
    return WhitenedRows(columns, ones, np.zeros(size, dtype=np.int64), 1)


def _whitened_term(
    term: Term,
    observations: Observations,
    context: FitContext,
    of_rows: RowNoise,
    *,
    capture: bool,
) -> Matrix | None:
    rows = _rows_of(observations, capture=capture)
    kept = _whitened_of(rows, of_rows).linear
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
    """Return the sums of least squares over the rows of a channel; the unknowns are the terms'
    coefficients, then the run offsets of the capture or the constant a₀ of the reference."""
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
    """Return R₂ − R₁ − α (or the contrast) of every capture row, or ε of every reference row."""
    return _rows_of(observations, capture=capture).measured_arcsec


def every_row_sums(
    terms: Sequence[Term],
    observations: Observations,
    context: FitContext,
    noise: Noise,
    *,
    capture: bool,
) -> ChannelSums | None:
    """Return the sums over all rows of a channel: block by block for a long channel, otherwise in
    one product.

    The correlation between blocks is neglected; the loss of information about slow noise is about
    the ratio of its time constant to the length of a block.
    """
    law = noise.capture_law if capture else noise.reference_law
    stored = observations.stored if capture else observations.stored_reference
    if stored is None or law is None:
        return channel_sums(terms, observations, context, noise, capture=capture)
    widths = term_widths(terms, observations)
    total: ChannelSums | None = None
    size = int(stored.run.size)
    for block in row_blocks(size):
        rows = stored.part(block) if isinstance(stored, ReferenceRows) else stored.rows(block)
        of_rows, offsets, run, mixed = law.on(rows), observations.runs, rows.run, None
        if isinstance(rows, ReferenceRows):
            offsets, run = 1, np.zeros(rows.run.size, dtype=np.int64)
        else:
            mixed = rows.offset_weights
        columns = block_columns(terms, widths, rows, context)
        ones = of_rows.whiten(np.ones(run.size))
        if len(terms) == 1:
            # With a single term, the array of columns belongs to the effect, which may keep it, so
            # that it must not be overwritten.
            columns = of_rows.whiten(columns)
        else:
            of_rows.whiten_in_place(columns)
        inside = WhitenedRows(columns, ones, run, offsets, mixed)
        sums = _sums(inside, of_rows.whiten(rows.measured_arcsec), of_rows)
        total = sums if total is None else total + sums
        rows_done(block.stop, size)
    return total
