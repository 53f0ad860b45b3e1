"""Telemetry in an SQLite file: a row a turn, a row a harmonic."""

from __future__ import annotations

import json
import sqlite3
from pathlib import Path

from arctrue.device.console import TelemetryLine

_SCHEMA = """
CREATE TABLE IF NOT EXISTS turn (
    id INTEGER PRIMARY KEY,
    recorded TEXT NOT NULL DEFAULT (strftime('%Y-%m-%dT%H:%M:%fZ', 'now')),
    number INTEGER NOT NULL,
    time_s REAL,
    result TEXT NOT NULL,
    reason TEXT NOT NULL,
    separation_deg REAL,
    residual_arcsec REAL,
    noise_arcsec REAL,
    active_arcsec REAL,
    candidate_arcsec REAL,
    temperature_c REAL,
    swaps INTEGER,
    alarms TEXT NOT NULL
);
CREATE TABLE IF NOT EXISTS harmonic (
    turn INTEGER NOT NULL REFERENCES turn (id),
    harmonic_order INTEGER NOT NULL,
    amplitude_arcsec REAL,
    phase_rad REAL,
    u_arcsec REAL,
    chosen INTEGER NOT NULL
);
"""
_COLUMNS = (
    "time_s",
    "result",
    "reason",
    "separation_deg",
    "residual_arcsec",
    "noise_arcsec",
    "active_arcsec",
    "candidate_arcsec",
    "temperature_c",
    "swaps",
)


class Recorder:
    """Appends to ``file``; raises sqlite3.Error where it is no such file."""

    def __init__(self, file: Path) -> None:
        """Open or make the file."""
        self._connection = sqlite3.connect(file)
        self._connection.executescript(_SCHEMA)
        self._add_what_older_files_lack()

    def _add_what_older_files_lack(self) -> None:
        present = {row[1] for row in self._connection.execute("PRAGMA table_info(turn)")}
        if "temperature_c" not in present:
            with self._connection:
                self._connection.execute("ALTER TABLE turn ADD COLUMN temperature_c REAL")

    def add(self, turn: TelemetryLine) -> None:
        """One turn, on the disk when this returns."""
        fields = turn.fields
        values = [fields["turn"], *(fields.get(name) for name in _COLUMNS)]
        values.append(json.dumps(fields.get("alarms", [])))
        marks = ", ".join("?" * len(values))
        with self._connection:
            row = self._connection.execute(
                f"INSERT INTO turn (number, {', '.join(_COLUMNS)}, alarms) VALUES ({marks})", values
            )
            self._connection.executemany(
                "INSERT INTO harmonic VALUES (?, ?, ?, ?, ?, ?)",
                [(row.lastrowid, *harmonic) for harmonic in fields.get("harmonics", [])],
            )

    def close(self) -> None:
        """Close the file."""
        self._connection.close()
