"""Keeps the daily NeXus files up to date: extends the present day's file while others read it."""

from __future__ import annotations

import os
import sqlite3
import time
from collections.abc import Callable
from dataclasses import dataclass
from datetime import UTC, date, datetime
from pathlib import Path
from typing import Any

from arctrue.device.nexus_days import (
    Event,
    Layout,
    append_events,
    append_turns,
    copy_of,
    day_file,
    days_in,
    events_in,
    midnight_s,
    needed_layout,
    open_day,
    write_days,
    write_whole_day,
)
from arctrue.device.recorder import record_identity, snapshot, turns_in

CHECK_S = 3600.0
"""Time in seconds between two checks of the files of all days of the record, for example whether
one was deleted."""
_BLOCK = 4096


class LiveDay:
    """The file of the present day, open in HDF5's SWMR mode. Raises OSError, RuntimeError."""

    def __init__(self, record: sqlite3.Connection, day: date, path: Path) -> None:
        """Write the file from the record and leave it open."""
        self.day, self.path = day, path
        self._identity = record_identity(record)
        self._last = _last_id(record)
        self._events = set[Event](events_in(record, day))
        self._file: Any
        self._layout: Layout
        self._file, self._layout = open_day(record, day, path)
        self._place = _place(path.stat())

    def append(self, record: sqlite3.Connection) -> bool:
        """Append the record's new turns and events; return False if the file must be made anew.

        The file must be made anew if its layout cannot hold a turn or event, if another file has
        its name, or if the record is another one.
        """
        if self._is_replaced() or record_identity(record) != self._identity:
            return False
        days = f"{self.day}T%"
        events = [e for e in events_in(record, self.day, self._last) if e not in self._events]
        end = _last_id(record)
        while True:
            query = "SELECT id FROM turn WHERE id > ? AND recorded LIKE ? ORDER BY id LIMIT ?"
            ids = [row[0] for row in record.execute(query, (self._last, days, _BLOCK))]
            if not ids:
                break
            turns = turns_in(
                record, "id BETWEEN ? AND ? AND recorded LIKE ?", ids[0], ids[-1], days
            )
            if not self._layout.holds(needed_layout(turns, [])):
                return False
            append_turns(self._file["entry"], turns, midnight_s(self.day), self._layout)
            self._last = ids[-1]
        self._last = end
        if not self._layout.holds(needed_layout([], events)):
            return False
        if events:
            append_events(self._file["entry"], events)
            self._events.update(events)
        return True

    def _is_replaced(self) -> bool:
        try:
            return _place(self.path.stat()) != self._place
        except FileNotFoundError:
            return True

    def close(self) -> None:
        """Close the file, so that every program can open it."""
        self._file.close()
        if not self._is_replaced():
            with self.path.open("rb") as file:
                os.fsync(file.fileno())


@dataclass(frozen=True, slots=True)
class Update:
    """Result of an update of the daily files."""

    written: list[Path]
    """Files that were made anew."""
    deletable: int
    """Largest id up to which closed files contain all turns; the record may delete these turns."""


class LiveDays:
    """The daily files of a record. All methods raise sqlite3.Error, OSError, RuntimeError."""

    def __init__(self, record: Path, folder: Path, clock: Callable[[], float] = time.time) -> None:
        """``clock`` returns the time in seconds since 1970, which states the present day."""
        self._record, self._folder, self._clock = record, folder, clock
        self._live: LiveDay | None = None
        self._checked, self._check_at_s = -1, 0.0
        self._deletable = self._copied = 0

    def update(self, *, exceeded: bool = False) -> Update:
        """Append new turns to the present day's file, and write the files of earlier days that lack
        turns. ``exceeded``: the record has more turns than its limits allow.

        In that case the present day's turns go to the day's copy, after which the record may delete
        them: the file that is being extended would lose them if its writer were killed.
        """
        today = datetime.fromtimestamp(self._clock(), UTC).date()
        with snapshot(self._record) as record:
            last = _last_id(record)
            if self._live is not None:
                complete = self._live.append(record)
                if not complete or self._live.day != today:
                    self._close(complete=complete)
            written = []
            others = "SELECT EXISTS (SELECT 1 FROM turn WHERE id > ? AND recorded NOT LIKE ?)"
            news = record.execute(others, (self._checked, f"{today}T%")).fetchone()[0]
            if self._live is None or news or time.monotonic() >= self._check_at_s:
                written = self._check(record, today, last)
            if exceeded and self._live is not None:
                copy = copy_of(self._live.path)
                write_whole_day(record, today, copy, (copy,))
                self._deletable = self._copied = last
            self._checked = last
        return Update(written, self._deletable)

    def _check(self, record: sqlite3.Connection, today: date, last: int) -> list[Path]:
        if self._live is None and last == self._checked and time.monotonic() < self._check_at_s:
            return []
        written = write_days(record, self._folder, without=today)
        if self._live is None and today in days_in(record):
            path = day_file(self._folder, today)
            self._live, self._copied = LiveDay(record, today, path), 0
            written.append(path)
        if self._live is None:
            self._deletable = last
        else:
            query = "SELECT min(id) FROM turn WHERE id > ? AND recorded LIKE ?"
            first = record.execute(query, (self._copied, f"{today}T%")).fetchone()[0]
            self._deletable = last if first is None else first - 1
        self._check_at_s = time.monotonic() + CHECK_S
        return written

    def _close(self, *, complete: bool) -> None:
        """Close the file of the present day, and remove its copy if the file is complete."""
        live, self._live = self._live, None
        if live is not None:
            live.close()
            self._checked = -1
            if complete:
                copy_of(live.path).unlink(missing_ok=True)

    def close(self) -> None:
        """Update the files, then close the present day's file."""
        self.update()
        self._close(complete=True)


def _last_id(record: sqlite3.Connection) -> int:
    return int(record.execute("SELECT coalesce(max(id), 0) FROM turn").fetchone()[0])


def _place(found: os.stat_result) -> tuple[int, int]:
    return found.st_dev, found.st_ino
