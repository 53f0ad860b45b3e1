"""Error on rows that the fit never saw, judged by revolutions of the capture, cycles of the
reference.

Of each revolution a quarter is left out of each fit, another one from turn to turn: every angle
and every stretch of time stay in the fit, so that a step in the last turn can be known too.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from arctrue.workbench.effects.base import FitContext
from arctrue.workbench.inference.normal import (
    ChannelSums,
    Matrix,
    RunningSums,
    Term,
    capture_columns,
    reference_columns,
    row_blocks,
    term_widths,
)
from arctrue.workbench.inference.solution import solve
from arctrue.workbench.observations import Observations

FOLDS = 4
SINGLE_TURN_PIECES = 128


@dataclass(frozen=True)
class HeldOut:
    """Mean squared held-out error of every unit (revolution or cycle), by channel."""

    capture_square: NDArray[np.float64] | None
    reference_square: NDArray[np.float64] | None

    @property
    def capture_rms_arcsec(self) -> float | None:
        """RMS over all units."""
        return _rms(self.capture_square)

    @property
    def reference_rms_arcsec(self) -> float | None:
        """RMS over all units."""
        return _rms(self.reference_square)


@dataclass(frozen=True)
class Improvement:
    """How much the held-out RMS falls, with its standard error over the units."""

    fall_arcsec: float
    standard_error_arcsec: float

    @property
    def is_real(self) -> bool:
        """It falls by more than its own standard error."""
        return self.fall_arcsec > self.standard_error_arcsec


def _rms(squares: NDArray[np.float64] | None) -> float | None:
    return None if squares is None or squares.size == 0 else float(np.sqrt(np.mean(squares)))


def improvement(
    before: NDArray[np.float64] | None, after: NDArray[np.float64] | None
) -> Improvement | None:
    """Of the RMS, from the paired differences of the units' mean squares."""
    if before is None or after is None or before.size == 0:
        return None
    old, new = float(np.sqrt(before.mean())), float(np.sqrt(after.mean()))
    differences = before - after
    spread = float(differences.std(ddof=1) / np.sqrt(differences.size)) if before.size > 1 else 0.0
    return Improvement(old - new, spread / max(old + new, 1e-30))


def capture_units(observations: Observations) -> NDArray[np.int64] | None:
    """Number of the held-out unit of each capture row: its revolution."""
    rows = observations.capture
    return None if rows is None else rows.revolution


def reference_units(observations: Observations) -> NDArray[np.int64] | None:
    """Number of the held-out unit of each reference row: its cycle, or a piece of the run."""
    rows = observations.reference
    if rows is None:
        return None
    if rows.cycle is not None:
        pairs = rows.run * (int(rows.cycle.max(initial=0)) + 1) + rows.cycle
        _, units = np.unique(pairs, return_inverse=True)
        if units.max(initial=0) >= 3:
            return _evened(np.asarray(units, dtype=np.int64))
    # Pieces in turn, so that every piece has neighbours in the fit.
    return np.asarray(np.arange(rows.run.size) * 16 // max(rows.run.size, 1), dtype=np.int64)


def _evened(units: NDArray[np.int64]) -> NDArray[np.int64]:
    """Units of many rows, as passes on the move are, in pieces of the usual size.

    A pass at a speed of its own is then never left out as a whole, and its many rows do not weigh
    like the few of a cycle over the stations.
    """
    counts = np.bincount(units)
    usual = float(np.median(counts))
    pieces = np.maximum(np.round(counts / usual), 1.0).astype(np.int64)
    first = np.concatenate([[0], np.cumsum(pieces)[:-1]])
    order = np.argsort(units, kind="stable")
    starts = np.concatenate([[0], np.cumsum(counts)[:-1]])
    place = np.empty_like(units)
    place[order] = np.arange(units.size) - np.repeat(starts, counts)
    return np.asarray(first[units] + place * pieces[units] // counts[units])


def held_out(terms: Sequence[Term], observations: Observations, context: FitContext) -> HeldOut:
    """Fit without each fold of units, judge on it. Sums are additive: one pass over the rows."""
    widths = term_widths(terms, observations)
    capture_fold = _capture_folds(observations)
    reference_fold = _folds(reference_units(observations))
    capture_parts = _fold_sums(terms, widths, observations, context, capture_fold, capture=True)
    reference_parts = _fold_sums(
        terms, widths, observations, context, reference_fold, capture=False
    )
    squares: list[NDArray[np.float64] | None] = []
    solutions = []
    for fold in range(FOLDS):
        solutions.append(
            solve(
                terms,
                observations,
                context,
                capture=_without(capture_parts, fold),
                reference=_without(reference_parts, fold),
            )
        )
    for channel, units, fold_of in (
        ("capture", capture_units(observations), capture_fold),
        ("reference", reference_units(observations), reference_fold),
    ):
        if units is None or fold_of is None:
            squares.append(None)
            continue
        total = np.zeros(int(units.max()) + 1)
        for block in row_blocks(units.size):
            matrix, run, measured = _block(
                terms, widths, observations, context, block, capture=channel == "capture"
            )
            shared = np.stack([item.coefficients for item in solutions], axis=1)
            offsets = np.stack(
                [
                    item.run_offsets_arcsec
                    if channel == "capture"
                    else np.array([item.reference_offset_arcsec])
                    for item in solutions
                ],
                axis=1,
            )
            predictions = matrix @ shared + offsets[run]
            chosen = predictions[np.arange(measured.size), fold_of[block]]
            total += np.bincount(
                units[block], weights=(measured - chosen) ** 2, minlength=total.size
            )
        counts = np.bincount(units, minlength=total.size)
        there = counts > 0
        # A rest of a few rows after the last whole revolution would weigh like a revolution.
        whole = there & (counts > 0.25 * np.median(counts[there]))
        squares.append(total[whole] / counts[whole])
    return HeldOut(*squares)


def _capture_folds(observations: Observations) -> NDArray[np.int64] | None:
    """Which fit leaves each row out: its quarter of the turn, one further every revolution."""
    rows = observations.capture
    if rows is None:
        return None
    # In a single turn short pieces, as no other turn has the angles that are left out.
    pieces = FOLDS if float(np.ptp(rows.angle_rad)) > 3.0 * np.pi else SINGLE_TURN_PIECES
    piece = np.floor(np.mod(rows.angle_rad / (2.0 * np.pi), 1.0) * pieces).astype(np.int64)
    return np.asarray((piece + rows.revolution) % FOLDS)


def _folds(units: NDArray[np.int64] | None) -> NDArray[np.int64] | None:
    return None if units is None else np.asarray(units % FOLDS)


def _fold_sums(
    terms: Sequence[Term],
    widths: Sequence[int],
    observations: Observations,
    context: FitContext,
    fold_of: NDArray[np.int64] | None,
    *,
    capture: bool,
) -> list[ChannelSums] | None:
    if fold_of is None:
        return None
    offsets = observations.runs if capture else 1
    sums = [RunningSums(sum(widths), offsets) for _ in range(FOLDS)]
    for block in row_blocks(fold_of.size):
        matrix, run, measured = _block(terms, widths, observations, context, block, capture=capture)
        for fold in range(FOLDS):
            inside = fold_of[block] == fold
            sums[fold].add(matrix[inside], run[inside], measured[inside])
    return [item.sums() for item in sums]


def _block(
    terms: Sequence[Term],
    widths: Sequence[int],
    observations: Observations,
    context: FitContext,
    block: slice,
    *,
    capture: bool,
) -> tuple[Matrix, NDArray[np.int64], Matrix]:
    """Columns, number of the offset, and measured value of a block of rows of one channel."""
    if capture:
        matrix, rows = capture_columns(terms, widths, observations, block, context)
        return matrix, rows.run, rows.difference_arcsec
    assert observations.reference is not None
    measured = observations.reference.error_arcsec[block]
    matrix = reference_columns(terms, widths, observations, block, context)
    return matrix, np.zeros(measured.size, dtype=np.int64), measured


def _without(parts: list[ChannelSums] | None, fold: int) -> ChannelSums | None:
    if parts is None:
        return None
    kept = [part for index, part in enumerate(parts) if index != fold]
    rows = sum(part.rows for part in kept)
    if rows == 0:
        return None
    return ChannelSums(
        np.sum([part.gram for part in kept], axis=0),
        np.sum([part.moment for part in kept], axis=0),
        sum(part.square for part in kept),
        rows,
    )
