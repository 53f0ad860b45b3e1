"""Simulates a rotary axis with motor, friction and a position loop whose only feedback is an
encoder.

Friction follows the LuGre model (Canudas de Wit et al., IEEE Trans. Automatic Control 40, 1995):
bristles of stiffness σ₀ bend before the axis slides; Stribeck's curve and viscous friction are
added. The controller is a proportional position loop around a proportional-integral speed loop; the
speed is computed from the difference of two readings.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Float = NDArray[np.float64]
SETTLED_COUNTS = 5.0
"""Largest distance of the feedback from the target in the settled state: 0.39″ at 2²⁴ counts a
turn."""
RECENT_SHARE = 0.01
"""Weight of a new sample in the averaged feedback, which shows whether the table has settled; the
average covers about 100 samples (10 ms) of 0.1″ noise."""
Feedback = Callable[[Float], Float]
"""Function that returns the position that the encoder shows, in radians and rounded to whole
counts, at a true angle."""


@dataclass(frozen=True)
class Axis:
    """Mechanical parameters of the axis."""

    inertia_kg_m2: float = 0.02
    coulomb_n_m: float = 0.30
    static_n_m: float = 0.36
    stribeck_rad_s: float = 2e-3
    viscous_n_m_s: float = 0.05
    bristle_n_m_rad: float = 3_000.0
    """σ₀, stiffness of the bristles: they bend by 100 µrad (20″) before the axis slides."""
    bristle_n_m_s: float = 8.0
    """σ₁, damping of the bristles."""
    torque_limit_n_m: float = 5.0

    def friction(self, speed: Float, bend: Float, step_s: float) -> tuple[Float, Float]:
        """Return the friction torque, and the bend of the bristles one step later, each ``(n,)``.

        The bend is computed implicitly, because it settles within less than a step while the axis
        slides.
        """
        level = self.coulomb_n_m + (self.static_n_m - self.coulomb_n_m) * np.exp(
            -((speed / self.stribeck_rad_s) ** 2)
        )
        stiffness = self.bristle_n_m_rad * np.abs(speed) / level
        after = (bend + speed * step_s) / (1.0 + stiffness * step_s)
        change = (after - bend) / step_s
        # The damping of the bristles decreases while the axis slides; otherwise it would equal a
        # second viscous friction.
        damping = self.bristle_n_m_s * np.exp(-((speed / self.stribeck_rad_s) ** 2))
        torque = self.bristle_n_m_rad * after + damping * change + self.viscous_n_m_s * speed
        return torque, after


@dataclass(frozen=True)
class Controller:
    """Gains of the controller at its sampling rate; the controller computes a new torque at each
    sample."""

    rate_hz: float = 10_000.0
    position_1_s: float = 60.0
    speed_n_m_s: float = 8.0
    integral_n_m: float = 1_600.0
    """Gain of the speed loop's integral part, per radian of position."""
    smoothing: float = 0.3
    """Weight of a new speed in the filtered speed."""


@dataclass(frozen=True)
class Moves:
    """Independent moves, each from rest to rest; arrays ``(moves,)`` in radians."""

    start_rad: Float
    target_rad: Float
    speed_rad_s: float = float(np.radians(30.0))
    acceleration_rad_s2: float = float(np.radians(120.0))

    def path(self, time_s: float) -> tuple[Float, Float]:
        """Return position and speed at a time on the trapezoidal profile of the moves."""
        length = np.abs(self.target_rad - self.start_rad)
        side = np.sign(self.target_rad - self.start_rad)
        top = np.minimum(self.speed_rad_s, np.sqrt(length * self.acceleration_rad_s2))
        ramp = top / self.acceleration_rad_s2
        with np.errstate(divide="ignore", invalid="ignore"):
            cruise = np.where(top > 0.0, length / top - ramp, 0.0)
        up = np.clip(time_s, 0.0, ramp)
        along = np.clip(time_s - ramp, 0.0, cruise)
        down = np.clip(time_s - ramp - cruise, 0.0, ramp)
        slope = self.acceleration_rad_s2
        way = slope * up**2 / 2.0 + top * along + top * down - slope * down**2 / 2.0
        return self.start_rad + side * way, side * slope * (up - down)

    @property
    def duration_s(self) -> float:
        """Return the duration of the longest move."""
        length = float(np.max(np.abs(self.target_rad - self.start_rad)))
        top = min(self.speed_rad_s, float(np.sqrt(length * self.acceleration_rad_s2)))
        return length / top + top / self.acceleration_rad_s2 if top else 0.0


@dataclass(frozen=True)
class Stopped:
    """State of the table at the end of each move, ``(moves,)``."""

    angle_rad: Float
    """Mean of the true angle over the dwell."""
    tremble_rad: Float
    """Largest minus smallest true angle in the dwell."""
    following_rad: float
    """Largest distance of the feedback from the path during the moves."""
    settled_s: Float
    """Time from the end of the path to the last instant at which the averaged feedback was more
    than SETTLED_COUNTS from the target."""


def drive(
    axis: Axis,
    controller: Controller,
    moves: Moves,
    feedback: Feedback,
    count_rad: float,
    *,
    settle_s: float = 0.8,
    dwell_s: float = 0.2,
) -> Stopped:
    """Simulate all moves in parallel; return the state of the table at their ends.

    At first the table stands at the angle at which its feedback shows the start. The torque of the
    controller is constant within a step. The semi-implicit Euler rule integrates the motion; in a
    step the phase of the bristles' oscillation advances by 0.04 rad.
    """
    step_s = 1.0 / controller.rate_hz
    angle = moves.start_rad.copy()
    for _ in range(8):
        angle = angle + moves.start_rad - feedback(angle)
    speed, bend, integral = np.zeros_like(angle), np.zeros_like(angle), np.zeros_like(angle)
    before, shown_speed = feedback(angle), np.zeros_like(angle)
    path_end_s = moves.duration_s
    steps = round((path_end_s + settle_s + dwell_s) * controller.rate_hz)
    dwell = round(dwell_s * controller.rate_hz)
    total, low, high = (
        np.zeros_like(angle),
        np.full_like(angle, np.inf),
        -np.full_like(angle, np.inf),
    )
    following = 0.0
    last_off, recent = np.zeros_like(angle), before.copy()
    for number in range(steps):
        time_s = number * step_s
        wanted, wanted_speed = moves.path(time_s)
        shown = feedback(angle)
        shown_speed = shown_speed + controller.smoothing * ((shown - before) / step_s - shown_speed)
        before = shown
        recent = recent + RECENT_SHARE * (shown - recent)
        asked = wanted_speed + controller.position_1_s * (wanted - shown)
        off = asked - shown_speed
        integral = np.clip(
            integral + controller.integral_n_m * off * step_s,
            -axis.torque_limit_n_m,
            axis.torque_limit_n_m,
        )
        torque = np.clip(
            controller.speed_n_m_s * off + integral, -axis.torque_limit_n_m, axis.torque_limit_n_m
        )
        rubbing, bend = axis.friction(speed, bend, step_s)
        speed = speed + (torque - rubbing) / axis.inertia_kg_m2 * step_s
        angle = angle + speed * step_s
        if time_s < path_end_s:
            following = max(following, float(np.max(np.abs(wanted - shown))))
        else:
            outside = np.abs(recent - moves.target_rad) > SETTLED_COUNTS * count_rad
            last_off = np.where(outside, time_s - path_end_s, last_off)
        if number >= steps - dwell:
            total += angle
            low, high = np.minimum(low, angle), np.maximum(high, angle)
    return Stopped(total / dwell, high - low, following, last_off)
