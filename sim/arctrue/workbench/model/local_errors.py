"""Converts local errors of a fitted model to a table of the gateware, and calculates its
correction."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from arctrue.base.units import arcsec_per_count
from arctrue.gateware.extension import (
    FRACTION_BITS,
    POINT_LIMIT,
    POINTS,
    WINDOW_EXPONENT_MOST,
    LocalTable,
)
from arctrue.gateware.local_table import LocalTable as Bank
from arctrue.gateware.local_table import local_table
from arctrue.gateware.mean_set import OFFSET_ONE, WEIGHT_ONE, MeanSet
from arctrue.generated.number_formats import LOCAL_VALUE_FRACTION
from arctrue.workbench.effects.base import Effect, LocalError
from arctrue.workbench.model.model import Model

Float = NDArray[np.float64]

WINDOWS = (1, 2, 4)
"""Numbers of windows that a table of the gateware can have."""
LEAST_GAP_COUNTS = 3.0
"""Least distance between two windows: the device refuses windows that touch, and the starts of both
are rounded to a count."""


def local_errors(model: Model, effects: Mapping[str, type[Effect]]) -> dict[int, LocalError]:
    """Find the effects of a fitted model that a local table can correct.

    Parameters
    ----------
    model : Model
        The model; its effects without coefficients are left out.
    effects : mapping of str to type[Effect]
        The catalogue.

    Returns
    -------
    dict of int to LocalError
        The local errors; each key is the index of the effect in the model.
    """
    found = {}
    for index, entry in enumerate(model.effects):
        if not entry.coefficients:
            continue
        local = entry.effect(effects).local_error(np.array(entry.coefficients), entry.search)
        if local is not None:
            found[index] = local
    return found


def at_heads_of_mean(
    errors: Sequence[LocalError], mean: MeanSet, counts_per_rev: int
) -> list[LocalError]:
    """Return the local errors of the mean of the heads.

    A scratch passes every head. The carrier is the head to whose reading r the gateware refers the
    mean (MeanSet). If head 1 has the error ε, the mean has the error Σ wᵢ ε(r + oᵢ).

    Parameters
    ----------
    errors : sequence of LocalError
        Local errors of head 1.
    mean : MeanSet
        Weights and offsets of the heads.
    counts_per_rev : int
        Number of counts per turn.

    Returns
    -------
    list of LocalError
        One local error for each pair of an error of ``errors`` and a head whose weight is not 0.
    """
    count_rad = 2.0 * np.pi / counts_per_rev
    found = []
    for weight_word, offset in zip(mean.weights, mean.offsets, strict=True):
        weight, offset_rad = weight_word / WEIGHT_ONE, offset / OFFSET_ONE * count_rad
        for error in errors if weight else ():

            def of_head(
                reading_rad: Float,
                error: LocalError = error,
                weight: float = weight,
                offset_rad: float = offset_rad,
            ) -> Float:
                return weight * error.error_arcsec(reading_rad + offset_rad)

            place_rad = (error.place_rad - offset_rad) % (2.0 * np.pi)
            found.append(LocalError(place_rad, error.half_width_rad, of_head))
    return found


def table_of(errors: Sequence[LocalError], counts_per_rev: int) -> LocalTable:
    """Sample local errors at the points of a table of the gateware.

    Parameters
    ----------
    errors : sequence of LocalError
        One error or more. Every point holds the sum of all errors.
    counts_per_rev : int
        Number of counts per turn.

    Returns
    -------
    LocalTable
        The table with the most closely spaced points whose windows contain each error completely
        and do not overlap. It has the largest number of fraction bits at which the largest point
        fits into its word. Errors whose windows would overlap share one window.

    Raises
    ------
    ValueError
        The errors exceed the range of a point.
    """
    count_rad = 2.0 * np.pi / counts_per_rev
    centres, exponent = _windows(errors, LEAST_GAP_COUNTS * count_rad)
    window_rad = 2.0 * np.pi / 2**exponent
    starts = [round((centre - window_rad / 2.0) / count_rad) % counts_per_rev for centre in centres]
    counts = _at_points(errors, starts, exponent, counts_per_rev)
    for fraction_bits in sorted(FRACTION_BITS, reverse=True):
        words = np.rint(counts * (1 << fraction_bits)).astype(np.int64)
        if np.abs(words).max() < POINT_LIMIT:
            return LocalTable(tuple(words.tolist()), tuple(starts), exponent, fraction_bits)
    raise ValueError(
        f"a local error reaches {np.abs(counts).max():.0f} counts, and a point of the gateware's "
        f"table holds fewer than {POINT_LIMIT >> min(FRACTION_BITS)}; repair the disc first"
    )


def _windows(errors: Sequence[LocalError], gap_rad: float) -> tuple[list[float], int]:
    """Return the centres of the windows of a table, radians, and the exponent of their width.

    Unused windows have the centre of the first one, which the gateware then uses alone.
    """
    chosen, chosen_exponent = [np.pi], 0
    for exponent in range(1, WINDOW_EXPONENT_MOST + 1):
        window_rad = 2.0 * np.pi / 2**exponent
        spans = _spans(errors, window_rad, gap_rad)
        if len(spans) > WINDOWS[-1] or any(high - low > window_rad for low, high in spans):
            continue
        windows = next(number for number in WINDOWS if number >= len(spans))
        # The distance of two points is windows / 2^exponent of their distance in a whole turn.
        if windows * 2**chosen_exponent < len(chosen) * 2**exponent:
            centres = [(low + high) / 2.0 for low, high in spans]
            chosen = centres + centres[:1] * (windows - len(centres))
            chosen_exponent = exponent
    return chosen, chosen_exponent


def _spans(
    errors: Sequence[LocalError], window_rad: float, gap_rad: float
) -> list[tuple[float, float]]:
    """Return the parts of the turn that contain the errors, radians. Parts are united until windows
    of this width about their centres have at least this gap between them."""
    turn_rad = 2.0 * np.pi

    def placed(low: float, high: float) -> tuple[float, float]:
        shift = (low + high) / 2.0 // turn_rad * turn_rad
        return low - shift, high - shift

    spans = sorted(
        (
            placed(error.place_rad - error.half_width_rad, error.place_rad + error.half_width_rad)
            for error in errors
        ),
        key=sum,
    )
    place = 0
    while place < len(spans) > 1:
        follower = (place + 1) % len(spans)
        ahead_rad = 0.0 if follower else turn_rad
        low, high = spans[place]
        next_low, next_high = spans[follower][0] + ahead_rad, spans[follower][1] + ahead_rad
        if (next_low + next_high - low - high) / 2.0 < window_rad + gap_rad:
            spans[place] = placed(min(low, next_low), max(high, next_high))
            del spans[follower]
            spans.sort(key=sum)
            place = 0
        else:
            place += 1
    return spans


def part_of_table(table: LocalTable, error: LocalError, counts_per_rev: int) -> LocalTable:
    """Return the table with one of its errors alone, at the same points.

    Parameters
    ----------
    table : LocalTable
        A table of several errors, from :func:`table_of`.
    error : LocalError
        One of the errors.
    counts_per_rev : int
        Number of counts per turn.

    Returns
    -------
    LocalTable
        The part of the table that corrects this error.
    """
    counts = _at_points([error], table.starts_counts, table.width_exponent, counts_per_rev)
    words = np.rint(counts * (1 << table.fraction_bits)).astype(np.int64)
    return replace(table, points=tuple(words.tolist()))


def _at_points(
    errors: Sequence[LocalError], starts: Sequence[int], exponent: int, counts_per_rev: int
) -> Float:
    """Return the sum of the errors at the points of a table, counts, (POINTS,)."""
    each = POINTS // len(starts)
    places = 2.0 * np.pi / 2**exponent * np.arange(each) / each
    reading = np.concatenate([start * 2.0 * np.pi / counts_per_rev + places for start in starts])
    counts = np.zeros(POINTS)
    for error in errors:
        counts += error.error_arcsec(reading) / arcsec_per_count(counts_per_rev)
    return counts


def taken_off_arcsec(table: LocalTable, counts_per_rev: int, reading_rad: Float) -> Float:
    """Calculate the correction of the gateware's local table, with the rounding of the gateware.

    Parameters
    ----------
    table : LocalTable
        The table of the coefficient file.
    counts_per_rev : int
        Number of counts per turn.
    reading_rad : ndarray, shape (n,)
        Readings of the head, radians.

    Returns
    -------
    ndarray, shape (n,)
        Correction, arcseconds.
    """
    turn = np.asarray(reading_rad, dtype=np.float64) / (2.0 * np.pi)
    counts = np.rint(turn * counts_per_rev).astype(np.int64) % counts_per_rev
    value = local_table(counts, Bank.of_file(table, counts_per_rev))
    return np.asarray(value * 2.0**-LOCAL_VALUE_FRACTION * arcsec_per_count(counts_per_rev))
