"""Defines the causes at the heads, their brackets and their counters."""

from __future__ import annotations

from typing import Self

import numpy as np

from arctrue.studies.benchmark.independent.causes.cause import (
    ARCSEC,
    Cause,
    Float,
    Random,
    log_uniform,
)
from arctrue.studies.benchmark.independent.conditions import Conditions


class HeadStandsOff(Cause):
    """Head 2 stands at another angle than the description states."""

    name = "head_angle_error"

    @classmethod
    def drawn(cls, random: Random) -> HeadStandsOff:
        """Draw a displacement of 1 to 40″ with either sign."""
        return cls(log_uniform(random, 1.0, 40.0) * float(random.choice([-1, 1])))

    def bracket_rad(self, at: Conditions, head: int) -> Float | float:
        """Return −size for head 2: α grows if head 2 is turned backwards."""
        return -self.size * ARCSEC if head == 2 else 0.0


class SubdivisionError(Cause):
    """The two signals of one head have offsets, unequal gains and a phase error."""

    name = "subdivision_error"
    columns = 4

    def __init__(
        self,
        size: float,
        head: int,
        offset: complex,
        gain: float,
        phase_rad: float,
        uneven: float = 0.0,
        at_rad: float = 0.0,
    ) -> None:
        """Set the size and the shape of the subdivision error.

        ``size``: amplitude of the error that the offset alone causes with 16,384 lines. ``uneven``:
        relative variation of the whole error around the disc.
        """
        super().__init__(size)
        self.head, self.offset, self.gain, self.phase_rad = head, offset, gain, phase_rad
        self.uneven, self.at_rad = uneven, at_rad

    @classmethod
    def drawn(cls, random: Random, uneven: float = 0.0) -> SubdivisionError:
        """Draw an offset that causes 0.06 to 2.4″, and gain and phase errors of either sign, each
        of which causes at most half of this error.
        """
        size = log_uniform(random, 0.06, 2.4)
        share = size * ARCSEC * 16_384
        return cls(
            size,
            int(random.integers(1, 3)),
            complex(share * np.exp(2j * np.pi * random.random())),
            share * random.uniform(-1, 1),
            share * random.uniform(-1, 1),
            uneven,
            random.uniform(0, 2 * np.pi),
        )

    def scaled(self, factor: float) -> Self:
        """Scale offset, gain and phase together."""
        found = super().scaled(factor)
        found.offset, found.gain = self.offset * factor, self.gain * factor
        found.phase_rad = self.phase_rad * factor
        return found

    def signals(
        self, sine: Float, cosine: Float, head: int, label_rad: Float
    ) -> tuple[Float, Float]:
        """Return sin(φ + p)·(1 + g) + Im o and cos φ + Re o.

        p is the phase error, g the gain error and o the offset.
        """
        if head != self.head:
            return sine, cosine
        around = 1 + self.uneven * np.cos(label_rad + self.at_rad)
        lean = self.phase_rad * around
        leaning = sine * np.cos(lean) + cosine * np.sin(lean)
        return (
            leaning * (1 + self.gain * around) + self.offset.imag * around,
            cosine + self.offset.real * around,
        )


class Shaking(Cause):
    """The bracket of a head vibrates at one frequency; the phase differs from run to run."""

    name = "vibration"
    columns, places = 8, 1000

    def __init__(self, size: float, head: int, hz: float, phases_rad: Float) -> None:
        """Set size, head, frequency and ``phases_rad``, one phase for each run."""
        super().__init__(size)
        self.head, self.hz, self.phases_rad = head, hz, phases_rad
        self.columns = 2 * phases_rad.size

    @classmethod
    def drawn(cls, random: Random, runs: int, step_s: float, run_s: float) -> Shaking:
        """Draw an amplitude of 0.1 to 2″ and a frequency between ten periods per run and a third of
        the sampling rate."""
        hz = log_uniform(random, 10 / run_s, 1 / (3 * step_s))
        phases = random.uniform(0, 2 * np.pi, runs)
        return cls(log_uniform(random, 0.1, 2.0), int(random.integers(1, 3)), hz, phases)

    def bracket_rad(self, at: Conditions, head: int) -> Float | float:
        """Return a·sin(2πft + φ), where φ depends on the run; the phases repeat if there are more
        runs than phases."""
        if head != self.head:
            return 0.0
        phase = 2 * np.pi * self.hz * at.time_s + self.phases_rad[at.run % self.phases_rad.size]
        found: Float = self.size * ARCSEC * np.sin(phase)
        return found

    def values(self) -> dict[str, tuple[float, ...]]:
        """Return the frequency under the key ``hz``."""
        return {"hz": (self.hz,)}


class LateHead(Cause):
    """The reading of head 2 is older than that of head 1; with a negative size it is newer."""

    name = "timing_skew"
    unit = "us"

    @classmethod
    def drawn(cls, random: Random) -> LateHead:
        """Draw a delay of 1 to 60 µs with either sign."""
        return cls(log_uniform(random, 1.0, 60.0) * float(random.choice([-1, 1])))

    def delay_s(self, head: int) -> float:
        """Return the delay for head 2, 0 for head 1."""
        return self.size * 1e-6 if head == 2 else 0.0


class OldReading(Cause):
    """The readings of both heads are older than their row by the same delay."""

    name = "latency"
    unit = "us"

    @classmethod
    def drawn(cls, random: Random) -> OldReading:
        """Draw a delay of 5 to 300 µs."""
        return cls(log_uniform(random, 5.0, 300.0))

    def delay_s(self, head: int) -> float:
        """Return the delay, which is equal for both heads."""
        return self.size * 1e-6


class WarmBracket(Cause):
    """The bracket of head 2 expands with rising temperature."""

    name = "thermal_head_drift"
    unit = "arcsec/K"

    @classmethod
    def drawn(cls, random: Random) -> WarmBracket:
        """Draw a displacement of 0.1 to 3″/K with either sign."""
        return cls(log_uniform(random, 0.1, 3.0) * float(random.choice([-1, 1])))

    def bracket_rad(self, at: Conditions, head: int) -> Float | float:
        """Return an angle proportional to the warming."""
        return self.size * ARCSEC * at.warming_k if head == 2 else 0.0


class Slip(Cause):
    """A counter loses or gains whole counts at one instant of one run."""

    name = "count_slip"
    unit = "counts"
    places = 2000

    def __init__(self, size: int, head: int, run: int, instant_s: float) -> None:
        """Set the slip of ``size`` counts at the session time ``instant_s`` of a run; the next run
        starts from the index again."""
        super().__init__(float(size))
        self.head, self.run, self.instant_s = head, run, instant_s

    def scaled(self, factor: float) -> Self:
        """Return a slip of a whole number of counts, at least one."""
        found = super().scaled(factor)
        found.size = float(np.sign(found.size) * max(1.0, np.ceil(abs(found.size))))
        return found

    def slipped_counts(self, at: Conditions, head: int) -> Float | float:
        """Return the slip from its instant to the end of the run."""
        if head != self.head:
            return 0.0
        found: Float = self.size * ((at.run == self.run) & (at.time_s >= self.instant_s))
        return found
