"""Averages the residual of one channel to about 1600 rows or fewer, which a search can process many
times."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from arctrue.workbench.inference.forward.fast_lines import (
    FastSize,
    changes_evenly,
    fast_lines,
    sizes_of,
)
from arctrue.workbench.noise.kernel_fit import Rows

Float = NDArray[np.float64]
Integer = NDArray[np.int64]

MOST_ROWS = 1600
"""Approximate largest number of rows of a record; a longer record is averaged to about this number.
A fit of the noise then takes 20 ms."""
MANY_RATES = 50
"""Smallest number of rates whose columns are kept: blocks of a grid have more rates, refinements of
one place 11. The largest grid has 1,200 rates, whose columns are 31 MB."""
ROWS_A_PERIOD = 4.0
"""Smallest number of averaged rows in a period of a line. With this number, averaging keeps 90 % of
the line's amplitude (sinc 1/4), and the columns contain the same factor."""
APART = 500.0
"""Distance of two stretches on the common clock, in lengths of the longest stretch. Noise with a
decay time of ten stretches, the longest that is fitted, keeps e⁻⁵⁰ of its correlation over this
distance."""
SAME_COLUMNS = 1e-4
"""A direction of the base is omitted if its singular value is a smaller share than this of the
largest one (on a short arc, all orders of the disc together are a few slow curves)."""
WHOLE_TURN = 0.1
"""A record counts as one turn if its length differs from one turn by less than this, in turns. Such
a record shows integer orders only: over one turn, a line near an order differs from this order by
less than a period."""


@dataclass(frozen=True, eq=False)
class Record:
    """Averaged rows of one channel, with the base that is fitted together with every line."""

    clock: Float
    """Clock of the noise, shape (rows,): time or row number, with large distances between
    stretches."""
    measured: Float
    """The clock as it was measured, shape (rows,)."""
    place: Float
    """Coordinate over which lines are sinusoids, turns or seconds, shape (rows,)."""
    width: Float
    """Angle or time over which each row is averaged, shape (rows,)."""
    readings: Float
    """Number of readings in the mean of each row, shape (rows,)."""
    residual_arcsec: Float
    base: Float
    """Orthonormal columns (rows, k) of the model, of a constant for each stretch, and of a linear
    drift."""
    stretch: Integer
    """Number of the stretch of each row."""
    step: float
    """Median step of the clock."""
    clock_span: float
    """Length of the longest stretch on the clock."""
    span: float
    """Difference between the largest and the smallest value of ``place``."""
    longest: float
    """Length of the longest stretch, in the unit of ``place``."""
    in_time: bool
    declared: float | None = None
    """Rate whose multiples are expected, such as the tooth count of the drive."""
    fast: tuple[FastSize, ...] = ()
    """Lines over ``place`` in the single rows that are too fast for the search in averaged rows."""

    @property
    def whole_orders_only(self) -> bool:
        """True if lines are searched at whole orders only: the record is one turn."""
        return not self.in_time and abs(self.span - 1.0) < WHOLE_TURN

    @property
    def highest(self) -> float:
        """Highest rate of the search."""
        steps = np.abs(np.diff(self.place))[np.diff(self.stretch) == 0]
        return float(1.0 / (ROWS_A_PERIOD * max(np.median(steps), 1e-300)))

    @property
    def highest_declared(self) -> float:
        """Highest rate at which a multiple of the declared rate is searched: in single rows, half
        their sampling rate minus the resolution of the record, because nothing averages the
        line."""
        if np.any(self.readings > 1.0):
            return self.highest
        return max(self.highest, self.highest * ROWS_A_PERIOD / 2.0 - 1.0 / self.span)

    @property
    def independent(self) -> float:
        """Number of independent rates between 0 and the highest rate."""
        return max(self.highest * self.span, 1.0)

    @cached_property
    def turns_on_the_clock(self) -> float:
        """Mean change of ``place`` per unit of the clock, such as turns per second."""
        same = np.diff(self.stretch) == 0
        ways, times = np.abs(np.diff(self.place))[same], np.diff(self.clock)[same]
        return float(np.sum(ways) / np.sum(times))

    def on_the_clock(self, rate: float) -> float:
        """Convert a line's rate from periods per unit of ``place`` to periods per unit of the
        clock."""
        return rate * self.turns_on_the_clock

    @cached_property
    def _kept(self) -> dict[bytes, Float]:
        """Columns of many rates: every scan of a search uses the same grid."""
        return {}

    def forget(self) -> None:
        """Release the columns that scans have in common."""
        self._kept.clear()

    def line_columns(self, rate: float) -> Float:
        """Return cos and sin at one rate, averaged like each row; shape (rows, 2)."""
        return self.columns(np.array([rate]))

    def columns(self, rates: Float) -> Float:
        """Return cos and sin of several rates, shape (rows, 2·rates); the two columns of a rate are
        neighbours. Columns of MANY_RATES or more are kept until :meth:`forget` and are
        read-only."""
        if rates.size < MANY_RATES:
            return self._columns(rates)
        key = rates.tobytes()
        if key not in self._kept:
            self._kept[key] = self._columns(rates)
            self._kept[key].setflags(write=False)
        return self._kept[key]

    def _columns(self, rates: Float) -> Float:
        phase = 2.0 * np.pi * np.outer(self.place - self.place[0], rates)
        found = np.empty((self.place.size, 2 * rates.size))
        found[:, 0::2] = np.cos(phase)
        found[:, 1::2] = np.sin(phase)
        if self.width.any():  # single rows have no width, and sinc 0 is 1
            kept = np.sinc(np.outer(self.width, rates))
            found[:, 0::2] *= kept
            found[:, 1::2] *= kept
        return found

    def of_few_rows(self, gain: float) -> float:
        """Return ``gain``, reduced because the columns of the base have absorbed noise.

        In white noise with v rows more than columns, Student's t of one column is
        √(v·(e^(2·gain/rows) − 1)), and its tail falls as e^(−gain·v/rows).
        """
        rows = self.clock.size
        return float(gain * max(rows - self.base.shape[1] - 1, 1) / rows)

    def rows(self, further: Float | None = None) -> Rows:
        """Return the values that a fit of the noise needs, with the base and the columns of
        ``further``."""
        blocks = [self.residual_arcsec[:, np.newaxis], self.base]
        if further is not None:
            blocks.append(further)
        return Rows(self.clock, self.readings, np.hstack(blocks), self.step, self.clock_span)


def record_of(
    clock: Float,
    place: Float,
    stretch: Integer,
    residual_arcsec: Float,
    columns: Float,
    *,
    in_time: bool,
    declared: float | None = None,
    fast: AveragedFastLines | None = None,
) -> Record:
    """Average consecutive rows of each stretch; ``columns`` are the columns of the model.

    Rows must be sorted by stretch and, within a stretch, by the clock. ``fast``: result of
    :func:`averaged_fast_lines`, whose columns are added to the base; without it, the lines over
    ``place`` are searched.
    """
    cuts, count = _averages(stretch)
    if fast is None:
        fast = averaged_fast_lines([place], stretch, residual_arcsec)

    def mean(values: Float) -> Float:
        return _mean(values, cuts, count)

    number, middle, where = stretch[cuts], mean(clock), mean(place)
    within = np.diff(number) == 0
    steps = np.diff(middle)[within]
    spans = [_span(middle[number == item]) for item in np.unique(number)]
    ways = [_span(where[number == item]) for item in np.unique(number)]
    longest = max(spans)
    apart = np.cumsum(np.concatenate([[0.0], np.where(within, 0.0, 1.0)])) * APART * longest
    starts = np.array([middle[number == item][0] for item in np.unique(number)])
    _, place_of_start = np.unique(number, return_inverse=True)
    even = middle - starts[place_of_start] + apart
    each = np.abs(np.diff(place, append=place[-1]))
    each[np.append(np.diff(stretch) != 0, True)] = 0.0
    width = mean(each) * np.where(count > 1, count, 0.0)
    return Record(
        clock=np.ascontiguousarray(even),
        measured=middle,
        place=where,
        width=width,
        readings=count,
        residual_arcsec=mean(residual_arcsec),
        base=_base(np.hstack([mean(columns), fast.columns]), number, middle),
        stretch=number,
        step=float(np.median(steps)),
        clock_span=longest,
        span=_span(where),
        longest=max(ways),
        in_time=in_time,
        declared=declared,
        fast=fast.sizes_over(place),
    )


@dataclass(frozen=True, eq=False)
class AveragedFastLines:
    """Lines in single rows that are too fast for the averaged rows of a record."""

    columns: Float
    """Averaged columns of the lines that the averaged rows show at an alias, shape (averaged rows,
    k)."""
    sizes: tuple[tuple[Float, tuple[FastSize, ...]], ...]
    """Each coordinate that was searched, and the lines over it that the search for lines in
    averaged rows does not reach."""

    def sizes_over(self, place: Float) -> tuple[FastSize, ...]:
        """Return the lines over a coordinate; none if it was not searched."""
        return next((found for over, found in self.sizes if over is place), ())


def averaged_fast_lines(
    places: Sequence[Float], stretch: Integer, residual_arcsec: Float
) -> AveragedFastLines:
    """Return the lines that are too fast for the averaged rows of a record: these rows show an
    alias of the line, or nothing.

    The lines over each coordinate in ``places`` are searched. A coordinate that changes evenly with
    an earlier one shows the same lines and is not searched.
    """
    cuts, count = _averages(stretch)
    columns = [np.zeros((cuts.size, 0))]
    sizes: list[tuple[Float, tuple[FastSize, ...]]] = []
    for over in places if cuts.size < stretch.size else ():
        if any(changes_evenly(over, other, stretch) for other, _ in sizes):
            continue
        steps = np.abs(np.diff(_mean(over, cuts, count)))[np.diff(stretch[cuts]) == 0]
        # Half the rate of the averaged rows: a slower line has no alias.
        lowest = 0.5 / max(float(np.median(steps)), 1e-300)
        highest = 2.0 / ROWS_A_PERIOD * lowest
        lines = list(fast_lines(over, stretch, residual_arcsec, 0.0))
        columns += [_mean(line.columns, cuts, count) for line in lines if line.rate > lowest]
        sizes.append((over, sizes_of(lines, over, stretch, residual_arcsec, highest)))
    return AveragedFastLines(np.hstack(columns), tuple(sizes))


def _averages(stretch: Integer) -> tuple[Integer, Float]:
    """Return the first row of each averaged row, and the number of rows in its mean."""
    cuts = _blocks(stretch, -(-stretch.size // MOST_ROWS))
    return cuts, np.diff(np.append(cuts, stretch.size)).astype(np.float64)


def _mean(values: Float, cuts: Integer, count: Float) -> Float:
    sums = np.add.reduceat(values, cuts, axis=0)
    return np.asarray(sums / (count if values.ndim == 1 else count[:, np.newaxis]))


def _blocks(stretch: Integer, block: int) -> Integer:
    """Return the first row of each block of ``block`` rows; no block extends over two stretches."""
    new = np.flatnonzero(np.diff(stretch) != 0) + 1
    bounds = [0, *new.tolist(), stretch.size]
    pieces = [
        np.arange(start, max(end - block // 2, start + 1), block) for start, end in pairwise(bounds)
    ]
    return np.concatenate(pieces)


def _span(values: Float) -> float:
    return float(np.ptp(values))


def _base(columns: Float, stretch: Integer, clock: Float) -> Float:
    """Return the model's columns, a constant for each stretch and a drift, made orthonormal."""
    constants = (stretch[:, np.newaxis] == np.unique(stretch)[np.newaxis]).astype(np.float64)
    constants /= np.sqrt(constants.sum(axis=0))
    drift = (clock - clock.mean()) / max(_span(clock), 1e-300)
    return orthonormal([constants, drift[:, np.newaxis], columns])


def orthonormal(blocks: Sequence[Float]) -> Float:
    """Return orthonormal columns that span all blocks. Each block in turn adds the directions that
    the blocks before it do not span."""
    found = np.zeros((blocks[0].shape[0], 0))
    for block in blocks:
        own = block - found @ (found.T @ block)
        norms = np.linalg.norm(block, axis=0)
        own = own[:, norms > 0.0] / norms[norms > 0.0]
        if own.shape[1] == 0:
            continue
        vectors, values, _ = np.linalg.svd(own, full_matrices=False)
        kept = vectors[:, values > SAME_COLUMNS * max(float(values[0]), 1.0)]
        found = np.hstack([found, kept])
    return found
