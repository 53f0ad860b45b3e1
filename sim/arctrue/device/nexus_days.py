"""One HDF5 file a day in NeXus form, written from the record of a device.

The record counts: a file is written completely or not at all, so that a reader always finds a
whole one and nothing has to be repaired after a crash. (A file that is extended while others read
it, HDF5's SWMR mode, cannot be opened again after its writer was killed.)
"""

from __future__ import annotations

import contextlib
import json
import sqlite3
from collections.abc import Iterator
from datetime import UTC, date, datetime, timedelta
from pathlib import Path
from typing import Any

import numpy as np

from arctrue.base.extras import LazyModule
from arctrue.base.whole_file import whole_file
from arctrue.device.recorder import RecordedTurn, read_turns

h5py: Any = LazyModule("h5py")

_STEP = timedelta(hours=1)
"""Of the day, read at once: the turns of a day need not fit into the memory."""
_NUMBERS = {
    "separation_deg": "deg",
    "u_separation_arcsec": "arcsec",
    "residual_arcsec": "arcsec",
    "noise_arcsec": "arcsec",
    "active_arcsec": "arcsec",
    "candidate_arcsec": "arcsec",
    "loaded_arcsec": "arcsec",
    "temperature_c": "celsius",
    "table_c": "celsius",
    "time_s": "s",
    "swaps": "",
}
_TEXTS = ("result", "reason", "alarms")
_OF_ORDER = {"amplitude": "arcsec", "phase": "rad", "amplitude_errors": "arcsec", "applied": ""}


class FewerTurnsError(ValueError):
    """The file of a day holds turns that the record has deleted meanwhile."""


def day_file(folder: Path, day: date) -> Path:
    """The file of a day."""
    return folder / f"arctrue-{day.isoformat()}.nxs"


def recorded_days(record: Path) -> list[date]:
    """The days in UTC of which the record has turns. Raises sqlite3.Error."""
    query = "SELECT DISTINCT substr(recorded, 1, 10) FROM turn ORDER BY 1"
    return [date.fromisoformat(row[0]) for row in _rows(record, query)]


def write_missing_days(record: Path, folder: Path) -> list[Path]:
    """Write the file of each day that lacks turns of the record, and return these files.

    A day whose file has turns that the record has deleted keeps its file.
    Raises sqlite3.Error, OSError, MissingExtraError.
    """
    written = []
    for day in recorded_days(record):
        path = day_file(folder, day)
        if turns_of_file(path) >= _count(record, day):
            continue
        with contextlib.suppress(FewerTurnsError):
            write_day(record, day, path)
            written.append(path)
    return written


def turns_of_file(path: Path) -> int:
    """Number of turns in the file of a day; 0 for a file that is missing or cannot be read."""
    try:
        with h5py.File(path, "r") as file:
            return int(file["entry/turns/time"].size)
    except (OSError, KeyError):
        return 0


def write_day(record: Path, day: date, path: Path) -> None:
    """Write all turns that were recorded on ``day`` (UTC) to ``path``.

    Raises FewerTurnsError, sqlite3.Error, OSError, MissingExtraError.
    """
    if _first_id(path) < _first_id_of(record, day):
        raise FewerTurnsError(f"{path}: has turns that {record} has deleted; the file stays")
    start = datetime(day.year, day.month, day.day, tzinfo=UTC)
    orders = _orders(record, day)
    with whole_file(path) as unfinished, h5py.File(unfinished, "w") as file:
        file.attrs["default"] = "entry"
        _make_layout(file, start, orders)
        for hour in range(24):
            begin = start + hour * _STEP
            span = (_iso(begin), _iso(begin + _STEP))
            turns = read_turns(record, span=span)
            if turns:
                _append(file["entry"], turns, start.timestamp(), orders)
        _write_events(file["entry"], record, day)


def _make_layout(file: Any, start: datetime, orders: list[int]) -> None:
    entry = _group(file, "entry", "NXentry")
    entry.attrs["default"] = "orders"
    entry["title"] = "Telemetry of an ArcTrue device, a row a turn"
    entry["start_time"] = _iso(start)
    entry["end_time"] = _iso(start + 24 * _STEP)
    entry["program_name"] = "arctrue device"
    instrument = _group(entry, "instrument", "NXinstrument")
    turns = _group(entry, "turns", "NXdata")
    turns.attrs.update({"signal": "active_arcsec", "axes": "time"})
    _growing(turns, "time", "f8", (), "s", start=_iso(start))
    _growing(turns, "id", "i8", ())
    _growing(turns, "turn", "i8", ())
    for name, unit in _NUMBERS.items():
        _growing(turns, name, "f8", (), unit)
    for name in _TEXTS:
        _growing(turns, name, h5py.string_dtype(), ())
    table = _group(entry, "orders", "NXdata")
    table.attrs.update({"signal": "amplitude", "axes": ["time", "order"]})
    table["time"] = turns["time"]
    table["order"] = np.array(orders, dtype=np.int64)
    for name, unit in _OF_ORDER.items():
        _growing(table, name, "f8", (len(orders),), unit)
    table["phase"].attrs["long_name"] = "error = amplitude · cos(order · angle + phase)"
    _linked(instrument, "head2", "NXpositioner", turns["separation_deg"], "angle after head 1")
    _linked(instrument, "die", "NXsensor", turns["temperature_c"], "temperature of the die")
    _linked(instrument, "table", "NXsensor", turns["table_c"], "temperature of the table")


def _linked(parent: Any, name: str, kind: str, value: Any, text: str) -> None:
    group = _group(parent, name, kind)
    group["name"], group["value"] = text, value
    if kind == "NXsensor":
        group["measurement"] = "temperature"


def _group(parent: Any, name: str, kind: str) -> Any:
    group = parent.create_group(name)
    group.attrs["NX_class"] = kind
    return group


def _growing(
    parent: Any, name: str, kind: Any, width: tuple[int, ...], unit: str = "", **attributes: str
) -> None:
    chunk = max(1024 // max(width, default=1), 1)
    made = parent.create_dataset(
        name,
        (0, *width),
        kind,
        maxshape=(None, *width),
        chunks=(chunk, *(max(w, 1) for w in width)),
    )
    made.attrs.update({**({"units": unit} if unit else {}), **attributes})


def _append(entry: Any, turns: list[RecordedTurn], start_s: float, orders: list[int]) -> None:
    group, table = entry["turns"], entry["orders"]
    _extend(group["time"], np.array([turn.recorded_s - start_s for turn in turns]))
    _extend(group["id"], np.array([turn.id for turn in turns]))
    _extend(group["turn"], np.array([turn.fields["turn"] for turn in turns]))
    for name in _NUMBERS:
        _extend(group[name], np.array([turn.fields[name] for turn in turns], dtype=np.float64))
    for name in ("result", "reason"):
        _extend(group[name], np.array([turn.fields[name] for turn in turns], dtype=object))
    alarms = [json.dumps(turn.fields["alarms"]) for turn in turns]
    _extend(group["alarms"], np.array(alarms, dtype=object))
    values = np.full((len(_OF_ORDER), len(turns), len(orders)), np.nan)
    columns = {order: column for column, order in enumerate(orders)}
    for row, turn in enumerate(turns):
        for order, *harmonic in turn.fields["harmonics"]:
            values[:, row, columns[order]] = harmonic
    for name, part in zip(_OF_ORDER, values, strict=True):
        _extend(table[name], part)


def _extend(dataset: Any, values: Any) -> None:
    before = dataset.shape[0]
    dataset.resize(before + len(values), axis=0)
    dataset[before:] = values


def _write_events(entry: Any, record: Path, day: date) -> None:
    query = "SELECT recorded, kind, text FROM event WHERE recorded LIKE ? ORDER BY id"
    rows = list(_rows(record, query, f"{day.isoformat()}T%"))
    events = _group(entry, "events", "NXcollection")
    for place, name in enumerate(("recorded", "kind", "text")):
        values = np.array([row[place] for row in rows], dtype=object)
        events.create_dataset(name, data=values, dtype=h5py.string_dtype())


def _orders(record: Path, day: date) -> list[int]:
    query = (
        "SELECT DISTINCT harmonic_order FROM harmonic JOIN turn ON turn.id = harmonic.turn "
        "WHERE recorded LIKE ? ORDER BY 1"
    )
    return [int(row[0]) for row in _rows(record, query, f"{day.isoformat()}T%")]


def _count(record: Path, day: date) -> int:
    query = "SELECT count(*) FROM turn WHERE recorded LIKE ?"
    return int(next(_rows(record, query, f"{day.isoformat()}T%"))[0])


def _first_id_of(record: Path, day: date) -> int:
    query = "SELECT coalesce(min(id), 0) FROM turn WHERE recorded LIKE ?"
    return int(next(_rows(record, query, f"{day.isoformat()}T%"))[0])


def _first_id(path: Path) -> float:
    try:
        with h5py.File(path, "r") as file:
            ids = file["entry/turns/id"]
            return float(ids[:].min()) if ids.size else float("inf")
    except (OSError, KeyError):
        return float("inf")


def _rows(record: Path, query: str, *values: str) -> Iterator[tuple[Any, ...]]:
    connection = sqlite3.connect(f"{record.resolve().as_uri()}?mode=ro", uri=True)
    try:
        yield from connection.execute(query, values)
    finally:
        connection.close()


def _iso(moment: datetime) -> str:
    return moment.isoformat(timespec="milliseconds").replace("+00:00", "Z")
