"""Tests that the daily NeXus files, read with h5py, contain the record, read with plain SQL."""

from __future__ import annotations

import sqlite3
import time
from contextlib import AbstractContextManager
from datetime import UTC, date, datetime
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
from sim.tests.command_line import arctrue
from sim.tests.device.daemon_process import Replay, announcement, daemon, until

from arctrue.base.whole_file import whole_file
from arctrue.device import nexus_days
from arctrue.device.connection import ask
from arctrue.device.lines import TelemetryLine
from arctrue.device.nexus_days import (
    day_file,
    recorded_days,
    turns_of_file,
    write_day,
    write_missing_days,
)
from arctrue.device.recorder import Recorder, Retention, last_turn, read_turns

START_S = datetime(2026, 3, 1, 22, 30, tzinfo=UTC).timestamp()
DAYS = [date(2026, 3, 1), date(2026, 3, 2)]


def record_of(file: Path, turns: int = 40) -> None:
    """Write a record with a turn every five minutes across midnight; turns from 20 on also have
    order 3."""
    now = [START_S]
    recorder = Recorder(file, clock=lambda: now[0], monotonic=lambda: now[0])
    for number in range(turns):
        now[0] += 300.0
        orders = (1, 3) if number >= 20 else (1,)
        recorder.add(
            TelemetryLine(
                {
                    "turn": number,
                    "result": "kept",
                    "reason": "none",
                    "separation_deg": 33.0 + number / 1e3,
                    "temperature_c": 40.0 + number,
                    "alarms": ["noise"] if number == 3 else [],
                    "harmonics": [[n, 10.0 * n + number, 0.1 * n, 0.01 * n, 1] for n in orders],
                }
            )
        )
    recorder.event("port", "lost")
    recorder.close()


def test_a_day_holds_what_the_record_has(tmp_path: Path) -> None:
    record = tmp_path / "telemetry.sqlite"
    record_of(record)
    assert list(recorded_days(record)) == DAYS
    assert write_missing_days(record, tmp_path) == [day_file(tmp_path, day) for day in DAYS]
    with sqlite3.connect(record) as database:
        rows = database.execute(
            "SELECT number, separation_deg, temperature_c, unixepoch(recorded) FROM turn"
        ).fetchall()
        amplitudes = database.execute(
            "SELECT number, harmonic_order, amplitude_arcsec, u_arcsec FROM harmonic "
            "JOIN turn ON turn.id = harmonic.turn"
        ).fetchall()
    found, found_amplitudes = [], []
    for day in DAYS:
        with h5py.File(day_file(tmp_path, day)) as file:
            turns = file["entry/turns"]
            midnight = datetime.fromisoformat(turns["time"].attrs["start"]).timestamp()
            columns = [turns[name][:] for name in ("turn", "separation_deg", "temperature_c")]
            found += list(zip(*columns, turns["time"][:] + midnight, strict=True))
            table = file["entry/orders"]
            for row, number in enumerate(turns["turn"][:]):
                for column, order in enumerate(table["order"][:]):
                    if np.isfinite(table["amplitude"][row, column]):
                        values = [table[n][row, column] for n in ("amplitude", "amplitude_errors")]
                        found_amplitudes.append((number, order, *values))
    assert found == rows
    assert found_amplitudes == amplitudes


def test_a_reader_of_nexus_finds_the_default_plot(tmp_path: Path) -> None:
    """A NeXus reader finds the default plot: the attributes default, signal and axes lead to fields
    of equal length."""
    record = tmp_path / "telemetry.sqlite"
    record_of(record)
    write_missing_days(record, tmp_path)
    with h5py.File(day_file(tmp_path, DAYS[1])) as file:
        entry = file[file.attrs["default"]]
        assert entry.attrs["NX_class"] == "NXentry"
        for data in (entry[entry.attrs["default"]], entry["turns"]):
            assert data.attrs["NX_class"] == "NXdata"
            signal = data[data.attrs["signal"]]
            axes = np.atleast_1d(data.attrs["axes"])
            assert [data[name].size for name in axes] == list(signal.shape)
            assert signal.attrs["units"] == "arcsec"
        head2 = entry["instrument/head2"]
        assert head2.attrs["NX_class"] == "NXpositioner"
        assert head2["value"].attrs["units"] == "deg"
        np.testing.assert_array_equal(head2["value"][:], entry["turns/separation_deg"][:])
        assert entry["events/text"].asstr()[:].tolist() == ["lost"]


def test_a_damaged_file_is_made_anew_and_a_fuller_one_stays(tmp_path: Path) -> None:
    record = tmp_path / "telemetry.sqlite"
    record_of(record)
    write_missing_days(record, tmp_path)
    assert write_missing_days(record, tmp_path) == []
    first = day_file(tmp_path, DAYS[0])
    whole = turns_of_file(first)
    first.write_bytes(first.read_bytes()[:2000])  # a writer that was killed leaves a damaged file
    assert write_missing_days(record, tmp_path) == [first]
    assert turns_of_file(first) == whole
    with sqlite3.connect(record) as database:
        database.execute("DELETE FROM turn WHERE id <= 5")
        database.execute("DELETE FROM harmonic WHERE turn <= 5")
    assert write_missing_days(record, tmp_path) == []
    before = columns_of(first)
    write_day(record, DAYS[0], first)
    assert columns_of(first) == before


def columns_of(path: Path) -> dict[str, list[Any]]:
    """Return the content of every array in a file, keyed by path; NaN becomes −1."""
    found: dict[str, list[Any]] = {}

    def take(name: str, item: Any) -> None:
        if isinstance(item, h5py.Dataset) and item.shape:
            found[name] = (
                np.nan_to_num(item[:], nan=-1.0).tolist()
                if item.dtype.kind == "f"
                else (item[:].tolist())
            )

    with h5py.File(path) as file:
        file.visititems(take)
    return found


def test_a_day_that_retention_thins_out_keeps_its_turns_and_gets_new_ones(tmp_path: Path) -> None:
    record = tmp_path / "telemetry.sqlite"
    now = [datetime(2026, 3, 1, 1, tzinfo=UTC).timestamp()]
    recorder = Recorder(record, Retention(days=0.1), lambda: now[0], lambda: now[0])
    (day,) = DAYS[:1]

    def add(numbers: range, order: int) -> None:
        for number in numbers:
            now[0] += 60.0
            fields = {"turn": number, "result": "kept", "reason": "none"}
            recorder.add(TelemetryLine(fields | {"harmonics": [[order, number, 0.5, 0.01, 1]]}))
            recorder.event("mark", str(number))

    add(range(100), 2)
    recorder.deletable = 0  # no day file has these turns yet
    now[0] += 5 * 3600.0
    recorder.apply_retention()
    assert len(read_turns(record)) == 100
    assert write_missing_days(record, tmp_path) == [day_file(tmp_path, day)]
    recorder.deletable = last_turn(record)
    recorder.apply_retention()
    assert len(read_turns(record)) == 1  # the latest turn stays
    add(range(100, 150), 7)
    write_missing_days(record, tmp_path)
    add(range(150, 160), 1)
    write_missing_days(record, tmp_path)
    recorder.close()
    found = columns_of(day_file(tmp_path, day))
    assert found["entry/turns/turn"] == list(range(160))
    assert found["entry/orders/order"] == [1, 2, 7]
    amplitudes = np.array(found["entry/orders/amplitude"])
    for number in range(160):
        column = 1 if number < 100 else 2 if number < 150 else 0
        expected = [-1.0, -1.0, -1.0]
        expected[column] = float(number)
        assert amplitudes[number].tolist() == expected
    assert [int(text) for text in found["entry/events/text"]] == list(range(160))


@pytest.mark.parametrize("next_order", [2, 5])
def test_turns_deleted_while_a_file_is_written_stay_in_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, next_order: int
) -> None:
    """The recorder deletes turns that the earlier file has, between the daemon's queries."""
    record = tmp_path / "telemetry.sqlite"
    now = [datetime(2026, 3, 1, 1, tzinfo=UTC).timestamp()]
    recorder = Recorder(record, Retention(days=0.0), lambda: now[0], lambda: now[0])

    def add(numbers: range, order: int) -> None:
        for number in numbers:
            now[0] += 1.0
            fields = {"turn": number, "result": "kept", "reason": "none"}
            recorder.add(TelemetryLine(fields | {"harmonics": [[order, 1.0, 0.5, 0.01, 1]]}))

    add(range(20), 2)
    recorder.deletable = 0
    write_missing_days(record, tmp_path)
    recorder.deletable = last_turn(record)
    add(range(20, 25), 2)

    def opened(path: Path) -> AbstractContextManager[Path]:
        recorder.apply_retention()
        add(range(25, 27), next_order)
        return whole_file(path)

    monkeypatch.setattr(nexus_days, "whole_file", opened)
    write_missing_days(record, tmp_path)
    assert len(read_turns(record)) == 7
    found = columns_of(day_file(tmp_path, DAYS[0]))
    assert found["entry/turns/turn"] == list(range(25))
    monkeypatch.undo()
    write_missing_days(record, tmp_path)
    recorder.close()
    assert columns_of(day_file(tmp_path, DAYS[0]))["entry/turns/turn"] == list(range(27))


def test_another_record_of_the_same_day_adds_its_turns(tmp_path: Path) -> None:
    """A day file also gets the turns of a second record, whose ids begin with 1 again."""
    for name in ("first", "second"):
        record_of(tmp_path / f"{name}.sqlite", turns=10)
        with sqlite3.connect(tmp_path / f"{name}.sqlite") as database:
            shift = "strftime('%Y-%m-%dT%H:%M:%fZ', recorded, '+7 seconds')"
            if name == "second":
                database.execute(f"UPDATE turn SET recorded = {shift}")
                database.execute("UPDATE turn SET number = number + 100")
        write_missing_days(tmp_path / f"{name}.sqlite", tmp_path)
    found = columns_of(day_file(tmp_path, DAYS[0]))
    assert found["entry/turns/turn"] == [*range(10), *range(100, 110)]
    assert write_missing_days(tmp_path / "second.sqlite", tmp_path) == []
    write_missing_days(tmp_path / "first.sqlite", tmp_path)
    assert sorted(columns_of(day_file(tmp_path, DAYS[0]))["entry/turns/turn"]) == sorted(
        [*range(10), *range(100, 110)]
    )


def test_a_value_that_an_earlier_file_lacks_is_not_a_number_or_empty(tmp_path: Path) -> None:
    """The turns of a file without some columns keep their rows; the missing values are NaN for
    numbers and empty for texts."""
    record = tmp_path / "telemetry.sqlite"
    record_of(record, turns=10)
    path = day_file(tmp_path, DAYS[0])
    write_day(record, DAYS[0], path)
    lacking = ("reason", "alarms", "table_c", "swaps")
    with h5py.File(path, "r+") as file:
        for name in lacking:
            del file[f"entry/turns/{name}"]
    with sqlite3.connect(record) as database:
        database.execute("DELETE FROM turn WHERE id <= 4")
        database.execute("DELETE FROM harmonic WHERE turn <= 4")
    write_day(record, DAYS[0], path)
    with h5py.File(path) as file:
        turns = file["entry/turns"]
        assert turns["turn"][:].tolist() == list(range(10))
        assert turns["result"].asstr()[:].tolist() == ["kept"] * 10
        assert turns["reason"].asstr()[:].tolist() == [""] * 4 + ["none"] * 6
        assert turns["alarms"].asstr()[:].tolist() == [""] * 4 + ["[]"] * 6
        assert np.isnan(turns["table_c"][:4]).all()


def test_a_record_of_an_earlier_version_becomes_day_files(tmp_path: Path) -> None:
    record = tmp_path / "telemetry.sqlite"
    record_of(record, turns=3)
    with sqlite3.connect(record) as database:
        for name in ("swaps", "table_c"):
            database.execute(f"ALTER TABLE turn DROP COLUMN {name}")
    done = arctrue("device", "files", record, tmp_path)
    assert done.exit_code == 0, done.output
    with h5py.File(day_file(tmp_path, DAYS[0])) as file:
        turns = file["entry/turns"]
        assert turns["temperature_c"][:].tolist() == [40.0, 41.0, 42.0]
        assert np.isnan(turns["swaps"][:]).all()
        assert np.isnan(turns["table_c"][:]).all()


def test_a_file_that_is_no_record_is_refused_with_what_to_give(tmp_path: Path) -> None:
    for name, content in (("empty.sqlite", b""), ("text.sqlite", b"turn,angle\n" * 100)):
        (tmp_path / name).write_bytes(content)
        done = arctrue("device", "files", tmp_path / name, tmp_path / "files")
        assert done.exit_code == 2
        assert not (tmp_path / "files").exists()
        assert f"{name}: is no record of arctrue device run" in done.output
        assert "telemetry.sqlite" in done.output


def opens(path: Path) -> bool:
    """Tell whether a reader without SWMR mode can open a file."""
    try:
        h5py.File(path).close()
    except OSError:
        return False
    return True


def test_a_daemon_deletes_no_turn_that_no_file_has(replay: Replay, tmp_path: Path) -> None:
    """The record, limited to 1 MB, cannot hold all turns of this test; record and day files
    together hold all."""
    store, files, count = tmp_path / "store", tmp_path / "files", 600
    wide = [[order, 1.0, 0.5, 0.01, 1] for order in range(1, 41)]
    options = ("--files", str(files), "--files-every", "0.01", "--keep-megabytes", "1")
    with daemon(replay.port, store, *options):
        for number in range(count):
            replay.turn(number, harmonics=wide)

        def in_files() -> int:
            return sum(map(turns_of_file, files.glob("*.nxs")))

        until(lambda: in_files() == count, lambda: str(in_files()))
        # The daemon checks the limits at every hundredth turn.
        for number in range(count, count + 100):
            replay.turn(number, harmonics=wide)
        until(lambda: in_files() == count + 100, lambda: str(in_files()))
        until(lambda: 0 < len(read_turns(store / "telemetry.sqlite")) < count)
    until(lambda: all(map(opens, files.glob("*.nxs"))))
    turns = [
        n for path in sorted(files.glob("*.nxs")) for n in columns_of(path)["entry/turns/turn"]
    ]
    assert turns == list(range(count + 100))


def test_a_killed_daemon_s_days_come_back_from_the_record(replay: Replay, tmp_path: Path) -> None:
    store, files = tmp_path / "store", tmp_path / "files"
    options = ("--files", str(files), "--files-every", "0.01")
    with daemon(replay.port, store, *options) as running:
        for number in range(30):
            replay.turn(number)
        running.heard(".nxs")
        replay.turn(30)
        until(lambda: ask(announcement(replay.port), "status")["turns"] == 31)
        running.kill_with_writer()
    (path,) = files.glob("*.nxs")
    path.write_bytes(b"half")
    done = arctrue("device", "files", store / "telemetry.sqlite", files)
    assert done.exit_code == 0, done.output
    assert sum(map(turns_of_file, files.glob("*.nxs"))) == 31
    path.unlink()
    with daemon(replay.port, store, *options):
        end = time.monotonic() + 30.0
        while not path.exists():
            assert time.monotonic() < end
            time.sleep(0.05)
    assert turns_of_file(path) == 31


@pytest.mark.large
def test_a_file_of_another_program_is_reported_and_the_days_go_on(
    replay: Replay, tmp_path: Path
) -> None:
    """The daemon reports a day's file that it cannot continue, and writes the day when the file is
    gone. The file of this test has the groups of a day, but no amplitudes."""
    store, files = tmp_path / "store", tmp_path / "files"
    files.mkdir()
    path = day_file(files, datetime.now(UTC).date())
    with h5py.File(path, "w") as file:
        for name in ("turns/id", "turns/time", "turns/turn", "orders/order"):
            file[f"entry/{name}"] = np.array([1])
        for name in ("recorded", "kind", "text"):
            file.create_dataset(f"entry/events/{name}", data=["a"], dtype=h5py.string_dtype())
    with daemon(replay.port, store, "--files", str(files), "--files-every", "0.05") as running:
        replay.turn(1)
        running.heard("no file was written: KeyError")
        path.unlink()
        until(lambda: turns_of_file(path) == 1)
