"""Tests the inputs and outputs for other instruments: probe, sync input, trigger, position compare.

The tests decode the pins of the heads themselves and correct the counts by equation (9) in double
precision. They control core and firmware only through pins and console lines.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import pytest
from numpy.typing import NDArray
from sim.tests.faults.scene import Scene
from sim.tests.faults.setting import COUNTS, RUN_UP_S, SPEED_RAD_S, TURN_CLOCKS, TURN_S
from sim.tests.gateware.equation_9 import correction_bound_counts, error_of_words_counts

from arctrue.device.probe import Probe
from arctrue.gateware.coefficients import Coefficients
from arctrue.instrument import (
    COMPARE_OUT,
    HEAD1_Z,
    PROBE_IN,
    SYNC_IN,
    TRIGGER_OUT,
    PinFault,
)
from arctrue.table import Motion, decode_quadrature

pytestmark = pytest.mark.large

HEAD2_SHIFT = 3
OUTPUT_SHIFT = 6
OUTPUT_Z = 4 << OUTPUT_SHIFT
PROBES = 40
PULSE_CLOCKS = 3
SAMPLES = 600
TRACED_CLOCKS = 12 * TURN_CLOCKS
START_RAD = -float(np.deg2rad(50.0))
"""Table angle at the start, chosen so that the recorded pins contain the first index of both heads.

The table moves by 2° to 3° while the firmware sets the core up, and then reaches the index of head
2 at −33°. The first index is the zero of turn_position (header of index_zero).
"""

SAMPLE_AFTER_EDGE = -1
"""Clocks from an edge of sync_in to the pins of the heads that its sample contains: the sample
contains the pins of the clock before the edge.

The strobe comes 4 clocks after the edge of its pin, the turn position 5 clocks after the pins of
the head (headers of pulse_input and quadrature_decoder).
"""
NOTED = 1
"""Clocks by which a recording shows outputs early: it contains the inputs of a clock, but the
outputs after the rising edge that ends this clock."""
TRIGGER_AFTER_EDGE = 4 + 1 + 1 - NOTED
"""Number of clocks from an edge of sync_in to the trigger, through pulse_input, sample_trigger and
pulse_output."""
COMPARE_AFTER_PINS = 5 + 29 + 2 + 1 - NOTED
"""Number of clocks from the pins of head 1 to the compare pulse, through decoder, pipeline,
position_compare and pulse_output."""


@dataclass(frozen=True, slots=True)
class Pins:
    """The pins from the clock ``first_clock`` on, with the counts that the tests decode from
    them."""

    first_clock: int
    levels: NDArray[np.uint16]
    turn_position: NDArray[np.int64]
    """Counts of heads 1 and 2 since their index, shape (2, n)."""

    def of(self, clock: NDArray[np.int64]) -> NDArray[np.int64]:
        """Return the columns of ``turn_position`` for these clocks."""
        return self.turn_position[:, clock - self.first_clock]

    def rises(self, pin: int, since: int) -> NDArray[np.int64]:
        """Return the clocks from ``since`` on in which ``pin`` rises."""
        level = self.levels & pin != 0
        clocks = np.flatnonzero(level[1:] & ~level[:-1]) + 1 + self.first_clock
        return clocks[clocks >= since]


class RecordedScene(Scene):
    """A calibrated scene whose pins are recorded from the beginning."""

    def __init__(self) -> None:
        super().__init__(
            Motion.steady(SPEED_RAD_S, 30.0 * TURN_S, ramp_s=RUN_UP_S, start_rad=START_RAD),
            generics={"EVENTS": "true"},
        )
        assert not any(self.instrument.read(f"head{k}.flags.index_seen") for k in (1, 2))
        self.first_clock = self.instrument.clock
        self.instrument.trace(TRACED_CLOCKS)
        self.calibrate()
        assert self.firmware.send("freeze on").startswith("ok")

    def pins(self) -> Pins:
        levels = self.instrument.traced()
        positions = []
        for head in (0, 1):
            of_head = (levels >> HEAD2_SHIFT * head & 7).astype(np.uint8)
            step, illegal = decode_quadrature(int(of_head[0]), of_head[1:])
            assert not illegal.size
            position = np.concatenate([[0], np.cumsum(step)])
            # The table turns upwards, so that the index is the rising edge of the mark.
            index = np.flatnonzero(of_head & HEAD1_Z)[0]
            positions.append(position - position[index])
        return Pins(self.first_clock, levels, np.array(positions))

    def pulses(self, pin: int, clocks: NDArray[np.int64]) -> None:
        self.instrument.disturb(*(PinFault(int(c), PULSE_CLOCKS, high=pin) for c in clocks))


class ConsoleOfTheFirmware:
    """A stand-in for :class:`arctrue.device.console.Console`, which passes lines to the
    firmware."""

    port = "the firmware on the compiled core"

    def __init__(self, scene: Scene) -> None:
        self._scene = scene

    def command(self, line: str) -> list[str]:
        *lines, end = self._scene.firmware.send(line).splitlines()
        assert end == "ok"
        return lines


def corrected(turn_position: NDArray[np.int64], bank: Coefficients) -> NDArray[np.float64]:
    """Return the counts of head 1 from its index, over many turns, corrected by equation (9)."""
    return turn_position - error_of_words_counts(bank, turn_position % COUNTS)


@pytest.fixture(scope="module")
def scene() -> Iterator[RecordedScene]:
    made = RecordedScene()
    yield made
    made.instrument.close()


def test_a_probe_reads_the_corrected_angle_of_its_edge(scene: RecordedScene) -> None:
    """The probe's angle agrees with equation (9) in double precision at the edge of the pin, within
    the bound of the correction."""
    instrument, bank = scene.instrument, scene.coefficients
    bound = correction_bound_counts(bank)
    draw = np.random.default_rng(5)
    probe = Probe(ConsoleOfTheFirmware(scene))  # type: ignore[arg-type]
    edges, latches = [], []
    for place in range(PROBES):
        falling = place % 2
        assert scene.firmware.send(f"probe falling {falling}") == "ok"
        begin = instrument.clock + int(draw.integers(20, 1500))
        scene.pulses(PROBE_IN, np.array([begin]))
        instrument.run(begin + 100 - instrument.clock)
        latch = probe.wait(0.0)
        assert latch is not None
        assert latch.missed == 0
        edges.append(begin + PULSE_CLOCKS * falling)
        latches.append(latch)
    clocks = np.array(edges)
    wanted = corrected(scene.pins().of(clocks)[0], bank)
    reported = np.array([latch.angle_deg for latch in latches]) * COUNTS / 360.0
    off = (reported - wanted + COUNTS / 2) % COUNTS - COUNTS / 2
    assert np.abs(off).max() <= bound
    # With the pins of one clock later, the worst angle would be wrong by a count; the test would
    # detect this.
    later = corrected(scene.pins().of(clocks + 1)[0], bank)
    assert np.abs((reported - later + COUNTS / 2) % COUNTS - COUNTS / 2).max() > bound
    # Positions and times of the two lists belong to the same edges, but have different zeros.
    positions = np.array([latch.position_counts for latch in latches])
    assert np.abs(np.diff(positions) - np.diff(wanted)).max() <= 2 * bound
    clock_hz = instrument.read("clock_hz")
    times = np.round(np.array([latch.time_s for latch in latches]) * clock_hz).astype(np.int64)
    assert np.array_equal(np.diff(times), np.diff(clocks))


def test_samples_are_taken_at_the_edges_of_sync_in(scene: RecordedScene) -> None:
    """Each edge of sync_in during a turn gives a sample of both heads' counts and a trigger
    pulse."""
    instrument, firmware = scene.instrument, scene.firmware
    for line in ("trigger width 2", "sync capture 1"):
        assert firmware.send(line) == "ok"
    # In this time the firmware drops the turn that began with samples at equal times.
    firmware.run(2000)
    assert instrument.read("capture_fill") == 0
    assert not instrument.read("status.capture_ready")
    begin = instrument.clock + 100
    gaps = np.random.default_rng(6).integers(100, 2 * TURN_CLOCKS // SAMPLES - 100, 2 * SAMPLES)
    edges = begin + np.cumsum(gaps)
    scene.pulses(SYNC_IN, edges)
    instrument.run(int(edges[0]) - instrument.clock)
    for _ in range(100):
        if instrument.read("status.capture_ready"):
            break
        instrument.run(TURN_CLOCKS // 50)
    samples = instrument.read_capture().samples
    pins = scene.pins()
    sampled = edges[: samples.shape[0]]
    assert samples.shape[0] > SAMPLES // 2
    turned = np.diff(pins.of(sampled[[0, -1]])[0])
    assert COUNTS <= turned <= COUNTS + gaps.max()
    assert np.array_equal(samples.T, pins.of(sampled + SAMPLE_AFTER_EDGE))
    reported = edges[edges < instrument.clock - TRIGGER_AFTER_EDGE]
    assert np.array_equal(pins.rises(TRIGGER_OUT, begin), reported + TRIGGER_AFTER_EDGE)
    # The firmware uses a turn of samples at edges of sync_in like any other turn.
    assert "samples sync_in" in firmware.send("status")
    assert scene.next_turn()["samples"] == samples.shape[0]


def test_the_compare_fires_at_the_corrected_places(scene: RecordedScene) -> None:
    """The compare gives one pulse at every place, in the clock in which the corrected count reaches
    it."""
    instrument, bank = scene.instrument, scene.coefficients
    interval, first = COUNTS // 32, 77
    begin = instrument.clock
    for line in (f"compare interval {interval}", f"compare first {first}", "compare on 1"):
        assert scene.firmware.send(line) == "ok"
    instrument.run(TURN_CLOCKS)
    pins = scene.pins()
    clocks = pins.rises(COMPARE_OUT, begin) - COMPARE_AFTER_PINS
    at_place = corrected(pins.of(clocks)[0], bank) - first
    places = np.round(at_place / interval) * interval
    assert np.abs(at_place - places).max() <= correction_bound_counts(bank)
    assert np.array_equal(np.diff(places), np.full(places.size - 1, interval))
    assert places.size >= 31


def test_no_event_of_probe_and_compare_is_lost(scene: RecordedScene) -> None:
    """The console reads each edge of the probe and each pulse of the compare once, with its clock
    and with the corrected count at this clock."""
    instrument, bank = scene.instrument, scene.coefficients
    bound = correction_bound_counts(bank)
    probe = Probe(ConsoleOfTheFirmware(scene))  # type: ignore[arg-type]
    assert probe.has_queue
    for line in (
        "probe falling 0",
        "compare interval 512",
        "compare first 100",
        "compare events 1",
        "compare on 1",
    ):
        assert scene.firmware.send(line) == "ok"
    begin = instrument.clock
    gaps = np.random.default_rng(8).integers(40, TURN_CLOCKS // 16, 25)
    edges = begin + np.cumsum(gaps)
    scene.pulses(PROBE_IN, edges)
    instrument.run(int(edges[-1]) + 100 - begin)
    assert scene.firmware.send("compare on 0") == "ok"
    found = []
    while (event := probe.wait(0.0)) is not None:
        found.append(event)
    pins = scene.pins()
    rises = pins.rises(COMPARE_OUT, begin)
    # The recorded pulse is one clock early (NOTED); a probe wired to compare_out sees it in the
    # next clock.
    pulses = rises + NOTED
    assert min(edges.size, rises.size) >= 15
    clocks = np.concatenate([edges, pulses])
    kinds = np.concatenate([np.full(edges.size, 1), np.full(pulses.size, 2)])
    order = np.argsort(clocks, kind="stable")
    assert np.unique(clocks).size == clocks.size, "no event is one of both probe and compare"
    assert [event.kind for event in found] == kinds[order].tolist()
    assert not any(event.missed for event in found)
    times = np.array([event.time_s for event in found]) * instrument.read("clock_hz")
    assert np.array_equal(np.diff(np.round(times)), np.diff(clocks[order]))
    wanted = corrected(pins.of(clocks[order])[0], bank)
    reported = np.array([event.angle_deg for event in found]) * COUNTS / 360.0
    assert np.abs((reported - wanted + COUNTS / 2) % COUNTS - COUNTS / 2).max() <= bound


def test_the_recorder_counts_the_output_up_to_its_index(scene: RecordedScene) -> None:
    """The recorded position at Z equals the position from the pins, although the recording stores
    only every 17th edge."""
    instrument = scene.instrument
    begin = instrument.clock
    instrument.record(every=17)
    instrument.run(2 * TURN_CLOCKS)
    recording = instrument.recording()
    pins = scene.pins()
    levels = (pins.levels >> OUTPUT_SHIFT & 7).astype(np.uint8)
    step, illegal = decode_quadrature(int(levels[0]), levels[1:])
    assert not illegal.size
    shown = np.concatenate([[0], np.cumsum(step)])
    track = recording.output
    # The positions of the two decoders differ only by a constant, their zeros.
    (apart,) = np.unique(track.position - shown[track.clock - pins.first_clock])
    rises = pins.rises(OUTPUT_Z, begin)
    assert rises.size == 2
    assert np.array_equal(recording.index_clock, rises)
    assert np.array_equal(recording.index_position - apart, shown[rises - pins.first_clock])
    assert np.diff(recording.index_position) == COUNTS
