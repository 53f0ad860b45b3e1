"""Holds the coefficients of equation (9) in the number formats of the gateware."""

from __future__ import annotations

import cmath
import dataclasses
import math
import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from arctrue.gateware.extension import MODULATORS, WIDTH_ONE, Extension, PhaseSource
from arctrue.gateware.mean_set import OFFSET_ONE
from arctrue.gateware.table_conditions import nominal_speed_word
from arctrue.gateware.thermal import ThermalLanes, as_lane
from arctrue.gateware.turn_offset_sweep import least_counts, turn_offsets
from arctrue.generated.number_formats import (
    AMPLITUDE_FRACTION,
    AMPLITUDE_WIDTH,
    CLOCK_HZ,
    COUNTS_PER_PERIOD,
    COUNTS_PER_REV_MAX,
    COUNTS_PER_REV_MIN,
    LANES_DEFAULT,
    LANES_MAX,
    ORDER_WIDTH,
    PHASE_STEP_WIDTH,
    PHASE_WIDTH,
    SPEED_FEEDBACK_EIGHTHS,
    SPEED_WINDOW_BITS,
    STEEPEST_PERCENT,
)

ORDER_MAX = (1 << ORDER_WIDTH) - 1
AMPLITUDE_LSB_COUNTS = 1.0 / (1 << AMPLITUDE_FRACTION)
AMPLITUDE_WORD_MAX = (1 << (AMPLITUDE_WIDTH - 1)) - 1
SIDE_MOST = 8
"""Largest magnitude of the side that is tried for a lane whose phase comes from an index of the
drive; :class:`PhaseSource` defines the side, a whole number."""
SIDE_TOLERANCE = 0.005
"""Largest distance, in periods per turn, between a fitted order minus its side and a multiple of
the number of the drive's indices in a turn. It is five times the standard uncertainty of an order
that is fitted to one turn of a reference."""
RANGE_STEPS = 32
"""Number of steps into which a temperature range is divided to compute bounds; the firmware uses
the same number."""
STEEPEST = STEEPEST_PERCENT / 100
"""Limit of |dε/dR| of all parts together. The corrected angle R − ε(R) moves in the direction of
the reading R if |dε/dR| < 1. The gateware calculates ε and the direction from R itself
(``stop_operator``), not from the corrected angle, so that no feedback lowers this limit."""
STEEPEST_REVERSAL = 0.5
"""Limit of the slope of the lanes with the modulator direction after a reversal, as in the
firmware: at least half of STEEPEST remains for the other parts, also of a later calibration."""
MOST_SPEED_FEEDBACK = SPEED_FEEDBACK_EIGHTHS / 8
"""Limit of :meth:`Coefficients.speed_feedback`: below 1/2, the measured speed settles whatever the
phases of the lanes (derivation in the header of ``table_speed.vhd``)."""
AMPLITUDE_LIMIT_COUNTS = float(1 << (AMPLITUDE_WIDTH - 1 - AMPLITUDE_FRACTION))


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
                raise ValueError(f"{name}: expected one word a lane, found shape {words.shape}")
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
            raise ValueError(f"a phase step, phase offset and amplitude a lane: found {sizes}")
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
                f"needs {least_counts(self.lanes)} at least: with fewer the next turn's phase "
                "offset is not ready in time"
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
                raise ValueError("without: each set has the lanes and counts a turn of the file")

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
            amplitudes[lane] = _amplitude_word(f"amplitude of order {order}", amplitude)
            turns = phase / (2.0 * math.pi)
            offsets[lane] = round(turns % 1.0 * 2**PHASE_WIDTH) % 2**PHASE_WIDTH
        return dataclasses.replace(self, phase_offsets=offsets, amplitudes=amplitudes, thermal=None)

    def extent(self) -> tuple[float, float]:
        """Return bounds of |dε/dR| and of a lane's largest amplitude in counts, valid at any
        temperature.

        Each bound is the largest value at RANGE_STEPS + 1 temperatures of ``thermal``, plus the
        largest excess of a lane over the chord between two of these temperatures, c₂h²/4, where h
        is their distance. Phases are ignored: Σ n·|c_n| bounds the sum of all lanes anywhere in the
        turn, whatever the modulators are, because they are at most 1. Lanes with the modulator
        direction also change after a reversal. A set for a missing head can replace the lanes; the
        slope of a local table adds to that of either.
        """
        thermal, orders = self.thermal, self.real_orders
        written = self.amplitudes_counts * np.exp(-1j * self.phases_rad)
        sizes: NDArray[np.float64]
        if thermal is None:
            sizes, bow = np.abs(written)[np.newaxis], np.zeros(self.lanes)
        else:
            celsius = np.linspace(thermal.least_c, thermal.most_c, RANGE_STEPS + 1)
            gains = [
                [thermal.change_counts(order, at) for order in self.orders.tolist()]
                for at in celsius.tolist()
            ]
            sizes = np.abs(written + np.array(gains) * self.plain_lanes)
            step = (thermal.most_c - thermal.least_c) / RANGE_STEPS
            bow = np.array([thermal.curve_counts(order) for order in self.orders.tolist()])
            bow *= step**2 / 4.0 * self.plain_lanes
        largest = float((sizes + bow).max())
        slope = float((sizes @ orders).max() + bow @ orders)
        slope *= 2.0 * math.pi / self.counts_per_rev
        slope += self.reversal_slope()
        if self.extension is not None:
            for extent in (one.extent() for one in self.extension.without):
                slope, largest = max(slope, extent[0]), max(largest, extent[1])
            if self.extension.local_table is not None:
                slope += self.extension.local_table.steepest(self.counts_per_rev)
        return slope, largest

    def speed_feedback(self, clock_hz: float = CLOCK_HZ) -> float:
        """Return the change of the corrected angle, over the change of the travel in a window, that
        the lanes of the speed make when the measured speed changes, whatever their phases.

        ``table_speed`` measures ω in the corrected angle, so that
        ωₙ = ω + g·(ωₙ₋₁ − ωₙ₋₂) with |g| up to this value. A window lasts 2¹⁴ clocks or a period
        of A and B; the square of the ratio changes by up to twice the change of the ratio.
        """
        if self.extension is None or self.extension.conditions is None:
            return 0.0
        weights = {"speed": 1.0, "speed_squared": 2.0}
        sizes = np.abs(self.amplitudes_counts)
        counts = sum(
            weights.get(name, 0.0) * float(sizes[lane]) for lane, name in self.extension.modulators
        )
        nominal = nominal_speed_word(
            self.extension.conditions.nominal_deg_per_s, self.counts_per_rev, clock_hz
        )
        return counts / max(nominal / 2.0 ** (32 - SPEED_WINDOW_BITS), float(COUNTS_PER_PERIOD))

    def reversal_slope(self) -> float:
        """Return a bound of |dε/dR| of the change of the direction after a reversal: Σ|A|/W over
        the lanes with the modulator direction."""
        extension = self.extension
        if extension is None or extension.conditions is None:
            return 0.0
        named = [lane for lane, name in extension.modulators if name == "direction"]
        width_counts = extension.conditions.width / WIDTH_ONE
        return float(np.abs(self.amplitudes_counts[named]).sum()) / width_counts

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

    def with_phase_from_heads(self) -> Coefficients:
        """Return the bank in which the device determines the phase of each lane of a real order
        from the heads."""
        return self._with_phase_sources(
            {lane: PhaseSource("heads") for lane in np.flatnonzero(self.turn_steps).tolist()}
        )

    def with_phase_from_probe(self, edge_turns: float, edges_per_turn: float) -> Coefficients:
        """Return the bank in which the device determines the phase of each lane of a real order
        from an index of the drive.

        ``edge_turns``: angle of the table at an index, in turns from the start of turn 0;
        ``edges_per_turn``: number of indices in a turn of the table. A harmonic has the same phase
        at every index if its order minus an integer, its side, is a multiple of ``edges_per_turn``.
        Raises ValueError for a harmonic without such a side.
        """
        sources = {}
        for lane in np.flatnonzero(self.turn_steps).tolist():
            order = float(self.real_orders[lane])
            side = _side_of(order, edges_per_turn)
            turns = self.phases_rad[lane] / (2.0 * np.pi) + (order - side) * edge_turns
            phase = round((turns % 1.0) * 2**PHASE_WIDTH) % 2**PHASE_WIDTH
            sources[lane] = PhaseSource("probe", side, phase)
        return self._with_phase_sources(sources)

    def _with_phase_sources(self, sources: Mapping[int, PhaseSource]) -> Coefficients:
        extension = dataclasses.replace(
            self.extension or Extension(), phase_sources=tuple(sorted(sources.items()))
        )
        return dataclasses.replace(self, extension=extension)

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
                "one amplitude and one phase an order: found "
                f"{len(order_list)} orders, {amplitudes.size} amplitudes, {phases.size} phases"
            )
        if len(order_list) > lanes:
            raise ValueError(
                f"{len(order_list)} harmonics do not fit into {lanes} lanes: "
                "leave out the smallest ones, or build the gateware with more lanes"
            )
        for order, amplitude, phase in zip(order_list, amplitudes, phases, strict=True):
            _amplitude_word(f"amplitude of order {order}", float(amplitude))
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
            _amplitude_word("offset", offset_counts),
            counts_per_rev,
        )

    def error_counts(self, angle_counts: ArrayLike) -> NDArray[np.float64]:
        """Compute ε in counts by equation (9) in double precision, from the quantised coefficients.

        ``angle_counts`` are whole counts of any shape; for a lane with a real order they are
        counted over all turns, with 0 at the start of turn 0. The result has the same shape.
        """
        angle = np.asarray(angle_counts, dtype=np.int64)
        error = np.full(angle.shape, self.offset_counts)
        for order, turn_step, amplitude, phase in zip(
            self.orders.tolist(),
            self.turn_steps.tolist(),
            self.amplitudes_counts,
            self.phases_rad,
            strict=True,
        ):
            # order · angle is still an exact whole number here, so that its reduction to one turn
            # is exact.
            turn_counts: NDArray[Any] = order * angle % self.counts_per_rev
            if turn_step:
                whole = _whole_part(order, turn_step)
                beyond = turn_step / 2.0**PHASE_STEP_WIDTH
                turn_counts = whole * angle % self.counts_per_rev + beyond * angle
            error += amplitude * np.cos(2.0 * math.pi * turn_counts / self.counts_per_rev + phase)
        return error


def check_counts_per_rev(counts_per_rev: int) -> None:
    """Raise ValueError unless the gateware supports this number of counts per turn."""
    if not COUNTS_PER_REV_MIN <= counts_per_rev <= COUNTS_PER_REV_MAX:
        raise ValueError(
            f"counts_per_rev: {counts_per_rev}, the gateware counts "
            f"{COUNTS_PER_REV_MIN} to {COUNTS_PER_REV_MAX} counts a turn"
        )


def phase_step(order: float, counts_per_rev: int) -> int:
    """Return K = round(n·2⁴⁸ / counts_per_rev) mod 2⁴⁸, in 2⁻⁴⁸ turn per count."""
    exact = Fraction(order) * (1 << (PHASE_STEP_WIDTH + 1))
    rounded = (exact + counts_per_rev) // (2 * counts_per_rev)
    return int(rounded) % (1 << PHASE_STEP_WIDTH)


def turn_step(order: float) -> int:
    """Return ν = round(n·2⁴⁸) mod 2⁴⁸, in 2⁻⁴⁸ turn per turn."""
    return round(Fraction(order) * (1 << PHASE_STEP_WIDTH)) % (1 << PHASE_STEP_WIDTH)


def _whole_part(nearest: int, turn_step: int) -> int:
    """Return the largest whole number that does not exceed a real order, from the whole number
    nearest to the order."""
    return nearest - (turn_step >= 1 << (PHASE_STEP_WIDTH - 1))


def _side_of(order: float, edges_per_turn: float) -> int:
    """Return the s of smallest size for which order - s is a multiple of ``edges_per_turn``.

    Raises ValueError if no s with |s| up to SIDE_MOST gives a multiple.
    """
    if not edges_per_turn > 0.0:
        raise ValueError(f"edges in a turn: {edges_per_turn:g}, expected more than 0")
    for side in sorted(range(-SIDE_MOST, SIDE_MOST + 1), key=abs):
        multiple = (order - side) / edges_per_turn
        if abs(multiple - round(multiple)) * edges_per_turn <= SIDE_TOLERANCE:
            return side
    raise ValueError(
        f"order {order:.7g}: neither it nor one of its sides up to {SIDE_MOST} is a multiple of "
        f"{edges_per_turn:.7g} edges in a turn, so that its phase differs from edge to edge"
    )


def _whole_order(index: int, order: object) -> int:
    value = float(order)  # type: ignore[arg-type]
    if not value.is_integer() or not 0 <= value <= ORDER_MAX:
        raise ValueError(f"orders[{index}]: {order}, expected a whole number 0 to {ORDER_MAX}")
    return int(value)


def _amplitude_word(name: str, value_counts: float) -> int:
    if not math.isfinite(value_counts):
        raise ValueError(f"{name}: {value_counts} is not a finite number")
    word = round(value_counts / AMPLITUDE_LSB_COUNTS)
    if abs(word) > AMPLITUDE_WORD_MAX:
        raise ValueError(
            f"{name}: {value_counts:g} counts, the gateware holds less than "
            f"{AMPLITUDE_LIMIT_COUNTS:g} counts; is it really an error of the table?"
        )
    return word
