"""Writes one HDF5 file for each day, in NeXus form, from the record of a device.

A file is written completely or not at all, so that a reader always finds a complete file and no
file needs repair after a crash. (A file that is extended while others read it, HDF5's SWMR mode,
cannot be opened again after its writer was killed.)
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
from arctrue.device.recorder import RecordedTurn, record_identity, snapshot, turns_in

h5py: Any = LazyModule("h5py")

_STEP = timedelta(hours=1)
"""Duration of the part of a day that is read in one step, so that the turns of a whole day need not
fit into memory."""
_BLOCK = 4096
"""Number of turns of an earlier file that are copied in one step."""
_RECORD, _LAST_ID = "arctrue_record", "arctrue_last_id"
"""Attributes of the NeXus entry: the record from which the file was written, and the id of the last
turn in the file."""
_MILLISECOND_BITS = 27
"""Number of bits that hold the milliseconds of a day: 86,400,000 < 2^27."""
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
_EVENT = ("recorded", "kind", "text")
_WHOLE = (
    "entry/turns/id", "entry/turns/time", "entry/turns/turn", "entry/orders/order",
    "entry/events/text",
)  # fmt: skip
_UNKNOWN = {"f": np.nan, "O": ""}
"""Value of a turn whose file lacks a column, by the column's kind in numpy: numbers and texts."""
_OF_ORDER = {"amplitude": "arcsec", "phase": "rad", "amplitude_errors": "arcsec", "applied": ""}


def day_file(folder: Path, day: date) -> Path:
    """Return the path of the file of a day."""
    return folder / f"arctrue-{day.isoformat()}.nxs"


def recorded_days(record: Path) -> dict[date, int]:
    """Return the days (UTC) that have turns in the record, each with the id of its last turn.

    Raises sqlite3.Error.
    """
    with snapshot(record) as unchanging:
        return _days_in(unchanging)


def _days_in(record: sqlite3.Connection) -> dict[date, int]:
    query = "SELECT substr(recorded, 1, 10), max(id) FROM turn GROUP BY 1 ORDER BY 1"
    return {date.fromisoformat(day): int(last) for day, last in record.execute(query)}


def write_missing_days(record: Path, folder: Path) -> list[Path]:
    """Write the file of each day whose file lacks turns of the record; return the written files.

    A file keeps turns that the record lacks: turns that the recorder has deleted because of the
    record's limits, and turns of another record. Raises sqlite3.Error, OSError, MissingExtraError.
    """
    written = []
    with snapshot(record) as unchanging:
        identity = record_identity(unchanging)
        for day, last in _days_in(unchanging).items():
            path = day_file(folder, day)
            if not _has(path, identity, last):
                _write_day(unchanging, day, path)
                written.append(path)
    return written


def turns_of_file(path: Path) -> int:
    """Return the number of turns in a day's file; 0 if it is missing or cannot be read."""
    with _opened(path) as file:
        return 0 if file is None else int(file["entry/turns/time"].size)


def write_day(record: Path, day: date, path: Path) -> None:
    """Write all turns recorded on ``day`` (UTC) to ``path``.

    Turns of an earlier file that the record lacks come first. Raises sqlite3.Error, OSError,
    MissingExtraError.
    """
    with snapshot(record) as unchanging:
        _write_day(unchanging, day, path)


def _write_day(record: sqlite3.Connection, day: date, path: Path) -> None:
    start = datetime(day.year, day.month, day.day, tzinfo=UTC)
    with _opened(path) as earlier:
        ids, times_s = _ids_and_times(record, day, start.timestamp())
        kept = _rows_not_in(earlier, _keys(ids, times_s))
        orders = sorted({*_orders(record, day), *_orders_of_file(earlier)})
        with whole_file(path) as unfinished, h5py.File(unfinished, "w") as file:
            file.attrs["default"] = "entry"
            _make_layout(file, start, orders)
            entry = file["entry"]
            for at in range(0, kept.size, _BLOCK):
                _copy(earlier["entry"], entry, kept[at : at + _BLOCK])
            for hour in range(24):
                begin = start + hour * _STEP
                span = (_iso(begin), _iso(begin + _STEP))
                turns = turns_in(record, "recorded >= ? AND recorded < ?", *span)
                if turns:
                    _append(entry, turns, start.timestamp(), orders)
            _write_events(entry, record, day, _events_of_file(earlier))
            entry.attrs[_RECORD] = record_identity(record)
            entry.attrs[_LAST_ID] = int(ids.max(initial=0))


def _make_layout(file: Any, start: datetime, orders: list[int]) -> None:
    entry = _group(file, "entry", "NXentry")
    entry.attrs["default"] = "orders"
    entry["title"] = "Telemetry of an ArcTrue device, one row per turn"
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


def _write_events(
    entry: Any, record: sqlite3.Connection, day: date, earlier: list[tuple[str, str, str]]
) -> None:
    """Write the events of the day; the events of an earlier file are kept."""
    query = "SELECT recorded, kind, text FROM event WHERE recorded LIKE ? ORDER BY id"
    recorded = [(str(a), str(b), str(c)) for a, b, c in record.execute(query, (f"{day}T%",))]
    rows = list(dict.fromkeys([*earlier, *recorded]))
    events = _group(entry, "events", "NXcollection")
    for place, name in enumerate(_EVENT):
        values = np.array([row[place] for row in rows], dtype=object)
        events.create_dataset(name, data=values, dtype=h5py.string_dtype())


def _events_of_file(file: Any) -> list[tuple[str, str, str]]:
    if file is None:
        return []
    columns = [file[f"entry/events/{name}"].asstr()[:].tolist() for name in _EVENT]
    return list(zip(*columns, strict=True))


def _copy(source: Any, entry: Any, rows: Any) -> None:
    """Append the turns of an earlier file; a column that this file lacks gets NaN for a number and
    an empty text for a text."""
    turns, table = source["turns"], source["orders"]
    for name, column in entry["turns"].items():
        if name in turns:
            _extend(column, turns[name][rows])
        else:
            unknown = _UNKNOWN[column.dtype.kind]
            _extend(column, np.full(rows.size, unknown, dtype=column.dtype))
    orders = entry["orders/order"][:]
    places = np.searchsorted(orders, table["order"][:])
    for name in _OF_ORDER:
        values = np.full((rows.size, orders.size), np.nan)
        values[:, places] = table[name][rows]
        _extend(entry["orders"][name], values)


def _orders_of_file(file: Any) -> list[int]:
    return [] if file is None else [int(order) for order in file["entry/orders/order"][:]]


def _rows_not_in(file: Any, keys: Any) -> Any:
    """Return the indices of those turns of a file, (n,), that are not in the record."""
    if file is None:
        return np.empty(0, dtype=np.int64)
    turns = file["entry/turns"]
    return np.flatnonzero(~np.isin(_keys(turns["id"][:], turns["time"][:]), keys))


def _keys(ids: Any, times_s: Any) -> Any:
    """Return a number that identifies each turn, (n,), computed from id and time.

    Turns of different records may have the same id, but not the same time.
    """
    return (ids << _MILLISECOND_BITS) | np.rint(1000.0 * times_s).astype(np.int64)


def _ids_and_times(record: sqlite3.Connection, day: date, start_s: float) -> tuple[Any, Any]:
    """Return ids, (n,), and seconds since midnight, (n,), of the turns of a day in the record."""
    query = "SELECT id, recorded FROM turn WHERE recorded LIKE ? ORDER BY id"
    rows = [
        (number, datetime.fromisoformat(recorded).timestamp() - start_s)
        for number, recorded in record.execute(query, (f"{day}T%",))
    ]
    return np.array([row[0] for row in rows], dtype=np.int64), np.array([row[1] for row in rows])


def _orders(record: sqlite3.Connection, day: date) -> list[int]:
    query = (
        "SELECT DISTINCT harmonic_order FROM harmonic JOIN turn ON turn.id = harmonic.turn "
        "WHERE recorded LIKE ? ORDER BY 1"
    )
    return [int(row[0]) for row in record.execute(query, (f"{day}T%",))]


def _has(path: Path, identity: str, last: int) -> bool:
    """Tell whether the file was written from this record and contains its turns up to ``last``."""
    with _opened(path) as file:
        if file is None:
            return False
        attributes = file["entry"].attrs
        return bool(
            attributes.get(_RECORD) == identity and int(attributes.get(_LAST_ID, -1)) >= last
        )


@contextlib.contextmanager
def _opened(path: Path) -> Iterator[Any]:
    """Yield the open file of a day, or None if it is missing, damaged or of another kind."""
    file = None
    with contextlib.suppress(OSError):
        file = h5py.File(path, "r")
    try:
        whole = file is not None and all(name in file for name in _WHOLE)
        yield file if whole else None
    finally:
        if file is not None:
            file.close()


def _iso(moment: datetime) -> str:
    return moment.isoformat(timespec="milliseconds").replace("+00:00", "Z")
