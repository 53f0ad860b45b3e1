"""Whitens the columns of several effects at once; a wave that they have in common is whitened
once."""

from __future__ import annotations

from collections.abc import Hashable, Sequence
from dataclasses import dataclass

import numpy as np

from arctrue.workbench.effects.base import Effect, Nonlinear, OfWaves
from arctrue.workbench.inference.design_matrix import Term, term_columns
from arctrue.workbench.inference.solution import Solution
from arctrue.workbench.numeric.least_squares import Matrix
from arctrue.workbench.observations import Observations


@dataclass(frozen=True)
class Inside:
    """Place of an effect's columns among the whitened columns of a channel."""

    number: int
    """Number of the effect."""
    columns: tuple[int, ...]
    """Numbers of the whitened columns."""
    factors: Matrix | None
    """Matrix that combines these columns into the effect's columns; None if both are the same."""
    square: float
    """Sum of the squares of a wave (cosine and sine) before whitening; 0 if the effect is not a
    wave of the signal period."""


def of_waves(effect: Effect, observations: Observations) -> OfWaves | None:
    """Return the waves of a capture whose combinations are the columns of the effect; None without
    such waves."""
    rows = observations.capture
    return None if rows is None else effect.of_waves(rows)


def whitened_side_by_side(
    solution: Solution, asked: Sequence[tuple[Hashable, Effect, Nonlinear]], *, capture: bool
) -> tuple[Matrix | None, list[Inside]]:
    """Return whitened columns of one channel, and the place of each effect that has columns in
    it. A wave that several effects have in common is whitened once."""
    observations = solution.observations
    noise = solution.noise.capture if capture else solution.noise.reference
    assert noise is not None
    blocks: list[Matrix] = []
    there: dict[Hashable, tuple[int, ...]] = {}
    inside: list[Inside] = []

    def place_of(key: Hashable, columns: Matrix) -> None:
        start = sum(block.shape[1] for block in blocks)
        there[key] = tuple(range(start, start + columns.shape[1]))
        blocks.append(columns)

    for number, (_, effect, place) in enumerate(asked):
        combined = of_waves(effect, observations) if capture else None
        if combined is not None:
            for wave in combined.waves:
                if wave.key not in there:
                    place_of(wave.key, wave.columns())
            at = tuple(index for wave in combined.waves for index in there[wave.key])
            inside.append(Inside(number, at, combined.factors, 0.0))
            continue
        columns = term_columns(Term(effect, place), observations, solution.context, capture=capture)
        if columns is not None:
            # Only the test of a wave of the signal period needs the squares.
            square = 0.0
            if effect.electrical_orders(observations):
                square = 2.0 * float(np.vdot(columns, columns)) / columns.shape[1]
            place_of(number, columns)
            inside.append(Inside(number, there[number], None, square))
    if not blocks:
        return None, inside
    if len(blocks) == 1:
        return noise.whiten(blocks[0]), inside
    found = np.ascontiguousarray(np.hstack(blocks), dtype=np.float64)
    noise.whiten_in_place(found)
    return found, inside
