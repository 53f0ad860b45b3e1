"""Tests that the firmware finds and follows the phase of a line (a harmonic whose order is not an
integer) from the heads' readings or from the edges of a probe."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from numpy.typing import NDArray
from sim.tests.calibration.synthetic import COUNTS
from sim.tests.firmware.calibrator import capture_in_c, verify
from sim.tests.firmware.library import firmware
from sim.tests.firmware.model_core import COEFFICIENTS, Firmware
from sim.tests.firmware.test_load import running, send, state, turn
from sim.tests.firmware.test_load_real import built

from arctrue.calibration.line_phase import LineFinder
from arctrue.device.load import load_frames
from arctrue.gateware.coefficients import Coefficients
from arctrue.gateware.extension import PhaseSource
from arctrue.gateware.turn_offset_sweep import turn_offsets

__all__ = ["running"]

Float = NDArray[np.float64]
ALPHA_DEG = 33.0
ALPHA_RAD = float(np.radians(ALPHA_DEG))
ARCSEC_PER_COUNT = 1_296_000 / COUNTS
SAMPLES = 1_500
NOISE_ARCSEC = 0.1
LANES = 32
SLIP = 0.001
TOLERANCE = 1e-9
"""Relative tolerance: C and Python add the 1,500 samples in different orders, in double
precision."""


class Table:
    """A disc with integer orders and a line whose order changes at random from turn to turn; the
    line's phase is continuous."""

    def __init__(self, order: float, amplitude_arcsec: float, turns: int, seed: int) -> None:
        self.amplitude = amplitude_arcsec
        self.random = np.random.default_rng(seed)
        self.first = -4
        steps = order * (1.0 + SLIP * self.random.standard_normal(turns + 16))
        self.phase = 0.17 + np.concatenate([[0.0], np.cumsum(steps)])

    def line(self, place_turns: Float) -> Float:
        numbers = self.first + np.arange(self.phase.size)
        phase = np.interp(place_turns, numbers, self.phase)
        return np.asarray(self.amplitude * np.cos(2.0 * np.pi * phase))

    def error(self, place_turns: Float) -> Float:
        theta = 2.0 * np.pi * place_turns
        whole = 150.0 * np.cos(theta + 0.4) + 6.0 * np.cos(2.0 * theta + 4.2)
        return np.asarray(whole + 1.2 * np.cos(7.0 * theta + 2.9) + self.line(place_turns))

    def turn(self, first_turns: float, side: int = 1) -> NDArray[np.int64]:
        """Return the counts (2, n) of both heads over one turn, counted from the zero of turn 0."""
        place = first_turns + side * np.arange(SAMPLES + 1) / SAMPLES
        ahead = place + ALPHA_DEG / 360.0
        readings = np.stack([place, ahead]) * 1_296_000
        readings += [self.error(place), self.error(ahead)]
        readings += self.random.normal(0.0, NOISE_ARCSEC, readings.shape)
        return np.asarray(np.rint(readings / ARCSEC_PER_COUNT), dtype=np.int64)


@pytest.mark.parametrize("order", [0.42, 0.5, 7.3, 71.4])
def test_the_firmware_computes_what_the_reference_computes(order: float) -> None:
    """The C code computes the states and phases of the Python reference. The turns go in both
    directions, start at different places, and reach negative turn numbers."""
    ffi, library = firmware()
    table = Table(order, 4.0, 12, 3)
    step = round((order % 1.0) * 2**48)
    sought = ffi.new(
        "struct line_sought *", {"order": order, "turn_step": step, "amplitude_arcsec": 4.0}
    )
    finder = ffi.new("struct line_finder *")
    reference = LineFinder(order, 4.0)
    for number, (first, side) in enumerate(
        [(0.3, 1), (1.4, 1), (2.4, -1), (0.9, -1), (-0.3, -1), (-1.2, 1), (3.1, 1)]
    ):
        counts = table.turn(first, side)
        in_c = capture_in_c(counts)
        reason, verified, _ = verify(in_c)
        assert reason == "none"
        library.turn_align(verified, ALPHA_RAD)
        used = counts[:, : verified.samples]
        first_turn = int(used[0, 0] // COUNTS)
        library.line_finder_add(finder, sought, verified, first_turn, ALPHA_RAD, 0.14)
        whole = used[0] // COUNTS
        reference.add(
            used[0] / COUNTS - whole,
            whole,
            (used[1] - used[0]) * ARCSEC_PER_COUNT - ALPHA_DEG * 3600.0,
            separation_rad=ALPHA_RAD,
            noise_arcsec=0.14,
        )
        found = np.array(list(finder.state))
        spread = np.array([list(row) for row in finder.covariance])
        scale = np.abs(reference.covariance).max()
        assert np.abs(found - reference.state).max() <= TOLERANCE * np.abs(reference.state).max()
        assert np.abs(spread - reference.covariance).max() <= TOLERANCE * max(scale, 1.0)
        assert bool(finder.is_known) == reference.is_known, number
        phase = library.line_finder_phase(finder) - reference.phase_turns
        assert abs(phase - round(phase)) <= 1e-6


def file_of(order: float, amplitude_arcsec: float, source: PhaseSource) -> Coefficients:
    bank = Coefficients.from_harmonics(
        [0] * LANES,
        [0.0] * (LANES - 1) + [amplitude_arcsec / ARCSEC_PER_COUNT],
        [0.0] * LANES,
        COUNTS,
        LANES,
    ).with_real_orders({LANES - 1: order})
    assert bank.extension is not None
    extension = dataclasses.replace(bank.extension, phase_sources=((LANES - 1, source),))
    return dataclasses.replace(bank, extension=extension)


def capture(running: Firmware, counts: NDArray[np.int64]) -> None:
    """Hand a turn over to the firmware, after setting the core's registers to the turn number and
    the angle of the last sample."""
    running.core.hand_over(counts)
    last = int(counts[0, -1])
    running.core.set("turn_number", last // COUNTS)
    running.core.set("snapshot.corrected_angle", last % COUNTS)
    running.step(8)


def lane_words(running: Firmware) -> list[int]:
    """Return the four words of the active lane."""
    return [running.core.active[COEFFICIENTS + 16 * (LANES - 1) + 4 * word] for word in range(4)]


def lane_arcsec(words: list[int], order: float, place_turns: Float) -> Float:
    """Return the correction of a lane with these words in arcseconds, at these places."""
    step = round((order % 1.0) * 2**48)
    offset = turn_offsets(int(place_turns[0] // 1.0), [step], [words[2]])[0]
    phase = order * (place_turns % 1.0) + int(offset) / 2**24
    amplitude = np.array(words[3], dtype=np.uint32).view(np.int32) / 2048 * ARCSEC_PER_COUNT
    return np.asarray(amplitude * np.cos(2.0 * np.pi * phase))


def followed(running: Firmware, order: float, turns: int) -> tuple[float, float, int]:
    """Return the RMS error of the corrected line relative to the line's RMS; the same for a lane
    that keeps its first phase; and the number of turns before the lane was active."""
    amplitude = 4.0
    table = Table(order, amplitude, turns, 8)
    built(running)
    frames = load_frames(file_of(order, amplitude, PhaseSource("heads")))
    assert set(send(running, frames)) == {"ok"}
    running.turn(turn(5))
    assert state(running) == "load active"
    left, kept, before, seen = 0.0, 0.0, 0, 0
    first: list[int] = []
    for number in range(turns):
        capture(running, table.turn(number + 0.37))
        place = number + 2.0 + np.arange(64) / 64
        lane = lane_arcsec(lane_words(running), order, place)
        if not lane.any():
            before = number + 1
            assert "phase_unknown" in running.send("load status")
            continue
        seen += 1
        first = first or lane_words(running)
        left += float(np.mean((table.line(place) - lane) ** 2))
        kept += float(np.mean((table.line(place) - lane_arcsec(first, order, place)) ** 2))
    assert f"real_order {order:.9f} phase_known" in running.send("load status")
    shares = [float(np.sqrt(2.0 * total / seen)) / amplitude for total in (left, kept)]
    return shares[0], shares[1], before


@pytest.mark.parametrize("order", [0.42, 7.3])
def test_a_line_that_slips_is_found_and_followed(running: Firmware, order: float) -> None:
    share, _, before = followed(running, order, 60)
    assert 3 <= before <= 20
    assert share <= 0.25


@pytest.mark.large
def test_a_line_that_slips_is_followed_over_a_thousand_turns(running: Firmware) -> None:
    """The order of the line changes at random by 0.1 % in every turn. The lane leaves at most a
    quarter of the line; a lane that keeps its first phase leaves more."""
    share, kept, _ = followed(running, 7.3, 1_000)
    assert share <= 0.25
    assert kept > 0.25


def probe_edge(running: Firmware, edges: int, edge_turns: float, now_turns: float) -> None:
    """Latch an edge of the probe at ``edge_turns`` while the table is at ``now_turns``; neither
    position wraps."""
    edge, now = round(edge_turns * COUNTS), round(now_turns * COUNTS)
    origin = 123_456
    for name, word in (
        ("probe.position", edge + origin),
        ("probe.angle", edge % COUNTS),
        ("probe.edges", edges),
        ("turn_number", now // COUNTS),
        ("snapshot.corrected_position", now + origin),
        ("snapshot.corrected_angle", now % COUNTS),
        ("snapshot.head1_angle", now % COUNTS),
    ):
        running.core.set(name, word)
    running.step(6)


@pytest.mark.parametrize("side", [0, 1, -1])
def test_an_index_of_the_drive_gives_the_phase(running: Firmware, side: int) -> None:
    """At every edge of the probe, the line has the stated phase plus ``side`` times the angle of
    the table."""
    order, phase = 71.4 + side, 0.2
    built(running)
    probe_edge(running, 7, 0.3, 0.31)
    source = PhaseSource("probe", side, round(phase * 2**24))
    frames = load_frames(file_of(order, 4.0, source), unseen=True)
    assert set(send(running, frames)) == {"ok"}
    running.turn(turn(5))
    assert state(running) == "load active"
    running.step(6)
    assert "phase_unknown" in running.send("load status"), "the age of that edge is unknown"
    probe_edge(running, 8, 1.36, 1.34)
    assert "phase_unknown" in running.send("load status"), (
        "edges are ignored while the readings fall"
    )
    # The edges are in positive and in negative turns; one edge came before the wrap.
    for number, (edge, now) in enumerate([(1.3, 1.32), (-2.7, -2.6), (4.99, 5.02)]):
        probe_edge(running, 9 + number, edge, now)
        assert f"real_order {order:.9f} phase_known" in running.send("load status")
        lane = lane_arcsec(lane_words(running), order, np.array([edge]))[0]
        expected = 4.0 * np.cos(2.0 * np.pi * (phase + side * edge))
        # The bound is a phase error of 72.4 · 2⁻²⁴ turn: one word of the phase, plus one count of
        # the edge times the order 71.4.
        assert lane == pytest.approx(expected, abs=4.0 * 2.0 * np.pi * 72.4 / COUNTS)
    words = dict(running.core.active)
    probe_edge(running, 20, 0.5 / 16_777_216, 5.0 + 8 / COUNTS)
    assert running.core.active == words, "near the wrap the turn is not certain"


def test_a_line_that_no_turn_shows_stays_off(running: Firmware) -> None:
    built(running)
    frames = load_frames(file_of(7.3, 4.0, PhaseSource("heads")))
    assert set(send(running, frames)) == {"ok"}
    running.turn(turn(5))
    table = Table(7.3, 0.0, 20, 9)
    for number in range(12):
        capture(running, table.turn(number + 0.37))
    assert "phase_unknown" in running.send("load status")
