"""Tests pairs of effects of a reference that each change only from run to run.

Example: runs at several speeds contain a delay and a reversal error. Each of the two alone explains
only a small part of the runs' offsets and is not significant; both together explain every offset.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.special import fdtrc

from arctrue.workbench.diagnose.candidate import Candidate, SecondRunEffect
from arctrue.workbench.effects.base import Effect
from arctrue.workbench.effects.capture_block import capture_block
from arctrue.workbench.effects.part_conditions import (
    conditions_by_direction,
    recorded_conditions,
)
from arctrue.workbench.effects.product_of_parts import ProductOfParts
from arctrue.workbench.inference.fit import fit
from arctrue.workbench.inference.forward.cycles import between_cycles
from arctrue.workbench.inference.residuals import Residuals
from arctrue.workbench.inference.significance import SIGNIFICANCE
from arctrue.workbench.observations import CaptureRows, Observations, ReferenceRows

Float = NDArray[np.float64]

LEAST_FREE = 2
"""Fewest degrees of freedom of the offsets with both effects in the model (runs − 3). With
one degree of freedom, two effects fit all offsets if two runs have the same offset by chance."""
LEAST_OWN = 0.01
"""Smallest share of the sum of squares of an effect's offsets that the other effect cannot
reproduce: with a correlation above 0.995 the runs cannot distinguish the two."""


@dataclass(frozen=True, eq=False)
class _Shape:
    """The offsets of the runs that an effect causes, with their mean subtracted."""

    effect: Effect
    coefficient: float
    """Coefficient of the effect at which it causes these offsets."""
    offsets: Float


def second_run_effects(
    residuals: Residuals, items: Sequence[Candidate], tests: float
) -> dict[str, SecondRunEffect]:
    """Find the effects of the catalogue that are significant among the runs only with another
    effect in the model; return the best other effect of each.

    Both effects must be significant with the other one in the model. The other effects are those of
    the catalogue with one coefficient, every recorded condition as a factor of a constant, and
    every further column times the direction. ``tests``: number of tests by which p of each effect
    is corrected.
    """
    base = residuals.solution
    shapes = {item.name: _shape(residuals, item.effect) for item in items if _has_one_size(item)}
    of_catalogue = [shape for shape in shapes.values() if shape is not None]
    known = {shape.effect.in_parts for shape in of_catalogue}
    products = [
        ProductOfParts.of(condition, (), "reference")
        for condition in (
            *recorded_conditions(base.observations),
            *conditions_by_direction(base.observations),
        )
    ]
    others = of_catalogue + [
        shape
        for product in products
        if tuple(product.parts) not in known and (shape := _shape(residuals, product)) is not None
    ]
    if not of_catalogue or not others:
        return {}
    left = between_cycles(base, np.asarray(base.reference_residual_arcsec()))[0]
    found: dict[str, SecondRunEffect] = {}
    for name, shape in shapes.items():
        if shape is None or tests * _p_given(left, shape, None) < SIGNIFICANCE:
            continue
        tried = [other for other in others if other.effect is not shape.effect]
        pairs = [(_p_given(left, shape, other), other) for other in tried]
        p_value, other = min(pairs, key=lambda pair: pair[0], default=(1.0, shape))
        p_value = min(1.0, p_value * len(pairs))
        if tests * max(p_value, _p_given(left, other, shape)) >= SIGNIFICANCE:
            continue
        both = np.column_stack([other.offsets, shape.offsets])
        factor = float(np.linalg.lstsq(both, left, rcond=1e-10)[0][0])
        found[name] = SecondRunEffect(other.effect, factor * other.coefficient, p_value)
    return found


def without(residuals: Residuals, other: SecondRunEffect) -> Residuals:
    """Return the residuals of the model with the other effect, and the constant of an unknown zero,
    subtracted from capture and reference."""
    solution = residuals.solution
    sizes = [(other.effect, other.coefficient), *([] if other.zero is None else [other.zero])]

    def corrected(rows: ReferenceRows | None) -> ReferenceRows | None:
        if rows is None:
            return None
        for effect, size in sizes:
            columns = effect.reference_columns(rows, {}, solution.context)
            if columns is not None:
                rows = replace(rows, error_arcsec=rows.error_arcsec - size * columns[:, 0])
        return rows

    def corrected_capture(rows: CaptureRows | None) -> CaptureRows | None:
        if rows is None:
            return None
        for effect, size in sizes:
            columns = capture_block(effect, rows, {}, solution.context)
            if columns is not None:
                error = size * columns[:, 0]
                rows = replace(rows, difference_arcsec=rows.difference_arcsec - error)
        return rows

    before = solution.observations
    capture = corrected_capture(before.capture)
    observations: Observations = replace(
        before,
        capture=capture,
        # The stored rows have no corrected values; the evidence needs only the rows of statistics.
        stored=before.stored if capture is before.capture else None,
        reference=corrected(before.reference),
        stored_reference=corrected(before.stored_reference),
    )
    return Residuals(fit(solution.terms, observations))


def _has_one_size(item: Candidate) -> bool:
    return not item.effect.search and item.rank == 1


def _shape(residuals: Residuals, effect: Effect) -> _Shape | None:
    """Return the offsets that an effect causes; None if it also changes within the runs, or if the
    set cannot test it."""
    base = residuals.solution
    if effect.missing(base.observations):
        return None
    score = residuals.score(effect, {})
    if score.rank != 1:
        return None
    grown = residuals.solution_with(effect, {}, score)
    before, after = base.reference_residual_arcsec(), grown.reference_residual_arcsec()
    assert before is not None
    assert after is not None
    offsets, only = between_cycles(base, before - after)
    coefficient = float(grown.coefficients[-1])
    if not only or coefficient == 0.0:
        return None
    return _Shape(effect, coefficient, offsets)


def _p_given(left: Float, shape: _Shape, other: _Shape | None) -> float:
    """Return p of an effect by the F test of the offsets, with another effect in the model."""
    own = shape.offsets
    free = left.size - 2 - (other is not None)
    if free < (1 if other is None else LEAST_FREE):
        return 1.0
    if other is not None:
        unit = other.offsets / max(float(np.linalg.norm(other.offsets)), 1e-300)
        own, left = own - unit * (unit @ own), left - unit * (unit @ left)
    square = float(own @ own)
    if square <= LEAST_OWN * float(shape.offsets @ shape.offsets):
        return 1.0
    explained = float(own @ left) ** 2 / square
    remaining = max(float(left @ left) - explained, 1e-300)
    return float(fdtrc(1, free, explained * free / remaining))
