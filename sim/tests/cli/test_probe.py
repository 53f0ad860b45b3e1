"""Tests ``arctrue probe`` against the firmware's console, with a model of the probe's
registers."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner
from sim.tests.cli.test_monitor import Device
from sim.tests.firmware.emulator import PATIENCE_S
from sim.tests.firmware.library import firmware
from sim.tests.firmware.model_core import Firmware, address

from arctrue.cli import main
from arctrue.device import console, probe

TURN = 1 << 24
CLOCK_HZ = 100_000_000
FIRST_EDGE = (1 << 16) - 2
"""Count of the probe's first edge; the 16-bit count wraps during the test."""


def position_of(edge: int) -> int:
    return 1_000_003 * (edge - 3)


class ProbedDevice(Device):
    """A device whose probe has one new edge after each printed latch; after the second and after
    the eighth edge it has three new edges at once."""

    def attach(self, made: Firmware) -> None:
        self.core = made.core
        self.edges = FIRST_EDGE
        self.latch()

    def latch(self) -> None:
        number = self.edges - FIRST_EDGE
        clocks = 50_000_000 * number + (1 << 33)
        self.core.words[address("probe.time")] = clocks & 0xFFFF_FFFF
        self.core.words[address("probe.time") + 4] = clocks >> 32
        self.core.set("probe.position", position_of(number))
        self.core.set("probe.angle", position_of(number) % TURN)
        self.core.set("probe.edges", self.edges % (1 << 16))

    def tell(self, said: str) -> None:
        super().tell(said)
        if "angle_counts" in said:
            self.edges += 3 if self.edges - FIRST_EDGE in (2, 8) else 1
            self.latch()


@pytest.fixture
def device(monkeypatch: pytest.MonkeyPatch) -> Iterator[ProbedDevice]:
    monkeypatch.setattr(probe, "LOOK_S", 0.0)
    made = ProbedDevice()
    with made.running(monkeypatch):
        yield made


def test_each_edge_and_each_missed_edge_is_reported(device: ProbedDevice, tmp_path: Path) -> None:
    out = tmp_path / "edges.csv"
    arguments = ["probe", device.port, "--count", "5", "--csv", str(out)]
    done = CliRunner().invoke(main, arguments)
    assert done.exit_code == 0, done.output
    assert done.output.count("2 edges missed before") == 1
    rows = np.loadtxt(out, delimiter=",", skiprows=1)
    numbers = np.array([1, 2, 5, 6, 7])
    np.testing.assert_array_equal(rows[:, 0], (FIRST_EDGE + numbers) % (1 << 16))
    np.testing.assert_allclose(rows[:, 1], (5e7 * numbers + 2**33) / CLOCK_HZ, rtol=1e-12)
    positions = np.array([position_of(int(number)) for number in numbers])
    np.testing.assert_array_equal(rows[:, 2], positions)
    np.testing.assert_allclose(rows[:, 3], positions % TURN / TURN * 360.0, atol=5.1e-8)
    assert "5 edges: " in done.output


LOST = range(60, 64)


class QueueDevice(Device):
    """A device with a queue of events, which gets four bursts of 50 events, each when it is empty.

    Events 11 to 14 of the second burst are lost.
    """

    def attach(self, made: Firmware) -> None:
        self.core = made.core
        self.core.build_events()
        self.bursts = 0

    def tell(self, said: str) -> None:
        super().tell(said)
        if "ok\r\n" in said and not self.core.events and self.bursts < 4:
            numbers = range(50 * self.bursts, 50 * self.bursts + 50)
            self.core.events.extend(queued(number) for number in numbers if number not in LOST)
            self.bursts += 1


def queued(number: int) -> tuple[int, int, int, int, int]:
    """Return event ``number`` of the queue; the 16-bit number of the event wraps after the 20th."""
    position = position_of(number)
    clocks = 1000 * number + (1 << 40)
    return (65_516 + number) % (1 << 16), 1 + number % 3, clocks, position, position % TURN


def test_every_event_of_a_burst_is_written(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    device, out = QueueDevice(), tmp_path / "edges.csv"
    with device.running(monkeypatch):
        arguments = ["probe", device.port, "--count", "100", "--csv", str(out)]
        done = CliRunner().invoke(main, arguments)
    assert done.exit_code == 0, done.output
    rows = np.loadtxt(out, delimiter=",", skiprows=1)
    first = int(rows[0, 0] - 65_516) % (1 << 16)
    numbers = np.array([n for n in range(first, first + 104) if n not in LOST])
    wanted = np.array([queued(int(number)) for number in numbers])
    np.testing.assert_array_equal(rows[:, 0], wanted[:, 0])
    np.testing.assert_allclose(rows[:, 1], wanted[:, 2] / CLOCK_HZ, atol=5.1e-10)
    np.testing.assert_array_equal(rows[:, 2], wanted[:, 3])
    np.testing.assert_allclose(rows[:, 3], wanted[:, 4] / TURN * 360.0, atol=5.1e-8)
    np.testing.assert_array_equal(rows[:, 4], wanted[:, 1])
    np.testing.assert_array_equal(rows[:, 5], np.where(numbers == LOST[-1] + 1, len(LOST), 0))
    assert done.output.count("edges missed before") == 1
    assert "4 edges missed before this one: 40 to 43" in done.output


class StillDevice(Device):
    """A device whose probe has no edge."""


class DyingDevice(ProbedDevice):
    """A device that stops answering after its third latch."""

    def tell(self, said: str) -> None:
        super().tell(said)
        self.ended = self.edges - FIRST_EDGE > 3


def test_edges_that_were_shown_are_written_where_the_device_falls_silent(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    firmware()
    monkeypatch.setattr(console.Console.command, "__defaults__", (1.0,))
    monkeypatch.setattr(probe, "LOOK_S", 0.0)
    device = DyingDevice()
    device.start()
    out = tmp_path / "edges.csv"
    done = CliRunner().invoke(main, ["probe", device.port, "--csv", str(out)])
    device.join(PATIENCE_S)
    assert done.exit_code == 2, done.output
    rows = np.loadtxt(out, delimiter=",", skiprows=1, ndmin=2)
    assert rows.shape[0] >= 1
    assert f"{rows.shape[0]} edges: " in done.output


def test_without_an_edge_nothing_is_reported(monkeypatch: pytest.MonkeyPatch) -> None:
    firmware()
    monkeypatch.setattr(console.Console.command, "__defaults__", (PATIENCE_S,))
    device = StillDevice()
    device.start()
    assert probe.Probe(console.Console(device.port)).wait(0.0) is None
    device.ended = True
    device.join(PATIENCE_S)


def test_a_file_of_another_kind_is_refused() -> None:
    done = CliRunner().invoke(main, ["probe", "/dev/null", "--csv", "edges.txt"])
    assert done.exit_code == 2
    assert "expected a name that ends in .csv" in done.output
