"""Defines the correction that a controller can apply to head 1, a function of reading and
direction."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from arctrue.calibration.acceptance import of_comparison
from arctrue.calibration.comparison import ReferenceComparison
from arctrue.measurement import Reference
from arctrue.workbench.effects.base import Effect
from arctrue.workbench.model.model import Model
from arctrue.workbench.model.reading_harmonics import ReadingHarmonics, harmonics_of_reading
from arctrue.workbench.observations import Observations

Float = NDArray[np.float64]
Integer = NDArray[np.int64]
Components = NDArray[np.float64]

REVERSAL = "reversal_error"
"""Name of the effect ε = d·B/2 and of its only coefficient B, the reversal error; d is the
direction of approach."""


@dataclass(frozen=True)
class Correction:
    """Correction g(R) + d·B/2, arcseconds: the error of indication at the reading R, approached
    from direction d."""

    orders: Integer
    """Orders of the correction g, (orders,)."""
    components_arcsec: Components
    """Cosine and sine of every order, (orders, 2)."""
    reversal_arcsec: float
    """Reversal error B: the error at a position that the table approaches from below, minus the
    error at the same position approached from above."""
    left_out: tuple[str, ...]
    """Parts of the model that the correction does not contain."""
    warnings: tuple[str, ...]

    @classmethod
    def of_model(
        cls,
        model: Model,
        observations: Observations,
        effects: Mapping[str, type[Effect]],
        *,
        temperature_c: float | None,
    ) -> Correction:
        """Make the correction from the significant orders and the reversal error of a fitted model.

        Raises ValueError for a model without coefficients.
        """
        found: ReadingHarmonics = harmonics_of_reading(
            model, observations, effects, temperature_c=temperature_c
        )
        orders = sorted(found.components)
        reversal = 0.0
        notes = dict(found.notes)
        for index, entry in enumerate(model.effects):
            units = entry.effect(effects).parameter_units
            if tuple(units) == (REVERSAL,) and len(entry.coefficients) == 1:
                reversal += entry.coefficients[0]
                notes.pop(index, None)
        return cls(
            np.array(orders, dtype=np.int64),
            np.array([found.components[order] for order in orders]).reshape(-1, 2),
            reversal,
            tuple(replace(found, notes=notes).left_out),
            tuple(found.warnings),
        )

    def by_reading(self, reading_rad: Float) -> Float:
        """Return g(R) without the reversal error, arcseconds, in the shape of ``reading_rad``."""
        phase = np.multiply.outer(reading_rad, self.orders.astype(np.float64))
        cosine, sine = self.components_arcsec.T
        return np.asarray(np.cos(phase) @ cosine + np.sin(phase) @ sine)

    def error_arcsec(self, reading_rad: Float, direction: Integer | int | None) -> Float:
        """Return g(R) + d·B/2, arcseconds.

        ``direction``: 1 from below, −1 from above, None if unknown.
        """
        values = self.by_reading(reading_rad)
        return values if direction is None else values + 0.5 * self.reversal_arcsec * direction


def reading_rad(reference: Reference, counts_per_rev: int | None) -> Float:
    """Return the reading of head 1 in every row, radians: from the recorded counts, or R = θ + ε if
    the counts or the counts per turn are missing."""
    if reference.head1_counts is not None and counts_per_rev is not None:
        turn = 2.0 * np.pi / counts_per_rev
        return np.asarray(np.remainder(reference.head1_counts, counts_per_rev) * turn)
    return np.asarray(np.radians(reference.target_deg + reference.error_arcsec / 3600.0))


def table_objections(
    reference: Reference | None, correction: Correction, counts_per_rev: int | None
) -> list[str]:
    """Return an objection if the correction would increase the error of the set's own reference run
    by more than the scatter of the rows explains; otherwise return an empty list."""
    if reference is None:
        return []
    if reference.mask is not None:
        reference = reference.where(~reference.mask)
    readings = reading_rad(reference, counts_per_rev)
    before = reference.error_arcsec
    after = before - correction.error_arcsec(readings, reference.direction)
    return of_comparison(
        ReferenceComparison(
            reference.target_deg,
            reference.direction,
            before - float(before.mean()),
            after - float(after.mean()),
            None,
        )
    )
