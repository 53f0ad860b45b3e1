"""Tests ``arctrue commission`` against the firmware's console, with exchanged and reversed
heads."""

from __future__ import annotations

import os
import re
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest
from click.testing import CliRunner
from sim.tests.calibration.synthetic import COUNTS
from sim.tests.cli.test_monitor import Device
from sim.tests.firmware.emulator import PATIENCE_S
from sim.tests.firmware.model_core import Firmware, bit
from sim.tests.firmware.test_heads import PLACES, World
from sim.tests.firmware.test_own_sets import FourHeadsCore

from arctrue.cli import main
from arctrue.device.commissioning import read_parameters
from arctrue.device.console import Console, ConsoleError

PLAN = ",".join(f"{place:g}" for place in PLACES[4])
CLOCK_HZ = 100_000_000.0
PERIOD_CLOCKS = 100_000
SAMPLES = 4000
DEG_PER_S = 360.0 / (SAMPLES * PERIOD_CLOCKS / CLOCK_HZ)
SKEW_NS = (0.0, 150.0, 0.0, 400.0)
RATIOS = (1.0, 1.001, 0.999, 1.0005)


@dataclass(frozen=True)
class TurningWorld(World):
    """A table that turns forward or backward; each head's reading is late by its value of
    SKEW_NS."""

    direction: int = 1

    def theta(self) -> Any:
        return self.direction * 2.0 * np.pi * np.arange(self.samples + 60) / self.samples + 0.3

    @property
    def true_rad(self) -> Any:
        late = np.array(SKEW_NS) * 1e-9 * np.radians(DEG_PER_S)
        return super().true_rad - self.direction * late


WORLD = TurningWorld(
    noise_arcsec=0.1, late_arcsec=(0.0,) * 4, samples=SAMPLES, ratios=RATIOS, seed=3
)


class TableDevice(Device):
    """A device whose table moves by 13° after each answer that contains "indexed"; turns captured
    after the first dump run backward."""

    cables = (0, 1, 2, 3)
    sense = (1, 1, 1, 1)

    def run(self) -> None:
        made = Firmware(FourHeadsCore())
        self.core = made.core
        self.angle_turns = 0.0
        self.world = WORLD
        for head in range(1, 5):
            self.core.set(f"head{head}.flags", bit("head1.flags", "index_seen"))
        made.library.application_start(made.application)
        made.core.see_index()
        made.send("set orders 8")
        made.send(f"set sample_period {PERIOD_CLOCKS}")
        made.core.see_index()
        self.made = made
        self.move()
        while not self.ended:
            try:
                said = made.send(self.received(os.read(self.end, 256)))
            except OSError:
                said = ""
                time.sleep(0.002)
            dumping = made.application.dump != 0
            if made.phase == "capture" and not made.core.get("status") and dumping:
                made.core.hand_over(self.world.counts())
            self.tell(said + made.step())

    def move(self) -> None:
        """Turn the table by 13°, and set the reading of every head in the core."""
        self.angle_turns += 13.0 / 360.0
        for cable, (head, sense) in enumerate(zip(self.cables, self.sense, strict=True), start=1):
            nominal = self.angle_turns + PLACES[4][head] / 360.0
            read = sense * round(nominal * COUNTS)
            there, last = ("snapshot.", "_") if cable < 3 else ("", ".")
            self.core.set(f"{there}head{cable}{last}turn_position", read)
            self.core.set(f"{there}head{cable}{last}angle", read % COUNTS)

    def tell(self, said: str) -> None:
        super().tell(said)
        if "indexed" in said:
            self.move()
        if "end of dump" in said:
            self.world = replace(WORLD, direction=-1, seed=4)


@contextmanager
def connected(
    monkeypatch: pytest.MonkeyPatch,
    cables: tuple[int, ...] = (0, 1, 2, 3),
    sense: tuple[int, ...] = (1, 1, 1, 1),
) -> Iterator[TableDevice]:
    made = TableDevice()
    made.cables, made.sense = cables, sense
    with made.running(monkeypatch):
        yield made


def commission(device: TableDevice, *options: str) -> Any:
    words = ["commission", device.port, "--places", PLAN, "--timeout", str(PATIENCE_S), *options]
    return CliRunner().invoke(main, words)


def test_exchanged_and_reversed_heads_are_named(monkeypatch: pytest.MonkeyPatch) -> None:
    """The command names cables 3 and 4, which are exchanged, and head 2, whose A and B are
    exchanged."""
    with connected(monkeypatch, cables=(0, 1, 3, 2), sense=(1, -1, 1, 1)) as device:
        done = commission(device)
    assert done.exit_code == 1, done.output
    assert (
        "head 2: counts in the opposite direction: exchange A and B (8 in head2_input)"
        in done.output
    )
    assert "cable 3 is at head 4, cable 4 is at head 3" in done.output


def test_heads_as_planned_and_a_missing_index(monkeypatch: pytest.MonkeyPatch) -> None:
    with connected(monkeypatch) as device:
        done = commission(device, "--connection")
        assert done.exit_code == 0, done.output
        assert "All heads are connected as planned" in done.output
        device.core.set("head3.flags", 0)
        missing = commission(device, "--connection")
    assert missing.exit_code == 1
    assert "head 3: no index detected" in missing.output


def test_places_radii_and_skew_are_measured_and_written(monkeypatch: pytest.MonkeyPatch) -> None:
    """After a turn in each direction, each result is right to within four of its standard
    uncertainties.

    The skews of 150 and 400 ns are 0.05″ and 0.13″ at 90°/s. The delays, in clocks of 10 ns, align
    all heads with the latest head.
    """
    with connected(monkeypatch) as device:
        done = commission(device, "--write")
        parameters = device.made.parameters()
    assert done.exit_code == 0, done.output
    rows = [line.split() for line in done.output.splitlines() if re.match(r"\s*[1-4]\s", line)]
    turned = np.array([[float(word) for word in row] for row in rows if len(row) == 8])
    assert turned.shape == (4, 8)
    _, places, u_place, radius, u_radius, late, u_late, delays = turned.T
    mounted = np.array(PLACES[4]) + np.array(WORLD.off_arcsec) / 3600.0
    assert np.all(np.abs(places - mounted) * 3600.0 <= 4.0 * u_place + 0.2)
    assert np.all(np.abs(radius - 1.0 / np.array(RATIOS)) <= 4.0 * u_radius + 1e-6)
    assert np.all(u_late[1:] < 20.0)
    assert np.all(np.abs(late - np.array(SKEW_NS)) <= 4.0 * u_late + 0.5)
    assert np.all(np.abs(delays * 10.0 - (400.0 - np.array(SKEW_NS))) <= 4.0 * u_late.max() + 5.0)
    word = sum(int(clocks) << 8 * head for head, clocks in enumerate(delays))
    assert float(parameters["head_delays"]) == word
    assert float(parameters["head3_deg"]) == pytest.approx(places[2], abs=1e-4)
    parity = re.search(r"Noise of the parity: ([\d.]+)″", done.output)
    assert parity is not None
    assert float(parity[1]) == pytest.approx(0.1, rel=0.2), "the noise of one reading"


def test_a_parameter_without_a_number_is_named() -> None:
    """An earlier firmware prints null for a parameter above 9e8; the message names it."""
    answers = {"show parameters": ["keep 0.8", "head_delays null"], "version": ["clock_hz 1"]}
    console = cast("Console", SimpleNamespace(command=answers.__getitem__))
    with pytest.raises(ConsoleError, match="head_delays: expected a number, found null"):
        read_parameters(console)
