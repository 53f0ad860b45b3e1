"""Calibrates by time measurement on a free spin with circle closure (TDR).

The motor spins the table up and releases it, and a fast clock times every line that passes head 1.
The true angle follows the free response of the axis: with Coulomb and viscous friction this is the
sum of a constant, a straight line and e^{−vt}. Each line passes again after exactly one turn
(closure); this separates the lines' errors from the deceleration. A torque that repeats with the
angle moves the table by an angle proportional to 1/speed²; this dependence on speed (dynamic
reversal) separates the torque from the lines' errors. The friction is the same as in ``arctrue
stop-and-go``: the table stops after about three turns, of which two are timed, and it is spun up
repeatedly during the measuring time.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from arctrue.base.units import ARCSEC_PER_RAD, RAD_PER_ARCSEC
from arctrue.studies.methods.method import Method, of_harmonics
from arctrue.studies.methods.normal_equations import NormalEquations
from arctrue.studies.methods.world import TURN_RAD, World
from arctrue.studies.stop_and_go.servo import Axis
from arctrue.table import TableState

Float = NDArray[np.float64]

AXIS = Axis()
"""Mechanics of the axis, the same as in ``arctrue stop-and-go``."""


@dataclass(frozen=True)
class FreeSpin:
    """Free deceleration of the table: ω′ = −coulomb − viscous·ω, plus a torque that repeats with
    the angle."""

    start_rad_s: float = 10.0 * TURN_RAD
    viscous_hz: float = AXIS.viscous_n_m_s / AXIS.inertia_kg_m2
    coulomb_rad_s2: float = AXIS.coulomb_n_m / AXIS.inertia_kg_m2
    torque_orders: tuple[int, ...] = (1, 2, 5)
    torque_shares: tuple[float, ...] = (1e-3, 2.5e-4, 1e-4)
    """Amplitudes of the torque divided by the Coulomb friction (assumed): order 1 moves the table
    by 0.8″ at the start."""
    fitted_torque_orders: tuple[int, ...] = (1, 2)
    clock_hz: float = 100e6
    lines: int = 512
    """Number of lines that are timed, evenly spaced among 16,384."""
    turns_a_spin: int = 2
    spin_s: float = 4.0
    """Time of one spin: acceleration, deceleration and a pause."""
    viscous_known_to: float = 0.02
    """Relative error of the viscous friction with which the fit starts."""

    @property
    def torque_rad_s2(self) -> tuple[float, ...]:
        """Return the amplitudes of the torque divided by the moment of inertia."""
        return tuple(share * self.coulomb_rad_s2 for share in self.torque_shares)

    def smooth(self, time_s: Float) -> tuple[Float, Float]:
        """Return angle and speed without the repeating torque."""
        offset = self.coulomb_rad_s2 / self.viscous_hz
        decay = np.exp(-self.viscous_hz * time_s)
        speed = (self.start_rad_s + offset) * decay - offset
        angle = (self.start_rad_s + offset) * (1.0 - decay) / self.viscous_hz - offset * time_s
        return angle, speed

    def angle(self, time_s: Float, start_rad: float = 0.0) -> tuple[Float, Float]:
        """Return true angle and speed; a torque of order n, integrated twice, adds τ/(n²ω²) to the
        angle."""
        smooth, speed = self.smooth(time_s)
        smooth = smooth + start_rad
        angle = smooth.copy()
        for order, torque in zip(self.torque_orders, self.torque_rad_s2, strict=True):
            angle -= torque / (order * speed) ** 2 * np.cos(order * smooth + 0.3 * order)
        return angle, speed

    def time_at(self, angle_rad: Float, guess_s: Float, start_rad: float = 0.0) -> Float:
        """Return the time at which the table passes each angle, by Newton's method from
        ``guess_s``."""
        time = guess_s.copy()
        for _ in range(12):
            angle, speed = self.angle(time, start_rad)
            time -= (angle - angle_rad) / speed
        return time


def timed_lines(world: World, spin: FreeSpin) -> list[tuple[Float, Float]]:
    """Return, for each spin, the times of the lines in seconds and the readings in radians.

    Raises ValueError if the table stops before it has made the turns of a spin.
    """
    random = np.random.default_rng([world.settings.seed, 7])
    line = np.arange(spin.turns_a_spin * spin.lines + 1)
    nominal: Float = line * np.float64(TURN_RAD / spin.lines)
    # Compute the true angle at which each line of one turn passes the head.
    one_turn = nominal[: spin.lines]
    passes = one_turn.copy()
    table = world.table()
    for _ in range(8):
        passes += one_turn - table.reading_rad(0, TableState.at_rest(passes))
    shift = passes - one_turn
    stops_s = np.log1p(spin.start_rad_s * spin.viscous_hz / spin.coulomb_rad_s2) / spin.viscous_hz
    reach = float(spin.smooth(np.array([stops_s]))[0][0])
    if reach < 1.1 * nominal[-1]:
        raise ValueError(
            f"the table comes to rest after {reach / TURN_RAD:.1f} turns, "
            f"a spin of {spin.turns_a_spin} was asked for"
        )
    curve_s = np.linspace(0.0, 0.999 * stops_s, 2000)
    curve_rad = spin.smooth(curve_s)[0]
    spins = []
    for _ in range(max(int(world.settings.time_s / spin.spin_s), 1)):
        start = float(random.uniform(0.0, TURN_RAD))
        first = int(np.ceil(start / TURN_RAD * spin.lines))
        number = first + line
        reading = number * np.float64(TURN_RAD / spin.lines)
        true = reading + shift[number % spin.lines]
        time = spin.time_at(true, np.interp(true - start, curve_rad, curve_s), start)
        _, passing = spin.angle(time, start)
        time += random.normal(0.0, world.settings.noise_arcsec * RAD_PER_ARCSEC, time.size) / (
            passing
        )
        spins.append((np.round(time * spin.clock_hz) / spin.clock_hz, reading))
    return spins


def harmonics_of_spin(world: World, spin: FreeSpin) -> tuple[NDArray[np.int64], Float]:
    """Fit the times of all spins; return the orders, and the coefficients of head 1's error as a
    function of its reading."""
    orders = world.settings.orders
    torque = np.asarray(spin.fitted_torque_orders, dtype=np.float64)
    sums = NormalEquations(2 * orders.size + 2 * torque.size)
    viscous = spin.viscous_hz * (1.0 + spin.viscous_known_to)
    for time, reading in timed_lines(world, spin):
        since = time - time[0]
        decay = np.exp(-viscous * since)
        # An error of the viscous friction adds t·e^{−vt} to first order, and t²·e^{−vt} to second
        # order.
        response = np.column_stack(
            (np.ones_like(since), since, decay, since * decay, since**2 * decay)
        )
        fitted = np.linalg.lstsq(response, reading)[0]
        speed = response @ np.array(
            [fitted[1], 0.0, -viscous * fitted[2] + fitted[3], 2.0 * fitted[4] - viscous
             * fitted[3], -viscous * fitted[4]]
        )  # fmt: skip
        phase = np.multiply.outer(reading, orders.astype(np.float64))
        swing = np.multiply.outer(reading, torque)
        weaker = (spin.start_rad_s / speed[:, None]) ** 2
        # R = θ(t) + g(R); θ(t) is the free response plus the contribution of the torque.
        design = np.hstack(
            [np.cos(phase), np.sin(phase), weaker * np.cos(swing), weaker * np.sin(swing)]
        )
        basis, _ = np.linalg.qr(response / np.linalg.norm(response, axis=0))
        # Subtract the fitted response first; otherwise the rounding error of angles of 10⁶″ would
        # be too large.
        observed = (reading - response @ fitted) * ARCSEC_PER_RAD
        sums.add(design - basis @ (basis.T @ design), observed - basis @ (basis.T @ observed))
    return orders, sums.solved()[: 2 * orders.size]


FREE_SPIN = Method(
    "free_spin",
    "Time measurement on a free spin (TDR)",
    "Lu et al. [3], Lu and Trumper [4]",
    1,
    "a motor that spins the table up to 10 turns per second every 4 s and releases it; the times "
    "of the lines",
    "differences between the spin and the working speed, such as the axis' motion; torque at "
    "orders that the fit does not contain",
    lambda world: of_harmonics(*harmonics_of_spin(world, FreeSpin())),
)
