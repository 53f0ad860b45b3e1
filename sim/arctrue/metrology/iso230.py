"""Computes accuracy and repeatability of positioning according to ISO 230-2:2014.

The symbols are those of clause 3 of the standard. A positioning deviation x is the actual minus the
target position: for a servo that follows head 1, x is the error of indication with the opposite
sign.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from arctrue.measurement import Reference

Float = NDArray[np.float64]
Integer = NDArray[np.int64]

LEAST_TARGETS = 8
"""Smallest number of targets that the standard requires for a rotary axis up to 360°."""
LEAST_RUNS = 5
"""Smallest number of approaches to each target from each direction that the standard requires."""
SAME_TARGET_DEG = 1e-6


@dataclass(frozen=True)
class Direction:
    """Statistics of the approaches from one direction, in arrays (targets,).

    For a target without an approach, ``approaches`` is 0 and the mean is NaN.
    """

    approaches: Integer
    mean_arcsec: Float
    """x̄ᵢ, mean unidirectional positioning deviation."""
    s_arcsec: Float
    """sᵢ, estimator of the repeatability: standard deviation; NaN for fewer than two approaches."""

    @property
    def repeatability_arcsec(self) -> Float:
        """Unidirectional repeatability Rᵢ = 4 sᵢ of each target, (targets,)."""
        return 4.0 * self.s_arcsec

    @property
    def accuracy(self) -> float:
        """Unidirectional accuracy A: the largest x̄ᵢ + 2 sᵢ minus the smallest x̄ᵢ − 2 sᵢ."""
        return _span(self.mean_arcsec + 2.0 * self.s_arcsec, self.mean_arcsec - 2.0 * self.s_arcsec)

    @property
    def repeatability(self) -> float:
        """Unidirectional repeatability R: the largest Rᵢ."""
        return _largest(self.repeatability_arcsec)

    @property
    def systematic(self) -> float:
        """Unidirectional systematic deviation E: the range of x̄ᵢ."""
        return _span(self.mean_arcsec, self.mean_arcsec)


@dataclass(frozen=True)
class Positioning:
    """Figures of one run according to the standard.

    All angles except ``target_deg`` are in arcseconds. A figure is NaN if the run does not define
    it: the repeatability needs two approaches to each target, and the reversal value needs both
    directions.
    """

    target_deg: Float
    """Target positions, (targets,), ascending, within a turn."""
    up: Direction
    down: Direction
    objections: tuple[str, ...]
    """Reasons why the figures do not follow the standard, one sentence each; empty if they do."""

    @property
    def mean_arcsec(self) -> Float:
        """x̄ᵢ, mean bidirectional positioning deviation, (targets,)."""
        return 0.5 * (self.up.mean_arcsec + self.down.mean_arcsec)

    @property
    def reversal_arcsec(self) -> Float:
        """Reversal value Bᵢ = x̄ᵢ↑ − x̄ᵢ↓ of each target, (targets,)."""
        return self.up.mean_arcsec - self.down.mean_arcsec

    @property
    def repeatability_arcsec(self) -> Float:
        """Bidirectional Rᵢ: the largest of 2sᵢ↑ + 2sᵢ↓ + |Bᵢ|, Rᵢ↑ and Rᵢ↓, (targets,)."""
        up, down = self.up, self.down
        both = 2.0 * (up.s_arcsec + down.s_arcsec) + np.abs(self.reversal_arcsec)
        return np.maximum(both, np.maximum(up.repeatability_arcsec, down.repeatability_arcsec))

    @property
    def approaches(self) -> int:
        """Smallest number of approaches to a target from one direction; a direction without any
        approach does not count."""
        fewest = [int(d.approaches.min()) for d in (self.up, self.down) if d.approaches.any()]
        return min(fewest)

    def figures(self) -> dict[str, float]:
        """Return the figures of the whole turn by their symbols in the standard."""
        up, down = self.up, self.down
        high = np.stack([d.mean_arcsec + 2.0 * d.s_arcsec for d in (up, down)])
        low = np.stack([d.mean_arcsec - 2.0 * d.s_arcsec for d in (up, down)])
        means = np.stack([up.mean_arcsec, down.mean_arcsec])
        return {
            "A": _span(high, low),
            "A↑": up.accuracy,
            "A↓": down.accuracy,
            "R": _largest(self.repeatability_arcsec),
            "R↑": up.repeatability,
            "R↓": down.repeatability,
            "E": _span(means, means),
            "E↑": up.systematic,
            "E↓": down.systematic,
            "M": _span(self.mean_arcsec, self.mean_arcsec),
            "B": _largest(np.abs(self.reversal_arcsec)),
            "B̄": float(np.mean(self.reversal_arcsec)),
        }


def positioning(
    target_deg: Float, direction: Integer | None, deviation_arcsec: Float
) -> Positioning:
    """Compute the figures from positioning deviations (rows,); ``direction`` is 1 for upward and −1
    for downward approaches.

    Targets that differ by whole turns are the same target. Without ``direction`` all approaches
    count as up. Raises ValueError if there are no rows, or for another direction.
    """
    if target_deg.size == 0:
        raise ValueError("the reference run has no usable row")
    sides = np.ones(target_deg.size, dtype=np.int64) if direction is None else direction
    if not np.isin(sides, (-1, 1)).all():
        raise ValueError("the column direction of the reference run: expected 1 or -1")
    turn = round(360.0 / SAME_TARGET_DEG)
    place = np.rint(target_deg / SAME_TARGET_DEG).astype(np.int64) % turn
    places, group = np.unique(place, return_inverse=True)
    up, down = (
        _one_direction(group[sides == side], deviation_arcsec[sides == side], places.size)
        for side in (1, -1)
    )
    return Positioning(
        np.asarray(places * SAME_TARGET_DEG, dtype=np.float64),
        up,
        down,
        _objections(places.size, up, down, direction),
    )


def of_reference(reference: Reference, correction_arcsec: Float | None = None) -> Positioning:
    """Compute the figures of a reference run whose errors are reduced by ``correction_arcsec``
    (rows,).

    Masked rows are not used. No other row is left out: the standard has no rule for outliers.
    """
    error = reference.error_arcsec
    if correction_arcsec is not None:
        error = error - correction_arcsec
    used = slice(None) if reference.mask is None else ~reference.mask
    direction = None if reference.direction is None else reference.direction[used]
    return positioning(reference.target_deg[used], direction, -error[used])


@dataclass(frozen=True)
class Contributions:
    """Standard uncertainties that contribute to the figures, arcseconds; None: unknown.

    ``device_arcsec``: uncertainty of the reference at one angle; errors at different angles are
    independent. ``environment_arcsec``: uncertainty of one approach due to the environment (drift).
    """

    device_arcsec: float | None
    environment_arcsec: float | None

    @classmethod
    def from_drift(cls, device_arcsec: float | None, drift_arcsec: float | None) -> Contributions:
        """Return contributions with ``environment_arcsec`` computed from the drift.

        ``drift_arcsec``: range of readings at rest, taken as a rectangular distribution.
        """
        environment = None if drift_arcsec is None else drift_arcsec / (2.0 * math.sqrt(3.0))
        return cls(device_arcsec, environment)

    def expanded(self, approaches: int) -> dict[str, float]:
        """Return the expanded uncertainty U (k = 2) of every figure, arcseconds; NaN if a
        contribution is unknown.

        The contributors are those of ISO/TR 230-9. The law of propagation (JCGM 100:2008, equation
        10) is applied to the definitions above: a range of means is a difference of the means at
        two angles. The reference has the same error at each visit of an angle, so this error does
        not enter R and B. If only the drift scattered the approaches, with the standard uncertainty
        u = ``environment_arcsec``, R↑ would be 4 u; this value is taken as the expanded uncertainty
        of R↑.
        """
        device = math.nan if self.device_arcsec is None else self.device_arcsec
        drift = math.nan if self.environment_arcsec is None else self.environment_arcsec
        scatter = 4.0 * drift
        reversal = 2.0 * drift * math.sqrt(2.0 / approaches)
        spread = 2.0 * math.sqrt(2.0 * device**2 + 2.0 * drift**2 / approaches)
        accuracy = math.hypot(spread, scatter)
        return {
            "A": accuracy,
            "A↑": accuracy,
            "A↓": accuracy,
            "R": math.hypot(scatter, reversal),
            "R↑": scatter,
            "R↓": scatter,
            "E": spread,
            "E↑": spread,
            "E↓": spread,
            "M": 2.0 * math.sqrt(2.0 * device**2 + drift**2 / approaches),
            "B": reversal,
            "B̄": reversal,
        }


def _one_direction(group: Integer, deviation: Float, targets: int) -> Direction:
    number = np.bincount(group, minlength=targets)
    with np.errstate(invalid="ignore", divide="ignore"):
        mean = np.bincount(group, weights=deviation, minlength=targets) / number
        square = np.bincount(group, weights=(deviation - mean[group]) ** 2, minlength=targets)
        s = np.where(number > 1, np.sqrt(square / (number - 1.0)), np.nan)
    return Direction(number, mean, s)


def _objections(
    targets: int, up: Direction, down: Direction, direction: Integer | None
) -> tuple[str, ...]:
    found = []
    if targets < LEAST_TARGETS:
        found.append(f"{targets} targets, {LEAST_TARGETS} or more are required")
    if direction is None:
        found.append(
            "the run does not state the direction of approach to its targets (column direction); "
            "all approaches count as ↑"
        )
    elif not up.approaches.any() or not down.approaches.any():
        only = "↑" if up.approaches.any() else "↓"
        found.append(f"one direction only ({only}), both are required")
    for sign, side in (("↑", up), ("↓", down)):
        if not side.approaches.any():
            continue
        fewest = int(side.approaches.min())
        short = int(np.count_nonzero(side.approaches < LEAST_RUNS))
        if short:
            found.append(
                f"{short} of {targets} targets have fewer than {LEAST_RUNS} approaches {sign} "
                f"(the fewest: {fewest})"
            )
    return tuple(found)


def _span(high: Float, low: Float) -> float:
    """Return the largest ``high`` minus the smallest ``low``; NaN if any value is NaN."""
    return float(np.max(high) - np.min(low))


def _largest(values: Float) -> float:
    return float(np.max(values))
