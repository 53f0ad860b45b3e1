"""Computes the reading of a head from the plane geometry of a graduated disc under fixed read
heads.

Stator angles count in the direction in which the table turns while its readings rise; head 1 stands
at 0, head 2 at −α. The mark with the label ψ lies at the stator angle θ − ψ, seen from the centre
of the disc. A head stands at the angle β and the radius r, and the centre of the disc is at c. The
mark ψ = θ − arg(r·exp(jβ) − c) is under the head, which reads ψ + g(ψ).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from arctrue.studies.benchmark.independent.causes.cause import Cause
from arctrue.studies.benchmark.independent.conditions import Conditions, Sweep

Float = NDArray[np.floating[Any]]
Random = np.random.Generator
SERVO_STEPS = 4
"""Number of fixed-point iterations of the servo: each iteration multiplies the remaining distance
by the slope ε′ < 10⁻², so that at most 10⁻¹¹ rad remain after four iterations."""


@dataclass(frozen=True)
class Disc:
    """Disc and heads without any cause; the disc has an eccentricity and graduation errors of low
    orders."""

    radius_m: float = 0.107950 / 2
    lines: int = 16_384
    counts_per_rev: int = 1 << 24
    separation_rad: float = float(np.radians(33.0))
    """Nominal separation of the heads; the true separation differs only if a cause turns a
    bracket."""
    eccentricity_m: complex = 0j
    """Eccentricity: the disc's centre relative to the axis, in the disc's frame at θ = 0."""
    orders: Float = field(default_factory=lambda: np.zeros(0, dtype=complex))
    """Graduation: g(ψ) = Re Σ orders[n − 1]·exp(jnψ), radians."""

    @property
    def arcsec_per_count(self) -> float:
        """Return the size of a count of the reading in arcseconds."""
        return 1_296_000 / self.counts_per_rev

    def graduation_rad(self, label_rad: Float) -> Float:
        """Return the graduation's placement error g(ψ) of the marks with the labels
        ``label_rad``."""
        found = np.zeros_like(label_rad)
        for order, size in enumerate(self.orders, start=1):
            found += (size * np.exp(1j * order * label_rad)).real
        return found


def any_disc(random: Random, counts_per_rev: int = 1 << 24) -> Disc:
    """Draw an eccentricity of 5 to 40 µm, and graduation orders n = 2 to 12 with
    Rayleigh-distributed amplitudes of scale a/n², where a is a random value between 3 and 20″.
    """
    off = np.exp(random.uniform(np.log(5e-6), np.log(40e-6)))
    number = np.arange(1, 13)
    sizes = np.radians(random.uniform(3, 20) / 3600) / number**2 * random.rayleigh(1.0, 12)
    sizes[0] = 0.0
    return Disc(
        counts_per_rev=counts_per_rev,
        eccentricity_m=complex(off * np.exp(2j * np.pi * random.random())),
        orders=sizes * np.exp(2j * np.pi * random.random(12)),
    )


def head_reading_rad(disc: Disc, at: Conditions, head: int, causes: Sequence[Cause]) -> Float:
    """Return the reading of ``head`` (1 or 2) in radians, continuous, before it is rounded to
    counts."""
    turned = at.turned_rad - sum((cause.wound_rad(at) for cause in causes), np.zeros(at.rows))
    centre = disc.eccentricity_m * np.exp(1j * turned)
    for cause in causes:
        centre = centre + cause.centre_m(at)
    place = 0.0 if head == 1 else -disc.separation_rad
    bracket = sum((cause.bracket_rad(at, head) for cause in causes), np.zeros(at.rows))
    # The angle is relative to the head's nominal place, so that ``np.angle`` gets an argument near
    # zero and does not wrap.
    seen = disc.radius_m * np.exp(1j * bracket) - centre * np.exp(-1j * place)
    label = turned - place - np.angle(seen)
    reading = label + disc.graduation_rad(label)
    for cause in causes:
        reading = reading + cause.mark_rad(label, at)
    phase = disc.lines * reading
    sine, cosine = np.sin(phase), np.cos(phase)
    for cause in causes:
        sine, cosine = cause.signals(sine, cosine, head, label)
    apart = np.arctan2(sine, cosine) - phase
    reading = reading + (apart - 2 * np.pi * np.round(apart / (2 * np.pi))) / disc.lines
    for cause in causes:
        slipped = cause.slipped_counts(at, head) * (2 * np.pi / disc.counts_per_rev)
        reading = reading + slipped
    found: Float = reading
    return found


def swept_reading_rad(disc: Disc, sweep: Sweep, head: int, causes: Sequence[Cause]) -> Float:
    """Return a head's reading at each row of a sweep, taken ``delay_s`` before the row's time."""
    delay = sum(cause.delay_s(head) for cause in causes)
    return head_reading_rad(disc, sweep.conditions(sweep.time_s - delay), head, causes)


def servo_error_rad(disc: Disc, at: Conditions, causes: Sequence[Cause]) -> Float:
    """Return head 1's reading minus the true angle while a servo holds head 1's reading at
    ``turned_rad``."""
    error = np.zeros(at.rows)
    for _ in range(SERVO_STEPS):
        there = at.moved(-error)
        error = head_reading_rad(disc, there, 1, causes) - there.turned_rad
    return error
