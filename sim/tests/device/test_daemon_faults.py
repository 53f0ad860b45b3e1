"""Tests that a daemon survives faults of the port, the device, the disk, the clock and its
clients."""

from __future__ import annotations

import asyncio
import json
import os
import signal
import socket
import sqlite3
import subprocess
import sys
import termios
import threading
import time
from pathlib import Path

import pytest
import serial
from sim.tests.command_line import arctrue
from sim.tests.device.daemon_process import (
    PATIENCE_S,
    PROGRAM,
    Replay,
    announcement,
    daemon,
    line_of,
    until,
)

from arctrue.device import port
from arctrue.device.connection import Watch, ask
from arctrue.device.daemon import serial_link, server
from arctrue.device.daemon.serial_link import SerialLink
from arctrue.device.lines import LONGEST_LINE, LineAssembler, TelemetryLine, telemetry_of
from arctrue.device.recorder import Recorder, Retention, read_turns


def numbers(file: Path) -> list[int]:
    return [turn.fields["turn"] for turn in read_turns(file)]


def kept(store: Path, count: int) -> list[int]:
    file = store / "telemetry.sqlite"
    until(lambda: len(numbers(file)) >= count, lambda: str(numbers(file)))
    return numbers(file)


def test_half_lines_and_garbage_cost_their_own_turn_alone(replay: Replay, tmp_path: Path) -> None:
    with daemon(replay.port, tmp_path):
        watch = Watch(announcement(replay.port))
        replay.turn(1)
        half = line_of(2)
        replay.send(half[:20])
        time.sleep(0.2)
        replay.send(half[20:])
        replay.send(line_of(3)[:30] + b"\r\n" + bytes(range(128, 256)) + b"\x00\n")
        replay.send(b'{"turn":1e999}\n{"turn":' + b"9" * 400 + b',"result":"","reason":""}\n')
        replay.send(b"{" + b"x" * (LONGEST_LINE + 10) + b"\n")
        replay.turn(4)
        assert kept(tmp_path, 3) == [1, 2, 4]
        seen = [watch.turn(PATIENCE_S) for _ in range(3)]
        assert [turn.fields["turn"] for turn in seen if turn] == [1, 2, 4]
        state = ask(announcement(replay.port), "status")
        assert (state["damaged_lines"], state["too_long_lines"]) == (3, 1)


def test_a_pulled_port_is_opened_again(tmp_path: Path) -> None:
    """The daemon opens a lost port again. The port's name is a link, as udev makes it, which leads
    to another device after the fault."""
    first, link = Replay(), tmp_path / "arctrue"
    link.symlink_to(first.port)
    with daemon(str(link), tmp_path / "store") as running:
        watch = Watch(announcement(str(link)))
        first.turn(1)
        kept(tmp_path / "store", 1)
        link.unlink()
        first.pull()
        running.heard("lost: ")
        second = Replay()
        link.symlink_to(second.port)
        # The board was switched off, so that telemetry is off after its start.
        asked = b""
        while b"telemetry on\r" not in asked:
            asked += second.received.get(timeout=PATIENCE_S)
        second.turn(0)
        assert kept(tmp_path / "store", 2) == [1, 0]
        running.heard("the board has started again")
        assert [turn.fields["turn"] for turn in (watch.turn(9.0), watch.turn(9.0)) if turn] == [
            1,
            0,
        ]
        with sqlite3.connect(tmp_path / "store" / "telemetry.sqlite") as database:
            kinds = [row[0] for row in database.execute("SELECT kind FROM event ORDER BY id")]
        assert kinds == ["port", "port", "port", "restart"]


@pytest.mark.parametrize("place", ["_reset_input_buffer", "_update_dtr_state", "keep_others_out"])
def test_an_error_of_usb_while_the_port_is_opened_again_is_retried(
    place: str, replay: Replay, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The link opens a lost port again after errors that pyserial and the kernel raise while a USB
    device is enumerated: termios.error from tcflush, plain OSError from ioctl."""
    changes: list[bool] = []
    errors = iter([termios.error(5, "Input/output error"), OSError(71, "Protocol error")])

    async def faulty() -> None:
        link = SerialLink(replay.port, 115_200, lambda _: None, lambda up, _: changes.append(up))
        link.open()
        owner = port if place == "keep_others_out" else serial.Serial
        known = getattr(owner, place)

        def fails(*arguments: object) -> None:
            for error in errors:
                raise error
            known(*arguments)

        monkeypatch.setattr(owner, place, fails)
        task = asyncio.get_running_loop().create_task(link.keep_open())
        link._lose("the test pulled it")
        async with asyncio.timeout(PATIENCE_S):
            while changes != [True, False, True]:
                assert not task.done(), task.exception()
                await asyncio.sleep(0.01)
        task.cancel()
        link.close()

    monkeypatch.setattr(serial_link, "FIRST_WAIT_S", 0.01)
    asyncio.run(faulty())
    assert next(errors, None) is None


@pytest.mark.large
def test_ten_thousand_lines_of_600_bytes_a_minute(replay: Replay, tmp_path: Path) -> None:
    """For six seconds at the highest rate, the daemon records every line and sends it to a
    watcher. A terminal buffers only 4 KB, so that a slow daemon delays the test's writes."""
    count, rate = 1000, 10_000 / 60.0
    padded = [line_of(number, pad="") for number in range(count)]
    lines = [line_of(n, pad="x" * (600 - len(line))) for n, line in enumerate(padded)]
    assert {len(line) for line in lines} == {600}
    with daemon(replay.port, tmp_path):
        watch = Watch(announcement(replay.port))
        start = time.monotonic()
        for number, line in enumerate(lines):
            time.sleep(max(start + number / rate - time.monotonic(), 0.0))
            replay.send(line)
        assert kept(tmp_path, count) == list(range(count))
        turns = [watch.turn(PATIENCE_S) for _ in range(count)]
        assert [turn.fields["turn"] for turn in turns if turn] == list(range(count))


def test_a_second_daemon_is_refused(replay: Replay, tmp_path: Path) -> None:
    with daemon(replay.port, tmp_path / "first") as running:
        words = [sys.executable, "-c", PROGRAM, "device", "run", replay.port]
        words += ["--store", str(tmp_path / "second"), "--tcp-port", "0"]
        done = subprocess.run(words, capture_output=True, text=True, check=False, timeout=60)
        assert done.returncode == 2
        assert f"{replay.port}: is in use by " in done.stderr
        assert f"(process {running.process.pid})" in done.stderr
        replay.turn(1)
        assert kept(tmp_path / "first", 1) == [1]


def test_a_second_device_needs_a_store_of_its_own(replay: Replay, tmp_path: Path) -> None:
    """Two daemons of two devices do not write into one record. A killed daemon leaves its store
    free."""
    other = Replay()
    words = [sys.executable, "-c", PROGRAM, "device", "run", other.port]
    words += ["--store", str(tmp_path), "--tcp-port", "0"]
    with daemon(replay.port, tmp_path) as running:
        done = subprocess.run(words, capture_output=True, text=True, check=False, timeout=60)
        assert done.returncode == 2
        owner = f"arctrue device run {replay.port} (process {running.process.pid})"
        said = " ".join(done.stderr.split())
        assert f"{tmp_path}: is in use by {owner}; name another folder: --store" in said
        other.turn(7)
        replay.turn(1)
        assert kept(tmp_path, 1) == [1]
    with daemon(other.port, tmp_path):
        pass


SMALL_DISC = """
import resource
resource.setrlimit(resource.RLIMIT_FSIZE, (300_000, resource.RLIM_INFINITY))
from arctrue.device.daemon import daemon
daemon.RETRY_RECORD_S = 0.2
"""


def test_a_full_disc_is_reported_and_telemetry_goes_on(replay: Replay, tmp_path: Path) -> None:
    """The daemon reports a full disk and continues. At first no file can grow beyond 300 kB, as on
    a full disk; then the test removes this limit."""
    import resource

    wide = [[order, 1.0, 0.5, 0.01, 1] for order in range(1, 41)]
    with daemon(replay.port, tmp_path, before=SMALL_DISC) as running:
        watch = Watch(announcement(replay.port))
        number = 0
        while not any("cannot be written" in line for line in running.said):
            assert number < 1000
            replay.turn(number, harmonics=wide)
            assert watch.turn(PATIENCE_S) is not None
            number += 1
        assert "telemetry continues" in "".join(running.said)
        replay.turn(number)
        turn = watch.turn(PATIENCE_S)
        assert turn is not None
        assert turn.fields["turn"] == number
        state = ask(announcement(replay.port), "status")
        assert state["recording"] is False
        assert state["unrecorded_turns"] >= 1
        # The test removes the limit, so that the daemon can write again.
        limit = (resource.RLIM_INFINITY, resource.RLIM_INFINITY)
        resource.prlimit(running.process.pid, resource.RLIMIT_FSIZE, limit)
        time.sleep(0.3)
        replay.turn(number + 1)
        running.heard("turns are recorded again")
        until(lambda: number + 1 in numbers(tmp_path / "telemetry.sqlite"))


def test_a_clock_that_is_set_back_is_stated_and_the_order_is_kept(tmp_path: Path) -> None:
    wall_s, steady_s = [10_000.0], [50.0]
    file = tmp_path / "turns.sqlite"
    recorder = Recorder(file, clock=lambda: wall_s[0], monotonic=lambda: steady_s[0])
    for number, set_by_s in ((1, 0.0), (2, -601.0), (3, 0.0)):
        wall_s[0] += 1.0 + set_by_s
        steady_s[0] += 1.0
        recorder.add(TelemetryLine({"turn": number, "result": "kept", "reason": "none"}))
    recorder.close()
    assert numbers(file) == [1, 2, 3]
    with sqlite3.connect(file) as database:
        events = database.execute("SELECT after_turn, kind, text FROM event").fetchall()
    assert events == [(1, "clock", "the system's clock was set back by 601 s")]
    # The daemon starts again while the clock shows a time before the latest turn.
    late = Recorder(file, clock=lambda: 1.0)
    late.add(TelemetryLine({"turn": 4, "result": "kept", "reason": "none"}))
    late.close()
    assert numbers(file) == [1, 2, 3, 4]
    with sqlite3.connect(file) as database:
        (text,) = database.execute("SELECT text FROM event ORDER BY id DESC LIMIT 1").fetchone()
    assert "a time before the latest turn" in text


def test_a_client_that_never_reads_is_dropped(replay: Replay, tmp_path: Path) -> None:
    with daemon(replay.port, tmp_path):
        found = announcement(replay.port)
        deaf = socket.socket()
        deaf.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
        deaf.connect((found.host, found.tcp_port))
        deaf.sendall(json.dumps({"ask": "watch", "token": found.token}).encode() + b"\n")
        watch = Watch(found)
        seen, number = [], 0
        while ask(found, "status")["dropped_clients"] == 0:
            for _ in range(20):
                replay.turn(number, pad="x" * 50_000)
                number += 1
                turn = watch.turn(PATIENCE_S)
                assert turn is not None
                seen.append(turn.fields["turn"])
            assert number < 2000
        # The other client received every turn.
        assert seen == list(range(number))
        deaf.close()


@pytest.mark.parametrize("after_s", [0.05, pytest.param(0.21, marks=pytest.mark.large), 0.4])
def test_a_killed_daemon_loses_the_last_turn_at_most(
    replay: Replay, tmp_path: Path, after_s: float
) -> None:
    """After a kill, the record is intact and contains every turn that a watcher had received."""
    stopped = threading.Event()

    def send() -> None:
        number = 0
        while not stopped.is_set():
            replay.turn(number)
            number += 1
            time.sleep(0.001)

    with daemon(replay.port, tmp_path) as running:
        watch = Watch(announcement(replay.port))
        sender = threading.Thread(target=send, daemon=True)
        sender.start()
        seen = [watch.turn(PATIENCE_S)]
        end = time.monotonic() + after_s
        while time.monotonic() < end:
            seen.append(watch.turn(PATIENCE_S))
        os.kill(running.process.pid, signal.SIGKILL)
        running.process.wait(PATIENCE_S)
        stopped.set()
    received = [turn.fields["turn"] for turn in seen if turn]
    recorded = numbers(tmp_path / "telemetry.sqlite")
    assert recorded == list(range(len(recorded)))
    assert received == recorded[: len(received)]
    with sqlite3.connect(tmp_path / "telemetry.sqlite") as database:
        assert database.execute("PRAGMA integrity_check").fetchone() == ("ok",)
        without = "SELECT count(*) FROM turn WHERE id NOT IN (SELECT turn FROM harmonic)"
        assert database.execute(without).fetchone() == (0,)
    # Nothing answers at the address that the killed daemon announced; a new daemon continues the
    # record.
    assert arctrue("device", "status", replay.port).exit_code == 2
    with daemon(replay.port, tmp_path):
        replay.turn(5000)
        until(lambda: 5000 in numbers(tmp_path / "telemetry.sqlite"))


def test_the_record_keeps_to_its_limits(tmp_path: Path) -> None:
    wide = [[order, 1.0, 0.5, 0.01, 1] for order in range(1, 41)]
    now = [1.0e9]
    file = tmp_path / "turns.sqlite"
    recorder = Recorder(file, Retention(1.0, 1.0), clock=lambda: now[0], monotonic=lambda: now[0])
    for number in range(2000):
        now[0] += 0.1
        fields = {"turn": number, "result": "kept", "reason": "none", "harmonics": wide}
        recorder.add(TelemetryLine(fields))
    left = numbers(file)
    assert left == list(range(left[0], 2000))
    assert 0 < left[0] < 1900
    # the limit of 1 MB, plus the bytes that are written between two checks
    assert file.stat().st_size < 1.5e6
    now[0] += 2 * 86_400.0
    recorder.add(TelemetryLine({"turn": 2000, "result": "kept", "reason": "none"}))
    recorder.apply_retention()
    recorder.close()
    assert numbers(file) == [2000]


def test_a_clock_that_jumps_ahead_deletes_no_turn(tmp_path: Path) -> None:
    """A clock that is a year ahead for an hour makes no turn older than the limit of one day."""
    wall_s, steady_s = [1.0e9], [50.0]
    file = tmp_path / "turns.sqlite"
    recorder = Recorder(file, Retention(1.0), lambda: wall_s[0], lambda: steady_s[0])

    def wait(seconds: float, set_by_s: float = 0.0) -> None:
        steady_s[0] += seconds
        wall_s[0] += seconds + set_by_s
        recorder.add(TelemetryLine({"turn": len(kept_turns), "result": "kept", "reason": "none"}))
        kept_turns.append(len(kept_turns))
        recorder.apply_retention()

    kept_turns: list[int] = []
    for seconds, set_by_s in ((60.0, 0.0), (60.0, 3.15e7), (3600.0, 0.0), (60.0, -3.15e7)):
        wait(seconds, set_by_s)
        assert numbers(file) == kept_turns
    wait(2 * 86_400.0)
    recorder.close()
    # The turns with a date in the future stay until this date; the others were too old.
    assert numbers(file) == [1, 2, 4]


def test_a_deeply_nested_request_is_no_request() -> None:
    with pytest.raises(ValueError, match="expected an object"):
        server._request(b"[" * 60000 + b"\n")


def test_lines_are_the_same_however_they_arrive() -> None:
    data = b"ok\r\n" + line_of(1) + b"\xff\n" + b"y" * (2 * LONGEST_LINE) + b"\nend\n"
    whole = LineAssembler()
    expected = whole.add(data)
    assert expected[0] == "ok"
    assert expected[-1] == "end"
    for step in (1, 7, 4096):
        parts = LineAssembler()
        found = [x for at in range(0, len(data), step) for x in parts.add(data[at : at + step])]
        assert found == expected
        assert parts.too_long == whole.too_long == 1
    for number in ("NaN", "1e400", "-1e400"):  # a float64 ends at 1.8e308
        line = f'{{"turn":1,"result":"kept","reason":"none","time_s":{number}}}'
        assert telemetry_of(line) is None
