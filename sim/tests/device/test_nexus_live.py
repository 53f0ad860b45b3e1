"""Tests of the present day's file, which readers in other processes watch in HDF5's SWMR mode."""

from __future__ import annotations

import asyncio
import json
import os
import shutil
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
from sim.tests.command_line import arctrue
from sim.tests.device.daemon_process import PATIENCE_S, Replay, announcement, daemon, until
from sim.tests.device.test_nexus_days import DAYS, columns_of, opens

from arctrue.device.connection import ask
from arctrue.device.daemon.day_writer import DayWriter, DayWriterError
from arctrue.device.daemon.live_day import LiveDays
from arctrue.device.daemon.store_lock import StoreLock
from arctrue.device.lines import TelemetryLine
from arctrue.device.nexus_days import copy_of, day_file, turns_of_file
from arctrue.device.recorder import Recorder, Retention, last_turn, read_turns

READER = """
import json, sys, h5py
file = h5py.File(sys.argv[1], "r", swmr=True)
print("open", flush=True)
for line in sys.stdin:
    ids = file["entry/turns/id"]
    ids.refresh()
    count, answer = ids.shape[0], {}
    for name in json.loads(line):
        column = file["entry"][name]
        column.refresh()
        values = column[:count]
        answer[name] = values.astype(str).tolist() if values.dtype.kind == "S" else values.tolist()
    print(json.dumps(answer), flush=True)
"""
"""A reader that opens the file once. It refreshes ``id`` first, as docs/device-daemon.md states."""


class Watching:
    """A reader in another process."""

    def __init__(self, path: Path) -> None:
        self.process = subprocess.Popen(
            [sys.executable, "-c", READER, str(path)],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
        )
        assert self._line() == "open"

    def _line(self) -> str:
        assert self.process.stdout is not None
        return self.process.stdout.readline().strip()

    def read(self, *names: str) -> dict[str, list[Any]]:
        assert self.process.stdin is not None
        self.process.stdin.write(json.dumps(names) + "\n")
        self.process.stdin.flush()
        return dict(json.loads(self._line()))


@contextmanager
def watching(path: Path) -> Iterator[Watching]:
    reader = Watching(path)
    try:
        yield reader
    finally:
        reader.process.kill()
        reader.process.wait(PATIENCE_S)


def test_a_reader_that_opened_the_file_earlier_sees_new_turns(
    replay: Replay, tmp_path: Path
) -> None:
    files = tmp_path / "files"
    options = ("--files", str(files), "--files-every", "0.01")
    with daemon(replay.port, tmp_path / "store", *options) as running:
        replay.turn(0)
        running.heard(".nxs")
        (path,) = files.glob("*.nxs")
        with watching(path) as reader:
            for number in range(1, 4):
                replay.turn(number, temperature_c=40.0 + number)
                until(lambda number=number: number in reader.read("turns/turn")["turns/turn"])
            found = reader.read("turns/turn", "turns/temperature_c", "orders/amplitude")
    assert found["turns/turn"] == [0, 1, 2, 3]
    assert found["turns/temperature_c"] == [40.5, 41.0, 42.0, 43.0]
    assert found["orders/amplitude"] == [[150.0]] * 4


def test_a_reader_never_finds_half_a_turn(tmp_path: Path) -> None:
    """While turns are appended, every row up to the last id has all values of its turn."""
    machine = Machine(tmp_path)
    machine.add(0, temperature_c=0.0)
    machine.days.update()
    stopped = threading.Event()
    names = ("turns/id", "turns/turn", "turns/temperature_c", "turns/result", "orders/amplitude")
    seen: list[int] = []
    with watching(day_file(tmp_path, DAYS[0])) as reader:

        def read() -> None:
            while not stopped.is_set():
                found = reader.read(*names)
                count = len(found["turns/id"])
                seen.append(count)
                numbers = list(range(count))
                assert found["turns/id"] == [number + 1 for number in numbers]
                assert found["turns/turn"] == found["turns/temperature_c"] == numbers
                assert found["turns/result"] == ["kept"] * count
                assert found["orders/amplitude"] == [[1.0 * number] for number in numbers]

        with ThreadPoolExecutor(1) as pool:
            reading = pool.submit(read)
            try:
                for number in range(1, 121):
                    machine.add(number, temperature_c=float(number))
                    if number % 3 == 0:
                        machine.days.update()
                machine.days.update()
                until(lambda: reading.done() or 121 in seen)
            finally:
                stopped.set()  # the pool waits for the reader
            reading.result()
    assert len(set(seen)) > 5  # the reader saw states in between
    machine.days.close()


class Machine:
    """A record and its daily files, with a clock that the test sets. Another process reads the open
    file, because HDF5 shares an open file within a process."""

    def __init__(self, folder: Path, retention: Retention | None = None) -> None:
        self.record, self.files = folder / "telemetry.sqlite", folder
        self.now_s = datetime(2026, 3, 1, 22, tzinfo=UTC).timestamp()
        self.recorder = Recorder(self.record, retention, lambda: self.now_s, lambda: self.now_s)
        self.days = LiveDays(self.record, folder, lambda: self.now_s)

    def add(self, *numbers: int, orders: tuple[int, ...] = (1,), **fields: Any) -> None:
        for number in numbers:
            self.now_s += 1.0
            harmonics = [[order, 1.0 * number, 0.5, 0.01, 1] for order in orders]
            made = {"turn": number, "result": "kept", "reason": "none", "harmonics": harmonics}
            self.recorder.add(TelemetryLine(made | fields))

    def turns(self, day: int) -> list[int]:
        return columns_of(day_file(self.files, DAYS[day]))["entry/turns/turn"]


def test_at_midnight_a_file_is_closed_and_then_stays_as_it_is(tmp_path: Path) -> None:
    machine = Machine(tmp_path)
    first, second = (day_file(tmp_path, day) for day in DAYS)
    machine.add(1, 2)
    assert machine.days.update().written == [first]
    assert not opens_elsewhere(first)
    machine.add(3)
    machine.now_s += 7200.0  # midnight comes before the next update
    machine.add(4)
    assert machine.days.update().written == [second]
    assert machine.turns(0) == [1, 2, 3]
    before = (first.stat(), first.read_bytes())
    machine.add(5)
    assert machine.days.update().written == []
    machine.days.close()
    assert (machine.turns(0), machine.turns(1)) == ([1, 2, 3], [4, 5])
    # The next daemon leaves complete files of earlier days alone.
    again = LiveDays(machine.record, tmp_path, lambda: machine.now_s)
    assert again.update().written == [second]
    again.close()
    after = first.stat()
    assert (after.st_ino, after.st_mtime_ns) == (before[0].st_ino, before[0].st_mtime_ns)
    assert first.read_bytes() == before[1]
    assert machine.turns(1) == [4, 5]


def opens_elsewhere(path: Path) -> bool:
    code = "import h5py, sys; h5py.File(sys.argv[1])"
    done = subprocess.run([sys.executable, "-c", code, str(path)], capture_output=True, check=False)
    return done.returncode == 0


def test_without_turns_a_file_is_closed_at_midnight_too(tmp_path: Path) -> None:
    machine = Machine(tmp_path)
    machine.add(1)
    machine.days.update()
    machine.now_s += 7200.0
    assert machine.days.update().written == []
    assert opens_elsewhere(day_file(tmp_path, DAYS[0]))
    assert machine.turns(0) == [1]


@pytest.mark.parametrize(
    "later",
    [
        {"orders": (1, 7)},
        {"alarms": ["temperature", "coefficients", "head_left_out", "not_confirmed"] * 5},
        {"reason": "µ" * 40},
    ],
)
def test_what_the_layout_cannot_hold_makes_a_new_file(
    tmp_path: Path, later: dict[str, Any]
) -> None:
    """The first file's layout has order 1, 32 bytes of reason and 128 bytes of alarms."""
    machine = Machine(tmp_path)
    path = day_file(tmp_path, DAYS[0])
    machine.add(1, 2)
    machine.days.update()
    with watching(path) as reader:
        machine.add(3)
        machine.add(4, **later)
        assert machine.days.update().written == [path]
        # A reader of the former file still reads what it has.
        assert reader.read("turns/turn")["turns/turn"] in ([1, 2], [1, 2, 3])
    with watching(path) as reader:
        machine.add(5, **later)
        assert machine.days.update().written == []
        assert reader.read("turns/turn")["turns/turn"] == [1, 2, 3, 4, 5]
    machine.days.close()
    with h5py.File(path) as file:
        turns, table = file["entry/turns"], file["entry/orders"]
        expected = {"reason": "none", "alarms": []} | later
        assert turns["reason"].asstr()[:].tolist() == ["none"] * 3 + [expected["reason"]] * 2
        texts = turns["alarms"].asstr()[:].tolist()
        assert [json.loads(text) for text in texts] == [[]] * 3 + [expected["alarms"]] * 2
        assert table["order"][:].tolist() == list(later.get("orders", (1,)))
        np.testing.assert_array_equal(table["amplitude"][:, 0], [1.0, 2.0, 3.0, 4.0, 5.0])
        known = np.isfinite(table["amplitude"][:, -1]).tolist()
        assert known == ([False] * 3 + [True] * 2 if "orders" in later else [True] * 5)


def test_a_day_without_orders_is_written(tmp_path: Path) -> None:
    machine = Machine(tmp_path)
    machine.add(1, 2, orders=())
    machine.days.update()
    machine.add(3, orders=())
    machine.days.update()
    machine.days.close()
    assert machine.turns(0) == [1, 2, 3]


def test_events_are_appended(tmp_path: Path) -> None:
    """A long event, here of 3000 bytes, makes a new file. After retention has deleted all events,
    SQLite gives a new event an id that the file already has; this event is also appended."""
    machine = Machine(tmp_path, Retention(days=0.01))
    texts = ["a", "b", "x" * 3000, "again"]
    machine.add(1)
    machine.recorder.event("mark", texts[0])
    machine.days.update()
    machine.recorder.event("mark", texts[1])
    machine.days.update()
    machine.recorder.event("mark", texts[2])
    machine.days.update()
    machine.now_s += 1800.0
    machine.add(2, 3)
    machine.days.update()
    machine.recorder.apply_retention()
    machine.recorder.event("mark", texts[3])
    machine.days.update()
    machine.days.close()
    assert len(read_turns(machine.record)) == 2
    found = columns_of(day_file(tmp_path, DAYS[0]))["entry/events/text"]
    assert [text.decode() for text in found] == texts


def test_after_the_clock_was_set_back_the_earlier_day_goes_on(tmp_path: Path) -> None:
    machine = Machine(tmp_path)
    machine.add(1)
    machine.days.update()
    machine.now_s += 7200.0
    machine.add(2)
    machine.days.update()
    machine.now_s -= 7200.0
    machine.add(3)
    assert machine.days.update().written == [day_file(tmp_path, DAYS[0])]
    assert machine.turns(1) == [2]
    machine.add(4)
    update = machine.days.update()
    assert update.written == []
    # Turn 1 is only in the record and in the file that is being extended.
    assert update.deletable == 0
    machine.now_s += 7200.0
    machine.add(5)
    machine.days.update()
    machine.days.close()
    assert (machine.turns(0), machine.turns(1)) == ([1, 3, 4], [2, 5])


def test_a_deleted_or_replaced_file_of_the_present_day_is_made_anew(tmp_path: Path) -> None:
    machine = Machine(tmp_path)
    path = day_file(tmp_path, DAYS[0])
    machine.add(1)
    machine.days.update()
    path.unlink()
    machine.add(2)
    assert machine.days.update().written == [path]
    path.unlink()
    path.write_bytes(b"of another program")
    machine.add(3)
    assert machine.days.update().written == [path]
    machine.days.close()
    assert machine.turns(0) == [1, 2, 3]


KILLED = """
import os, sys
from pathlib import Path
from arctrue.device.daemon.live_day import LiveDays
days = LiveDays(Path(sys.argv[1]), Path(sys.argv[2]), lambda: float(sys.argv[3]))
done = days.update(exceeded=sys.argv[4] == "exceeded")
print(done.deletable)
sys.stdout.flush()
os.kill(os.getpid(), 9)
"""


def killed_writer(machine: Machine, *, exceeded: bool) -> int:
    """Write the files in a process that is killed then; return the id that may be deleted."""
    words = [str(machine.record), str(machine.files), str(machine.now_s)]
    words.append("exceeded" if exceeded else "")
    done = subprocess.run(
        [sys.executable, "-c", KILLED, *words], stdout=subprocess.PIPE, text=True, check=False
    )
    assert done.returncode == -signal.SIGKILL
    return int(done.stdout)


def test_turns_that_the_record_has_deleted_survive_a_killed_writer(tmp_path: Path) -> None:
    """The record may delete turns of the present day only after they are in the day's copy. Here it
    deletes all that it may, and each writer is killed, after which its file cannot be opened."""
    machine = Machine(tmp_path, Retention(days=0.0))
    path = day_file(tmp_path, DAYS[0])
    machine.recorder.deletable = 0
    for begin in (0, 10):
        machine.add(*range(begin, begin + 10))
        machine.recorder.event("mark", str(begin))
        machine.recorder.deletable = killed_writer(machine, exceeded=False)
        machine.recorder.apply_retention()
        assert machine.recorder.exceeded
        assert [turn.fields["turn"] for turn in read_turns(machine.record)][-10:] == list(
            range(begin, begin + 10)
        )
        assert not opens_elsewhere(path)
        machine.recorder.deletable = killed_writer(machine, exceeded=True)
        assert machine.recorder.deletable == last_turn(machine.record)
        machine.recorder.apply_retention()
        assert not machine.recorder.exceeded
        assert len(read_turns(machine.record)) == 1
        assert not opens_elsewhere(path)
    assert turns_of_file(path) == 20
    path.unlink()
    machine.days.update()
    assert copy_of(path).exists()
    machine.days.close()
    assert not copy_of(path).exists()
    assert machine.turns(0) == list(range(20))
    assert columns_of(path)["entry/events/text"] == [b"0", b"10"]
    # A daemon that continues a file with turns that the record lacks makes the copy first.
    killed_writer(machine, exceeded=False)
    assert not opens_elsewhere(path)
    machine.now_s += 86_400.0
    machine.add(20)
    machine.days.update()
    machine.days.close()
    assert machine.turns(0) == list(range(20))
    assert not copy_of(path).exists()


@pytest.mark.parametrize(
    "stopping",
    [
        signal.SIGTERM,
        pytest.param(
            signal.SIGHUP,
            marks=pytest.mark.skipif(
                signal.getsignal(signal.SIGHUP) == signal.SIG_IGN, reason="nohup ignores SIGHUP"
            ),
        ),
        pytest.param(signal.SIGINT, marks=pytest.mark.large),
    ],
)
def test_a_stopped_daemon_leaves_closed_files_with_all_turns(
    replay: Replay, tmp_path: Path, stopping: signal.Signals
) -> None:
    store, files = tmp_path / "store", tmp_path / "files"
    with daemon(replay.port, store, "--files", str(files), "--files-every", "60") as running:
        # As soon as this file exists, the writer ignores the signal.
        until((files / ".arctrue-files-lock").exists)
        for number in range(20):
            replay.turn(number)
        until(lambda: ask(announcement(replay.port), "status")["turns"] == 20)
        # The terminal's Ctrl-C cannot reach the writer, whenever it comes.
        (writer,) = running.writers()
        assert os.getsid(writer) == writer
        # systemd sends the signal to the writer too.
        for number in (signal.SIGQUIT, stopping):
            os.kill(writer, number)
        running.process.send_signal(stopping)
        assert running.process.wait(PATIENCE_S) == 0
    assert [
        n for path in sorted(files.glob("*.nxs")) for n in columns_of(path)["entry/turns/turn"]
    ] == list(range(20))


def test_a_stop_that_takes_long_says_so(replay: Replay, tmp_path: Path) -> None:
    files = tmp_path / "files"
    with daemon(replay.port, tmp_path / "store", "--files", str(files)) as running:
        until((files / ".arctrue-files-lock").exists)
        (writer,) = running.writers()
        os.kill(writer, signal.SIGSTOP)
        try:
            running.process.send_signal(signal.SIGTERM)
            running.heard(f"{files}: closing the day's file")
        finally:
            os.kill(writer, signal.SIGCONT)
        assert running.process.wait(PATIENCE_S) == 0


def test_the_owner_of_a_folder_decides_who_may_lock_it(tmp_path: Path) -> None:
    before = os.umask(0o002)
    try:
        StoreLock.of_files(tmp_path, "a program", "").release()
    finally:
        os.umask(before)
    assert (tmp_path / ".arctrue-files-lock").stat().st_mode & 0o777 == 0o664


def test_a_daemon_that_nohup_started_survives_the_end_of_its_terminal(
    replay: Replay, tmp_path: Path
) -> None:
    before = "import signal; signal.signal(signal.SIGHUP, signal.SIG_IGN)\n"
    with daemon(replay.port, tmp_path / "store", before=before) as running:
        running.process.send_signal(signal.SIGHUP)
        replay.turn(0)
        until(lambda: ask(announcement(replay.port), "status")["turns"] == 1)


@pytest.mark.parametrize(
    ("program", "reason"),
    [
        (None, "the writer cannot be started: .*No such file"),
        ("read line; echo warning; read line", "the writer's answer is not JSON: warning"),
        ("read line; echo 5; read line", "the writer's answer is not JSON: 5"),
        ("read line; kill -KILL $$", "the writer was killed by signal 9"),
        ("read line; exit 3", "the writer ended with exit code 3"),
    ],
)
def test_every_failure_of_the_writer_is_an_error_after_which_another_one_starts(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, program: str | None, reason: str
) -> None:
    """``program`` is a shell program in place of Python; without one, Python is missing."""
    machine = Machine(tmp_path)
    machine.add(1)
    python, other = sys.executable, tmp_path / "python"
    if program is not None:
        other.write_text(f"#!/bin/sh\n{program}\n")
        other.chmod(0o755)

    async def write() -> None:
        writer = DayWriter(machine.record, tmp_path)
        monkeypatch.setattr(sys, "executable", str(other))
        with pytest.raises(DayWriterError, match=reason):
            await writer.update(exceeded=False)
        await writer.close()
        monkeypatch.setattr(sys, "executable", python)
        assert await writer.update(exceeded=False) == ([str(day_file(tmp_path, DAYS[0]))], 1)
        await writer.close()

    asyncio.run(write())
    assert machine.turns(0) == [1]


def test_a_last_answer_that_is_not_json_is_an_error(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    other = tmp_path / "python"
    answer = json.dumps({"written": [], "deletable": 0})
    other.write_text(f"#!/bin/sh\nread line; echo '{answer}'; read line; echo warning; exit 1\n")
    other.chmod(0o755)
    monkeypatch.setattr(sys, "executable", str(other))

    async def write() -> None:
        writer = DayWriter(tmp_path / "telemetry.sqlite", tmp_path)
        await writer.update(exceeded=False)
        with pytest.raises(DayWriterError, match="the writer's answer is not JSON: warning"):
            await writer.close()

    asyncio.run(write())


def test_after_a_kill_of_the_daemon_its_writer_closes_the_file(
    replay: Replay, tmp_path: Path
) -> None:
    store, files = tmp_path / "store", tmp_path / "files"
    with daemon(replay.port, store, "--files", str(files), "--files-every", "0.01") as running:
        replay.turn(0)
        running.heard(".nxs")
        (path,) = files.glob("*.nxs")
        assert not opens_elsewhere(path)
        done = arctrue("device", "files", store / "telemetry.sqlite", files)
        assert done.exit_code == 2
        said = " ".join(done.output.split())
        assert f"{files}: is in use by arctrue device run" in said
        assert "it writes missing files itself" in said
        running.process.kill()
        running.process.wait(PATIENCE_S)
        until(lambda: opens_elsewhere(path))
    assert turns_of_file(path) == 1


@pytest.mark.parametrize("after_s", [0.4, pytest.param(1.3, marks=pytest.mark.large)])
def test_after_a_power_cut_the_next_daemon_makes_the_file_anew(
    replay: Replay, tmp_path: Path, after_s: float
) -> None:
    """Daemon and writer are killed while turns arrive. The file refuses to open; the next daemon's
    file has every turn of the record."""
    store, files = tmp_path / "store", tmp_path / "files"
    options = ("--files", str(files), "--files-every", "0.01")
    stopped = threading.Event()

    def send() -> None:
        number = 1
        while not stopped.is_set():
            replay.turn(number)
            number += 1
            time.sleep(0.002)

    with daemon(replay.port, store, *options) as running:
        replay.turn(0)
        running.heard(".nxs")
        sender = threading.Thread(target=send, daemon=True)
        sender.start()
        time.sleep(after_s)
        running.kill_with_writer()
        stopped.set()
    (path,) = files.glob("arctrue-*.nxs")
    assert not opens(path)
    recorded = [turn.fields["turn"] for turn in read_turns(store / "telemetry.sqlite")]
    assert recorded == list(range(len(recorded)))
    assert len(recorded) > 1
    (files / f".{path.stem}.unfinished.nxs").write_bytes(b"half")
    with daemon(replay.port, store, *options) as running:
        running.heard(".nxs")
        running.process.send_signal(signal.SIGTERM)
        assert running.process.wait(PATIENCE_S) == 0
    assert columns_of(path)["entry/turns/turn"][: len(recorded)] == recorded
    assert list(files.glob("*.nxs*")) == [path]


def test_a_full_disk_stops_neither_the_record_nor_later_files(
    replay: Replay, tmp_path: Path
) -> None:
    """The writer's file cannot grow beyond 200 kB, as on a full disk. HDF5 can then neither close
    the file nor end. The daemon reports this and continues, and another writer, which has no such
    limit, writes all turns."""
    import resource

    store, files = tmp_path / "store", tmp_path / "files"
    wide = [[order, 1.0, 0.5, 0.01, 1] for order in range(1, 41)]
    options = ("--files", str(files), "--files-every", "0.01")
    with daemon(replay.port, store, *options) as running:
        replay.turn(0, harmonics=wide)
        running.heard(".nxs")
        (writer,) = running.writers()
        resource.prlimit(writer, resource.RLIMIT_FSIZE, (200_000, resource.RLIM_INFINITY))
        number = 1
        while not any("no file was written" in line for line in running.said):
            assert number < 1000
            replay.turn(number, harmonics=wide)
            number += 1
            time.sleep(0.01)
        running.heard("no file was written: File too large")
        replay.turn(number)
        until(lambda: ask(announcement(replay.port), "status")["turns"] == number + 1)
        assert ask(announcement(replay.port), "status")["recording"] is True
        until(lambda: sum(map(turns_of_file, files.glob("*.nxs"))) == number + 1)
        running.process.send_signal(signal.SIGTERM)
        assert running.process.wait(PATIENCE_S) == 0
    assert [
        n for path in sorted(files.glob("*.nxs")) for n in columns_of(path)["entry/turns/turn"]
    ] == list(range(number + 1))


FULL = """
import resource, signal, sys
resource.setrlimit(resource.RLIMIT_FSIZE, (int(sys.argv.pop(1)), resource.RLIM_INFINITY))
from arctrue.cli import main
main()
"""


@pytest.mark.parametrize("room_bytes", [60_000, 150_000, 250_000])
def test_the_command_files_states_a_full_disk(tmp_path: Path, room_bytes: int) -> None:
    """On a full disk, here a limit of the size of files, the command reports the fault and keeps
    the earlier file of the day. In an earlier version, HDF5 ended the command with a segmentation
    fault."""
    machine = Machine(tmp_path)
    wide = tuple(range(1, 41))
    machine.add(*range(10), orders=wide)
    machine.days.update()
    machine.days.close()
    path = day_file(tmp_path, DAYS[0])
    before = path.read_bytes()
    machine.add(*range(10, 210), orders=wide)
    machine.recorder.close()  # SQLite would have to write its own files
    command = ["device", "files", str(machine.record), str(tmp_path)]
    done = subprocess.run(
        [sys.executable, "-c", FULL, str(room_bytes), *command],
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 2, done.stderr
    said = " ".join(done.stderr.split())
    assert said == f"error: {path}: cannot be read or written: File too large"
    assert path.read_bytes() == before
    assert list(tmp_path.glob("*arctrue-2026*")) == [path]


NO_LOCKS = """
#include <errno.h>
int flock(int file, int operation) { (void)file; (void)operation; errno = ENOLCK; return -1; }
"""


def test_a_file_system_without_locks_needs_no_setting(replay: Replay, tmp_path: Path) -> None:
    """On such a file system, here one whose flock() fails with ENOLCK as on some NFS servers, the
    daemon writes its files; a reader needs HDF5_USE_FILE_LOCKING=FALSE."""
    compiler = shutil.which("cc")
    if compiler is None:
        pytest.skip("needs a C compiler")
    source, library = tmp_path / "no_locks.c", tmp_path / "no_locks.so"
    source.write_text(NO_LOCKS)
    subprocess.run([compiler, "-shared", "-fPIC", "-o", library, source], check=True)
    machine = Machine(tmp_path)
    machine.add(1, 2)
    code = (
        "import sys; from pathlib import Path; from arctrue.device.daemon.live_day import LiveDays;"
        "days = LiveDays(Path(sys.argv[1]), Path(sys.argv[2]), lambda: float(sys.argv[3]));"
        "days.update(); days.close(); print(len(days.update().written)); days.close()"
    )
    free = {name: value for name, value in os.environ.items() if name != "HDF5_USE_FILE_LOCKING"}
    free["LD_PRELOAD"] = str(library)
    words = [str(machine.record), str(machine.files), str(machine.now_s)]
    subprocess.run([sys.executable, "-c", code, *words], env=free, check=True)
    path = day_file(tmp_path, DAYS[0])
    assert machine.turns(0) == [1, 2]
    code = "import h5py, sys; h5py.File(sys.argv[1], swmr=True)"
    for locking, works in ((None, False), ("FALSE", True)):
        environment = free if locking is None else free | {"HDF5_USE_FILE_LOCKING": locking}
        done = subprocess.run(
            [sys.executable, "-c", code, str(path)],
            env=environment,
            capture_output=True,
            check=False,
        )
        assert (done.returncode == 0) is works, done.stderr
