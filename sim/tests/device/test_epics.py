"""Tests a device's PVs with caproto, an independent implementation of Channel Access in
Python."""

from __future__ import annotations

import ctypes
import os
import socket
import sqlite3
import sys
import threading
import time
from collections.abc import Callable
from datetime import datetime
from pathlib import Path
from queue import SimpleQueue
from typing import Any

import numpy as np
import pytest
from sim.tests.device.daemon_process import (
    PATIENCE_S,
    Replay,
    announcement,
    daemon,
    until,
)
from sim.tests.device.epics_process import PREFIX, free_ports, pvs

from arctrue.device import epics_server
from arctrue.device.announcement import Announcement
from arctrue.device.connection import Watch, ask

client = pytest.importorskip("caproto.sync.client", reason="softioc has x86-64 wheels only")
import caproto  # noqa: E402


@pytest.fixture
def ports(monkeypatch: pytest.MonkeyPatch) -> dict[str, str]:
    """Set EPICS ports that no other program uses; give each test its own client sockets."""
    found = free_ports()
    for name, value in found.items():
        monkeypatch.setenv(name, value)
    monkeypatch.setattr(caproto, "bcast_socket", udp_socket)
    return found


def udp_socket() -> socket.socket:
    """Return a UDP socket at a port that no other socket uses. caproto's own socket allows reuse
    (SO_REUSEADDR).

    Linux may then choose a port that another such socket uses, for example the server's; the answer
    would go to that socket.
    """
    return socket.socket(socket.AF_INET, socket.SOCK_DGRAM)


def read(name: str, kind: str = "time") -> Any:
    """Return a PV, either with timestamp and severity (``time``) or with unit and limits
    (``control``)."""
    return client.read(f"{PREFIX}{name}", data_type=kind, timeout=20.0, repeater=False)


def shows(name: str, is_right: Callable[[Any], bool]) -> None:
    until(lambda: is_right(read(name)), lambda: f"{name}: {read(name)}")


def test_a_turn_becomes_pvs_with_unit_limits_severity_and_time(
    replay: Replay, tmp_path: Path, ports: dict[str, str]
) -> None:
    harmonics = [[1, 150.0, 0.4, 0.01, 1], [2, 6.25, -2.0, 0.02, 0]]
    with daemon(replay.port, tmp_path, "--no-alarm-capture") as running, pvs(replay.port):
        watch = Watch(announcement(replay.port))
        replay.turn(7, harmonics=harmonics, separation_deg=33.25)
        shows("Turn", lambda found: found.data[0] == 7)
        shows("HeadSeparation", lambda found: found.data[0] == 33.25)
        found = read("HeadSeparation")
        assert found.metadata.severity == 0
        event = watch.event(PATIENCE_S)
        assert event is not None
        # The daemon sends the event only after it has stored the turn in the record.
        assert 0.0 <= event["recorded_s"] - found.metadata.timestamp < 1.0
        shows("Amplitudes", lambda found: found.data.tolist() == [150.0, 6.25])
        shows("Uncertainties", lambda found: found.data.tolist() == [0.01, 0.02])
        # The device did not send a table temperature.
        shows("TableTemperature", lambda found: found.metadata.severity == 3)
        limits = read("DieTemperature", "control").metadata
        assert limits.units == b"degC"
        assert (limits.upper_warning_limit, limits.upper_alarm_limit) == (85.0, 100.0)
        replay.turn(8, temperature_c=90.0, alarms=["temperature"], separation_deg=33.25)
        shows("Turn", lambda found: found.data[0] == 8)
        shows("DieTemperature", lambda found: found.metadata.severity == 1)
        shows("Alarms", lambda found: found.metadata.severity == 2)
        assert bytes(read("Alarms").data).rstrip(b"\0") == b"temperature"
        # Without the daemon no value is valid.
        assert read("HeadSeparation").metadata.severity == 0
        running.process.kill()
        shows("HeadSeparation", lambda found: found.metadata.severity == 3)
        shows("Connected", lambda found: found.data[0] == 0)


def test_nobody_writes_unless_it_is_allowed(
    replay: Replay, tmp_path: Path, ports: dict[str, str]
) -> None:
    def write(name: str, value: float, *, notify: bool = True) -> str:
        """Write a PV and return the status of EPICS' answer, which comes after the write is
        processed."""
        asked = {"notify": notify, "timeout": 20.0, "repeater": False}
        found = client.write(f"{PREFIX}{name}", value, **asked)
        return str(found.status.name) if notify else ""

    with daemon(replay.port, tmp_path):
        with pvs(replay.port):
            for name in ("Capture", "Zero", "HeadSeparation", "DieTemperature.HIGH"):
                assert write(name, 1.0) == "ECA_NOWTACCESS"
        with pvs(replay.port, "--allow-control"):
            assert write("HeadSeparation", 1.0) == "ECA_NOWTACCESS"
            write("Capture", 1.0, notify=False)
            asks_for_a_capture(replay)


class ProbedReplay(Replay):
    """A device that answers requests for the probe's latch; the test sets the latched values.

    With ``has_queue`` the device has a queue, into which the test puts number, kind, time, position
    and angle of events.
    """

    def __init__(self, *, has_queue: bool = False) -> None:
        super().__init__()
        self.events: SimpleQueue[tuple[int, int, int, int, int]] | None = None
        if has_queue:
            self.events = SimpleQueue()
        self.latched = (65_535, 0, 0, 0)
        threading.Thread(target=self._answer, daemon=True).start()

    def _answer(self) -> None:
        begun = b""
        while True:
            *lines, begun = (begun + self.received.get()).split(b"\r")
            for line in lines:
                names = ("edges", "time_clocks", "position_counts", "angle_counts")
                latched = zip(names, self.latched, strict=True)
                answers = {
                    b"version": "clock_hz 100000000\r\n",
                    b"show parameters": "counts_per_rev 16777216\r\nlanes many\r\n",
                    b"probe": "".join(f"{name} {value}\r\n" for name, value in latched),
                }
                if self.events is not None:
                    answers[b"probe events"] = "".join(
                        f"event {' '.join(map(str, self.events.get()))}\r\n"
                        for _ in range(self.events.qsize())
                    )
                elif line == b"probe events":
                    self.send(b"error: the gateware is built without EVENTS\r\n")
                if line in answers:
                    self.send(answers[line].encode() + b"ok\r\n")


@pytest.mark.large
def test_edges_of_the_probe_count_from_the_zero_of_a_motor_record(
    tmp_path: Path, ports: dict[str, str]
) -> None:
    """The PV ProbeAngle counts from the zero of a motor record. Such a record writes the angle of
    the index into the PV Zero after its homing; here the test writes it."""
    device = ProbedReplay()
    with (
        daemon(device.port, tmp_path, "--probe-every", "0.01"),
        pvs(device.port, "--allow-control"),
    ):
        shows("Connected", lambda found: found.data[0] == 1)
        time.sleep(1.0)  # the first reading is not an edge
        device.latched = (1, 3 << 32, 5 * 2**24 + 2**22, 2**22)
        shows("ProbeEdge", lambda found: found.data[0] == 1)
        shows("ProbeAngle", lambda found: found.data[0] == 90.0)
        assert read("ProbeMissed").data[0] == 1
        assert read("ProbeTime").data[0] == (3 << 32) / 1e8
        assert read("ProbePosition").data[0] == 5 * 2**24 + 2**22
        assert read("ProbeAngle", "control").metadata.units == b"deg"
        with sqlite3.connect(tmp_path / "telemetry.sqlite") as database:
            ((recorded,),) = database.execute("SELECT recorded FROM edge").fetchall()
        moment = datetime.fromisoformat(recorded).timestamp()
        assert read("ProbeTime").metadata.timestamp == pytest.approx(moment, abs=1.0)
        client.write(f"{PREFIX}Zero", -12.5, notify=True, timeout=20.0, repeater=False)
        shows("ProbeAngle", lambda found: found.data[0] == 77.5)
        device.latched = (2, 4 << 32, 5 * 2**24 + 2**23, 2**23)
        shows("ProbeAngle", lambda found: found.data[0] == 167.5)


def test_the_zero_of_a_motor_record_outlives_both_programs(
    replay: Replay, tmp_path: Path, ports: dict[str, str]
) -> None:
    """A motor record writes its zero once, after its homing. Later servers of the PVs and later
    daemons still have it; the record states when it was written."""
    with daemon(replay.port, tmp_path), pvs(replay.port, "--allow-control"):
        shows("Connected", lambda found: found.data[0] == 1)
        client.write(f"{PREFIX}Zero", -123.4567891, notify=True, timeout=20.0, repeater=False)
        assert ask(announcement(replay.port), "status")["zero_deg"] == -123.4567891
    with daemon(replay.port, tmp_path), pvs(replay.port):
        shows("Connected", lambda found: found.data[0] == 1)
        assert read("Zero").data[0] == -123.4567891
    with sqlite3.connect(tmp_path / "telemetry.sqlite") as database:
        rows = database.execute("SELECT text FROM event WHERE kind = 'zero'").fetchall()
    assert rows == [("the zero was set: the index is at -123.4567891°",)]


def test_a_zero_that_is_written_while_the_former_one_is_sent_is_not_lost(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    unsent, sent = [1.0], []

    def ask_slowly(_daemon: object, _request: str, *, degrees: float) -> None:
        sent.append(degrees)
        if degrees == 1.0:
            unsent[:] = [2.0]

    monkeypatch.setattr(epics_server, "ask", ask_slowly)
    daemon = Announcement("/dev/none", "127.0.0.1", 1, "", 1)
    for _ in range(3):
        epics_server._send_zero(daemon, unsent, print)
    assert (sent, unsent) == ([1.0, 2.0], [])


def test_the_latest_events_are_waveforms(tmp_path: Path, ports: dict[str, str]) -> None:
    """The waveform PVs show the last 64 of 70 events, which come in two bursts; the record contains
    all 70."""
    device = ProbedReplay(has_queue=True)
    assert device.events is not None
    with daemon(device.port, tmp_path, "--probe-every", "0.01"), pvs(device.port):
        shows("Connected", lambda found: found.data[0] == 1)
        for first in (0, 40):
            for number in range(first, min(first + 40, 70)):
                device.events.put((number, 1 + number % 3, 1000 * number, number, 2**18 * number))
            last = min(first + 40, 70) - 1
            shows("ProbeEdge", lambda found, last=last: found.data[0] == last)
        latest = np.arange(6, 70)
        for name, wanted in (
            ("ProbeEdges", latest),
            ("ProbeTimes", latest / 1e5),
            ("ProbePositions", latest),
            ("ProbeAngles", latest * 360.0 / 64.0),
            ("ProbeKinds", 1 + latest % 3),
        ):
            np.testing.assert_allclose(read(name).data, wanted, rtol=1e-12)
        assert read("ProbeKind").data[0] == 1 + 69 % 3
    with sqlite3.connect(tmp_path / "telemetry.sqlite") as database:
        rows = database.execute("SELECT edge, kind, missed FROM edge ORDER BY id").fetchall()
    assert rows == [(number, 1 + number % 3, 0) for number in range(70)]


def asks_for_a_capture(replay: Replay) -> None:
    """Wait until the daemon begins a capture: its console sends a marker, whose answer synchronises
    the console with the device. This device never answers."""
    asked = b""
    while b"marker" not in asked:
        asked += replay.received.get(timeout=PATIENCE_S)


@pytest.mark.large
def test_nobody_writes_over_pvaccess_unless_it_is_allowed(
    replay: Replay, tmp_path: Path, ports: dict[str, str]
) -> None:
    """The client p4p, over PVAccess, reads the PVs, and may write the PV Capture only if writing is
    allowed."""
    p4p = pytest.importorskip("p4p.client.thread")

    def refused(client: Any, name: str, value: float) -> None:
        with pytest.raises(p4p.RemoteError, match=r"not permitted|putDisabled"):
            client.put(f"{PREFIX}{name}", value, timeout=20.0)

    with daemon(replay.port, tmp_path):
        with pvs(replay.port), p4p.Context("pva") as client:
            assert not bool(client.get(f"{PREFIX}Capture", timeout=20.0))
            for name in ("Capture", "Zero", "HeadSeparation", "DieTemperature.HIGH"):
                refused(client, name, 1.0)
        with pvs(replay.port, "--allow-control"), p4p.Context("pva") as client:
            refused(client, "HeadSeparation", 1.0)
            client.put(f"{PREFIX}Capture", 1, timeout=20.0)
            asks_for_a_capture(replay)


def test_after_a_reconnection_values_are_valid_before_connected(
    tmp_path: Path, ports: dict[str, str]
) -> None:
    """After a reconnection the PVs are valid again although a table at rest sends no turn; the
    latest turn keeps its time."""
    first, link = Replay(), tmp_path / "arctrue"
    link.symlink_to(first.port)
    with daemon(str(link), tmp_path / "store") as running, pvs(str(link)):
        first.turn(7, separation_deg=33.25)
        shows("Connected", lambda found: found.data[0] == 1)
        shows("Turn", lambda found: found.data[0] == 7)
        before = read("HeadSeparation").metadata.timestamp
        link.unlink()
        first.pull()
        running.heard("lost: ")
        shows("HeadSeparation", lambda found: found.metadata.severity == 3)
        second = Replay()
        link.symlink_to(second.port)
        shows("Connected", lambda found: found.data[0] == 1)
        for name in ("HeadSeparation", "Turn", "Amplitudes", "Alarms"):
            assert read(name).metadata.severity == 0, name
        assert read("HeadSeparation").metadata.timestamp == before
        second.turn(8, separation_deg=33.5)
        shows("HeadSeparation", lambda found: found.data[0] == 33.5)


@pytest.mark.large
def test_alarms_of_the_machine_s_history_are_in_the_pv(
    replay: Replay, tmp_path: Path, ports: dict[str, str]
) -> None:
    """The PV Alarms lists the alarms that ``arctrue life`` sends to the daemon, after the device's
    own alarms; it still lists them after the daemon has restarted."""

    def text_of(found: Any) -> bytes:
        return bytes(found.data).rstrip(b"\0")

    with pvs(replay.port):
        with daemon(replay.port, tmp_path, "--no-alarm-capture"):
            ask(announcement(replay.port), "life", alarms={"hysteresis.a": "ALARM: it passes."})
            replay.turn(1, alarms=["noise"])
            shows("Alarms", lambda found: text_of(found) == b"noise, life: hysteresis.a")
            assert read("Alarms").metadata.severity == 2
            replay.turn(2)
            shows("Alarms", lambda found: text_of(found) == b"life: hysteresis.a")
        shows("Connected", lambda found: found.data[0] == 0)
        with daemon(replay.port, tmp_path):
            shows("Connected", lambda found: found.data[0] == 1)
            assert text_of(read("Alarms")) == b"life: hysteresis.a"
            ask(announcement(replay.port), "life", alarms={})
            shows("Alarms", lambda found: found.metadata.severity == 0)
            assert text_of(read("Alarms")) == b""


def socket_of(process: int, number: int) -> socket.socket:
    """Return a duplicate of a socket of another process. Raises OSError if the socket is closed."""
    pidfd_getfd = 438
    found = ctypes.CDLL(None, use_errno=True).syscall(
        pidfd_getfd, os.pidfd_open(process), number, 0
    )
    if found < 0:
        raise OSError(ctypes.get_errno(), os.strerror(ctypes.get_errno()))
    return socket.socket(fileno=found)


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="by calls of Linux")
def test_every_socket_is_of_this_machine_alone(
    replay: Replay, tmp_path: Path, ports: dict[str, str]
) -> None:
    """Each listening TCP socket and each UDP socket is bound to the loopback address or the
    loopback interface."""
    with daemon(replay.port, tmp_path), pvs(replay.port) as running:
        served = []
        for link in Path(f"/proc/{running.process.pid}/fd").iterdir():
            try:
                if not str(link.readlink()).startswith("socket:"):
                    continue
                found = socket_of(running.process.pid, int(link.name))
            except OSError:  # the server has closed the socket in the meantime
                continue
            with found:
                if found.family not in (socket.AF_INET, socket.AF_INET6):
                    continue
                device = found.getsockopt(socket.SOL_SOCKET, socket.SO_BINDTODEVICE, 16)
                address, port = found.getsockname()[:2]
                assert address == "127.0.0.1" or device.rstrip(b"\0") == b"lo", (address, port)
                served.append(str(port))
    # These ports serve Channel Access and the searches of PVAccess.
    assert {ports["EPICS_CA_SERVER_PORT"], ports["EPICS_PVA_BROADCAST_PORT"]} <= set(served)


def test_a_missing_pv_is_no_pv(ports: dict[str, str]) -> None:
    with pytest.raises(caproto.CaprotoTimeoutError):
        client.read(f"{PREFIX}Nothing", timeout=0.2, repeater=False)
