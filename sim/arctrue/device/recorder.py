"""Records telemetry in an SQLite file: one row for each turn, each harmonic, each event, and each
edge of probe_in or pulse of compare_out."""

from __future__ import annotations

import json
import sqlite3
import time
import uuid
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from arctrue.device.lines import TelemetryLine
from arctrue.device.probe import Latch

_TURN = {
    "recorded": "TEXT NOT NULL",
    "number": "INTEGER NOT NULL",
    "time_s": "REAL",
    "result": "TEXT NOT NULL",
    "reason": "TEXT NOT NULL",
    "separation_deg": "REAL",
    "u_separation_arcsec": "REAL",
    "residual_arcsec": "REAL",
    "noise_arcsec": "REAL",
    "active_arcsec": "REAL",
    "candidate_arcsec": "REAL",
    "loaded_arcsec": "REAL",
    "temperature_c": "REAL",
    "table_c": "REAL",
    "swaps": "INTEGER",
    "alarms": "TEXT NOT NULL",
}
"""SQL types of the columns of the table of turns, by column."""
_FIELDS = tuple(name for name in _TURN if name not in ("recorded", "number", "alarms"))
"""Columns that contain the telemetry field of the same name, unchanged."""
_KIND_OF_EDGE = "kind INTEGER NOT NULL DEFAULT 1"
"""Definition of a column that older files lack; its values are keys of
arctrue.device.probe.KINDS."""
_SCHEMA = f"""
CREATE TABLE IF NOT EXISTS turn (
    id INTEGER PRIMARY KEY,
    {", ".join(f"{name} {kind}" for name, kind in _TURN.items())}
);
CREATE TABLE IF NOT EXISTS harmonic (
    turn INTEGER NOT NULL REFERENCES turn (id),
    harmonic_order INTEGER NOT NULL,
    amplitude_arcsec REAL,
    phase_rad REAL,
    u_arcsec REAL,
    chosen INTEGER NOT NULL
);
CREATE INDEX IF NOT EXISTS harmonic_turn ON harmonic (turn);
CREATE TABLE IF NOT EXISTS edge (
    id INTEGER PRIMARY KEY,
    recorded TEXT NOT NULL,
    after_turn INTEGER NOT NULL,
    edge INTEGER NOT NULL,
    time_s REAL NOT NULL,
    position_counts INTEGER NOT NULL,
    angle_deg REAL NOT NULL,
    missed INTEGER NOT NULL,
    {_KIND_OF_EDGE}
);
CREATE TABLE IF NOT EXISTS identity (name TEXT NOT NULL);
CREATE TABLE IF NOT EXISTS event (
    id INTEGER PRIMARY KEY,
    recorded TEXT NOT NULL,
    after_turn INTEGER NOT NULL,
    kind TEXT NOT NULL,
    text TEXT NOT NULL
);
"""
CLOCK_STEP_S = 1.0
"""Largest difference in seconds between the advances of the system clock and of the monotonic
clock; a larger one means that the system clock was set."""
_DELETED_AT_ONCE = 500
_BETWEEN_RETENTIONS = 100
"""Number of turns after which the limits are checked again."""
_DAY_S = 86_400.0
_MEGABYTE = 1_000_000


@dataclass(frozen=True, slots=True)
class Retention:
    """Limits of the record's size and age; None: no limit."""

    days: float | None = None
    megabytes: float | None = None


class Recorder:
    """Appends turns and events to ``file``; a turn is on the disk when ``add`` returns.

    The ``id`` of the rows gives their order even after the system's clock was set back. The file is
    in SQLite's WAL mode: other programs can read it at the same time, and a program that is killed
    loses at most the turn that it was writing. All methods raise sqlite3.Error.
    """

    def __init__(
        self,
        file: Path,
        retention: Retention | None = None,
        clock: Callable[[], float] = time.time,
        monotonic: Callable[[], float] = time.monotonic,
    ) -> None:
        """Open or create the file. ``clock`` and ``monotonic`` return seconds."""
        self._retention = retention or Retention()
        self._clock, self._monotonic = clock, monotonic
        self._connection = sqlite3.connect(file, isolation_level=None, timeout=1.0)
        self._connection.execute("PRAGMA auto_vacuum = INCREMENTAL")
        self._connection.execute("PRAGMA journal_mode = WAL")
        self._connection.executescript(_SCHEMA)
        if self._one("SELECT count(*) FROM identity") == 0:
            self._connection.execute("INSERT INTO identity VALUES (?)", (uuid.uuid4().hex,))
        self.deletable: int | None = None
        """Largest id of a turn that may be deleted because of the limits; None: any turn."""
        self.exceeded = False
        """True if ``deletable`` keeps turns that exceed the limits."""
        self._add_what_older_files_lack()
        self._last_id = self._one("SELECT coalesce(max(id), 0) FROM turn")
        self._since_retention = 0
        self._clocks = self._started = (clock(), monotonic())
        self._state_a_clock_behind_the_record()

    def _add_what_older_files_lack(self) -> None:
        present = {row[1] for row in self._connection.execute("PRAGMA table_info(turn)")}
        for name in _TURN.keys() - present:
            self._connection.execute(f"ALTER TABLE turn ADD COLUMN {name} {_TURN[name]}")
        if "kind" not in {row[1] for row in self._connection.execute("PRAGMA table_info(edge)")}:
            self._connection.execute(f"ALTER TABLE edge ADD COLUMN {_KIND_OF_EDGE}")

    def _state_a_clock_behind_the_record(self) -> None:
        row = self._connection.execute("SELECT recorded FROM turn ORDER BY id DESC").fetchone()
        if row is not None and row[0] > self._now():
            self.event("clock", f"the clock shows a time before the latest turn, {row[0]}")

    def add(self, turn: TelemetryLine) -> int:
        """Append one turn; return its id."""
        self._state_a_set_clock()
        fields = turn.fields
        values = [self._now(), fields["turn"], *(fields.get(name) for name in _FIELDS)]
        values.append(json.dumps(fields.get("alarms", [])))
        marks = ", ".join("?" * len(values))
        names = f"recorded, number, {', '.join(_FIELDS)}, alarms"
        with self._transaction():
            row = self._connection.execute(f"INSERT INTO turn ({names}) VALUES ({marks})", values)
            self._connection.executemany(
                "INSERT INTO harmonic VALUES (?, ?, ?, ?, ?, ?)",
                [(row.lastrowid, *harmonic) for harmonic in fields.get("harmonics", [])],
            )
        self._last_id = int(row.lastrowid or 0)
        self._since_retention += 1
        if self._since_retention >= _BETWEEN_RETENTIONS:
            self._since_retention = 0
            self.apply_retention()
        return self._last_id

    def event(self, kind: str, text: str) -> None:
        """Append an event, for example a lost port, after the latest turn."""
        with self._transaction():
            self._connection.execute(
                "INSERT INTO event (recorded, after_turn, kind, text) VALUES (?, ?, ?, ?)",
                (self._now(), self._last_id, kind, text),
            )

    def edges(self, latches: Sequence[Latch]) -> None:
        """Append the positions of the table at edges of probe_in and pulses of compare_out."""
        names = ("edge", "time_s", "position_counts", "angle_deg", "missed", "kind")
        before = (self._now(), self._last_id)
        rows = [(*before, *(getattr(latch, name) for name in names)) for latch in latches]
        with self._transaction():
            self._connection.executemany(
                f"INSERT INTO edge (recorded, after_turn, {', '.join(names)}) "
                "VALUES (?, ?, ?, ?, ?, ?, ?, ?)",
                rows,
            )

    def apply_retention(self) -> None:
        """Delete the oldest turns until both limits are satisfied, but no turn above ``deletable``
        and never the latest turn.

        No turn is deleted because the system's clock was set forward.
        """
        self.exceeded = False
        if self._retention.days is not None:
            started_s, at_start_s = self._started
            now_s = min(self._clock(), started_s + self._monotonic() - at_start_s)
            before = _utc(now_s - self._retention.days * _DAY_S)
            while self._delete_oldest("AND recorded < ?", before):
                pass
            if self.deletable is not None:
                exceeded = "SELECT EXISTS (SELECT 1 FROM turn WHERE id < ? AND recorded < ?)"
                row = self._connection.execute(exceeded, (self._last_id, before)).fetchone()
                self.exceeded = bool(row[0])
        if self._retention.megabytes is not None:
            while self._used_bytes() > self._retention.megabytes * _MEGABYTE:
                if not self._delete_oldest(""):
                    most = self.deletable
                    self.exceeded = most is not None and most < self._last_id
                    break
        self._connection.execute("PRAGMA incremental_vacuum").fetchall()

    def _delete_oldest(self, where: str, *values: str) -> bool:
        most = self._last_id if self.deletable is None else self.deletable
        chosen = f"SELECT id FROM turn WHERE id <= ? {where} ORDER BY id LIMIT {_DELETED_AT_ONCE}"
        ids = [row[0] for row in self._connection.execute(chosen, (most, *values))]
        # The latest turn is never deleted; a new row therefore never gets the id of an earlier row.
        ids = [number for number in ids if number != self._last_id]
        if not ids:
            return False
        with self._transaction():
            self._connection.executemany("DELETE FROM harmonic WHERE turn = ?", [(n,) for n in ids])
            self._connection.executemany("DELETE FROM turn WHERE id = ?", [(n,) for n in ids])
            for table in ("event", "edge"):
                self._connection.execute(f"DELETE FROM {table} WHERE after_turn <= ?", (max(ids),))
        return True

    def _used_bytes(self) -> int:
        used = self._one("PRAGMA page_count") - self._one("PRAGMA freelist_count")
        return used * self._one("PRAGMA page_size")

    def _one(self, query: str) -> int:
        return int(self._connection.execute(query).fetchone()[0])

    def _state_a_set_clock(self) -> None:
        now = (self._clock(), self._monotonic())
        step = (now[0] - self._clocks[0]) - (now[1] - self._clocks[1])
        if abs(step) > CLOCK_STEP_S:
            way = "back" if step < 0 else "forward"
            self.event("clock", f"the system's clock was set {way} by {abs(step):.0f} s")
        self._clocks = now

    def _now(self) -> str:
        return _utc(self._clock())

    @contextmanager
    def _transaction(self) -> Iterator[None]:
        self._connection.execute("BEGIN IMMEDIATE")
        try:
            yield
            self._connection.execute("COMMIT")
        except BaseException:
            if self._connection.in_transaction:
                self._connection.execute("ROLLBACK")
            raise

    def close(self) -> None:
        """Close the file."""
        self._connection.close()


def _utc(seconds: float) -> str:
    """Return the time in UTC with milliseconds, in the format of SQLite's own functions."""
    moment = datetime.fromtimestamp(seconds, UTC)
    return moment.isoformat(timespec="milliseconds").replace("+00:00", "Z")


@dataclass(frozen=True, slots=True)
class RecordedTurn:
    """A turn of the record; ``fields`` are the fields of the telemetry."""

    id: int
    recorded_s: float
    """Time of the recording in seconds since 1970, UTC."""
    fields: dict[str, Any]


@contextmanager
def snapshot(file: Path) -> Iterator[sqlite3.Connection]:
    """Yield a connection whose queries all read the same state of a record, also while the recorder
    adds and deletes turns.

    Raises sqlite3.Error.
    """
    connection = sqlite3.connect(f"{file.resolve().as_uri()}?mode=ro", uri=True)
    try:
        connection.execute("BEGIN")
        yield connection
    finally:
        connection.close()


def record_identity(record: sqlite3.Connection) -> str:
    """Return the name that distinguishes a record from other records; empty for a record of an
    older version.

    Raises sqlite3.Error.
    """
    named = "SELECT count(*) FROM sqlite_master WHERE name = 'identity'"
    if not record.execute(named).fetchone()[0]:
        return ""
    row = record.execute("SELECT name FROM identity").fetchone()
    return "" if row is None else str(row[0])


def last_turn(file: Path) -> int:
    """Return the id of the latest turn of a record; 0 for a record without turns. Raises
    sqlite3.Error."""
    return max((turn.id for turn in read_turns(file, latest=1)), default=0)


def read_turns(file: Path, latest: int = -1, after: int = 0) -> list[RecordedTurn]:
    """Return the ``latest`` turns of a record (-1: all) with an id above ``after``, oldest first.

    Raises sqlite3.Error.
    """
    with snapshot(file) as record:
        return turns_in(record, "id > ?", after, latest=latest)


def turns_in(
    record: sqlite3.Connection, where: str, *values: int | str, latest: int = -1
) -> list[RecordedTurn]:
    """Return the ``latest`` turns (-1: all) that satisfy an SQL condition, oldest first.

    Raises sqlite3.Error.
    """
    cursor = record.cursor()
    cursor.row_factory = sqlite3.Row
    query = f"SELECT * FROM turn WHERE {where} ORDER BY id DESC LIMIT ?"
    turns: dict[int, RecordedTurn] = {}
    for row in reversed(cursor.execute(query, [*values, latest]).fetchall()):
        # A record of an earlier version lacks columns.
        fields = {**dict.fromkeys(_FIELDS), **dict(row)}
        identifier, recorded = fields.pop("id"), fields.pop("recorded")
        fields["turn"] = fields.pop("number")
        fields["alarms"] = json.loads(fields["alarms"])
        fields["harmonics"] = []
        moment = datetime.fromisoformat(recorded).timestamp()
        turns[identifier] = RecordedTurn(identifier, moment, fields)
    limits = (min(turns, default=0), max(turns, default=0))
    query = "SELECT * FROM harmonic WHERE turn BETWEEN ? AND ? ORDER BY rowid"
    for row in cursor.execute(query, limits):
        number, *harmonic = tuple(row)
        if number in turns:
            turns[number].fields["harmonics"].append(harmonic)
    return list(turns.values())
