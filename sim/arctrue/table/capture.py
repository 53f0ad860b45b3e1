"""What a sampler and a polygon would record of the table."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from arctrue.table.causes.cause import READING, refuse_unhonoured
from arctrue.table.motion import Motion
from arctrue.table.rotary_table import RotaryTable
from arctrue.table.stations import stations


@dataclass(frozen=True, slots=True)
class SampledRun:
    """Both heads latched at the same instants; arrays ``(n,)``, counts ``(2, n)``."""

    time_s: NDArray[np.float64]
    true_angle_rad: NDArray[np.float64]
    counts: NDArray[np.int64]


@dataclass(frozen=True, slots=True)
class ReferenceRun:
    """Head 1 against a polygon, station by station; arrays ``(n,)``."""

    time_s: NDArray[np.float64]
    cycle: NDArray[np.int64]
    direction: NDArray[np.int64]
    target_deg: NDArray[np.float64]
    head1_counts: NDArray[np.int64]
    error_arcsec: NDArray[np.float64]


def sample(
    table: RotaryTable,
    motion: Motion,
    period_s: float,
    random: np.random.Generator | None = None,
) -> SampledRun:
    """Latch both heads every ``period_s`` over the whole motion."""
    refuse_unhonoured(table.effects, READING, "a sampled run")
    if not period_s > 0:
        raise ValueError(f"the sampling period must be positive, found {period_s} s")
    number = int(np.floor(motion.duration_s / period_s * (1 + 1e-12))) + 1
    state = motion.state(np.minimum(np.arange(number) * period_s, motion.duration_s))
    counts = np.stack([table.counts(head, state, random) for head in (0, 1)])
    return SampledRun(state.time_s, state.angle_rad, counts)


def measure_with_polygon(
    table: RotaryTable,
    *,
    faces: int = 24,
    cycles: int = 10,
    station_s: float = 4.0,
    reference_noise_arcsec: float = 0.15,
    random: np.random.Generator,
) -> ReferenceRun:
    """Drive to every face and back, ``cycles`` times, and compare head 1 with the reference.

    The servo brings the *reading* of head 1 to the target, so the table stands at the true
    angle θ with R₁(θ) = target, and the error is the reading minus θ as the reference sees it.
    """
    refuse_unhonoured(table.effects, READING, "a polygon run at rest")
    up = np.arange(faces) * (360.0 / faces)
    target_deg = np.tile(np.concatenate([up, up[::-1]]), cycles)
    rows = np.arange(target_deg.size)
    target_rad = np.deg2rad(target_deg)
    time_s = rows.astype(np.float64) * station_s
    direction = np.where(rows // faces % 2 == 0, 1, -1)
    there = stations(time_s, target_rad, direction)
    # The target minus ε(target): a station need not be hit, only known.
    state = there.turned(2 * target_rad - table.reading_rad(0, there))
    counts = table.counts(0, state, random)
    noise_arcsec = random.normal(0.0, reference_noise_arcsec, rows.size)
    error_rad = counts * table.count_rad - state.angle_rad
    return ReferenceRun(
        time_s=time_s,
        cycle=rows // (2 * faces),
        direction=direction,
        target_deg=target_deg,
        head1_counts=counts,
        error_arcsec=np.rad2deg(error_rad) * 3600 + noise_arcsec,
    )
