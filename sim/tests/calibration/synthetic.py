"""Simulates a table for the tests: computes readings from the true angle θ directly, and θ from
readings by iteration.

The module shares no code with arctrue.calibration or arctrue.table.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from arctrue.measurement import Capture, MeasurementSet, Reference, Table

COUNTS = 1 << 24
ARCSEC = np.pi / 648_000.0
ALPHA_DEG = 33.0
Float = NDArray[np.float64]


@dataclass(frozen=True)
class Disc:
    """A disc with the error ε(θ) = Σ amplitude·cos(nθ + phase); ``orders`` maps each order n to its
    amplitude in ″ and its phase in rad."""

    orders: Mapping[int, tuple[float, float]] = field(default_factory=lambda: {1: (150.0, 0.4)})
    alpha_deg: float = ALPHA_DEG
    counts_per_rev: int = COUNTS

    def error_rad(self, theta: Float) -> Float:
        total = np.zeros_like(theta)
        for order, (amplitude, phase) in self.orders.items():
            total += amplitude * ARCSEC * np.cos(order * theta + phase)
        return total

    def true_angle(self, reading: Float) -> Float:
        """Return θ with θ + ε(θ) = reading, by Newton's method with a difference quotient."""
        theta = np.array(reading)
        for _ in range(8):
            wrong = theta + self.error_rad(theta) - reading
            h = 1e-5
            slope = 1.0 + (self.error_rad(theta + h) - self.error_rad(theta - h)) / (2.0 * h)
            theta = theta - wrong / slope
        return theta

    def heads(
        self, theta: Float, noise_arcsec: float = 0.0, random: np.random.Generator | None = None
    ) -> NDArray[np.int64]:
        """Return the counts of both heads at the true angles, with the shape (2, n)."""
        alpha = np.radians(self.alpha_deg)
        readings = np.stack(
            [theta + self.error_rad(theta), theta + alpha + self.error_rad(theta + alpha)]
        )
        if random is not None:
            readings += random.normal(0.0, noise_arcsec * ARCSEC, readings.shape)
        return np.rint(readings * (self.counts_per_rev / (2.0 * np.pi))).astype(np.int64)


def turn_angles(
    samples: int = 12_000,
    turns: int = 1,
    *,
    start: float = 0.3,
    direction: int = 1,
    ripple_rad: float = 0.0,
    ripple_order: int = 7,
) -> Float:
    """Return true angles at equal steps of time, ``samples`` per turn. A sine of ``ripple_rad`` and
    ``ripple_order`` is added to the uniform motion."""
    even = 2.0 * np.pi * np.arange(samples * turns) / samples
    return start + direction * (even + ripple_rad * np.sin(ripple_order * even))


def capture_of(
    runs: list[NDArray[np.int64]], period_s: float | list[float] = 1e-3, **more: object
) -> Capture:
    """Return a capture whose runs have these counts, each of the shape (2, n)."""
    periods = period_s if isinstance(period_s, list) else [period_s] * len(runs)
    return Capture(
        run=np.repeat(np.arange(len(runs)), [run.shape[1] for run in runs]),
        time_s=np.concatenate(
            [
                100.0 * i + np.arange(r.shape[1]) * p
                for i, (r, p) in enumerate(zip(runs, periods, strict=True))
            ]
        ),
        head1_counts=np.concatenate([run[0] for run in runs]),
        head2_counts=np.concatenate([run[1] for run in runs]),
        **more,  # type: ignore[arg-type]
    )


def polygon_of(disc: Disc, noise_arcsec: float, random: np.random.Generator) -> Reference:
    """Return a reference run over a polygon's 24 faces, forward and backward, in 5 cycles; the
    drive turns the table until head 1 shows the target angle."""
    up = np.arange(24) * 15.0
    target = np.tile(np.concatenate((up, up[::-1])), 5)
    counts = np.rint(target / 360.0 * disc.counts_per_rev).astype(np.int64)
    reading = counts * (2.0 * np.pi / disc.counts_per_rev)
    error = (reading - disc.true_angle(reading)) / ARCSEC
    return Reference(
        target_deg=target,
        error_arcsec=error + random.normal(0.0, noise_arcsec, target.size),
        direction=np.tile(np.repeat([1, -1], 24), 5),
        head1_counts=counts,
    )


def set_of(disc: Disc, capture: Capture, reference: Reference | None = None) -> MeasurementSet:
    """Return a measurement set with a nominal separation of 33°."""
    return MeasurementSet(
        Table(counts_per_rev=disc.counts_per_rev, head_separation_deg=ALPHA_DEG),
        capture,
        reference,
        title="synthetic",
    )
