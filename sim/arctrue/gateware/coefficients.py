"""Holds the coefficients of equation (9) in the number formats of the gateware."""

from __future__ import annotations

import cmath
import dataclasses
import math
import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from arctrue.gateware.capability import Capability
from arctrue.gateware.extension import MODULATORS, Conditions, LocalTable, PhaseSource
from arctrue.gateware.lane_words import (
    AMPLITUDE_LSB_COUNTS,
    AMPLITUDE_WORD_MAX,
    ORDER_MAX,
    amplitude_word,
    check_counts_per_rev,
    phase_step,
    turn_step,
)
from arctrue.gateware.mean_set import OFFSET_ONE, MeanSet
from arctrue.gateware.thermal import ThermalLanes, as_lane
from arctrue.gateware.turn_offset_sweep import least_counts, turn_offsets
from arctrue.generated.number_formats import (
    LANES_DEFAULT,
    LANES_MAX,
    PHASE_STEP_WIDTH,
    PHASE_WIDTH,
)


@dataclass(frozen=True)
class Extension:
    """The parts of a coefficient file of schema 3; a lane that is in none of the mappings has a
    constant amplitude and an integer order.

    ``modulators``: lane → one of MODULATORS. ``turn_steps``: lane → fraction of its order, u0.48
    turn per turn. ``without``: one prepared set of coefficients for each head that may fail; the
    extension of each set contains the set's mean. ``phase_sources``: lane of a real order → the
    origin of its phase; without an entry the operator states the phase.
    """

    mean: MeanSet | None = None
    conditions: Conditions | None = None
    modulators: tuple[tuple[int, str], ...] = ()
    turn_steps: tuple[tuple[int, int], ...] = ()
    local_table: LocalTable | None = None
    without: tuple[Coefficients, ...] = ()
    phase_sources: tuple[tuple[int, PhaseSource], ...] = ()

    def __post_init__(self) -> None:
        """Raise ValueError if the parts contradict each other."""
        for lane, name in self.modulators:
            if name not in MODULATORS[1:]:
                raise ValueError(
                    f"lane {lane}: modulator {name!r}, expected one of {', '.join(MODULATORS[1:])}"
                )
        for lane, step in self.turn_steps:
            if not 0 < step < 1 << PHASE_STEP_WIDTH:
                raise ValueError(f"lane {lane}: turn_step {step}, expected 1 to 2^48 - 1")
        alone = {lane for lane, _ in self.phase_sources} - {lane for lane, _ in self.turn_steps}
        if alone:
            raise ValueError(f"lane {min(alone)}: phase_from is for a lane of a real order")
        conditional = [name for _, name in self.modulators if not name.startswith("word")]
        if conditional and self.conditions is None:
            raise ValueError(f"conditions: is missing, but a lane follows {conditional[0]}")
        if self.without and self.mean is None:
            raise ValueError("without: a set for a missing head needs the mean of all heads")
        sets = (entry.extension for entry in self.without)
        if self.without and (self.turn_steps or any(one.turn_steps for one in sets if one)):
            raise ValueError(
                "without: a set for a missing head holds no turn steps, so the file cannot have "
                "such sets and a lane of a real order; leave one of the two out"
            )

    @property
    def needs(self) -> Capability:
        """Return the generics of the smallest bitstream that can load these parts."""
        sets = [entry.extension for entry in self.without if entry.extension is not None]
        return Capability(
            heads=self.mean.heads if self.mean else 2,
            mean=self.mean is not None,
            modulators=bool(self.modulators) or any(entry.modulators for entry in sets),
            real_orders=bool(self.turn_steps),
            local_table=self.local_table is not None,
            failover=bool(self.without),
        )


@dataclass(frozen=True, eq=False)
class Coefficients:
    """Holds one bank of the coefficient memory.

    ``phase_steps``: uint64 (lanes,), K in 2⁻⁴⁸ turn per count; ``phase_offsets``: uint32 (lanes,),
    Φ in 2⁻²⁴ turn; ``amplitudes``: int32 (lanes,), 2·A_n of equation (9) in 2⁻¹¹ count; ``offset``:
    in 2⁻¹¹ count, added to the sum; ``counts_per_rev``: counts per turn for which K was computed;
    ``thermal``: the lanes that follow the temperature, which the firmware updates; ``extension``:
    mean, conditions, real orders (orders that are not integers) and local table, if the gateware is
    built with them. A lane with a turn step has a real order; ``orders`` then holds the nearest
    integer.

    Raises ValueError for a word that does not fit its format.
    """

    phase_steps: NDArray[np.uint64]
    phase_offsets: NDArray[np.uint32]
    amplitudes: NDArray[np.int32]
    offset: int
    counts_per_rev: int
    thermal: ThermalLanes | None = None
    extension: Extension | None = None

    @property
    def modulator_numbers(self) -> NDArray[np.int64]:
        """Return the number of each lane's modulator: bits 18 to 16 of its word 1, (lanes,)."""
        numbers = np.zeros(self.lanes, dtype=np.int64)
        for lane, name in self.extension.modulators if self.extension else ():
            numbers[lane] = MODULATORS.index(name)
        return numbers

    @property
    def turn_steps(self) -> NDArray[np.uint64]:
        """Return the turn step ν of each lane, u0.48 turn per turn, (lanes,); 0 for integer
        orders."""
        steps = np.zeros(self.lanes, dtype=np.uint64)
        for lane, step in self.extension.turn_steps if self.extension else ():
            steps[lane] = step
        return steps

    def __post_init__(self) -> None:
        """Check every word against its format and make the arrays read-only."""
        check_counts_per_rev(self.counts_per_rev)
        for name, dtype, low, high in (
            ("phase_steps", np.uint64, 0, 2**PHASE_STEP_WIDTH - 1),
            ("phase_offsets", np.uint32, 0, 2**PHASE_WIDTH - 1),
            ("amplitudes", np.int32, -AMPLITUDE_WORD_MAX - 1, AMPLITUDE_WORD_MAX),
        ):
            words = np.asarray(getattr(self, name))
            if words.ndim != 1:
                raise ValueError(f"{name}: expected one word per lane, found shape {words.shape}")
            if words.size and words.dtype.kind not in "iu":
                raise ValueError(f"{name}: expected integer words, found {words.dtype}")
            outside = [lane for lane, word in enumerate(words.tolist()) if not low <= word <= high]
            if outside:
                raise ValueError(
                    f"{name}: lane {outside[0]} holds {words[outside[0]]}, "
                    f"the format holds {low} to {high}"
                )
            words = words.astype(dtype)
            words.flags.writeable = False
            object.__setattr__(self, name, words)
        if self.thermal is not None:
            lacking = set(self.thermal.orders) - set(self.orders.tolist())
            if lacking:
                raise ValueError(
                    f"orders {sorted(lacking)} follow the temperature, but have no lane"
                )
        sizes = {self.phase_steps.size, self.phase_offsets.size, self.amplitudes.size}
        if len(sizes) != 1:
            raise ValueError(
                f"expected one phase step, phase offset and amplitude per lane: found {sizes}"
            )
        if not 1 <= self.lanes <= LANES_MAX:
            raise ValueError(f"lanes: {self.lanes}, the gateware has 1 to {LANES_MAX}")
        self._check_extension()
        if not -AMPLITUDE_WORD_MAX - 1 <= self.offset <= AMPLITUDE_WORD_MAX:
            raise ValueError(
                f"offset: {self.offset}, the format holds "
                f"{-AMPLITUDE_WORD_MAX - 1} to {AMPLITUDE_WORD_MAX}"
            )

    def _check_extension(self) -> None:
        """Raise ValueError if the extension does not fit the lanes and counts of this bank."""
        if self.extension is None:
            return
        named = {lane for lane, _ in (*self.extension.modulators, *self.extension.turn_steps)}
        if not named <= set(range(self.lanes)):
            raise ValueError(f"extension: lane {max(named)}, there are lanes 0 to {self.lanes - 1}")
        if self.extension.turn_steps and self.counts_per_rev < least_counts(self.lanes):
            raise ValueError(
                f"counts_per_rev: {self.counts_per_rev}, with {self.lanes} lanes a real order "
                f"needs {least_counts(self.lanes)} at least; with fewer counts, the phase offset "
                "of the next turn is not ready in time"
            )
        if self.extension.local_table is not None:
            windows = self.extension.local_table.overlap(self.counts_per_rev)
            if windows is not None:
                raise ValueError(
                    f"starts_counts: the windows that begin at {windows[0]} and {windows[1]} "
                    "counts overlap or touch; expected a count or more between them, because the "
                    "correction would jump from one window's points to the other's"
                )
        if self.extension.mean:
            for head, offset in enumerate(self.extension.mean.offsets, start=1):
                if offset >= self.counts_per_rev * OFFSET_ONE:
                    raise ValueError(
                        f"offset of head {head}: {offset / OFFSET_ONE:g} counts, expected less "
                        f"than the turn's {self.counts_per_rev}"
                    )
        for entry in self.extension.without:
            mean = entry.extension.mean if entry.extension else None
            if mean is None or not mean.missing:
                raise ValueError("without: each set needs a mean that leaves out a head")
            if (entry.lanes, entry.counts_per_rev) != (self.lanes, self.counts_per_rev):
                raise ValueError("without: each set needs the file's lanes and counts_per_rev")

    def __eq__(self, other: object) -> bool:
        """Tell whether all words of both objects are equal."""
        if not isinstance(other, Coefficients):
            return NotImplemented
        return (
            self.counts_per_rev == other.counts_per_rev
            and self.offset == other.offset
            and np.array_equal(self.phase_steps, other.phase_steps)
            and np.array_equal(self.phase_offsets, other.phase_offsets)
            and np.array_equal(self.amplitudes, other.amplitudes)
            and self.thermal == other.thermal
            and self.extension == other.extension
        )

    def at(self, celsius: float) -> Coefficients:
        """Return the bank at a temperature; it is this bank if no lane follows the temperature."""
        if self.thermal is None:
            return self
        offsets, amplitudes = self.phase_offsets.copy(), self.amplitudes.copy()
        plain = self.plain_lanes
        for lane, order in enumerate(self.orders.tolist()):
            if order not in self.thermal.orders or not plain[lane]:
                continue
            written = cmath.rect(float(self.amplitudes_counts[lane]), -float(self.phases_rad[lane]))
            amplitude, phase = as_lane(written + self.thermal.change_counts(order, celsius))
            amplitudes[lane] = amplitude_word(f"amplitude of order {order}", amplitude)
            turns = phase / (2.0 * math.pi)
            offsets[lane] = round(turns % 1.0 * 2**PHASE_WIDTH) % 2**PHASE_WIDTH
        return dataclasses.replace(self, phase_offsets=offsets, amplitudes=amplitudes, thermal=None)

    @property
    def plain_lanes(self) -> NDArray[np.bool_]:
        """Return which lanes have neither a modulator nor a real order, (lanes,)."""
        return np.asarray((self.modulator_numbers == 0) & (self.turn_steps == 0))

    @property
    def lanes(self) -> int:
        """Return the number of lanes."""
        return int(self.phase_steps.size)

    @property
    def orders(self) -> NDArray[np.int64]:
        """Return the order of every lane, (lanes,), modulo counts_per_rev, because orders alias at
        whole counts."""
        return np.array(
            [
                ((2 * step * self.counts_per_rev + 2**PHASE_STEP_WIDTH) >> (PHASE_STEP_WIDTH + 1))
                % self.counts_per_rev
                for step in self.phase_steps.tolist()
            ],
            dtype=np.int64,
        )

    @property
    def real_orders(self) -> NDArray[np.float64]:
        """Return the order of every lane, (lanes,); a lane with a turn step has an order with a
        fraction."""
        fractions = self.turn_steps.astype(np.float64) / 2.0**PHASE_STEP_WIDTH
        turns = self.phase_steps.astype(np.float64) * (self.counts_per_rev / 2.0**PHASE_STEP_WIDTH)
        return np.where(fractions > 0.0, np.rint(turns - fractions) + fractions, self.orders)

    def with_real_orders(self, orders: Mapping[int, float]) -> Coefficients:
        """Return the bank with lanes of real orders (orders that are not integers); ``orders`` maps
        the number of a lane to its order.

        Amplitude and phase offset remain; the phase offset is valid in turn 0.
        """
        steps = self.phase_steps.copy()
        for lane, order in orders.items():
            steps[lane] = phase_step(order, self.counts_per_rev)
        turns = tuple(
            (lane, turn_step(order)) for lane, order in sorted(orders.items()) if turn_step(order)
        )
        extension = dataclasses.replace(self.extension or Extension(), turn_steps=turns)
        return dataclasses.replace(self, phase_steps=steps, extension=extension)

    def from_turn(self, turn: int) -> Coefficients:
        """Return the bank whose lanes have, in turn ``turn``, the phases that the lanes of this
        bank have in turn 0."""
        fractions = turn_offsets(-turn, self.turn_steps, np.zeros(self.lanes))
        offsets = (self.phase_offsets + fractions) % 2**PHASE_WIDTH
        return dataclasses.replace(self, phase_offsets=offsets.astype(np.uint32))

    @property
    def amplitudes_counts(self) -> NDArray[np.float64]:
        """Return the amplitude of every lane in counts, (lanes,)."""
        return self.amplitudes.astype(np.float64) * AMPLITUDE_LSB_COUNTS

    @property
    def phases_rad(self) -> NDArray[np.float64]:
        """Return Φ of every lane in radians, (lanes,), in [-π, π)."""
        turn = 1 << PHASE_WIDTH
        signed = (self.phase_offsets.astype(np.int64) + turn // 2) % turn - turn // 2
        return signed.astype(np.float64) * (2.0 * math.pi / turn)

    @property
    def offset_counts(self) -> float:
        """Return the offset in counts."""
        return self.offset * AMPLITUDE_LSB_COUNTS

    @classmethod
    def zero(cls, counts_per_rev: int, lanes: int = LANES_DEFAULT) -> Coefficients:
        """Return a bank that corrects nothing."""
        return cls.from_harmonics((), (), (), counts_per_rev, lanes)

    @classmethod
    def from_harmonics(
        cls,
        orders: Sequence[int] | NDArray[np.integer],
        amplitudes_counts: ArrayLike,
        phases_rad: ArrayLike,
        counts_per_rev: int,
        lanes: int = LANES_DEFAULT,
        offset_counts: float = 0.0,
    ) -> Coefficients:
        """Quantise the coefficients of ε(θ) = offset + Σ amplitude·cos(n·θ + phase), equation (9).

        ``orders``, ``amplitudes_counts`` (2·A_n) and ``phases_rad`` have one entry per harmonic, at
        most ``lanes``; the lanes without a harmonic have amplitude 0. Warns of an order of at least
        half of ``counts_per_rev``: whole counts cannot distinguish this order from a lower one.
        Raises ValueError for values that the formats cannot hold: more harmonics than lanes, an
        order outside 0…65535, an amplitude or offset of 8192 counts or more, a value that is not
        finite.
        """
        check_counts_per_rev(counts_per_rev)
        if not 1 <= lanes <= LANES_MAX:
            raise ValueError(f"lanes: {lanes}, the gateware has 1 to {LANES_MAX}")
        order_list = [_whole_order(index, order) for index, order in enumerate(orders)]
        amplitudes = np.atleast_1d(np.asarray(amplitudes_counts, dtype=np.float64))
        phases = np.atleast_1d(np.asarray(phases_rad, dtype=np.float64))
        if not amplitudes.shape == phases.shape == (len(order_list),):
            raise ValueError(
                "expected one amplitude and one phase per order: found "
                f"{len(order_list)} orders, {amplitudes.size} amplitudes, {phases.size} phases"
            )
        if len(order_list) > lanes:
            raise ValueError(
                f"{len(order_list)} harmonics do not fit into {lanes} lanes: "
                "leave out the smallest ones, or build the gateware with more lanes"
            )
        for order, amplitude, phase in zip(order_list, amplitudes, phases, strict=True):
            amplitude_word(f"amplitude of order {order}", float(amplitude))
            if not math.isfinite(phase):
                raise ValueError(f"phase of order {order}: {phase} is not a finite number")
            if 2 * order >= counts_per_rev:
                warnings.warn(
                    f"order {order} is at or above half of the {counts_per_rev} counts a turn: "
                    "whole counts cannot distinguish it from a lower order",
                    stacklevel=2,
                )
        used = len(order_list)
        phase_steps = np.zeros(lanes, dtype=np.uint64)
        phase_offsets = np.zeros(lanes, dtype=np.uint32)
        words = np.zeros(lanes, dtype=np.int32)
        phase_steps[:used] = [phase_step(order, counts_per_rev) for order in order_list]
        turns = np.remainder(phases / (2.0 * math.pi), 1.0)
        phase_offsets[:used] = np.rint(turns * 2**PHASE_WIDTH).astype(np.int64) % 2**PHASE_WIDTH
        words[:used] = np.rint(amplitudes / AMPLITUDE_LSB_COUNTS)
        return cls(
            phase_steps,
            phase_offsets,
            words,
            amplitude_word("offset", offset_counts),
            counts_per_rev,
        )

    def error_counts(self, angle_counts: ArrayLike) -> NDArray[np.float64]:
        """Compute ε in counts by equation (9) in double precision, from the quantised coefficients.

        ``angle_counts`` are whole counts of any shape; for a lane with a real order they are
        counted over all turns, with 0 at the start of turn 0. The result has the same shape.
        """
        angle = np.asarray(angle_counts, dtype=np.int64)
        error = np.full(angle.shape, self.offset_counts)
        for order, step, amplitude, phase in zip(
            self.orders.tolist(),
            self.turn_steps.tolist(),
            self.amplitudes_counts,
            self.phases_rad,
            strict=True,
        ):
            # order · angle is still an exact whole number here, so that its reduction to one turn
            # is exact.
            turn_counts: NDArray[Any] = order * angle % self.counts_per_rev
            if step:
                whole = _whole_part(order, step)
                beyond = step / 2.0**PHASE_STEP_WIDTH
                turn_counts = whole * angle % self.counts_per_rev + beyond * angle
            error += amplitude * np.cos(2.0 * math.pi * turn_counts / self.counts_per_rev + phase)
        return error


def _whole_part(nearest: int, step: int) -> int:
    """Return the largest whole number that does not exceed a real order, from the whole number
    nearest to the order and the turn step."""
    return nearest - (step >= 1 << (PHASE_STEP_WIDTH - 1))


def _whole_order(index: int, order: object) -> int:
    value = float(order)  # type: ignore[arg-type]
    if not value.is_integer() or not 0 <= value <= ORDER_MAX:
        raise ValueError(f"orders[{index}]: {order}, expected a whole number 0 to {ORDER_MAX}")
    return int(value)
