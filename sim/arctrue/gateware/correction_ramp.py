"""Models the entity ``correction_ramp``: total = ε + r, where r removes the step at a marker (a
change of the coefficients) and then decays to 0."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from arctrue.base.units import ARCSEC_PER_TURN
from arctrue.generated.number_formats import (
    CLOCK_HZ,
    CORRECTION_FRACTION,
    CORRECTION_WIDTH,
    PAIR_FRACTION,
    RAMP_LOOK_CLOCK,
    RAMP_MARGIN_BITS,
    RAMP_TICK_WIDTH,
    RAMP_VELOCITY_FRACTION,
)

RATE_MAX = 2**32 - 1
ACCELERATION_MAX = 2**32 - 1
COMPARE = RAMP_LOOK_CLOCK + 1
"""Clock (0 to 255 in each cycle of the velocity) in which the remainder is compared; it was read
one clock before."""
DECIDE = 2**RAMP_TICK_WIDTH - 1
"""Last clock of the cycle, in which the velocity changes."""
TOTAL_MOST = 1 << (CORRECTION_WIDTH - 1 - CORRECTION_FRACTION)
"""Limit of the total correction, s19.F, in counts: the total is at least −TOTAL_MOST and below
TOTAL_MOST."""
HOLD = 3
"""Number of clocks for which the total keeps its value after a marker."""
CATCH_AGE = 1
# Number of clocks from a marker to the last total in which r still has its captured value at every
# rate.
DECAY_START = 5


@dataclass(frozen=True)
class RampState:
    """State of the ramp: the latest total, which the ramp holds after a marker, and r as captured
    after the latest marker, in 2⁻ᶠ count.

    ``age``: clocks since the latest marker.
    """

    held: int = 0
    caught: int = 0
    age: int = HOLD
    motion: RampVelocity | None = None
    """r and its velocity if the acceleration is bounded; they replace ``caught``."""
    excess_then: int = 0
    """−r that belongs to the total of the previous clock if the acceleration is bounded; ``motion``
    contains the value for the next clock."""


@dataclass
class RampVelocity:
    """Models the entity ``ramp_velocity``; one call of :meth:`clock` is one clock.

    ``velocity``: 2⁻⁵¹ count per clock; ``way``: braking distance, 2⁻ᶠ count; ``excess``: −r for the
    next total (the entity correction_ramp stores this value); ``step``: change of ``excess`` in a
    clock.
    """

    excess: int = 0
    velocity: int = 0
    way: int = 0
    step: int = 0
    falling: bool = False
    ends: bool = False
    moves: bool = False
    tick: int = 0
    fraction: int = 0
    was_marker: bool = False
    is_stale: bool = False
    seen: tuple[int, bool, bool] = (0, True, False)
    """Sampled properties of the remainder r: its size, whether it counts as 0, and whether it
    grows."""
    fits: tuple[bool, bool] = (False, False)
    """Whether the braking distance permits a higher velocity, and whether it permits the present
    velocity."""

    def clock(self, marker: bool, rate: int, acceleration: int) -> None:
        """Advance by one clock; the caller then computes the new ``excess`` from ``step`` and
        ``ends``, and sets it."""
        whole = self.velocity >> RAMP_VELOCITY_FRACTION
        moved = self.fraction + whole
        is_held = marker or self.was_marker
        self.step = 0 if is_held else (moved >> RAMP_TICK_WIDTH) * (-1 if self.falling else 1)
        self.fraction = 0 if is_held else moved % 2**RAMP_TICK_WIDTH
        self.was_marker = marker
        faster = self.velocity + acceleration
        more = faster >> RAMP_VELOCITY_FRACTION
        velocity, self.ends = self.velocity, False
        if self.tick == RAMP_LOOK_CLOCK:
            self.is_stale = False
            size = self.excess if self.excess >= 0 else ~self.excess
            away = self.moves and self.falling == (self.excess < 0)
            self.seen = size, self.excess == 0 or (size == 0 and not away), away
        elif self.tick == COMPARE:
            enough = (
                self.way + more + (more >> RAMP_MARGIN_BITS),
                self.way + (whole >> RAMP_MARGIN_BITS),
            )
            self.fits = self.seen[0] >= enough[0], self.seen[0] >= enough[1]
        elif self.tick == DECIDE and (self.is_stale or marker):
            # While the remainder is unknown, the ramp brakes.
            velocity, self.way = velocity - acceleration, self.way - whole
            if velocity <= 0:
                self.moves, velocity, self.way = False, 0, 0
        elif self.tick == DECIDE:
            limit = rate << RAMP_VELOCITY_FRACTION
            if (not self.moves and not self.fits[0]) or (self.seen[1] and whole <= 1):
                self.ends, self.moves, velocity, self.way = True, False, 0, 0
            elif velocity > limit or self.seen[2] or not self.fits[1]:
                velocity, self.way = velocity - acceleration, self.way - whole
                if velocity <= 0:
                    self.moves, velocity, self.way = False, 0, 0
            elif self.fits[0] and faster <= limit:
                self.falling = self.falling if self.moves else self.excess >= 0
                velocity, self.way, self.moves = faster, self.way + more, True
        self.tick = (self.tick + 1) % 2**RAMP_TICK_WIDTH
        self.is_stale |= marker
        self.velocity = velocity


def ramp_arcsec_s(ramp_rate: float, counts_per_rev: int) -> float:
    """Convert a ramp's velocity from the register's 2⁻³⁵ count per clock to ″/s.

    The firmware converts its parameter ``ramp_arcsec_s`` to this register.
    """
    return ramp_rate / 2**35 * CLOCK_HZ * ARCSEC_PER_TURN / counts_per_rev


def ramp_arcsec_s2(ramp_acceleration: float, counts_per_rev: int) -> float:
    """Convert a ramp's acceleration from the register's 2⁻⁵⁹ count per clock² to ″/s²."""
    return ramp_acceleration / 2**59 * CLOCK_HZ**2 * ARCSEC_PER_TURN / counts_per_rev


class RampResult(NamedTuple):
    """Outputs of the ramp. ``total``: int64 in 2⁻ᶠ count, F = PAIR_FRACTION; ``limited`` and
    ``busy``: bool."""

    total: NDArray[np.int64]
    limited: NDArray[np.bool_]
    busy: NDArray[np.bool_]
    state: RampState


def correction_ramp(
    correction: NDArray[np.int64],
    marker: NDArray[np.bool_],
    limit: int,
    ramp_rate: int,
    state: RampState | None = None,
    inserted: NDArray[np.int64] | None = None,
    ramp_acceleration: int = 0,
) -> RampResult:
    """Return the total correction of consecutive clocks.

    ``correction``: ε in 2⁻ᶠ count, (clocks,); ``marker``: (clocks,), true if ε comes from other
    coefficients than in the previous clock; ``limit`` in counts; ``ramp_rate`` u8.24 in 2⁻¹¹ count
    per clock. ``state``: the state after the previous clocks, default: after reset. ``inserted``:
    counts by which the reading jumps in the clock of a marker, (clocks,); ignored in other clocks.
    ``ramp_acceleration`` in 2⁻⁵⁹ count per clock²; 0: the velocity is equal to the rate from the
    first clock on. Raises ValueError for a rate that u8.24 cannot hold, or an acceleration that 32
    bits cannot hold.
    """
    if not 0 <= ramp_acceleration <= ACCELERATION_MAX:
        raise ValueError(
            f"ramp_acceleration: {ramp_acceleration}, expected 0 to {ACCELERATION_MAX}"
        )
    if not 0 <= ramp_rate <= RATE_MAX:
        raise ValueError(f"ramp_rate: {ramp_rate}, expected 0 to {RATE_MAX} (u8.24)")
    state = state or RampState()
    if ramp_acceleration:
        return _accelerated(
            correction, marker, limit, ramp_rate, ramp_acceleration, state, inserted
        )
    clocks = correction.size
    total = np.empty(clocks, dtype=np.int64)
    limited = np.zeros(clocks, dtype=np.bool_)
    busy = np.zeros(clocks, dtype=np.bool_)
    top = limit << PAIR_FRACTION
    held, caught, age = state.held, state.caught, state.age
    start = 0
    for end in [*np.flatnonzero(marker).tolist(), clocks]:
        # After the previous marker, the total first keeps its value; then r decays.
        until = min(end, start + max(HOLD - 1 - age, 0))
        if age < CATCH_AGE <= age + until - start:
            caught = held - int(correction[start + CATCH_AGE - age - 1])
        total[start:until] = held
        busy[start:until] = True
        age += until - start
        if end > until:
            ages = age + 1 + np.arange(end - until, dtype=np.int64)
            remainder = _decayed(caught, ages, ramp_rate)
            unlimited = correction[until:end] + remainder
            total[until:end] = np.clip(unlimited, -top - 1, top)
            limited[until:end] = (unlimited > top) | (unlimited < -top)
            busy[until:end] = remainder != 0
            held = int(total[end - 1])
            age = int(ages[-1])
        if end < clocks:
            if inserted is not None:
                held, limited[end] = _jumped(held, int(inserted[end]), limit)
            total[end] = held
            busy[end] = True
            age = 0
        start = end + 1
    return RampResult(total, limited, busy, RampState(held, caught, age))


def _jumped(held: int, counts: int, limit: int) -> tuple[int, bool]:
    """Return the total after a jump of the reading, and whether the limit replaced it."""
    whole = (held >> PAIR_FRACTION) + counts
    fits = -TOTAL_MOST <= whole < TOTAL_MOST
    if not fits:
        whole = limit if counts > 0 else -limit - 1
    return (whole << PAIR_FRACTION) + held % 2**PAIR_FRACTION, not fits


def _decayed(caught: int, ages: NDArray[np.int64], ramp_rate: int) -> NDArray[np.int64]:
    if caught == 0:
        return np.zeros(ages.size, dtype=np.int64)
    lost = (np.maximum(ages - DECAY_START, 0) * ramp_rate) >> RAMP_TICK_WIDTH
    left: NDArray[np.int64] = np.maximum(abs(caught) - lost, 0)
    return left if caught > 0 else -left


def _accelerated(
    correction: NDArray[np.int64],
    marker: NDArray[np.bool_],
    limit: int,
    ramp_rate: int,
    ramp_acceleration: int,
    state: RampState,
    inserted: NDArray[np.int64] | None,
) -> RampResult:
    """Compute the total clock by clock, because the velocity depends on r."""
    motion = replace(state.motion or RampVelocity())
    held, age, excess, top = state.held, state.age, state.excess_then, limit << PAIR_FRACTION
    jumps = np.zeros(correction.size, dtype=np.int64) if inserted is None else inserted
    rows = []
    for now, marks, jump in zip(correction.tolist(), marker.tolist(), jumps.tolist(), strict=True):
        catches, age = age + 1 == CATCH_AGE, 0 if marks else age + 1
        caught = now - held
        busy, limited = excess != 0 or motion.moves or age < HOLD, False
        if marks:
            held, limited = _jumped(held, jump, limit)
        elif age >= HOLD:
            unlimited = now - excess
            held = min(max(unlimited, -top - 1), top)
            limited = not -top <= unlimited <= top
        excess = 0 if motion.ends else motion.excess
        after = caught if catches else 0 if motion.ends else motion.excess + motion.step
        motion.clock(catches, ramp_rate, ramp_acceleration)
        motion.excess = after
        rows.append((held, limited, busy))
    total, limits, busies = (np.array(column) for column in zip(*rows, strict=True))
    return RampResult(
        total.astype(np.int64),
        limits.astype(np.bool_),
        busies.astype(np.bool_),
        RampState(held=held, age=age, motion=motion, excess_then=excess),
    )
