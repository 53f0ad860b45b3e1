"""Computes a table with four heads from the geometry, without any code of the effects.

The disc's centre C moves in the frame. Head i stands at R·(cos pᵢ, −sin pᵢ). When the disc has
turned by θ, the head reads it at ψᵢ = θ − arg(hᵢ − C), which is θ + pᵢ without motion. The reading
is ψᵢ plus the disc's error there, in whole counts from the index; in each run the zero of each head
is wrong by −1, 0 or +1 count.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from arctrue.measurement import Capture, MeasurementSet, Table

Float = NDArray[np.float64]
Motion = Callable[[Float], Float]
"""Motion of the axis in metres, as a complex function of the table's unwrapped angle."""

PLACES_DEG = (0.0, 33.0, 162.5, 300.5)
COUNTS = 1 << 24
LINES = 16_384
RADIUS_M = 0.054
ARCSEC = np.pi / 648_000
NOISE_ARCSEC = 0.1
DISC = ((1, 80.0, 0.4), (2, 1.1, 2.0), (3, 0.6, -1.0), (5, 0.3, 0.2), (11, 0.2, 1.5))
"""Error of the disc: (order, amplitude in arcseconds, phase in radians)."""
RUNS = ((0.5, 0.0), (-0.5, 0.5), (1.5, 1.0), (0.5, 3.0))
"""Speed in rad/s and temperature at the start, in kelvin above that of the first run, for each
run."""


@dataclass
class FourHeads:
    """A table that turns, with errors of the disc and motions of the axis."""

    motion: Motion = field(default=lambda angle: np.zeros_like(angle, dtype=np.complex128))
    disc: tuple[tuple[float, float, float], ...] = DISC
    creep_arcsec_k: tuple[float, ...] = (0.0, 0.0, 0.0, 0.0)
    """Creep of each head's bracket along the disc, in arcseconds per kelvin."""
    places_deg: tuple[float, ...] = PLACES_DEG
    slip: tuple[int, int, int] | None = None
    """Run, head (1, 2, …), and the number of counts that this head's count gains in mid-run."""
    settling: tuple[int, float, float] | None = None
    """Head, error in arcseconds and time constant in seconds of a bracket that bends at each start
    and settles."""
    later_s: tuple[float, ...] = (0.0, 0.0, 0.0, 0.0)
    """Time in seconds by which each head is read later than the sample is taken."""
    turns: float = 2.0
    samples: int = 800
    """Number of samples per run."""

    def measured(self, seed: int) -> MeasurementSet:
        """Return a capture of four runs."""
        random = np.random.default_rng(seed)
        parts = [self._run(number, random) for number in range(len(RUNS))]
        run, time, warmth, *heads = (np.concatenate(column) for column in zip(*parts, strict=True))
        counts = {f"head{number}_counts": head for number, head in enumerate(heads, start=1)}
        return MeasurementSet(
            title="four heads",
            table=Table(
                counts_per_rev=COUNTS,
                grating_lines=LINES,
                disc_diameter_mm=2e3 * RADIUS_M,
                head_places_deg=self.places_deg,
            ),
            capture=Capture(run=run, time_s=time, temperature_c=20.0 + warmth, **counts),
            reference=None,
        )

    def _run(self, number: int, random: np.random.Generator) -> list[NDArray[np.generic]]:
        speed, warm = RUNS[number]
        duration = self.turns * 2.0 * np.pi / abs(speed)
        since = np.arange(self.samples) * duration / self.samples
        angle = 0.3 * number + speed * since
        warmth = warm + 1.5 * since / duration
        run = np.full(self.samples, number)
        time = 400.0 * number + since
        heads = self._readings(number, angle, speed, warmth, random)
        if self.settling is not None:
            head, size_arcsec, constant_s = self.settling
            bent = size_arcsec * np.exp(-since / constant_s) / 1_296_000.0 * COUNTS
            heads[head - 1] += np.rint(bent).astype(np.int64)
        return [run, time, warmth, *heads]

    def _readings(
        self, number: int, now: Float, speed: float, warmth: Float, random: np.random.Generator
    ) -> list[NDArray[np.int64]]:
        found = []
        for index, place_deg in enumerate(self.places_deg):
            angle = now + speed * self.later_s[index]
            centre = self.motion(angle)
            place = np.radians(place_deg) + self.creep_arcsec_k[index] * ARCSEC * warmth
            head = RADIUS_M * np.exp(-1j * place)
            seen = np.angle((head - centre) / RADIUS_M * np.exp(1j * np.radians(place_deg)))
            disc = angle + np.radians(place_deg) - seen
            error = sum(size * np.cos(order * disc + phase) for order, size, phase in self.disc)
            reading = disc + (error + random.normal(0.0, NOISE_ARCSEC, angle.size)) * ARCSEC
            counts = np.rint(reading / (2.0 * np.pi) * COUNTS).astype(np.int64)
            counts += random.integers(-1, 2)
            if self.slip is not None and self.slip[:2] == (number, index + 1):
                counts[counts.size // 2 :] += self.slip[2]
            found.append(counts)
        return found


def ball_pass(size_m: float, order: float) -> Motion:
    """Return a motion on a forward circle with a non-integer order."""
    return lambda angle: size_m * np.exp(1j * order * angle)


def orders_2_and_3(second_m: float, third_m: float) -> Motion:
    """Return a motion with order 2 along a line in x and order 3 on a backward circle."""
    return lambda angle: second_m * np.cos(2.0 * angle + 0.7) + third_m * np.exp(-3j * angle + 0.2j)
