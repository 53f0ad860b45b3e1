"""Defines the causes in the drive and in the reference; only the rows of a reference show them."""

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


class GearError(Cause):
    """The drive has a periodic error at the order of its tooth count, with a second harmonic."""

    name = "drive_gear_error"
    columns = 4

    def __init__(self, size: float, teeth: float, phases_rad: tuple[float, float]) -> None:
        """Set the amplitude ``size`` (arcseconds) at the tooth count; the second harmonic has a
        fifth of this amplitude."""
        super().__init__(size)
        self.teeth, self.phases_rad = teeth, phases_rad

    def reference_rad(self, at: Conditions, error_rad: Float) -> Float:
        """Return a·(cos(zθ + φ₁) + cos(2zθ + φ₂)/5), with z teeth and the table's angle θ."""
        tooth = self.teeth * at.turned_rad
        first, second = self.phases_rad
        found: Float = (
            self.size * ARCSEC * (np.cos(tooth + first) + 0.2 * np.cos(2 * tooth + second))
        )
        return found

    def values(self) -> dict[str, tuple[float, ...]]:
        """Return the tooth count, and twice the tooth count."""
        return {"order": (self.teeth, 2 * self.teeth)}


class Line(Cause):
    """A part of the drive, which the description does not mention, causes an error that is a sine
    in time."""

    name = "periodic_error"
    columns, places = 2, 1000

    def __init__(self, size: float, hz: float, phase_rad: float) -> None:
        """Set the amplitude ``size`` in arcseconds, the frequency and the phase."""
        super().__init__(size)
        self.hz, self.phase_rad = hz, phase_rad

    def reference_rad(self, at: Conditions, error_rad: Float) -> Float:
        """Return a·cos(2πft + φ), with the amplitude a, the frequency f and the phase φ."""
        found: Float = self.size * ARCSEC * np.cos(2 * np.pi * self.hz * at.time_s + self.phase_rad)
        return found

    def values(self) -> dict[str, tuple[float, ...]]:
        """Return the frequency under the key ``hz``."""
        return {"hz": (self.hz,)}


class AngleLine(Cause):
    """A part of the drive causes an error that is a sine of the table's angle, at any order."""

    name = "periodic_error"
    columns, places = 2, 1000

    def __init__(
        self, size: float, order: float, phase_rad: float, back_rad: float | None = None
    ) -> None:
        """Set amplitude, order and phase; ``back_rad`` is the phase in the backward direction if it
        differs."""
        super().__init__(size)
        self.order, self.phase_rad = order, phase_rad
        self.back_rad = phase_rad if back_rad is None else back_rad

    def reference_rad(self, at: Conditions, error_rad: Float) -> Float:
        """Return a·cos(νθ + φ), with the order ν, the table's angle θ and the phase φ."""
        phase = np.where(at.direction > 0, self.phase_rad, self.back_rad)
        found: Float = self.size * ARCSEC * np.cos(self.order * at.turned_rad + phase)
        return found

    def values(self) -> dict[str, tuple[float, ...]]:
        """Return the order under the key ``order``."""
        return {"order": (self.order,)}


class Faces(Cause):
    """The angles between the faces of the polygon are unequal."""

    name = "polygon_face_error"

    def __init__(self, size: float, faces_arcsec: Float) -> None:
        """Set the faces' errors ``faces_arcsec``, by station, and ``size``, the standard deviation
        with which they were drawn."""
        super().__init__(size)
        self.faces_rad = np.asarray(faces_arcsec) * ARCSEC
        self.columns = len(faces_arcsec) - 1

    @classmethod
    def drawn(cls, random: Random, faces: int) -> Faces:
        """Draw a standard deviation of 0.1 to 0.5″, and the errors of the faces."""
        size = log_uniform(random, 0.1, 0.5)
        return cls(size, size * random.standard_normal(faces))

    def scaled(self, factor: float) -> Self:
        """Scale the error of every face."""
        found = super().scaled(factor)
        found.faces_rad = self.faces_rad * factor
        return found

    def reference_rad(self, at: Conditions, error_rad: Float) -> Float:
        """Return, for each row, the error of the polygon's face that the autocollimator reads."""
        found: Float = self.faces_rad[at.station]
        return found


class FirstOrderOfReference(Cause):
    """Tilt and pyramidal error of the polygon together cause an error of order 1 in the reference
    alone."""

    name = "polygon_eccentricity"
    columns = 2

    def __init__(self, size: float, phase_rad: float) -> None:
        """Set the amplitude ``size`` in arcseconds and the phase."""
        super().__init__(size)
        self.phase_rad = phase_rad

    @classmethod
    def drawn(cls, random: Random) -> FirstOrderOfReference:
        """Draw an amplitude of 0.1 to 2″."""
        return cls(log_uniform(random, 0.1, 2.0), random.uniform(0, 2 * np.pi))

    def reference_rad(self, at: Conditions, error_rad: Float) -> Float:
        """Return a·cos(θ + φ), with the amplitude a and the table's angle θ."""
        found: Float = self.size * ARCSEC * np.cos(at.turned_rad + self.phase_rad)
        return found


class GainOfReference(Cause):
    """The autocollimator has a gain error."""

    name = "autocollimator_gain"
    unit = "1"

    @classmethod
    def drawn(cls, random: Random) -> GainOfReference:
        """Draw a gain error of 0.2 to 2 % with either sign."""
        return cls(log_uniform(random, 2e-3, 2e-2) * float(random.choice([-1, 1])))

    def reference_rad(self, at: Conditions, error_rad: Float) -> Float:
        """Return an error proportional to the measured error."""
        found: Float = self.size * error_rad
        return found


class Creep(Cause):
    """The stand of the reference creeps at a constant rate."""

    name = "reference_drift"
    unit = "arcsec/h"

    @classmethod
    def drawn(cls, random: Random, length_s: float) -> Creep:
        """Draw a creep of 0.3 to 3″ over the session, with either sign."""
        over = log_uniform(random, 0.3, 3.0) * float(random.choice([-1, 1]))
        return cls(over * 3600 / length_s)

    def reference_rad(self, at: Conditions, error_rad: Float) -> Float:
        """Return an error proportional to time."""
        found: Float = self.size * ARCSEC / 3600 * (at.time_s - at.time_s[0])
        return found
