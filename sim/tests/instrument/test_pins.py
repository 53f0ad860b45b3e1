"""Tests the edges of the instrument's pins against edges that are computed one by one."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest
from sim.tests.instrument.sizes import DEPTH, LANES

from arctrue.instrument import HEAD1_A, HEAD1_Z, HEAD2_B, Instrument, InstrumentError, PinFault
from arctrue.table import (
    DiscEccentricity,
    GraduationHarmonics,
    Motion,
    PinEvents,
    RotaryTable,
    clocked_pins,
    count_edges,
    decode_quadrature,
    two_heads,
)

COUNTS = 4096
CLOCK_HZ = 1e6
# The test computes an edge to 1e-7 counts; the cubic between knots is right to 1e-3 counts. An edge
# near the end of a clock may therefore differ by a clock; at about 4 clocks per count, this happens
# once in some thousand edges.
MOST_EDGES_A_CLOCK_OFF = 20


def table() -> RotaryTable:
    return RotaryTable(
        heads=two_heads(),
        causes=(
            DiscEccentricity(4e-4, 1.0),
            GraduationHarmonics((2, 7), (2e-3, 4e-4), (0.3, 2.0)),
        ),
        counts_per_rev=COUNTS,
    )


def there_and_back() -> Motion:
    speed = 2 * np.pi / COUNTS * CLOCK_HZ / 4
    return Motion((0.0, 0.002, 0.012, 0.016, 0.03), (0.0, speed, speed, -speed, -speed), -0.3)


@pytest.fixture(scope="module")
def instrument() -> Iterator[Instrument]:
    with Instrument(LANES, DEPTH, clock_hz=CLOCK_HZ) as made:
        yield made


def played(instrument: Instrument, clocks: int) -> np.ndarray:
    instrument.trace(clocks)
    instrument.run(clocks)
    return instrument.traced()


def levels_of(events: PinEvents, clocks: int) -> np.ndarray:
    place = np.searchsorted(events.clock, np.arange(clocks), side="right")
    return np.concatenate([[events.first_levels], events.levels])[place]


def test_pins_of_a_table(instrument: Instrument) -> None:
    motion = there_and_back()
    heads = tuple(count_edges(table(), head, motion) for head in (0, 1))
    events = clocked_pins(heads, COUNTS, CLOCK_HZ)
    clocks = int(motion.duration_s * CLOCK_HZ)
    instrument.attach(table(), motion)
    pins = played(instrument, clocks) & 63
    instrument.detach()
    wanted = levels_of(events, clocks)
    off = np.flatnonzero(pins != wanted)
    assert np.count_nonzero(np.diff(wanted)) > 10_000
    assert off.size <= MOST_EDGES_A_CLOCK_OFF
    # Each of these edges differs by one clock, because no two of them are adjacent.
    assert np.all(np.diff(off) > 1)


def test_true_angle_and_end(instrument: Instrument) -> None:
    motion = there_and_back()
    instrument.attach(table(), motion)
    begin = instrument.clock
    reason = instrument.run_until(true_angle_rad=0.1)
    assert reason == "true_angle"
    time_s = (instrument.clock - 1 - begin) / CLOCK_HZ
    counts_a_clock = 0.25
    off_rad = motion.state(np.array([time_s])).angle_rad[0] - 0.1
    assert abs(off_rad) <= counts_a_clock * table().count_rad
    assert instrument.run_until(end_of_stimulus=True) == "end"
    assert instrument.clock - begin == int(motion.duration_s * CLOCK_HZ)
    before = played(instrument, 1)[0] & 63
    assert np.all((played(instrument, 50) & 63) == before)
    instrument.detach()


def test_output_is_decoded_as_it_was_put_in(instrument: Instrument) -> None:
    """Without a correction the core repeats head 1; the recorder counts the output like
    decode_quadrature."""
    motion = there_and_back()
    instrument.attach(table(), motion)
    instrument.reset()
    instrument.write("counts_per_rev", COUNTS)
    instrument.command("rearm")
    instrument.run(200)
    instrument.write("output_spacing", 1)
    instrument.update("control", output_enable=1)
    instrument.record(every=1, bins=8)
    clocks = 25_000
    begin = instrument.clock
    trace = played(instrument, clocks)
    instrument.detach()
    recording = instrument.recording()
    output = (trace >> 6 & 7).astype(np.uint8)
    step, illegal = decode_quadrature(int(output[0]), output[1:])
    assert recording.illegal == illegal.size == 0
    assert recording.output.edges == np.count_nonzero(step) == recording.output.clock.size
    assert np.array_equal(recording.output.clock, begin + 1 + np.flatnonzero(step))
    # A downward step passes the upper end of the new count.
    level = np.where(step < 0, np.cumsum(step) + 1, np.cumsum(step))[step != 0]
    assert np.array_equal(np.diff(recording.output.position), np.diff(level))
    # The error of the reading is known exactly; an edge is recorded up to one clock late, on
    # average half a clock.
    angle = recording.head1.true_angle_rad
    state = motion.state(np.clip((recording.head1.clock - begin) / CLOCK_HZ, 0, motion.duration_s))
    assert np.max(np.abs(np.diff(recording.head1.position))) <= 1
    assert np.all(np.abs(angle - angle[0]) < 2 * np.pi)
    assert state.angle_rad.size == recording.head1.edges
    assert recording.output.bin_edges.sum() == recording.output.edges


def test_latency_is_that_of_the_edges(instrument: Instrument) -> None:
    """A single edge at head 1 appears at the output after ``latency_clocks``, also with the
    filter."""
    for length in (1, 4):
        instrument.attach_pins(PinEvents(0, np.zeros(0, dtype=np.int64), np.zeros(0, np.uint8)))
        instrument.reset()
        instrument.write("filter_length", length)
        instrument.write("output_spacing", 1)
        instrument.update("control", output_enable=1)
        instrument.run(100)
        latency = instrument.latency_clocks
        edges = PinEvents(0, np.array([20, 60]), np.array([HEAD1_A, HEAD1_A | 2], dtype=np.uint8))
        instrument.attach_pins(edges)
        trace = played(instrument, 200)
        came = np.flatnonzero(np.diff(trace >> 6 & 3, prepend=0))
        assert came.tolist() == [20 + latency, 60 + latency]
    instrument.detach()


def test_disturbed_pins(instrument: Instrument) -> None:
    quiet = PinEvents(HEAD2_B, np.zeros(0, dtype=np.int64), np.zeros(0, np.uint8))
    instrument.attach_pins(quiet)
    now = instrument.clock
    instrument.disturb(
        PinFault(now + 10, 5, invert=HEAD1_A),
        PinFault(now + 12, 2, low=HEAD2_B, high=HEAD1_Z),
        PinFault(now + 100, 1000, invert=HEAD1_A, probability=0.25),
    )
    pins = played(instrument, 1200) & 63
    instrument.disturb()
    assert pins[9] == pins[15] == HEAD2_B
    assert pins[10] == HEAD2_B | HEAD1_A
    assert pins[12] == HEAD1_A | HEAD1_Z
    struck = np.count_nonzero(pins[100:1100] & HEAD1_A)
    # 250 clocks with an inversion are expected; the bound is 5 standard deviations of the binomial
    # distribution.
    assert abs(struck - 250) < 5 * np.sqrt(1000 * 0.25 * 0.75)
    instrument.detach()


def test_too_fast_is_refused(instrument: Instrument) -> None:
    fast = Motion.steady(2 * np.pi / COUNTS * CLOCK_HZ * 2, 0.01)
    instrument.attach(table(), fast)
    with pytest.raises(InstrumentError, match=r"head 1 makes \d counts in clock \d+"):
        instrument.run(1000)
    instrument.attach(table(), fast, may_jump=True)
    instrument.run(1000)
    instrument.detach()
