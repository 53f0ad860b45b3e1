"""A rotary axis with motor, friction and a position loop whose only feedback is an encoder.

Friction is the LuGre model (Canudas de Wit et al., IEEE Trans. Automatic Control 40, 1995):
bristles of stiffness σ₀ that bend before the axis slides, Stribeck's curve, viscous friction. The
controller is a proportional position loop around a proportional-integral speed loop, speed being
the difference of two readings.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Float = NDArray[np.float64]
SETTLED_COUNTS = 5.0
"""Largest distance from the target in the settled state: 0.39″ at 2²⁴ counts a turn."""
RECENT_SHARE = 0.01
"""Weight of a new sample in the feedback's average over about 100 samples, 10 ms, which the test
uses: its noise is 0.1″."""
Feedback = Callable[[Float], Float]
"""Function that converts the true angle to the position that the encoder shows, radians; whole
counts."""


@dataclass(frozen=True)
class Axis:
    """The mechanics."""

    inertia_kg_m2: float = 0.02
    coulomb_n_m: float = 0.30
    static_n_m: float = 0.36
    stribeck_rad_s: float = 2e-3
    viscous_n_m_s: float = 0.05
    bristle_n_m_rad: float = 3_000.0
    """σ₀: the axis bends by 100 µrad, 20″, before it slides."""
    bristle_n_m_s: float = 8.0
    """σ₁."""
    torque_limit_n_m: float = 5.0

    def friction(self, speed: Float, bend: Float, step_s: float) -> tuple[Float, Float]:
        """Return the torque of the friction and the bristles' bend a step later, each ``(n,)``.

        The bend is computed implicitly: while the axis slides it settles within less than a step.
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
    """Gains at a sampling rate; a new torque every sample."""

    rate_hz: float = 10_000.0
    position_1_s: float = 60.0
    speed_n_m_s: float = 8.0
    integral_n_m: float = 1_600.0
    """Gain of the speed loop's integral, which is per radian of position."""
    smoothing: float = 0.3
    """Weight of a new speed in the filtered one."""


@dataclass(frozen=True)
class Moves:
    """Many independent moves, each from rest to rest; arrays ``(moves,)`` in radians."""

    start_rad: Float
    target_rad: Float
    speed_rad_s: float = float(np.radians(30.0))
    acceleration_rad_s2: float = float(np.radians(120.0))

    def path(self, time_s: float) -> tuple[Float, Float]:
        """Give position and speed of a trapezoidal profile at a time, in the feedback's angle."""
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
        """Duration of the longest move."""
        length = float(np.max(np.abs(self.target_rad - self.start_rad)))
        top = min(self.speed_rad_s, float(np.sqrt(length * self.acceleration_rad_s2)))
        return length / top + top / self.acceleration_rad_s2 if top else 0.0


@dataclass(frozen=True)
class Stopped:
    """Final state of the table after each move, ``(moves,)``."""

    angle_rad: Float
    """True angle, mean over the dwell."""
    tremble_rad: Float
    """Largest minus smallest true angle during the dwell."""
    following_rad: float
    """Largest distance of the feedback from the path during the moves."""
    settled_s: Float
    """Time from the end of the path until the averaged feedback stays within five counts."""


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
    """Make all moves at once. At first the feedback of the table shows the start.

    A step is one of the controller; the torque is constant within it. The semi-implicit Euler rule
    integrates the motion; a step is 0.04 rad of the bristles' oscillation.
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
