"""Defines the causes on the disc and its axis."""

from __future__ import annotations

from collections.abc import Sequence

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


class HighOrder(Cause):
    """The graduation has an error of one order above the orders of the model."""

    name = "high_order_graduation"
    columns, places = 2, 400

    def __init__(self, size: float, order: int, phase_rad: float) -> None:
        """Set the amplitude ``size`` in arcseconds, the order per turn, and the phase."""
        super().__init__(size)
        self.order, self.phase_rad = order, phase_rad

    @classmethod
    def drawn(cls, random: Random) -> HighOrder:
        """Draw an order from 23 to 180 that is not near a multiple of 120/11, because two heads 33°
        apart cannot determine an order at such a multiple."""
        seen = [n for n in range(23, 181) if abs(np.sin(n * np.radians(33.0) / 2)) > 0.5]
        return cls(
            log_uniform(random, 0.1, 2.0), int(random.choice(seen)), random.uniform(0, 2 * np.pi)
        )

    def mark_rad(self, label_rad: Float, at: Conditions) -> Float:
        """Return a·cos(nψ + φ), with the amplitude a, the order n, the label ψ and the phase φ."""
        wave: Float = self.size * ARCSEC * np.cos(self.order * label_rad + self.phase_rad)
        return wave

    def values(self) -> dict[str, tuple[float, ...]]:
        """Return the order under the key ``order``."""
        return {"order": (float(self.order),)}


class Defect(Cause):
    """Dirt or a scratch displaces the marks over a few degrees by a raised cosine."""

    name = "graduation_defect"
    columns, places = 1, 400

    def __init__(self, size: float, place_rad: float, half_width_rad: float) -> None:
        """Set the largest error ``size`` in arcseconds, the place on the disc, and the half
        width."""
        super().__init__(size)
        self.place_rad, self.half_width_rad = place_rad, half_width_rad

    @classmethod
    def drawn(cls, random: Random) -> Defect:
        """Draw a height of 0.5 to 5″ and a full width at half maximum of 1.5 to 6°."""
        size = log_uniform(random, 0.5, 5.0) * float(random.choice([-1, 1]))
        return cls(size, random.uniform(0, 2 * np.pi), np.radians(random.uniform(1.5, 6.0)))

    def mark_rad(self, label_rad: Float, at: Conditions) -> Float:
        """Return a·(1 + cos(πx/w))/2 at the distance x from the place, within ±w."""
        off = np.angle(np.exp(1j * (label_rad - self.place_rad))) / self.half_width_rad
        bump = np.where(np.abs(off) < 1, 0.5 + 0.5 * np.cos(np.pi * off), 0.0)
        found: Float = self.size * ARCSEC * bump
        return found


class AxisMotion(Cause):
    """The axis moves in the frame of the stator on a path that repeats every turn."""

    name = "radial_error_motion"
    unit = "um"

    def __init__(
        self, size: float, orders: Sequence[int], x: Sequence[complex], y: Sequence[complex]
    ) -> None:
        """Set the path x + jy = size·Σ (Re x_k·exp(jkθ) + j·Re y_k·exp(jkθ))."""
        super().__init__(size)
        self.orders, self.x, self.y = list(orders), list(x), list(y)
        self.columns = 2 * len(self.orders)

    @classmethod
    def drawn(cls, random: Random) -> AxisMotion:
        """Draw one to three of the orders 2 to 5 and 7."""
        orders = [int(k) for k in random.choice([2, 3, 4, 5, 7], random.integers(1, 4), False)]
        x = random.rayleigh(1.0, len(orders)) * np.exp(2j * np.pi * random.random(len(orders)))
        y = random.rayleigh(1.0, len(orders)) * np.exp(2j * np.pi * random.random(len(orders)))
        return cls(log_uniform(random, 0.05, 1.0), orders, x.tolist(), y.tolist())

    def centre_m(self, at: Conditions) -> Complex:
        """Return the displacement of the axis, with which the disc's centre moves."""
        found: Complex = np.zeros(at.rows, dtype=complex)
        for order, x, y in zip(self.orders, self.x, self.y, strict=True):
            wave = np.exp(1j * order * at.turned_rad)
            found += (x * wave).real + 1j * (y * wave).real
        return self.size * MICROMETRE * found


class BallPass(Cause):
    """The cage and the balls of the bearing move the axis at an order per turn that is not an
    integer."""

    name = "bearing_ball_pass"
    unit = "um"
    columns, places = 4, 400

    def __init__(self, size: float, order: float, phase_rad: float, ratio: float) -> None:
        """Set the path of the axis: an ellipse with the half axes ``size`` (µm) and
        ``size·ratio``."""
        super().__init__(size)
        self.order, self.phase_rad, self.ratio = order, phase_rad, ratio

    @classmethod
    def drawn(cls, random: Random) -> BallPass:
        """Draw the number n of balls and the ratio q = d/D·cos β, with the ball's diameter d, the
        pitch diameter D and the contact angle β. The order is n/2·(1 − q), of the outer race, or
        ½·(1 − q), of the cage; an order within 0.1 of a multiple of ½ is raised by 0.13.
        """
        share = random.uniform(0.06, 0.25)
        cage = 0.5 * (1 - share)
        order = cage * int(random.integers(8, 22)) if random.random() < 0.6 else cage
        if abs(2 * order - round(2 * order)) < 0.2:
            order += 0.13
        size = log_uniform(random, 0.05, 1.0)
        return cls(size, float(order), random.uniform(0, 2 * np.pi), random.uniform(-1, 1))

    def centre_m(self, at: Conditions) -> Complex:
        """Return a point on an ellipse; its phase continues over all turns of the session."""
        angle = self.order * at.turned_rad + self.phase_rad
        found: Complex = self.size * MICROMETRE * (np.cos(angle) + 1j * self.ratio * np.sin(angle))
        return found

    def values(self) -> dict[str, tuple[float, ...]]:
        """Return the order under the key ``order``."""
        return {"order": (self.order,)}


class WarmCentre(Cause):
    """The disc's centre moves off the axis with rising temperature."""

    name = "thermal_eccentricity"
    unit = "um/K"
    columns = 2

    def __init__(self, size: float, place_rad: float) -> None:
        """Set the motion ``size`` in µm/K and its direction ``place_rad`` in the disc's frame."""
        super().__init__(size)
        self.place_rad = place_rad

    @classmethod
    def drawn(cls, random: Random) -> WarmCentre:
        """Draw a motion of 0.1 to 1 µm/K."""
        return cls(log_uniform(random, 0.1, 1.0), random.uniform(0, 2 * np.pi))

    def centre_m(self, at: Conditions) -> Complex:
        """Return a displacement that is proportional to the warming and turns with the disc."""
        found: Complex = (
            self.size * MICROMETRE * at.warming_k * np.exp(1j * (at.turned_rad + self.place_rad))
        )
        return found


class Backlash(Cause):
    """The disc lags behind the table by half the play, against the direction of motion."""

    name = "hysteresis"

    def __init__(self, size: float, share: float = 0.0, phase_rad: float = 0.0) -> None:
        """Set the whole play ``size`` in arcseconds and its relative variation ``share`` around the
        turn."""
        super().__init__(size)
        self.share, self.phase_rad = share, phase_rad

    @classmethod
    def drawn(cls, random: Random) -> Backlash:
        """Draw a play of 0.2 to 5″."""
        return cls(log_uniform(random, 0.2, 5.0))

    def wound_rad(self, at: Conditions) -> Float:
        """Return half the play times the direction, times (1 + share·cos(θ + φ))."""
        around = 1 + self.share * np.cos(at.turned_rad + self.phase_rad)
        lag: Float = 0.5 * self.size * ARCSEC * at.direction * around
        return lag
