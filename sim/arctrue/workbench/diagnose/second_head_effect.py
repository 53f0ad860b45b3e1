"""Tests pairs of effects of a capture that each change only the offsets of the runs.

Example: a head drifts with the temperature, and the stated separation of the heads is that of
another temperature. Each of the two effects alone explains only a part of the offsets and is not
significant; both together explain every offset.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.special import chdtrc, fdtrc

from arctrue.workbench.diagnose.candidate import Candidate, SecondRunEffect
from arctrue.workbench.effects.base import Effect
from arctrue.workbench.effects.capture_block import capture_block
from arctrue.workbench.effects.part_conditions import ALWAYS
from arctrue.workbench.effects.product_of_parts import FRAME_OF_HEAD, ProductOfParts
from arctrue.workbench.inference.forward.cycles import MOST_WITHIN
from arctrue.workbench.inference.likelihood_ratio import (
    with_index_as_known,
    without_slow_noise,
)
from arctrue.workbench.inference.residuals import Residuals
from arctrue.workbench.inference.significance import SIGNIFICANCE
from arctrue.workbench.inference.solution import Solution

Float = NDArray[np.float64]

LEAST_FREE = 4
"""Fewest degrees of freedom of the offsets of one channel with both effects in the model (recorded
runs − 2). With fewer, two effects fit offsets that slow noise causes, if it exceeds the
repeatability of the index."""
LEAST_OWN = 0.01
"""Smallest share of the sum of squares of an effect's offsets that the other effect cannot
reproduce; the pairs of the reference have the same limit (:mod:`second_run_effect`)."""


def second_head_effects(
    residuals: Residuals, items: Sequence[Candidate], tests: float
) -> dict[str, SecondRunEffect]:
    """Find the effects of the catalogue that are significant among the runs of a capture only with
    another effect in the model; return the best other effect of each.

    Both effects must be significant with the other one in the model. The fit of the offsets has
    only white noise, because slow noise that was estimated without the effects would absorb them.
    An effect that is a constant is not returned with an effect whose zero is unknown
    (:attr:`~arctrue.workbench.effects.base.Effect.zero_is_unknown`), because this zero causes a
    constant. Two other effects, one of them with an unknown zero, are tested also with the constant
    of this zero in the model. ``tests``: number of tests by which p of each effect is corrected; if
    one head was selected for an effect, each head counts as a trial.
    """
    if residuals.observations.recorded_runs - 2 < LEAST_FREE:
        return {}
    known = with_index_as_known(without_slow_noise(residuals)).solution
    channels = residuals.observations.channels_of_capture

    def is_constant(shape: Float) -> bool:
        """Tell whether the offsets of an effect are the same in every recorded run."""
        change = float(np.ptp(shape.reshape(-1, channels), axis=0).max())
        return change <= MOST_WITHIN * float(np.abs(shape).max())

    shapes = [
        (item, shape)
        for item in items
        if not item.effect.search
        and item.rank == 1
        and (shape := _shape(known, item.effect)) is not None
    ]
    zeros = {item.name: _zero(known, item.effect) for item, _ in shapes}
    found: dict[str, SecondRunEffect] = {}
    for item, shape in shapes:
        own_tests = tests * item.trials
        if own_tests * _p_given(known, shape, []) < SIGNIFICANCE:
            continue
        pairs: list[tuple[float, Candidate, _Zero | None, list[Float]]] = []
        for other, column in shapes:
            if other is item:
                continue
            pairs.append((_p_given(known, shape, [column]), other, None, [column]))
            zero = zeros[item.name] or zeros[other.name]
            enough = residuals.observations.recorded_runs - 3 >= LEAST_FREE
            if zero is not None and enough and not any(map(is_constant, (shape, column))):
                columns = [column, zero.offsets]
                pairs.append((_p_given(known, shape, columns), other, zero, columns))
        if not pairs:
            continue
        p_value, other, zero, columns = min(pairs, key=lambda pair: pair[0])
        p_value = min(1.0, p_value * len(pairs) * item.trials)
        of_other = _p_given(known, columns[0], [shape, *columns[1:]]) * other.trials
        if tests * max(p_value, of_other) >= SIGNIFICANCE:
            continue
        if other.effect.zero_is_unknown and is_constant(shape):
            continue
        model = np.column_stack([*columns, shape])
        sizes = np.linalg.lstsq(model, known.run_offsets_arcsec, rcond=1e-10)[0]
        constant = None if zero is None else (zero.effect, float(sizes[1]))
        found[item.name] = SecondRunEffect(other.effect, float(sizes[0]), p_value, constant)
    return found


@dataclass(frozen=True, eq=False)
class _Zero:
    """The constant that the unknown zero of an effect causes: an error of one head in all runs."""

    effect: Effect
    offsets: Float


def _zero(known: Solution, effect: Effect) -> _Zero | None:
    """Return the constant of an effect whose zero is unknown; None for another effect."""
    if not effect.zero_is_unknown or not effect.in_parts:
        return None
    frame = next((name for name in FRAME_OF_HEAD.values() if name in effect.in_parts), None)
    if frame is None:
        return None
    constant = ProductOfParts.of(ALWAYS, (), frame)
    offsets = _shape(known, constant)
    return None if offsets is None else _Zero(constant, offsets)


def _shape(known: Solution, effect: Effect) -> Float | None:
    """Return the offsets of the runs that an effect of size 1 causes; None if it also changes
    within the runs, or does not change R₂ − R₁."""
    rows = known.observations.capture
    assert rows is not None
    if effect.missing(known.observations):
        return None
    columns = capture_block(effect, rows, {}, known.context)
    if columns is None:
        return None
    column = columns[:, 0]
    size = np.maximum(np.bincount(rows.run, minlength=rows.runs), 1)
    means = np.bincount(rows.run, column, rows.runs) / size
    within, whole = float(np.sum((column - means[rows.run]) ** 2)), float(column @ column)
    if whole == 0.0 or within > MOST_WITHIN * whole:
        return None
    weights = rows.offset_weights
    if weights is None:
        return means
    return np.asarray(np.linalg.solve(weights, means.reshape(-1, rows.channels).T).T.reshape(-1))


def _p_given(known: Solution, shape: Float, others: Sequence[Float]) -> float:
    """Return p of an effect by the F test of the offsets, with other columns in the model.

    The offsets that remain and the known repeatability of the index, with the degrees of freedom of
    its prior, determine the variance. If the offsets that remain contradict this repeatability,
    they alone determine the variance.
    """
    left, own = known.run_offsets_arcsec, shape
    if others:
        units = np.linalg.qr(np.column_stack(others))[0]
        own, left = own - units @ (units.T @ own), left - units @ (units.T @ left)
    square = float(own @ own)
    if square <= LEAST_OWN * float(shape @ shape):
        return 1.0
    explained = float(own @ left) ** 2 / square
    remaining = max(float(left @ left) - explained, 1e-300)
    freedom = left.size - 1.0 - len(others)
    index_variance = known.observations.index_sigma_arcsec**2
    if float(chdtrc(freedom, remaining / index_variance)) >= SIGNIFICANCE:
        prior = known.noise.index_freedom
        remaining, freedom = remaining + prior * index_variance, freedom + prior
    return float(fdtrc(1, freedom, explained * freedom / remaining))
