"""Defines causes that the catalogue does not contain; for a set with such a cause the right answer
is ``unknown``."""

from __future__ import annotations

import numpy as np

from arctrue.studies.benchmark.independent.causes.cause import (
    ARCSEC,
    MICROMETRE,
    Cause,
    Complex,
    Float,
    Random,
    log_uniform,
)
from arctrue.studies.benchmark.independent.conditions import Conditions


class Stranger(Cause):
    """Base class of the causes that the catalogue does not contain."""

    known = False


class WarmOval(Stranger):
    """The disc becomes oval as the temperature rises."""

    name = "warm_oval"
    columns, places, unit = 2, 20, "arcsec/K"

    @classmethod
    def drawn(cls, random: Random) -> WarmOval:
        """Draw an amplitude of 0.1 to 1″/K."""
        return cls(log_uniform(random, 0.1, 1.0))

    def mark_rad(self, label_rad: Float, at: Conditions) -> Float:
        """Return a·ΔT·cos 2ψ, with the warming ΔT and the label ψ."""
        found: Float = self.size * ARCSEC * at.warming_k * np.cos(2 * label_rad)
        return found


class FastLobes(Stranger):
    """An error of order 3 grows with the square of the speed."""

    name = "fast_lobes"
    columns, places = 2, 20

    @classmethod
    def drawn(cls, random: Random) -> FastLobes:
        """Draw an amplitude of 0.05 to 1″ at 30°/s."""
        return cls(log_uniform(random, 0.05, 1.0))

    def mark_rad(self, label_rad: Float, at: Conditions) -> Float:
        """Return a·(ω/30°/s)²·cos 3ψ, with the speed ω and the label ψ."""
        share = (at.speed_rad_s / np.radians(30.0)) ** 2
        found: Float = self.size * ARCSEC * share * np.cos(3 * label_rad)
        return found


class SettlingBracket(Stranger):
    """The bracket of head 2 settles after the start of the session."""

    name = "settling_bracket"
    places = 10

    def __init__(self, size: float, time_constant_s: float) -> None:
        """Set the angle ``size`` (arcseconds) at the start of the session and the time constant."""
        super().__init__(size)
        self.time_constant_s = time_constant_s

    @classmethod
    def drawn(cls, random: Random, run_s: float) -> SettlingBracket:
        """Draw an angle of 0.5 to 5″, and a time constant that is a fraction of the first run's
        duration."""
        return cls(log_uniform(random, 0.5, 5.0), run_s * random.uniform(0.1, 0.4))

    def bracket_rad(self, at: Conditions, head: int) -> Float | float:
        """Return a·exp(−t/τ), with the time t since the start of the session."""
        if head != 2:
            return 0.0
        found: Float = self.size * ARCSEC * np.exp(-at.time_s / self.time_constant_s)
        return found


class AirDrag(Stranger):
    """The bracket of head 2 bends in proportion to the square root of speed, in both directions."""

    name = "air_drag"

    @classmethod
    def drawn(cls, random: Random) -> AirDrag:
        """Draw an angle of 0.5 to 5″ at 30°/s."""
        return cls(log_uniform(random, 0.5, 5.0))

    def bracket_rad(self, at: Conditions, head: int) -> Float | float:
        """Return a·√(|ω|/30°/s), with the speed ω."""
        if head != 2:
            return 0.0
        share = np.sqrt(np.abs(at.speed_rad_s) / np.radians(30.0))
        found: Float = self.size * ARCSEC * share
        return found


class Sectors(Stranger):
    """Every second sector of the disc is shifted, because the disc was written sector by sector:
    the error is a square wave."""

    name = "sectors"
    columns, places = 2, 40

    def __init__(self, size: float, pairs: int, phase_rad: float) -> None:
        """Set ``size``, half of the shift between two sectors in arcseconds, the number of pairs of
        sectors, and the phase."""
        super().__init__(size)
        self.pairs, self.phase_rad = pairs, phase_rad

    @classmethod
    def drawn(cls, random: Random) -> Sectors:
        """Draw 5 to 9 pairs of sectors and a size of 0.2 to 2″."""
        pairs = int(random.integers(5, 10))
        return cls(log_uniform(random, 0.2, 2.0), pairs, random.uniform(0, 2 * np.pi))

    def mark_rad(self, label_rad: Float, at: Conditions) -> Float:
        """Return ±size: the sign of a sine with one period per pair of sectors."""
        found: Float = self.size * ARCSEC * np.sign(np.sin(self.pairs * label_rad + self.phase_rad))
        return found


class LooseBracket(Stranger):
    """The bracket of head 2 jumps between two positions at random instants."""

    name = "loose_bracket"
    columns, places = 6, 2000

    def __init__(self, size: float, instants_s: Float) -> None:
        """Set the distance ``size`` (arcseconds) between the two positions and the instants of the
        jumps."""
        super().__init__(size)
        self.instants_s = np.sort(instants_s)

    @classmethod
    def drawn(cls, random: Random, length_s: float) -> LooseBracket:
        """Draw a distance of 0.3 to 3″ and 9 to 16 jumps."""
        instants = random.uniform(0, length_s, int(random.integers(9, 17)))
        return cls(log_uniform(random, 0.3, 3.0), instants)

    def bracket_rad(self, at: Conditions, head: int) -> Float | float:
        """Return the bracket's position: 0, or ``size`` after an odd number of jumps."""
        if head != 2:
            return 0.0
        found: Float = self.size * ARCSEC * (np.searchsorted(self.instants_s, at.time_s) % 2)
        return found


class WobblingRoller(Stranger):
    """A roller moves the axis along a line; the amplitude of the roller's order rises and falls in
    time."""

    name = "wobbling_roller"
    unit = "um"
    columns, places = 4, 400

    def __init__(self, size: float, order: float, swell_s: float) -> None:
        """Set the amplitude ``size`` of x and of y in µm, the order per turn, and ``swell_s``, the
        period in which both amplitudes rise and fall.
        """
        super().__init__(size)
        self.order, self.swell_s = order, swell_s

    @classmethod
    def drawn(cls, random: Random, length_s: float) -> WobblingRoller:
        """Draw an amplitude of 0.1 to 1 µm, an order with the whole part 2 to 8 and the fraction
        0.3 to 0.45, and 1.3 to 2.7 periods ``swell_s`` per session.
        """
        order = float(random.integers(2, 9)) + random.uniform(0.3, 0.45)
        return cls(log_uniform(random, 0.1, 1.0), order, length_s / random.uniform(1.3, 2.7))

    def centre_m(self, at: Conditions) -> Complex:
        """Return the displacement of the axis, which lies on one straight line."""
        swell = np.sin(2 * np.pi * at.time_s / self.swell_s)
        found: Complex = (
            self.size * MICROMETRE * swell * np.cos(self.order * at.turned_rad) * (1 + 1j)
        )
        return found


class BentScale(Stranger):
    """The autocollimator's scale is not linear: its reading has a cubic part."""

    name = "bent_scale"
    places = 3

    @classmethod
    def drawn(cls, random: Random) -> BentScale:
        """Draw a size of 0.5 to 3″ with either sign; it is the cubic part at the largest error."""
        return cls(log_uniform(random, 0.5, 3.0) * float(random.choice([-1, 1])))

    def reference_rad(self, at: Conditions, error_rad: Float) -> Float:
        """Return a·(ε/ε_max)³ minus its linear part, with the measured error ε."""
        share = error_rad / np.max(np.abs(error_rad))
        found: Float = self.size * ARCSEC * (share**3 - 0.6 * share)
        return found


class Chirp(Stranger):
    """A slipping belt or an accelerating fan causes a sine in time whose frequency changes."""

    name = "chirp"
    columns, places = 2, 5000

    def __init__(self, size: float, hz: float, hz_s: float, phase_rad: float) -> None:
        """Set a sine with the amplitude ``size`` (arcseconds) whose frequency starts at ``hz`` and
        changes by ``hz_s`` per second."""
        super().__init__(size)
        self.hz, self.hz_s, self.phase_rad = hz, hz_s, phase_rad

    @classmethod
    def drawn(cls, random: Random, length_s: float, sigma_arcsec: float) -> Chirp:
        """Draw a size of 1 to 4 σ and an initial frequency of 8 to 20 periods per session; the
        frequency triples by the end of the session."""
        hz = random.uniform(8, 20) / length_s
        size = sigma_arcsec * log_uniform(random, 1.0, 4.0)
        return cls(size, hz, 2 * hz / length_s, random.uniform(0, 2 * np.pi))

    def reference_rad(self, at: Conditions, error_rad: Float) -> Float:
        """Return a·cos(2π(f + kt/2)t + φ); the initial frequency f changes by k per second."""
        time_s = at.time_s - at.time_s[0]
        phase = 2 * np.pi * (self.hz + self.hz_s * time_s / 2) * time_s + self.phase_rad
        found: Float = self.size * ARCSEC * np.cos(phase)
        return found


class ReferenceJump(Stranger):
    """The stand of the reference was knocked; all later readings have the same offset."""

    name = "reference_jump"
    places = 500

    def __init__(self, size: float, instant_s: float) -> None:
        """Set the offset ``size`` (arcseconds) after the jump and the instant of the jump."""
        super().__init__(size)
        self.instant_s = instant_s

    def reference_rad(self, at: Conditions, error_rad: Float) -> Float:
        """Return 0 before the jump and ``size`` after it."""
        found: Float = self.size * ARCSEC * (at.time_s >= self.instant_s)
        return found


class TimeDrift(Stranger):
    """The bracket of head 2 creeps at a constant rate that does not depend on temperature."""

    name = "head_creep"
    unit = "arcsec/h"

    def bracket_rad(self, at: Conditions, head: int) -> Float | float:
        """Return an angle proportional to time."""
        if head != 2:
            return 0.0
        return self.size * ARCSEC / 3600 * at.time_s
