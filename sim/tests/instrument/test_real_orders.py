"""Tests lanes of non-integer orders over many turns, from a moving table's pins to the output."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest
from numpy.typing import NDArray
from sim.tests.instrument.sizes import DEPTH, EXTENSIONS, LANES

from arctrue.gateware.coefficients import Coefficients
from arctrue.instrument import Instrument

COUNTS = 1 << 15
KNOT = 8
PACE = 0.8
"""Speed in counts per clock."""
LEAD = 3000.5
"""Counts from the start to the index."""
TURN_RAD = 2.0 * np.pi
ORDERS = np.array([0.5, 71.4, 70.4, 72.4])
"""Orders of a belt, of a gear, and of the gear's two side harmonics."""
AMPLITUDES = np.array([10.0, 3.0, 1.0, 1.0])
"""Amplitudes in counts, so small that the error as a function of the reading equals the error as a
function of the angle within 0.4 count."""
PHASES = np.array([0.7, -2.0, 1.1, 0.3])
SHOWN_TURNS = 2


def lines_counts(place: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the error of the reading in counts at ``place``, counts over any number of turns."""
    phase = np.multiply.outer(place, ORDERS) * (TURN_RAD / COUNTS) + PHASES
    return np.asarray(np.cos(phase) @ AMPLITUDES)


class ThereAndBack:
    """A table that makes ``up`` turns forwards from its index, and then ``down`` turns
    backwards."""

    counts_per_rev = COUNTS
    index_width_counts = 1
    rounding_counts = 0.0

    def __init__(self, up: float, down: float) -> None:
        self.top_clock = int((LEAD + up * COUNTS) / PACE)
        self.clocks = self.top_clock + int(down * COUNTS / PACE)

    def piece(self, first_clock: int, clocks: int) -> tuple[int, *tuple[NDArray[np.float64], ...]]:  # type: ignore[override]
        """Return a piece of the curve in the form of :class:`Curves`."""
        intervals = max(1, min(clocks, self.clocks - first_clock) // KNOT)
        clock = first_clock + KNOT * np.arange(-1.0, intervals + 2)
        clock = np.clip(clock, 0.0, float(self.clocks))
        place = PACE * (self.top_clock - np.abs(self.top_clock - clock)) - LEAD
        reading = place + lines_counts(place)
        return KNOT, reading, reading, place * (TURN_RAD / COUNTS)


@pytest.fixture(scope="module")
def built() -> Iterator[Instrument]:
    with Instrument(LANES, DEPTH, generics=EXTENSIONS) as instrument:
        yield instrument


def bank(on: bool) -> Coefficients:
    plain = Coefficients.from_harmonics([0] * LANES, AMPLITUDES * on, PHASES, COUNTS, LANES)
    return plain.with_real_orders(dict(enumerate(ORDERS.tolist())))


def amplitudes_left(instrument: Instrument, end_turns: float) -> NDArray[np.float64]:
    """Return the amplitude in counts of each harmonic of ORDERS in the output, over the two turns
    before ``end_turns``."""
    way = 1.0 if end_turns * TURN_RAD > instrument.true_angle_rad else -1.0
    instrument.run_until(true_angle_rad=(end_turns - way * (SHOWN_TURNS + 0.1)) * TURN_RAD)
    instrument.record(every=1, turns=float(SHOWN_TURNS))
    instrument.run_until(true_angle_rad=end_turns * TURN_RAD)
    seen = instrument.recording().output
    place = seen.true_angle_rad * (COUNTS / TURN_RAD)
    phase = np.multiply.outer(place, ORDERS) * (TURN_RAD / COUNTS)
    columns = np.column_stack([np.ones(place.size), np.cos(phase), np.sin(phase)])
    found = np.linalg.lstsq(columns, seen.position - place, rcond=None)[0]
    return np.asarray(np.hypot(found[1 : 1 + ORDERS.size], found[1 + ORDERS.size :]))


def run(
    instrument: Instrument, coefficients: Coefficients, up: int, down: int
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the amplitudes in counts that remain after ``up`` turns forwards, and after ``down``
    turns back."""
    instrument.attach_curves(ThereAndBack(up + 0.5, down + 0.5))  # type: ignore[arg-type]
    instrument.reset()
    instrument.write("counts_per_rev", COUNTS)
    instrument.command("rearm")
    for name, value in (
        ("ramp_rate", 0xFFFF_FFFF),
        ("ramp_acceleration", 0),
        ("output_spacing", 1),
    ):
        instrument.write(name, value)
    instrument.write_coefficients(coefficients)
    instrument.command("swap")
    instrument.update("control", compensate=1, output_enable=1)
    forwards = amplitudes_left(instrument, float(up))
    assert instrument.read("turn_number") in (up - 1, up)
    instrument.run(int(0.6 * COUNTS / PACE))
    backwards = amplitudes_left(instrument, float(up - down))
    assert instrument.read("turn_number") in (up - down - 1, up - down)
    assert not instrument.read("status.cannot_keep_up")
    instrument.detach()
    return forwards, backwards


@pytest.mark.large
def test_lines_are_gone_after_some_turns_and_backwards(built: Instrument) -> None:
    """The lanes leave less than 0.5 count of each harmonic, also when the table goes back past its
    index into negative turns; with the lanes off, the output contains the amplitudes of the
    table."""
    for found in run(built, bank(on=True), 6, 9):
        assert found.max() < 0.5, found
    for found in run(built, bank(on=False), 4, 4):
        # A fit over two turns separates the harmonics of the gear within 5 %.
        assert found == pytest.approx(AMPLITUDES, rel=0.05)


@pytest.mark.large
def test_lines_are_gone_after_a_thousand_turns(built: Instrument) -> None:
    """After a thousand turns forwards, and after the way back, less than 0.5 count of each harmonic
    remains, because the lanes' phase does not drift."""
    for found in run(built, bank(on=True), 1000, 1000):
        assert found.max() < 0.5, found
