"""Tests that commands reach a device through its daemon; the firmware answers at a
pseudo-terminal."""

from __future__ import annotations

import json
import os
import shutil
import socket
import sqlite3
import stat
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
import pytest
from sim.tests.cli.test_load import file_of
from sim.tests.cli.test_monitor import COUNTS, Device
from sim.tests.cli.test_probe import (
    CLOCK_HZ,
    FIRST_EDGE,
    LOST,
    TURN,
    ProbedDevice,
    QueueDevice,
    position_of,
    queued,
)
from sim.tests.command_line import arctrue
from sim.tests.device.daemon_process import (
    PATIENCE_S,
    Replay,
    announcement,
    daemon,
    line_of,
    until,
)

from arctrue.device.announcement import FOLDER_VARIABLE, Announcement, announce, announced
from arctrue.device.connection import Watch, ask, console_through, daemon_at
from arctrue.device.console import ConsoleError
from arctrue.device.daemon.captures import drop_oldest, mark_latest
from arctrue.device.daemon.console_rights import refusal_of
from arctrue.measurement import read_measurement_set


@pytest.fixture
def device(monkeypatch: pytest.MonkeyPatch) -> Iterator[Device]:
    made = Device()
    os.close(made.far)  # the daemon is a separate program, which opens the port itself
    with made.running(monkeypatch):
        yield made


def test_reading_commands_go_through_a_read_only_daemon(device: Device, tmp_path: Path) -> None:
    store, out = tmp_path / "store", tmp_path / "set"
    with daemon(device.port, store) as running:
        said = f"{device.port}: through its daemon (process {running.process.pid}, 127.0.0.1:"
        done = arctrue("capture", device.port, out, "--timeout", PATIENCE_S)
        assert done.exit_code == 0, done.output
        assert done.stderr.count(said) == 1
        capture = read_measurement_set(out).capture
        assert capture is not None
        np.testing.assert_array_equal(capture.head1_counts, COUNTS[0])
        done = arctrue("monitor", device.port, "--turns", 2, "--sets", tmp_path / "sets")
        assert done.exit_code == 0, done.output
        assert done.stderr.count(said) == 1
        assert len(list((tmp_path / "sets").iterdir())) == 1
        path = Path(ask(announcement(device.port), "capture", PATIENCE_S)["capture"])
        assert path.parent == (store / "captures").resolve()
        assert read_measurement_set(path).capture is not None
        done = arctrue("device", "status", device.port)
        assert "captures: 1" in done.output
        assert "latest turn: " in done.output


def test_what_changes_the_device_needs_allow_control(device: Device, tmp_path: Path) -> None:
    file = file_of(tmp_path, {1: (150.0, 0.4), 2: (6.0, 4.2)})
    with daemon(device.port, tmp_path / "store"):
        for words in (("load", device.port, file), ("save", device.port)):
            done = arctrue(*words)
            assert done.exit_code == 2, done.output
            assert "read-only; start arctrue device run with --allow-control" in done.output
    with daemon(device.port, tmp_path / "store", "--allow-control"):
        done = arctrue("load", device.port, file, "--timeout", PATIENCE_S)
        assert done.exit_code == 0, done.output
        assert "2 orders are loaded and active" in done.output


@pytest.mark.parametrize(
    "line",
    [
        b"status",
        b"heads",
        b"dump",
        b"dump rows 3 10",
        b"marker12.1",
        b"",
        b"help jump",
        b"show parameters",
    ],
)
def test_lines_that_read_are_passed_on(line: bytes) -> None:
    assert refusal_of(line) is None


@pytest.mark.parametrize(
    "line",
    [
        b"save",
        b"forget",
        b"set keep 0",
        b"telemetry off",
        b"flash erase 0",
        b"load begin 1 2",
        b"probe falling 1",
        b"status\x00save",
        b"dump rows 1 2 save",
        b"freeze on",
    ],
)
def test_lines_that_change_something_are_refused(line: bytes) -> None:
    assert refusal_of(line) is not None


def test_one_operator_at_a_time_and_a_token(
    replay: Replay, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with daemon(replay.port, tmp_path / "store"):
        found = announcement(replay.port)
        console = console_through(found)
        with pytest.raises(ConsoleError, match="in use by another program"):
            console_through(found)
        console.close()
        until(lambda: not ask(found, "status")["console_in_use"])
        console_through(found).close()
        with socket.create_connection((found.host, found.tcp_port)) as stranger:
            stranger.sendall(b'{"ask":"watch","token":"guessed"}\n')
            assert b"the token is wrong" in stranger.recv(4096)
        file = tmp_path / "store" / "token"
        assert stat.S_IMODE(file.stat().st_mode) == 0o600
        # Without announcements, as on another machine, a client needs the address and the token.
        monkeypatch.setenv("ARCTRUE_RUN", str(tmp_path / "elsewhere"))
        assert arctrue("device", "status", found.address).exit_code == 2
        monkeypatch.setenv("ARCTRUE_DEVICE_TOKEN", file.read_text().strip())
        done = arctrue("device", "status", found.address)
        assert done.exit_code == 0, done.output
        assert daemon_at("/dev/ttyUSB1") is None


def test_a_file_among_the_page_s_uploads_is_no_announcement(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A program finds the announcement that ``announce`` wrote for a user without a runtime folder,
    and ignores a file of the same form that somebody dropped into the page."""
    for name in (FOLDER_VARIABLE, "RUNTIME_DIRECTORY", "XDG_RUNTIME_DIR"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setenv("HOME", str(tmp_path))
    monkeypatch.setattr("arctrue.device.announcement.SYSTEM_FOLDER", tmp_path / "system")
    with socket.create_server(("127.0.0.1", 0)) as listening:
        number = listening.getsockname()[1]
        dropped = Announcement("/dev/dropped", "127.0.0.1", number, "token", 1)
        files = tmp_path / ".local" / "state" / "arctrue" / "page" / "0123456789abcdef" / "files"
        files.mkdir(parents=True)
        (files / "plan.json").write_bytes(msgspec.json.encode(dropped))
        assert announced("/dev/dropped") is None
        own = msgspec.structs.replace(dropped, port="/dev/own")
        announce(own)
        assert announced("/dev/own") == own
        # systemd makes one folder for each service.
        service = msgspec.structs.replace(dropped, port="/dev/service")
        (tmp_path / "system" / "table").mkdir(parents=True)
        (tmp_path / "system" / "table" / "x.json").write_bytes(msgspec.json.encode(service))
        assert announced("/dev/service") == service


def test_a_refusal_does_not_damage_a_line_of_the_device(replay: Replay, tmp_path: Path) -> None:
    """The daemon sends its refusal between two lines of the device, even if the refusal is ready in
    the middle of a line."""
    half = line_of(2)
    with daemon(replay.port, tmp_path):
        found = announcement(replay.port)
        with socket.create_connection((found.host, found.tcp_port)) as operator:
            operator.settimeout(PATIENCE_S)
            operator.sendall(json.dumps({"ask": "console", "token": found.token}).encode() + b"\n")
            lines = operator.makefile("rb")
            assert b"console" in lines.readline()
            replay.send(half[:20])
            assert lines.read(20) == half[:20]
            operator.sendall(b"save\r")
            # When this line reaches the device, the daemon has already processed (refused) the line
            # before.
            operator.sendall(b"status\r")
            asked = b""
            while b"status\r" not in asked:
                asked += replay.received.get(timeout=PATIENCE_S)
            replay.send(half[20:])
            assert lines.readline() == half[20:]
            assert lines.readline().startswith(b"error: read-only")


def test_earlier_turns_come_first_without_a_gap(replay: Replay, tmp_path: Path) -> None:
    with daemon(replay.port, tmp_path):
        for number in range(20):
            replay.turn(number)
        until(lambda: ask(announcement(replay.port), "status")["turns"] == 20)
        watch = Watch(announcement(replay.port), latest=15)
        replay.turn(20)
        turns = [watch.turn(PATIENCE_S) for _ in range(16)]
        assert [turn.fields["turn"] for turn in turns if turn] == list(range(5, 21))
        assert turns[0] is not None
        assert turns[0].fields["harmonics"] == [[1, 150.0, 0.4, 0.01, 1]]


def test_an_event_keeps_characters_beyond_ascii(replay: Replay, tmp_path: Path) -> None:
    text = "0.12″ more, in /home/müller/set"
    with daemon(replay.port, tmp_path):
        watch = Watch(announcement(replay.port))
        ask(announcement(replay.port), "life", alarms={"hysteresis.a": text})
        event = watch.event(PATIENCE_S)
        while event is not None and event["event"] != "life":
            event = watch.event(PATIENCE_S)
        assert event is not None
        assert text in event["text"]
        assert event["state"]["machine_alarms"] == {"hysteresis.a": text}


def test_edges_of_the_probe_are_recorded(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """The daemon records the edges of the probe and counts the missed ones. A new edge comes after
    each read of the latch; twice, three edges come at once, of which two are missed."""
    device = ProbedDevice()
    os.close(device.far)
    with (
        device.running(monkeypatch),
        daemon(device.port, tmp_path, "--probe-every", "0.01", "--no-alarm-capture"),
    ):
        watch = Watch(announcement(device.port))
        found: list[dict[str, Any]] = []

        def more(count: int) -> None:
            while len(found) < count:
                event = watch.event(PATIENCE_S)
                assert event is not None
                found.extend([event] if event["event"] == "probe" else [])

        more(6)
        # While an operator captures a set, the daemon still counts the edges.
        assert arctrue("capture", device.port, tmp_path / "set").exit_code == 0
        more(12)
        state = ask(announcement(device.port), "status")
    assert state["probe_edges"] >= 12
    assert state["probe_missed"] >= 4
    edge = None
    for event in found:
        number = (event["edge"] - FIRST_EDGE) % (1 << 16)
        assert event["position_counts"] == position_of(number)
        assert event["angle_deg"] == position_of(number) % TURN / TURN * 360.0
        assert event["time_s"] == pytest.approx((50_000_000 * number + (1 << 33)) / CLOCK_HZ)
        if edge is not None:
            assert event["missed"] == (event["edge"] - edge) % (1 << 16) - 1
        edge = event["edge"]
    with sqlite3.connect(tmp_path / "telemetry.sqlite") as database:
        rows = database.execute("SELECT edge, position_counts, missed FROM edge ORDER BY id")
        recorded = rows.fetchall()
    shown = [(event["edge"], event["position_counts"], event["missed"]) for event in found]
    place = recorded.index(shown[0])
    assert recorded[place : place + len(shown)] == shown


def test_every_event_of_the_queue_is_recorded(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    """The daemon records two hundred events, which come in bursts, except four that the gateware
    loses; gaps in the numbers of the events show the loss."""
    device = QueueDevice()
    os.close(device.far)
    with (
        device.running(monkeypatch),
        daemon(device.port, tmp_path, "--probe-every", "0.01", "--no-alarm-capture"),
    ):
        found = announcement(device.port)
        until(lambda: device.bursts == 4 and not device.core.events)
        until(lambda: ask(found, "status")["probe_edges"] == 200 - len(LOST))
        assert ask(found, "status")["probe_missed"] == len(LOST)
        # A read-only console can also read events from the queue; the daemon records these events,
        # too.
        console = console_through(found)
        assert console.command("probe events") == []
        console.close()
    with sqlite3.connect(tmp_path / "telemetry.sqlite") as database:
        columns = "edge, kind, time_s, position_counts, missed"
        rows = database.execute(f"SELECT {columns} FROM edge ORDER BY id").fetchall()
    numbers = [number for number in range(200) if number not in LOST]
    for row, number in zip(rows, numbers, strict=True):
        edge, kind, clocks, position, _ = queued(number)
        assert row[:2] == (edge, kind)
        assert row[2] == pytest.approx(clocks / CLOCK_HZ, abs=1e-9)
        assert row[3:] == (position, len(LOST) * (number == LOST[-1] + 1))


class AlarmedDevice(Device):
    """A device whose telemetry has, after some turns, the alarm for too much noise."""

    alarmed = False

    def tell(self, said: str) -> None:
        super().tell(said.replace('"alarms":[]', '"alarms":["noise"]') if self.alarmed else said)


def test_a_new_alarm_takes_one_capture(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    device = AlarmedDevice()
    os.close(device.far)
    with device.running(monkeypatch), daemon(device.port, tmp_path) as running:
        until(lambda: ask(announcement(device.port), "status")["turns"] > 2)
        assert not list((tmp_path / "captures").iterdir())
        device.alarmed = True
        running.heard("new alarm: noise")
        running.heard("captured: ")
        device.alarmed = False
        until(lambda: not ask(announcement(device.port), "status")["alarms"])
        device.alarmed = True
        until(lambda: sum("new alarm: noise" in line for line in running.said) == 2)
        # The next alarm comes before the end of the pause between captures, so that it starts no
        # second capture.
        (path,) = (tmp_path / "captures").iterdir()
        assert path.name.endswith("-alarm")


@pytest.mark.large
def test_captures_are_taken_on_a_schedule(device: Device, tmp_path: Path) -> None:
    with daemon(device.port, tmp_path, "--capture-every", "0.001", "--no-alarm-capture") as running:
        running.heard("captured: ")
    names = [path.name for path in (tmp_path / "captures").iterdir()]
    assert names[0].endswith("-schedule")


def test_the_oldest_captures_are_deleted_and_other_folders_stay(tmp_path: Path) -> None:
    for name in ("20260101T000000Z-alarm", "20260102T000000Z-2-schedule", "20260103T000000Z-asked"):
        (tmp_path / name).mkdir()
        mark_latest(tmp_path / name)
    (tmp_path / "mine").mkdir()
    drop_oldest(tmp_path, 1)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["20260103T000000Z-asked", "mine"]


def test_a_capture_after_the_clock_was_set_back_is_not_the_oldest(tmp_path: Path) -> None:
    """The system's clock sets the time of a folder and the time in its name. After the clock was
    set back by a year, both are earlier for a new capture than for the captures before; the daemon
    must not delete the new capture as the oldest."""
    taken = ["20270101T000000Z-alarm", "20260101T000000Z-asked", "20260101T000100Z-schedule"]
    for number, name in enumerate(taken):
        (tmp_path / name).mkdir()
        back_s = 1.8e9 - 3.15e7 * (number > 0) + 60.0 * number
        os.utime(tmp_path / name, (back_s, back_s))
        mark_latest(tmp_path / name)
        drop_oldest(tmp_path, 2)
    assert sorted(path.name for path in tmp_path.iterdir()) == sorted(taken[1:])


def test_systemd_hears_that_it_is_ready_and_alive(
    replay: Replay, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    name = tmp_path / "notify"
    manager = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
    manager.bind(str(name))
    manager.settimeout(PATIENCE_S)
    monkeypatch.setenv("NOTIFY_SOCKET", str(name))
    monkeypatch.setenv("WATCHDOG_USEC", "200000")
    heard: list[str] = []

    def hear(text: str) -> None:
        while not any(line.startswith(text) for line in heard):
            heard.extend(manager.recv(4096).decode().splitlines())

    with daemon(replay.port, tmp_path / "store") as running:
        hear("READY=1")
        heard.clear()
        hear("WATCHDOG=1")
        heard.clear()
        hear("WATCHDOG=1")
        running.process.terminate()
        assert running.process.wait(PATIENCE_S) == 0
        hear("STOPPING=1")
    manager.close()
    assert not list((tmp_path / "run").iterdir()), (
        "expected that the daemon deletes its announcement"
    )


@pytest.mark.skipif(shutil.which("systemd-analyze") is None, reason="systemd is not installed")
def test_systemd_accepts_the_unit(tmp_path: Path) -> None:
    assert arctrue("device", "unit", tmp_path).exit_code == 0
    unit = tmp_path / "arctrue-device@.service"
    done = subprocess.run(
        [
            "systemd-analyze",
            "verify",
            "--man=no",
            unit.rename(tmp_path / "arctrue-device@x.service"),
        ],
        capture_output=True,
        text=True,
        check=False,
    )
    complaints = [line for line in done.stderr.splitlines() if "arctrue-device" in line]
    assert complaints == []


def test_a_program_in_a_home_folder_is_no_program_of_a_service(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The unit hides home folders from the service and gives it a user of its own."""
    monkeypatch.setattr(sys, "executable", "/home/anna/venv/bin/python")
    done = arctrue("device", "unit", tmp_path)
    assert done.exit_code == 0, done.output
    said = " ".join(done.stderr.split())
    assert "/home/anna/venv/bin/arctrue: a service cannot read home folders" in said
    monkeypatch.setattr(sys, "executable", "/opt/arctrue/bin/python")
    assert arctrue("device", "unit", tmp_path).stderr == ""


def test_the_unit_and_the_rule_name_this_program_and_one_link(tmp_path: Path) -> None:
    done = arctrue("device", "unit", tmp_path)
    assert done.exit_code == 0, done.output
    unit = (tmp_path / "arctrue-device@.service").read_text()
    (start,) = [line for line in unit.splitlines() if line.startswith("ExecStart=")]
    program = Path(start.removeprefix("ExecStart=").split()[0])
    assert os.access(program, os.X_OK)
    assert "Type=notify" in unit
    rules = (tmp_path / "70-arctrue.rules").read_text()
    assert 'SYMLINK+="arctrue"' in rules
