"""Tests lanes that follow direction or speed, from a moving table's pins to the output's edges."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator

import numpy as np
import pytest
from numpy.typing import NDArray
from sim.tests.instrument.sizes import DEPTH, EXTENSIONS, LANES

from arctrue.gateware.coefficient_bounds import MOST_SPEED_FEEDBACK, speed_feedback
from arctrue.gateware.coefficients import Coefficients, Extension
from arctrue.gateware.extension import Conditions
from arctrue.gateware.table_conditions import MODULATOR_ONE
from arctrue.generated.number_formats import AMPLITUDE_SWEEP_CLOCKS
from arctrue.instrument import BusError, Instrument

COUNTS = 1 << 18
KNOT = 8
WINDOW = 0x2100


class Script:
    """A table that moves at given speeds for given times; its reading is late or has a reversal
    error."""

    index_width_counts = 1
    rounding_counts = 0.0

    def __init__(
        self,
        legs: list[tuple[int, float]],
        *,
        late_clocks: int = 0,
        half_reversal: float = 0.0,
        width: float = 1.0,
        counts_per_rev: int = COUNTS,
    ) -> None:
        """Compute the motion; ``legs`` are pairs of (clocks, counts per clock). ``half_reversal``
        and ``width``, half of the travel that a reversal takes, are in counts."""
        self.counts_per_rev = counts_per_rev
        speed = np.concatenate([np.full(clocks // KNOT, pace) for clocks, pace in legs])
        self.clocks = speed.size * KNOT
        self.place = np.concatenate([[0.0], np.cumsum(speed * KNOT)]) - 3000.5
        late = np.clip(np.arange(self.place.size) - late_clocks / KNOT, 0.0, self.place.size - 1.0)
        reading = np.interp(late, np.arange(self.place.size), self.place)
        wound, winding = -1.0, np.empty(self.place.size)
        for knot, step in enumerate(np.diff(self.place, prepend=self.place[0])):
            wound = min(max(wound + step / width, -1.0), 1.0)
            winding[knot] = wound
        self.reading = reading + half_reversal * winding

    def piece(self, first_clock: int, clocks: int) -> tuple[int, *tuple[NDArray[np.float64], ...]]:  # type: ignore[override]
        """Return a piece of the curve in the form of :class:`Curves`."""
        intervals = max(1, min(clocks, self.clocks - first_clock) // KNOT)
        at = np.clip(first_clock // KNOT + np.arange(-1, intervals + 2), 0, self.place.size - 1)
        turn = 2.0 * np.pi / self.counts_per_rev
        return KNOT, self.reading[at], self.reading[at], self.place[at] * turn


@pytest.fixture(scope="module")
def modulated() -> Iterator[Instrument]:
    with Instrument(LANES, DEPTH, generics=EXTENSIONS) as instrument:
        yield instrument


FULL_LANES = 32
"""Number of lanes of the paper's core."""


@pytest.fixture(scope="module")
def of_32_lanes() -> Iterator[Instrument]:
    with Instrument(FULL_LANES, DEPTH, generics={"MODULATORS": "true"}) as instrument:
        yield instrument


def order_0(
    counts: float, modulator: str | None, counts_per_rev: int = COUNTS, lanes: int = LANES
) -> Coefficients:
    """Return coefficients with one lane of order 0, which follows the condition ``modulator``;
    None: it is constant. With FULL_LANES it is the second-last lane; pairs of lanes of order 7,
    which cancel each other, fill all lanes before it, and the last lane is empty."""
    others = FULL_LANES - 2 if lanes == FULL_LANES else 0
    phase = 0.0 if counts > 0 else np.pi
    bank = Coefficients.from_harmonics(
        [7] * others + [0],
        [100.0] * others + [abs(counts)],
        [0.4, 0.4 + np.pi] * (others // 2) + [phase],
        counts_per_rev,
        lanes,
    )
    if modulator is None:
        return bank
    extension = Extension(conditions=Conditions(1, 0, 90.0), modulators=((others, modulator),))
    return dataclasses.replace(bank, extension=extension)


def run(
    instrument: Instrument, script: Script, bank: Coefficients, **words: int
) -> tuple[NDArray[np.int64], NDArray[np.float64], float]:
    """Return the clock of every output edge, its error in counts, and the latency in clocks. The
    error refers to the true angle at the edge's time minus the latency."""
    instrument.attach_curves(script)  # type: ignore[arg-type]
    instrument.reset()
    instrument.write("counts_per_rev", script.counts_per_rev)
    instrument.command("rearm")
    for name, value in (
        ("ramp_rate", 0xFFFF_FFFF),
        ("ramp_acceleration", 0),
        ("output_spacing", 1),
    ):
        instrument.write(name, value)
    instrument.write("conditions.slew", 1 << 26)
    for name, value in words.items():
        instrument.write(f"conditions.{name}", value)
    instrument.write_coefficients(bank)
    instrument.command("swap")
    instrument.update("control", compensate=1, output_enable=1)
    instrument.record(every=1)
    instrument.run_until(end_of_stimulus=True)
    seen = instrument.recording().output
    error = seen.position - seen.true_angle_rad * script.counts_per_rev / (2.0 * np.pi)
    instrument.detach()
    return seen.clock, error, instrument.latency_clocks


LATE = 120
"""Delay of the reading in clocks: 36 counts at the first speed."""
PACES = (0.3, 0.15)


def speed_errors(instrument: Instrument, modulator: str | None) -> list[float]:
    """Return the mean error of the output in counts against the present angle, for each speed in
    PACES."""
    legs = [(120_000, PACES[0]), (200_000, PACES[1])]
    script = Script(legs, late_clocks=LATE)
    age = LATE + instrument.latency_clocks
    nominal = 0.5
    start = instrument.clock
    clock, error, latency = run(
        instrument,
        script,
        order_0(-age * nominal, modulator),
        nominal_speed=round(nominal * 2**32),
    )
    found = []
    for first, last, pace in ((80e3, 119e3, PACES[0]), (200e3, 319e3, PACES[1])):
        chosen = (clock - start > first) & (clock - start < last)
        # ``error`` compares an edge with the true angle one latency earlier; in this time the angle
        # has grown by pace · latency.
        found.append(float(np.mean(error[chosen])) - pace * latency)
    return found


def test_latency_is_taken_away_at_two_speeds(modulated: Instrument) -> None:
    """A lane of order 0 that follows the speed removes the delay of reading and pipeline; a
    constant lane does not.

    The bound is half a count for the rounding of the reading, and half a count for that of the
    output.
    """
    first, second = speed_errors(modulated, "speed")
    # The zero of the output is the index, which is the same for both speeds.
    assert abs(first - second) <= 1.0
    read = modulated.read("conditions.speed") / MODULATOR_ONE
    assert read == pytest.approx(PACES[1] / 0.5, abs=2e-4)
    squared = modulated.read("conditions.speed_squared") / MODULATOR_ONE
    assert squared == pytest.approx((PACES[1] / 0.5) ** 2, abs=2e-4)
    without = speed_errors(modulated, None)
    age = LATE + modulated.latency_clocks
    assert abs(without[0] - without[1]) == pytest.approx(age * (PACES[0] - PACES[1]), abs=1.0)


FULL_COUNTS = 1 << 24
FULL_PACE = 30.0 / 360.0 * FULL_COUNTS / 100e6
"""Speed of 30°/s in counts per clock."""
FULL_LATE = 2000
"""Delay of 20 µs in clocks: 28 counts at 30°/s."""
CHANGE_CLOCKS = 200_000
LAG_CLOCKS = 1.5 * (1 << 14)
"""Largest lag of the measured speed in clocks (header of table_speed)."""


def changing_errors(
    instrument: Instrument, modulator: str | None, lanes: int = LANES
) -> NDArray[np.float64]:
    """Return the error of every edge in counts, while the speed falls to one half and rises again.

    The zero is the mean error at the first speed, because the reading was late at the index, too.
    """
    half = 0.5 * FULL_PACE
    down = np.linspace(FULL_PACE, half, CHANGE_CLOCKS // KNOT)
    legs = [(400_000, FULL_PACE), *[(KNOT, pace) for pace in down.tolist()]]
    legs += [(150_000, half), *[(KNOT, pace) for pace in down[::-1].tolist()]]
    legs += [(100_000, FULL_PACE)]
    nominal = 1.1 * FULL_PACE
    start = instrument.clock
    clock, error, _ = run(
        instrument,
        Script(legs, late_clocks=FULL_LATE, counts_per_rev=FULL_COUNTS),
        order_0(-FULL_LATE * nominal, modulator, FULL_COUNTS, lanes),
        nominal_speed=round(nominal * 2**32),
    )
    at = clock - start
    return np.asarray(error[at > 300_000] - error[(at > 300_000) & (at < 390_000)].mean())


def check_changing_speed(instrument: Instrument, lanes: int) -> None:
    """At 2²⁴ counts per turn and changing speed, the lane leaves at most two counts plus τ·a·lag
    (delay, acceleration, lag of the measured speed); a constant lane leaves the whole change."""
    slowing = 0.5 * FULL_PACE / CHANGE_CLOCKS
    error = changing_errors(instrument, "speed", lanes)
    assert np.abs(error).max() <= 2.0 + FULL_LATE * slowing * LAG_CLOCKS
    # At the end the speed is constant again, so that at most two counts remain.
    assert np.abs(error[-500:]).max() <= 2.0
    without = changing_errors(instrument, None, lanes)
    assert np.abs(without).max() == pytest.approx(0.5 * FULL_LATE * FULL_PACE, abs=1.5)


@pytest.mark.large
def test_latency_at_the_papers_scale_while_the_speed_changes(modulated: Instrument) -> None:
    check_changing_speed(modulated, LANES)


@pytest.mark.large
def test_latency_with_32_lanes_while_the_speed_changes(of_32_lanes: Instrument) -> None:
    check_changing_speed(of_32_lanes, FULL_LANES)


WINDOW_CLOCKS = 1 << 14
RINGING_COUNTS = 3.0
"""Bound of the error from peak to peak: one count each for the roundings of reading and output, and
twice the half count to which the step's error has fallen."""


@pytest.mark.parametrize(
    ("delay_us", "windows"),
    [
        pytest.param(20.0, 12, marks=pytest.mark.large),
        pytest.param(61.4, 12, marks=pytest.mark.large),
        pytest.param(-61.4, 26, marks=pytest.mark.large),
        pytest.param(100.0, 12, marks=pytest.mark.large),
        pytest.param(-85.0, 26, marks=pytest.mark.large),
    ],
)
def test_the_measured_speed_settles_after_a_step(
    modulated: Instrument, delay_us: float, windows: int
) -> None:
    """Up to the limit of the feedback, the output has settled ``windows`` windows after the speed
    has halved. With a delay beyond the limit, which every loader refuses, the output still rings or
    has stopped.

    Two windows are the lag. The error is first τ·Δω = 43 counts (61 µs). Each further window
    multiplies it by at most 0.61, or by 0.83 for a reading that is early
    (``SPEED_FEEDBACK_EIGHTHS``), until it is below half a count.
    """
    late, step = round(100 * delay_us), 400_000
    nominal = 1.5 * FULL_PACE
    bank = order_0(-late * nominal, "speed", FULL_COUNTS)
    conditions = Conditions(1, 0, nominal * 100e6 * 360.0 / FULL_COUNTS)
    assert bank.extension is not None
    held = dataclasses.replace(
        bank, extension=dataclasses.replace(bank.extension, conditions=conditions)
    )
    assert speed_feedback(held) == pytest.approx(abs(late) / WINDOW_CLOCKS, rel=1e-4)
    start = modulated.clock
    clock, error, _ = run(
        modulated,
        Script(
            [(step, FULL_PACE), ((windows + 12) * WINDOW_CLOCKS, 0.5 * FULL_PACE)],
            late_clocks=late,
            counts_per_rev=FULL_COUNTS,
        ),
        bank,
        nominal_speed=round(nominal * 2**32),
    )
    left = error[clock - start > step + windows * WINDOW_CLOCKS]
    # A measured speed that diverges stops the output.
    has_settled = left.size > 0 and float(np.ptp(left)) <= RINGING_COUNTS
    is_accepted = speed_feedback(held) <= MOST_SPEED_FEEDBACK
    assert is_accepted == (abs(delay_us) < 61.5)
    assert has_settled == is_accepted


@pytest.mark.large
def test_a_swap_to_another_nominal_speed_makes_no_jump(modulated: Instrument) -> None:
    """A set with the same delay and another nominal speed replaces the present set while the table
    turns; the output does not move.

    The bound is half a count each for the roundings of reading and output before and after the
    swap. The new words become active together with the new lanes; until the swap the ratio of the
    speeds keeps its old value.
    """
    script = Script([(900_000, FULL_PACE)], late_clocks=FULL_LATE, counts_per_rev=FULL_COUNTS)
    modulated.attach_curves(script)  # type: ignore[arg-type]
    modulated.reset()
    start = modulated.clock
    modulated.write("counts_per_rev", FULL_COUNTS)
    modulated.command("rearm")
    modulated.write("output_spacing", 1)
    modulated.update("control", compensate=1, output_enable=1)
    modulated.record(every=1)
    for swaps, (nominal, until) in enumerate(((1.5, 500e3), (3.0, 700e3), (1.1, 880e3))):
        modulated.write_coefficients(
            order_0(-FULL_LATE * nominal * FULL_PACE, "speed", FULL_COUNTS)
        )
        before = modulated.read("conditions.speed")
        modulated.write("conditions.nominal_speed", round(nominal * FULL_PACE * 2**32))
        modulated.run(40_000)
        if swaps:
            now = modulated.read("conditions.speed")
            assert abs(now - before) <= before / (1 << 14) + 2.0
        modulated.command("swap")
        modulated.run(2000)
        if swaps:
            ratio = modulated.read("conditions.speed") / MODULATOR_ONE
            assert ratio == pytest.approx(1.0 / nominal, abs=2e-4)
        modulated.run(start + round(until) - modulated.clock)
    modulated.run_until(end_of_stimulus=True)
    seen = modulated.recording().output
    modulated.detach()
    error = seen.position - seen.true_angle_rad * FULL_COUNTS / (2.0 * np.pi)
    settled = seen.clock - start > 400_000
    assert np.ptp(error[settled]) <= 2.0


FULL_HALF_REVERSAL = 1.0 / 1_296_000 * FULL_COUNTS
"""Half of the reversal error in counts: 1″ to each side."""
FULL_WIDTH = 5000.0


def check_reversals(instrument: Instrument, modulator: str | None, lanes: int) -> None:
    """At 2²⁴ counts per turn and with the lane, the errors of settled edges in both directions
    differ by at most a twentieth of the reversal error of 2″."""
    pace = 0.25
    legs = [(90_000, pace)]
    for way in (-14_000.0, 13_000.0, -12_000.0):
        legs += [(round(abs(way) / pace), pace * float(np.sign(way))), (4000, 0.0)]
    script = Script(
        legs, half_reversal=FULL_HALF_REVERSAL, width=FULL_WIDTH, counts_per_rev=FULL_COUNTS
    )
    start = instrument.clock
    clock, error, _ = run(
        instrument,
        script,
        order_0(FULL_HALF_REVERSAL, modulator, FULL_COUNTS, lanes),
        width=round(16 * FULL_WIDTH),
        dead_zone=2,
    )
    knot = np.clip((clock - start) // KNOT, 0, script.place.size - 2)
    step = np.diff(script.place)[knot]
    # An edge is settled if the table has travelled more than twice FULL_WIDTH in one direction
    # before it.
    travel = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(script.place)))])
    before = np.searchsorted(travel, travel[knot] - 2.1 * FULL_WIDTH)
    moved = np.abs(script.place[knot] - script.place[before])
    settled = (clock - start > 70_000) & (step != 0.0) & (moved > 2.1 * FULL_WIDTH - 1.0)
    up = error[settled & (step > 0)].mean()
    down = error[settled & (step < 0)].mean()
    if modulator is None:
        assert abs(up - down) == pytest.approx(2.0 * FULL_HALF_REVERSAL, abs=1.0)
    else:
        assert abs(up - down) <= 2.0 * FULL_HALF_REVERSAL / 20.0
        # The bound also holds during the reversals, as in the test with fewer counts.
        slope = FULL_HALF_REVERSAL / FULL_WIDTH
        bound = 1.0 + slope * (2.0 + 1.0 + pace * (2 * AMPLITUDE_SWEEP_CLOCKS + 20))
        assert np.ptp(error[clock - start > 70_000]) / 2.0 <= bound


@pytest.mark.parametrize("modulator", ["direction", None])
def test_reversal_error_at_the_papers_scale(modulated: Instrument, modulator: str | None) -> None:
    check_reversals(modulated, modulator, LANES)


@pytest.mark.large
@pytest.mark.parametrize("modulator", ["direction", None])
def test_reversal_error_with_32_lanes(of_32_lanes: Instrument, modulator: str | None) -> None:
    check_reversals(of_32_lanes, modulator, FULL_LANES)


HALF_REVERSAL = 26.0
WIDTH = 700.0


def reversal_errors(instrument: Instrument, modulator: str | None) -> NDArray[np.float64]:
    """Return the error in counts of every edge after the clock from which the direction is known,
    also of edges during reversals."""
    pace = 0.1
    legs = [(90_000, pace)]
    for way in (-4000.0, 900.0, -500.0, 3000.0):
        legs += [(round(abs(way) / pace), pace * float(np.sign(way))), (2000, 0.0)]
    script = Script(legs, half_reversal=HALF_REVERSAL, width=WIDTH)
    start = instrument.clock
    clock, error, _ = run(
        instrument,
        script,
        order_0(HALF_REVERSAL, modulator),
        width=round(16 * WIDTH),
        dead_zone=2,
    )
    return error[clock - start > 70_000]


def test_reversal_error_is_taken_away(modulated: Instrument) -> None:
    """The lane that follows the direction removes the reversal error, also during reversals; a
    constant lane removes nothing.

    The bound is one count for roundings, plus the change of the reversal error during the delay of
    the correction. The slope of this error is HALF_REVERSAL / WIDTH. The delay in counts is the sum
    of the dead zone (2), a step of one count (1), and the travel at 0.1 count per clock during
    two sweeps and a division of 20 clocks.
    """
    slope = HALF_REVERSAL / WIDTH
    bound = 1.0 + slope * (2.0 + 1.0 + 0.1 * (2 * AMPLITUDE_SWEEP_CLOCKS + 20))
    error = reversal_errors(modulated, "direction")
    assert np.ptp(error) / 2.0 <= bound
    without = reversal_errors(modulated, None)
    assert np.ptp(without) / 2.0 == pytest.approx(HALF_REVERSAL, abs=1.0)


def test_the_direction_stands_while_the_table_trembles(modulated: Instrument) -> None:
    """The direction does not change while the table moves back and forth within the dead zone."""
    legs = [(90_000, 0.1), *[(40, 0.05), (40, -0.05)] * 100, (3000, 0.0)]
    run(
        modulated,
        Script(legs, half_reversal=HALF_REVERSAL, width=WIDTH),
        order_0(HALF_REVERSAL, "direction"),
        width=round(16 * WIDTH),
        dead_zone=4,
    )
    assert modulated.read("conditions.direction.known") == 1
    assert modulated.read("conditions.direction.value") == MODULATOR_ONE


def test_the_console_moves_what_follows_a_word(modulated: Instrument) -> None:
    """The console changes the word of a lane of 20 counts from 0.5 to -0.25; the output then moves
    by 15 counts at the slew rate, without a step.

    The bound is half a count each for the roundings of reading and output.
    """
    pace, size = 0.1, 20.0
    modulated.attach_curves(Script([(200_000, pace)]))  # type: ignore[arg-type]
    modulated.reset()
    modulated.firmware.start()
    for name, value in (
        ("counts_per_rev", COUNTS),
        ("ramp_rate", 0xFFFF_FFFF),
        ("ramp_acceleration", 0),
        ("output_spacing", 1),
        ("conditions.slew", 1 << 24),
    ):
        modulated.write(name, value)
    modulated.command("rearm")
    modulated.write_coefficients(order_0(size, "word_a"))
    modulated.command("swap")
    modulated.update("control", compensate=1, output_enable=1)
    start = modulated.clock
    modulated.record(every=1)
    assert modulated.firmware.send("word a 0.5") == "ok"
    modulated.run(120_000)
    assert modulated.read("conditions.word_a") == MODULATOR_ONE // 2
    assert modulated.firmware.send("word a -0.25") == "ok"
    modulated.run_until(end_of_stimulus=True)
    seen = modulated.recording().output
    modulated.detach()
    error = seen.position - seen.true_angle_rad * COUNTS / (2.0 * np.pi)
    clock = seen.clock - start
    before = float(np.mean(error[(clock > 90_000) & (clock < 119_000)]))
    after = float(np.mean(error[clock > 175_000]))
    assert after - before == pytest.approx(0.75 * size, abs=1.0)
    late = clock > 90_000
    assert np.abs(np.diff(seen.position[late])).max() == 1


def test_every_word_of_the_window(modulated: Instrument) -> None:
    """Words 0 to 5 of the window can be written, words 6 to 8 only read; the core refuses all other
    words. The words of a lane are read back."""
    assert modulated.read("capability.modulators") == 1
    for word in range(16):
        for is_write in (False, True):
            try:
                if is_write:
                    modulated.write_words(WINDOW + 4 * word, [0])
                else:
                    modulated.read_words(WINDOW + 4 * word, 1)
                accepted = True
            except BusError:
                accepted = False
            assert accepted == (word < 6 or (word < 9 and not is_write)), (word, is_write)
    modulated.write_coefficients(order_0(5.0, "word_a"))
    assert modulated.read_words(0x1004, 1) == [4 << 16]


def test_without_the_generic_the_window_is_refused() -> None:
    with Instrument(LANES, DEPTH) as plain:
        assert plain.read("capability.modulators") == 0
        with pytest.raises(BusError):
            plain.read("conditions.width")
        plain.write_coefficients(order_0(5.0, "word_a"))
        assert plain.read_words(0x1004, 1) == [0], "the core has no bits of the modulator"
