"""Makes an uncertainty budget in the form of EURAMET cg-23, calculated by JCGM 100:2008.

The measurand is the error of indication of head 1 after the correction, at any angle. Uncertainties
that change over the turn enter with their root mean square.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import stats

from arctrue.base.units import ARCSEC_PER_RAD, RAD_PER_ARCSEC, arcsec_per_count
from arctrue.calibration.calibration import Calibration
from arctrue.calibration.head_separation import (
    INDEX_REPEATABILITY_COUNTS,
    NOMINAL_TOLERANCE_ARCSEC,
)
from arctrue.calibration.noise import NEIGHBOURS
from arctrue.measurement import MeasurementSet, Reference, Table
from arctrue.metrology.correction import Correction, reading_rad

Float = NDArray[np.float64]

COVERAGE = 2.0
REVERSAL = "reversal error, half of it"
BY_ANGLE_DEG: Float = np.arange(0.0, 360.0, 5.0)
"""Readings at which the uncertainty is stated, degrees."""
CONFIDENCE = 0.9545
"""Probability that a normal variable lies within two standard deviations."""
DIVISORS = {"normal": 1.0, "rectangular": math.sqrt(3.0), "two values": 1.0}
"""Divisor that converts a size to a standard uncertainty, by distribution. The size is a standard
deviation (normal), a half-width (rectangular), or half the difference of two values."""


@dataclass(frozen=True)
class Contribution:
    """One line of the uncertainty budget."""

    quantity: str
    source: str
    evaluation: str
    """Type A (evaluated by statistics) or B (evaluated from other knowledge), JCGM 100 clause
    3.3.4."""
    distribution: str
    size_arcsec: float
    """Standard deviation, half-width, or half the difference of two values, depending on
    ``distribution``."""
    sensitivity: float = 1.0
    degrees_of_freedom: float = math.inf

    @property
    def divisor(self) -> float:
        """Divisor that converts the size to a standard uncertainty."""
        return DIVISORS[self.distribution]

    @property
    def u_arcsec(self) -> float:
        """Standard uncertainty of the measurand that is due to this contribution."""
        return abs(self.sensitivity) * self.size_arcsec / self.divisor

    def record(self) -> dict[str, object]:
        """Return the line as a mapping by the names of its columns; infinite degrees of freedom
        become null."""
        finite = math.isfinite(self.degrees_of_freedom)
        return {
            "quantity": self.quantity,
            "source": self.source,
            "type": self.evaluation,
            "distribution": self.distribution,
            "size_arcsec": self.size_arcsec,
            "divisor": self.divisor,
            "sensitivity": self.sensitivity,
            "u_arcsec": self.u_arcsec,
            "degrees_of_freedom": self.degrees_of_freedom if finite else None,
        }


@dataclass(frozen=True)
class Budget:
    """All contributions to the uncertainty of the error of indication after correction."""

    method: str
    """Description of the calibration method."""
    contributions: tuple[Contribution, ...]
    missing: tuple[str, ...]
    """Contributions whose size the measurement set does not state; without them U is too small."""
    not_evaluated: tuple[str, ...]
    """Effects that the measurement set cannot show."""
    checks: tuple[str, ...]
    """Results of checks against the reference run."""
    u_by_angle_arcsec: Float | None = None
    """Combined standard uncertainty for every 5° of the reading, (72,); None if unknown."""

    @property
    def u_arcsec(self) -> float:
        """Combined standard uncertainty by JCGM 100 equation 10, without correlations."""
        return math.sqrt(sum(one.u_arcsec**2 for one in self.contributions))

    @property
    def degrees_of_freedom(self) -> float:
        """Effective degrees of freedom by the Welch–Satterthwaite formula, JCGM 100 equation
        G.2b."""
        shares = sum(one.u_arcsec**4 / one.degrees_of_freedom for one in self.contributions)
        return math.inf if shares == 0.0 else self.u_arcsec**4 / shares

    @property
    def expanded_arcsec(self) -> float:
        """Expanded uncertainty U with k = 2."""
        return COVERAGE * self.u_arcsec

    @property
    def coverage_factor(self) -> float:
        """Coverage factor k for 95.45 %, computed from the effective degrees of freedom."""
        free = self.degrees_of_freedom
        return COVERAGE if math.isinf(free) else float(stats.t.ppf(0.5 + CONFIDENCE / 2.0, free))


def two_heads_budget(measurement: MeasurementSet, calibration: Calibration) -> Budget:
    """Make the budget of a calibration from two heads; the calibration's covariance is divided by
    cause."""
    table = measurement.table
    assert table.counts_per_rev is not None
    estimate = calibration.estimate
    number = estimate.orders.size
    applied = np.array([verdict.applied for verdict in calibration.verdicts], dtype=bool)
    kept = np.tile(applied, 2)
    total = 0.5 * float(np.trace(estimate.covariance[np.ix_(kept, kept)]))
    slope = separation_slope(calibration)
    of_separation = slope * estimate.u_head_separation_rad * ARCSEC_PER_RAD
    noise = math.sqrt(max(total - of_separation**2, 0.0))
    seen = np.isfinite(estimate.noise_gain) & ~applied
    left = math.sqrt(0.5 * float(np.sum(estimate.amplitude_arcsec[seen] ** 2)))
    of_alpha = _separation_lines(table, calibration, slope)
    lines = [
        Contribution(
            "noise of R₂ − R₁ and disagreement of the runs",
            "residuals of the fit around each order, through TF(n)",
            "A",
            "normal",
            noise,
            degrees_of_freedom=2.0 * NEIGHBOURS,
        ),
        *of_alpha,
        Contribution(
            f"orders up to {number} that are not corrected",
            "their amplitudes as estimated: not significant, or no lane",
            "A",
            "normal",
            left,
            degrees_of_freedom=2.0 * max(int(np.count_nonzero(seen)), 1),
        ),
        *count_lines(table),
    ]
    checks: list[str] = []
    if measurement.reference is not None and calibration.comparison is not None:
        left_arcsec = calibration.comparison.after_arcsec
        used = measurement.reference
        if used.mask is not None and not used.mask.all():
            used = used.where(~used.mask)
        lines += reversal_lines(used.direction, left_arcsec)
        checks.append(_check(lines, used, left_arcsec))
    hidden = estimate.orders[~np.isfinite(estimate.noise_gain)].tolist()
    return Budget(
        f"two heads, {estimate.separation_choice} head separation, orders "
        f"{', '.join(map(str, estimate.orders[applied])) or 'none'}",
        tuple(lines),
        (),
        (
            f"orders above {number}",
            *(
                [f"orders {', '.join(map(str, hidden))}, which the heads do not determine"]
                if hidden
                else []
            ),
            *(
                []
                if any(one.quantity == REVERSAL for one in lines)
                else ["reversal error between disc and table, because both heads read the disc"]
            ),
            "motion of the axis and subdivision error, which are not fixed to the disc",
            "temperature other than that of the capture",
        ),
        tuple(checks),
        np.hypot(
            estimate.u_error_arcsec(np.radians(BY_ANGLE_DEG), applied),
            math.sqrt(sum(one.u_arcsec**2 for one in lines[1 + len(of_alpha) :])),
        ),
    )


def separation_slope(calibration: Calibration) -> float:
    """Return the RMS change of the correction over the turn per arcsecond of α, in arcseconds.

    E_n = D_n / (e^{jnα} − 1) gives dE_n/dα = −E_n · j n e^{jnα} / (e^{jnα} − 1).
    """
    estimate = calibration.estimate
    applied = np.array([verdict.applied for verdict in calibration.verdicts], dtype=bool)
    turned = np.exp(1j * estimate.orders[applied] * estimate.head_separation_rad)
    change = estimate.amplitude_arcsec[applied] * estimate.orders[applied] / np.abs(turned - 1.0)
    return float(np.sqrt(0.5 * np.sum(change**2))) * RAD_PER_ARCSEC


def reference_budget(measurement: MeasurementSet, correction: Correction) -> Budget:
    """Make the budget of a correction that was fitted to the set's own reference run.

    Raises ValueError for a set without a reference run, or if the number of rows does not exceed
    the number of the fit's coefficients (the constant included).
    """
    reference = measurement.reference
    if reference is None:
        raise ValueError("the set has no reference run, which this budget needs")
    if reference.mask is not None:
        reference = reference.where(~reference.mask)
    reading = reading_rad(reference, measurement.table.counts_per_rev)
    corrected_reversal = correction.reversal_arcsec != 0.0
    design = _design(reading, correction, reference.direction if corrected_reversal else None)
    rows, width = design.shape
    if rows <= width:
        raise ValueError(f"the reference run has {rows} rows for {width} coefficients")
    error = reference.error_arcsec - correction.error_arcsec(reading, reference.direction)
    error = error - float(error.mean())
    grid = np.radians(np.arange(3600, dtype=np.float64) / 10.0)
    over_turn = _design(grid, correction, np.ones(3600) if corrected_reversal else None)
    spread = np.linalg.pinv(design.T @ design)
    leverage = math.sqrt(float(np.mean(np.sum(over_turn @ spread * over_turn, axis=1))))
    repeat, freedom, means, visits = _repeats(reference, error)
    lines: list[Contribution] = []
    if not corrected_reversal:
        lines += reversal_lines(reference.direction, error)
    half_reversal = lines[0].u_arcsec if lines else 0.0
    square = float(np.mean(means**2)) - half_reversal**2
    if freedom > 0:
        lines.insert(
            0,
            Contribution(
                "repeatability, through the fit",
                f"{rows} rows, scatter of repeated visits",
                "A",
                "normal",
                repeat,
                leverage,
                float(freedom),
            ),
        )
        # The fit absorbs one degree of freedom of the means for each of its coefficients.
        square *= means.size / max(means.size - width, 1)
        square -= repeat**2 * float(np.mean(1.0 / visits))
        lines.insert(
            1,
            Contribution(
                "remaining error at the targets after the correction",
                "means of each target and direction, repeatability subtracted",
                "A",
                "normal",
                math.sqrt(max(square, 0.0)),
                degrees_of_freedom=float(max(means.size - width, 1)),
            ),
        )
    else:
        lines.insert(
            0,
            Contribution(
                "remaining error after the correction, and its scatter",
                f"{rows} rows, no target visited twice",
                "A",
                "normal",
                math.sqrt(max(square, 0.0) * rows / (rows - width)) * math.hypot(1.0, leverage),
                degrees_of_freedom=float(rows - width),
            ),
        )
    missing = []
    if reference.standard_uncertainty_arcsec is None:
        missing.append(
            "the reference instrument: reference.standard_uncertainty_arcsec is not stated in "
            "measurement.toml"
        )
    else:
        lines.append(
            Contribution(
                "reference instrument",
                reference.instrument or "reference.standard_uncertainty_arcsec",
                "B",
                "normal",
                reference.standard_uncertainty_arcsec,
            )
        )
    lines += count_lines(measurement.table)
    if measurement.table.counts_per_rev is None:
        missing.append("resolution of the reading: table.counts_per_rev is not stated")
    return Budget(
        f"reference run, orders {', '.join(map(str, correction.orders)) or 'none'}"
        + (" and reversal error" if corrected_reversal else ""),
        tuple(lines),
        tuple(missing),
        (
            "errors between the targets, above the orders that the targets determine",
            "mounting of the reference on the table (coupling, eccentricity, pyramidal error)",
            "temperature other than that of the reference run",
        ),
        (f"over the reference run the error is {float(np.sqrt(np.mean(error**2))):.3f}″ RMS",),
    )


def _separation_lines(
    table: Table, calibration: Calibration, slope: float
) -> Sequence[Contribution]:
    assert table.counts_per_rev is not None
    choice = calibration.estimate.separation_choice
    if choice == "nominal":
        return [
            Contribution(
                "head separation α",
                "mounting, table.head_separation_deg",
                "B",
                "rectangular",
                NOMINAL_TOLERANCE_ARCSEC,
                slope,
            )
        ]
    if choice == "harmonics":
        u = calibration.estimate.u_head_separation_rad * ARCSEC_PER_RAD
        return [
            Contribution("head separation α", "harmonics of the reference run", "A", "normal", u,
                         slope)
        ]  # fmt: skip
    count, stated = arcsec_per_count(table.counts_per_rev), table.index_repeatability_counts
    detection = table.index_detection_arcsec
    return [
        Contribution(
            "index mark of two heads, repeatability",
            "± 1 count" if stated is None else "table.index_repeatability_counts",
            "B",
            "rectangular" if stated is None else "normal",
            count * (INDEX_REPEATABILITY_COUNTS if stated is None else stated),
            slope * math.sqrt(2.0),
        ),
        Contribution(
            "index mark, place of detection between the heads",
            "mounting, ± 50″" if detection is None else "table.index_detection_arcsec",
            "B",
            "rectangular" if detection is None else "normal",
            NOMINAL_TOLERANCE_ARCSEC if detection is None else detection,
            slope,
        ),
    ]


def reversal_lines(direction: NDArray[np.generic] | None, error: Float) -> list[Contribution]:
    """Return half the reversal error of the errors (rows,) as a contribution; an empty list for a
    run in one direction. ``direction``: direction of motion of each row, (rows,)."""
    if direction is None:
        return []
    up, down = (error[direction == way] for way in (1, -1))
    if not (up.size and down.size):
        return []
    return [
        Contribution(
            REVERSAL,
            "mean error approached from below minus from above; it is not corrected",
            "B",
            "two values",
            0.5 * abs(float(up.mean() - down.mean())),
        )
    ]


def _check(lines: Sequence[Contribution], reference: Reference, error: Float) -> str:
    """Compare the error at an independent reference run with the budget and with the scatter of
    this reference run."""
    repeat, freedom, _, _ = _repeats(reference, error)
    stated = reference.standard_uncertainty_arcsec or 0.0
    explained = math.sqrt(
        sum(one.u_arcsec**2 for one in lines) + stated**2 + (repeat**2 if freedom else 0.0)
    )
    rms = float(np.sqrt(np.mean(np.square(error))))
    verdict = (
        "the budget holds"
        if rms <= COVERAGE * explained
        else "the budget lacks a contribution; search for its cause with arctrue diagnose"
    )
    return (
        f"against the reference run the error is {rms:.3f}″ RMS; the budget, the reference and "
        f"its scatter explain {explained:.3f}″: {verdict}"
    )


def count_lines(table: Table) -> list[Contribution]:
    """Return the contributions of resolution and rounding; empty if the table states no counts per
    turn."""
    if table.counts_per_rev is None:
        return []
    half = 0.5 * arcsec_per_count(table.counts_per_rev)
    return [
        Contribution("reading of head 1, resolution", "half a count", "B", "rectangular", half),
        Contribution("corrected angle, rounding", "half a count", "B", "rectangular", half),
    ]


def _design(reading: Float, correction: Correction, direction: NDArray[np.generic] | None) -> Float:
    phase = np.multiply.outer(reading, correction.orders.astype(np.float64))
    columns = [np.ones((reading.size, 1)), np.cos(phase), np.sin(phase)]
    if direction is not None:
        columns.append(0.5 * direction.astype(np.float64)[:, None])
    return np.hstack(columns)


def _repeats(reference: Reference, error: Float) -> tuple[float, int, Float, Float]:
    """Return the pooled standard deviation of repeats, its degrees of freedom, and the mean and the
    number of visits of each target and direction."""
    place = np.round(np.remainder(reference.target_deg, 360.0), 6)
    side = np.zeros(place.size) if reference.direction is None else reference.direction
    _, group = np.unique(np.stack([place, side]), axis=1, return_inverse=True)
    group = group.ravel()
    visits = np.bincount(group).astype(np.float64)
    means = np.bincount(group, weights=error) / visits
    freedom = int(place.size - visits.size)
    square = float(np.sum((error - means[group]) ** 2))
    return (math.sqrt(square / freedom) if freedom else math.nan), freedom, means, visits
