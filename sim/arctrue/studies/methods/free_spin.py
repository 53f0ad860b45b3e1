"""Time measurement on a free spin with circle closure (TDR).

The table is spun up, the motor let go, and a fast clock takes the time of every line that passes
head 1. Within a few turns the true angle is a smooth function of time; the same line comes by again
after exactly one turn (closure), which is what separates the lines' errors from the slowing down.
A torque that repeats with the angle moves the table by an angle that falls with 1/speed²: turns at
different speeds (the dynamic reversal) separate it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from arctrue.base.units import ARCSEC_PER_RAD, RAD_PER_ARCSEC
from arctrue.studies.methods.method import Method, of_harmonics
from arctrue.studies.methods.normal_equations import NormalEquations
from arctrue.studies.methods.world import TURN_RAD, World
from arctrue.table import TableState

Float = NDArray[np.float64]


@dataclass(frozen=True)
class FreeSpin:
    """A spin-down: ω′ = −coulomb − viscous·ω, and a torque that repeats with the angle."""

    start_rad_s: float = 10.0 * TURN_RAD
    viscous_hz: float = 2e-3
    coulomb_rad_s2: float = 2e-3
    torque_orders: tuple[int, ...] = (1, 2)
    torque_rad_s2: tuple[float, ...] = (2e-4, 5e-5)
    """Amplitudes over the moment of inertia, assumed: 0.01″ at the start, 0.6″ at the end."""
    clock_hz: float = 100e6
    lines: int = 512
    """Of 16,384, evenly chosen."""
    windows: int = 100
    """Of some turns each, spread over the time of measurement."""
    turns_a_window: int = 3
    degree: int = 4
    """Of the polynomial of the angle over time in a window."""

    def smooth(self, time_s: Float) -> tuple[Float, Float]:
        """Angle and speed without the repeating torque."""
        offset = self.coulomb_rad_s2 / self.viscous_hz
        decay = np.exp(-self.viscous_hz * time_s)
        speed = (self.start_rad_s + offset) * decay - offset
        angle = (self.start_rad_s + offset) * (1.0 - decay) / self.viscous_hz - offset * time_s
        return angle, speed

    def angle(self, time_s: Float) -> tuple[Float, Float]:
        """True angle and speed: the torque's twice integrated part is τ/(n²ω²)."""
        smooth, speed = self.smooth(time_s)
        angle = smooth.copy()
        for order, torque in zip(self.torque_orders, self.torque_rad_s2, strict=True):
            angle -= torque / (order * speed) ** 2 * np.cos(order * smooth + 0.3 * order)
        return angle, speed

    def time_at(self, angle_rad: Float, guess_s: Float) -> Float:
        """When the table passes each angle, by Newton's method from ``guess_s``."""
        time = guess_s.copy()
        for _ in range(6):
            angle, speed = self.angle(time)
            time -= (angle - angle_rad) / speed
        return time


def timed_lines(world: World, spin: FreeSpin) -> list[tuple[Float, Float]]:
    """Times in seconds and readings in radians of the lines, window by window."""
    random = np.random.default_rng([world.settings.seed, 7])
    total_s = world.settings.time_s
    line = np.arange(spin.turns_a_window * spin.lines + 1)
    nominal: Float = line * np.float64(TURN_RAD / spin.lines)
    # The true angle at which each line of one turn passes the head.
    one_turn = nominal[: spin.lines]
    passes = one_turn.copy()
    table = world.table()
    for _ in range(8):
        passes += one_turn - table.reading_rad(0, TableState.at_rest(passes))
    shift = passes - one_turn
    last_s = total_s - 2.0 * spin.turns_a_window * TURN_RAD / spin.smooth(np.array([total_s]))[1][0]
    windows = []
    for begin_s in np.linspace(0.0, last_s, spin.windows):
        angle, speed = spin.angle(np.array([begin_s]))
        first_turn = np.ceil(angle[0] / TURN_RAD)
        true = first_turn * TURN_RAD + nominal + shift[line % spin.lines]
        guess = begin_s + (true - angle[0]) / speed[0]
        time = spin.time_at(true, guess)
        _, passing = spin.angle(time)
        time += random.normal(0.0, world.settings.noise_arcsec * RAD_PER_ARCSEC, time.size) / (
            passing
        )
        windows.append((np.round(time * spin.clock_hz) / spin.clock_hz, nominal))
    return windows


def harmonics_of_spin(world: World, spin: FreeSpin) -> tuple[NDArray[np.int64], Float]:
    """Orders and values of head 1's error as a function of its reading.

    Raises ValueError where the table comes to rest within the time of measurement.
    """
    total_s = world.settings.time_s
    if spin.smooth(np.array([total_s]))[1][0] <= 0.0:
        raise ValueError(f"the table comes to rest before {total_s:g} s")
    orders = world.settings.orders
    torque = np.asarray(spin.torque_orders, dtype=np.float64)
    sums = NormalEquations(2 * orders.size + 2 * torque.size)
    for time, reading in timed_lines(world, spin):
        middle, half = 0.5 * (time[0] + time[-1]), 0.5 * (time[-1] - time[0])
        smooth = np.polynomial.chebyshev.chebvander((time - middle) / half, spin.degree)
        mean_speed = (reading[-1] - reading[0]) / (time[-1] - time[0])
        phase = np.multiply.outer(reading, orders.astype(np.float64))
        swing = np.multiply.outer(reading, torque)
        weaker = (spin.start_rad_s / mean_speed) ** 2
        # R = θ(t) + g(R), and θ(t) a polynomial with the torque's part.
        design = np.hstack(
            [np.cos(phase), np.sin(phase), weaker * np.cos(swing), weaker * np.sin(swing)]
        )
        basis, _ = np.linalg.qr(smooth)
        # One common straight line first, so that 10⁵″ are not left to rounding.
        observed = (reading - mean_speed * (time - time[0])) * ARCSEC_PER_RAD
        sums.add(design - basis @ (basis.T @ design), observed - basis @ (basis.T @ observed))
    return orders, sums.solved()[: 2 * orders.size]


FREE_SPIN = Method(
    "free_spin",
    "Time measurement on a free spin (TDR)",
    "Lu et al. [3], Lu and Trumper [4]",
    1,
    "a motor that lets go, a bearing almost without friction, 10 turns a second, raw lines",
    "what speed changes: the axis' motion at working speed, torque that does not fall with speed²",
    lambda world: of_harmonics(*harmonics_of_spin(world, FreeSpin())),
)
