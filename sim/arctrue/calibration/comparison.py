"""Compares the error against the reference before and after the correction by the gateware."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from arctrue.base.units import ARCSEC_PER_DEG, arcsec_per_count
from arctrue.gateware.amplitude_sweep import Modulators, modulated
from arctrue.gateware.coefficients import Coefficients
from arctrue.gateware.compensation_pipeline import compensate
from arctrue.gateware.local_table import LocalTable
from arctrue.gateware.table_conditions import MODULATOR_ONE
from arctrue.measurement.measurement_set import Reference

Float = NDArray[np.float64]


class Extent(NamedTuple):
    """Range and RMS of values, arcseconds."""

    lowest: float
    highest: float
    rms: float

    @property
    def peak_to_peak(self) -> float:
        """Difference of the highest and the lowest value."""
        return self.highest - self.lowest


@dataclass(frozen=True)
class ReferenceComparison:
    """Errors of head 1 at the rows of the reference run, (rows,), arcseconds.

    The same constant is subtracted from both errors: the mean a₀ of the error cannot be observed,
    and its best estimate is the mean of the error after the correction.
    """

    target_deg: Float
    direction: NDArray[np.int64] | None
    before_arcsec: Float
    after_arcsec: Float
    noise: Extent | None
    """Scatter of the repeats about the mean of each target; None if a target has only one row."""


def extent(values: Float) -> Extent:
    """Return the lowest value, the highest value and the RMS of the values."""
    return Extent(
        float(values.min()), float(values.max()), float(np.sqrt(np.mean(np.square(values))))
    )


def compare(reference: Reference, coefficients: Coefficients) -> ReferenceComparison:
    """Compute the errors of the reference run before and after the correction by the bit-true
    gateware.

    The gateware outputs whole counts, so that its rounding is part of the error after the
    correction. A lane that follows the direction uses the direction of the row, or 0 if the rows
    state no direction. The rows contain neither the words of the host nor, as a rule, a speed; a
    lane that follows one of them has the amplitude 0. The correction includes the local table and
    the lanes of real orders, which depend on the number of the turn.
    """
    counts_per_rev = coefficients.counts_per_rev
    counts = reading_counts(reference, counts_per_rev)
    angle = np.remainder(counts, counts_per_rev)
    corrected = _corrected(counts, reference.direction, coefficients)
    half = counts_per_rev // 2
    correction = (angle - corrected + half) % counts_per_rev - half
    after = reference.error_arcsec - correction * arcsec_per_count(counts_per_rev)
    unobservable = float(after.mean())
    return ReferenceComparison(
        reference.target_deg,
        reference.direction,
        reference.error_arcsec - unobservable,
        after - unobservable,
        _repeat_noise(reference),
    )


def reading_counts(reference: Reference, counts_per_rev: int) -> NDArray[np.int64]:
    """Return head 1's reading in counts: the recorded reading or, without one, the target plus the
    error."""
    if reference.head1_counts is not None:
        return reference.head1_counts
    degrees = reference.target_deg + reference.error_arcsec / ARCSEC_PER_DEG
    return np.rint(degrees / 360.0 * counts_per_rev).astype(np.int64)


def _corrected(
    counts: NDArray[np.int64], direction: NDArray[np.int64] | None, coefficients: Coefficients
) -> NDArray[np.int64]:
    """Return the corrected angles of readings in counts, (rows,), with the row's direction."""
    turns, angle = np.divmod(counts, coefficients.counts_per_rev)
    held = None if coefficients.extension is None else coefficients.extension.local_table
    table = None if held is None else LocalTable.of_file(held, coefficients.counts_per_rev)
    ways = np.zeros(counts.size, dtype=np.int64) if direction is None else np.sign(direction)
    corrected = np.empty_like(angle)
    for way in np.unique(ways).tolist():
        rows = ways == way
        bank = modulated(coefficients, Modulators(direction=way * MODULATOR_ONE))
        zero = np.zeros(np.count_nonzero(rows), dtype=np.int64)
        found = compensate(angle[rows], zero, bank, table=table, turns=turns[rows])
        corrected[rows] = found.corrected_angle
    return corrected


def _repeat_noise(reference: Reference) -> Extent | None:
    place = np.round(np.remainder(reference.target_deg, 360.0) * 1e6).astype(np.int64)
    _, group, repeats = np.unique(place, return_inverse=True, return_counts=True)
    if repeats.min() < 2:
        return None
    means = np.bincount(group, weights=reference.error_arcsec) / repeats
    return extent(reference.error_arcsec - means[group])
