"""Tests ``arctrue monitor`` and ``arctrue capture`` against the firmware's console at a
pseudo-terminal."""

from __future__ import annotations

import functools
import importlib
import os
import pty
import re
import sqlite3
import threading
import time
import tty
from collections.abc import Iterator
from contextlib import contextmanager
from datetime import UTC, datetime
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from click.testing import CliRunner
from sim.tests.firmware.emulator import PATIENCE_S
from sim.tests.firmware.library import firmware
from sim.tests.firmware.model_core import Firmware, ModelCore
from sim.tests.firmware.test_application import Sensor
from sim.tests.firmware.test_estimates import counts_of

from arctrue.cli import main
from arctrue.device import console
from arctrue.device.console import TelemetryLine
from arctrue.device.recorder import Recorder
from arctrue.measurement import MeasurementSet, Reference, Table, read_measurement_set
from arctrue.metrology import trend

COUNTS = counts_of(samples=600)
ANGLES = COUNTS * (2 * np.pi / (1 << 24))


class Device(threading.Thread):
    """A device: the firmware with a model of the core, which delivers a turn when a capture
    starts."""

    @contextmanager
    def running(self, monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
        """Run the device's thread until the block ends."""
        # The firmware is compiled here, if needed, before any test waits for an answer.
        firmware()
        monkeypatch.setattr(console.Console.command, "__defaults__", (PATIENCE_S,))
        self.start()
        yield
        self.stop()

    def stop(self) -> None:
        """End the device's thread. After that, a test may use the firmware itself."""
        self.ended = True
        self.join(PATIENCE_S)
        assert not self.is_alive()

    def __init__(self) -> None:
        super().__init__(daemon=True)
        self.end, self.far = pty.openpty()
        tty.setraw(self.far)
        os.set_blocking(self.end, False)
        self.port = os.ttyname(self.far)
        self.ended = False
        self.with_sensor = False
        self.bad_turns = False
        self.moved_counts = 0
        self.growing_counts = 0.0
        self.turns = 0

    def run(self) -> None:
        made = Firmware(ModelCore())
        self.attach(made)
        made.library.application_start(made.application)
        made.core.see_index()
        self.sensor = Sensor(made) if self.with_sensor else None
        while not self.ended:
            try:
                said = made.send(self.received(os.read(self.end, 256)))
            except OSError:  # no data was sent, or no program has the port open
                said = ""
                time.sleep(0.002)
            if made.phase == "capture" and not made.core.get("status"):
                self.turns += 1
                counts = COUNTS + self.moved_counts * self.turns
                counts += np.rint(self.growing_counts * self.turns * np.cos(3 * ANGLES)).astype(int)
                counts[0, 300:] += 10**6 * self.bad_turns
                made.core.hand_over(counts)
            self.tell(said + made.step())

    def attach(self, made: Firmware) -> None:
        """Attach further parts of the board, before the firmware starts."""

    def received(self, data: bytes) -> bytes:
        """Return the part of ``data`` that the serial line delivers."""
        return data

    def tell(self, said: str) -> None:
        data = said.encode()
        while data and not self.ended:
            try:
                data = data[os.write(self.end, data) :]
            except BlockingIOError:
                time.sleep(0.001)


@pytest.fixture(params=[False, True], ids=["without a sensor", "with a sensor"])
def device(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> Iterator[Device]:
    made = Device()
    made.with_sensor = request.param
    with made.running(monkeypatch):
        yield made


def test_a_capture_becomes_a_measurement_set(device: Device, tmp_path: Path) -> None:
    done = CliRunner().invoke(
        main, ["capture", device.port, str(tmp_path / "set"), "--timeout", str(PATIENCE_S)]
    )
    assert done.exit_code == 0, done.output
    measurement = read_measurement_set(tmp_path / "set")
    assert measurement.capture is not None
    np.testing.assert_array_equal(measurement.capture.head1_counts, COUNTS[0])
    np.testing.assert_array_equal(measurement.capture.head2_counts, COUNTS[1])
    assert measurement.table.counts_per_rev == 1 << 24
    if device.with_sensor:
        assert measurement.capture.temperature_c is not None
        assert set(measurement.capture.temperature_c) == {40.0}
    else:
        assert measurement.capture.temperature_c is None


def test_turns_are_shown_and_recorded(device: Device, tmp_path: Path) -> None:
    record, sets = tmp_path / "turns.sqlite", tmp_path / "sets"
    arguments = [device.port, "--turns", "3", "--record", str(record), "--sets", str(sets)]
    done = CliRunner().invoke(main, ["monitor", *arguments])
    assert done.exit_code == 0, done.output
    assert " none " in done.output or " not_better " in done.output
    assert " 32.99999" in done.output or " 33.00000" in done.output
    with sqlite3.connect(record) as database:
        turns = database.execute("SELECT temperature_c FROM turn").fetchall()
        assert turns == [(40.0 if device.with_sensor else None,)] * 3
        (amplitude,) = database.execute(
            "SELECT amplitude_arcsec FROM harmonic WHERE harmonic_order = 1 LIMIT 1"
        ).fetchone()
    assert amplitude == pytest.approx(150.0, abs=0.1)
    (folder,) = sets.iterdir()
    assert read_measurement_set(folder).capture is not None


def test_a_record_of_an_older_version_is_continued(tmp_path: Path) -> None:
    file = tmp_path / "turns.sqlite"
    Recorder(file).close()
    with sqlite3.connect(file) as database:
        database.execute("ALTER TABLE turn DROP COLUMN temperature_c")
    recorder = Recorder(file)
    recorder.add(
        TelemetryLine({"turn": 1, "result": "kept", "reason": "none", "temperature_c": 51.5})
    )
    recorder.close()
    with sqlite3.connect(file) as database:
        assert database.execute("SELECT temperature_c FROM turn").fetchall() == [(51.5,)]


def test_a_refused_turn_is_shown(device: Device) -> None:
    device.bad_turns = True
    done = CliRunner().invoke(main, ["monitor", device.port, "--turns", "2"])
    assert done.exit_code == 0, done.output
    assert "refused  jump" in done.output


def test_an_order_that_grows_is_reported(device: Device, monkeypatch: pytest.MonkeyPatch) -> None:
    """The monitor reports order 3, which grows by 1″ per turn. The test is short because the
    monitor uses blocks of one turn."""
    device.growing_counts = 1.0 / 0.0772
    quick = functools.partial(trend.TrendWatch, block_turns=1)
    monkeypatch.setattr(trend, "TrendWatch", quick)
    done = CliRunner().invoke(main, ["monitor", device.port, "--turns", "20"])
    assert done.exit_code == 0, done.output
    assert re.search(r"order 3 changes by [4-9](\.\d)?″ in 7 turns", done.output), done.output
    done = CliRunner().invoke(main, ["monitor", device.port, "--turns", "9", "--trend", "50"])
    assert "trend" not in done.output


def test_captures_are_added_to_a_set(device: Device, tmp_path: Path) -> None:
    words = [device.port, str(tmp_path / "set"), "--timeout", str(PATIENCE_S), "--append"]
    device.moved_counts = 5  # the table has moved between two turns
    assert CliRunner().invoke(main, ["capture", *words]).exit_code == 0
    done = CliRunner().invoke(main, ["capture", *words])
    assert done.exit_code == 0, done.output
    assert "because the pause is not known" in done.output
    found = read_measurement_set(tmp_path / "set").capture
    assert found is not None
    assert np.unique(found.run).size == 2
    assert found.head1_counts.size == 2 * COUNTS.shape[1]
    again = CliRunner().invoke(main, ["capture", *words[:-1]])
    assert again.exit_code == 2
    assert "--append" in again.output


def test_a_further_capture_is_what_was_asked_for_or_refused(device: Device, tmp_path: Path) -> None:
    folder = tmp_path / "set"
    words = [device.port, str(folder), "--timeout", str(PATIENCE_S), "--append"]
    early = CliRunner().invoke(main, ["capture", *words, "--next", "speed"])
    assert early.exit_code == 2
    assert "holds no set yet" in early.stderr
    assert CliRunner().invoke(main, ["capture", *words]).exit_code == 0
    device.moved_counts = 5  # the table has moved between two turns
    # The table turns in the same way as in the first capture.
    same = CliRunner().invoke(main, ["capture", *words, "--next", "speed"])
    assert same.exit_code == 1
    assert "1. turn the table up at" in same.stderr
    assert "error: refused: not the requested measurement (speed): it turns at" in same.stderr
    kept = read_measurement_set(folder).capture
    assert kept is not None
    assert np.unique(kept.run).size == 1
    cannot = CliRunner().invoke(main, ["capture", *words, "--next", "turns"])
    assert cannot.exit_code == 2
    assert "the device captures one turn" in cannot.stderr
    again = CliRunner().invoke(main, ["capture", *words, "--next", "again"])
    assert again.exit_code == 0, again.output
    assert "let the table stand still for ten minutes" in again.stderr
    grown = read_measurement_set(folder).capture
    assert grown is not None
    assert np.unique(grown.run).size == 2


def test_silence_is_followed_by_no_further_capture(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """With ``--sets --every 2``, the monitor captures a set before turns 1 and 3 of three turns,
    and makes no further capture while it waits for a late turn."""
    module = importlib.import_module("arctrue.cli.monitor")
    turns = iter([None, 1, None, 2, None, 3])
    captures: list[str] = []

    class Telemetry:
        def turn(self, _: float) -> TelemetryLine | None:
            number = next(turns)
            return None if number is None else TelemetryLine({"turn": number})

    def capture(port: str, *_: object) -> MeasurementSet:
        captures.append(port)
        return MeasurementSet(Table(), None, Reference(np.zeros(1), np.zeros(1)))

    monkeypatch.setattr(module, "watch_at", lambda _: Telemetry())
    monkeypatch.setattr(module, "_capture", capture)
    monkeypatch.setattr(module, "_row", str)
    monkeypatch.setattr(module, "write_dated_set", lambda *_: None)
    words = ["monitor", "port", "--turns", "3", "--sets", str(tmp_path / "sets"), "--every", "2"]
    done = CliRunner().invoke(main, words, catch_exceptions=False)
    assert done.exit_code == 0, done.output
    assert captures == ["port"] * 2


def test_sets_of_the_monitor_state_their_date_in_utc(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The monitor writes each capture with its date, which ``arctrue life`` needs, and with a name
    in UTC; two captures within one second become two sets."""
    module = importlib.import_module("arctrue.cli.monitor")
    made = MeasurementSet(Table(), None, Reference(np.zeros(1), np.zeros(1)))
    lines = iter(range(2))
    telemetry = SimpleNamespace(turn=lambda _: TelemetryLine({"turn": next(lines)}))
    monkeypatch.setattr(module, "watch_at", lambda _: telemetry)
    monkeypatch.setattr(module, "_capture", lambda *_: made)
    monkeypatch.setattr(module, "_row", str)
    words = ["monitor", "port", "--turns", "2", "--sets", str(tmp_path), "--every", "1"]
    start = datetime.now(UTC).replace(microsecond=0)
    done = CliRunner().invoke(main, words, catch_exceptions=False)
    assert done.exit_code == 0, done.output
    sets = sorted(tmp_path.iterdir())
    assert len(sets) == 2
    for path in sets:
        date = read_measurement_set(path).date
        assert date is not None
        assert start <= date <= datetime.now(UTC)
        assert path.name.startswith(f"{date:%Y%m%dT%H%M%SZ}")


def test_a_port_that_is_not_there(tmp_path: Path) -> None:
    for command in ("monitor", "capture", "probe", "save"):
        arguments = [str(tmp_path / "none"), *([str(tmp_path)] if command == "capture" else [])]
        done = CliRunner().invoke(main, [command, *arguments])
        assert done.exit_code == 2
        assert "cannot be opened" in done.output


def test_a_port_that_does_not_answer(monkeypatch: pytest.MonkeyPatch) -> None:
    near, far = pty.openpty()
    tty.setraw(far)
    monkeypatch.setattr(console.Console.command, "__defaults__", (0.3,))
    monkeypatch.setattr(console, "LATE_S", 0.3)
    done = CliRunner().invoke(main, ["monitor", os.ttyname(far)])
    assert done.exit_code == 2
    assert "no answer to 'telemetry on'" in done.output
    os.close(near)


@pytest.mark.parametrize(
    "spoiled",
    [
        b'{"turn":1,"reszlt":"applied","reason":"none"}',
        b'{"turn":"1","result":"applied","reason":"none"}',
        b'{"turn":1,"result":"kept","reason":"none","noise_arcsec":"0.1"}',
        b'{"turn":1,"result":"kept","reason":"none","harmonics":[[1,2.0]]}',
        b'{"turn":1,"result":',
    ],
)
def test_a_spoiled_line_is_one_turn_less(spoiled: bytes) -> None:
    """The console skips a damaged line of telemetry, even if the line is still valid JSON."""
    near, far = pty.openpty()
    tty.setraw(far)
    device = console.Console(os.ttyname(far), timeout_s=0.2)
    whole = b'{"turn":2,"result":"kept","reason":"none","further":1}'
    os.write(near, spoiled + b"\r\n" + whole + b"\r\n")
    turn = device.turn(10.0)
    assert turn is not None
    assert turn.fields["turn"] == 2
    device.close()
    os.close(near)
