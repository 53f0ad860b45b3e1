"""Writes one HDF5 file for each day, in NeXus form, from the record of a device.

A file of a past day is written completely or not at all. ``device/daemon/live_day`` extends the
present day's file while others read it, in HDF5's SWMR mode. Such a file cannot be opened again
after its writer was killed; the next writer makes it anew from the record. A turn that the record
lacks must therefore also be in a closed file: the day's *copy*.
"""

from __future__ import annotations

import contextlib
import json
import re
import sqlite3
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from datetime import UTC, date, datetime, timedelta
from pathlib import Path
from typing import Any

import numpy as np

from arctrue.base.extras import LazyModule
from arctrue.base.whole_file import whole_file
from arctrue.device.recorder import RecordedTurn, record_identity, snapshot, turns_in

h5py: Any = LazyModule("h5py")

LIBVER = ("v110", "v110")
"""Formats of a file: those of HDF5 1.10, the first with SWMR mode. With "latest" the writer's
version would decide which readers can open the file."""
LOCKING = False
"""HDF5 takes no locks: a file system without locks would refuse them, and a file gets its final
name only when other programs may read it. The environment variable HDF5_USE_FILE_LOCKING has
priority."""
_BLOCK = 4096
"""Number of turns that are written in one step, so that a whole day need not fit into memory."""
_CHUNK_BYTES = 8192
_RECORD, _FIRST_ROW, _LAST_ID = "arctrue_record", "arctrue_first_row", "arctrue_last_id"
"""Attributes of the NeXus entry: the record from which the file was written, and the first row with
a turn that this record had. Files of version 0.1 have the id of the last turn instead."""
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
_BYTES = {"result": 16, "reason": 32, "alarms": 128, "recorded": 24, "kind": 16, "text": 256}
"""Smallest length of the texts of a column. SWMR mode allows no texts of variable length; a longer
text doubles the length as often as necessary."""
_WHOLE = (
    "entry/turns/id", "entry/turns/time", "entry/turns/turn", "entry/orders/order",
    "entry/events/text",
)  # fmt: skip
_UNKNOWN = {"f": np.nan, "S": b""}
"""Value of a turn whose file lacks a column, by the column's kind in numpy: numbers and texts."""
_OF_ORDER = {"amplitude": "arcsec", "phase": "rad", "amplitude_errors": "arcsec", "applied": ""}


@dataclass(frozen=True)
class Layout:
    """Properties that are fixed in a file that others read: orders, and bytes of the texts by
    column."""

    orders: tuple[int, ...]
    bytes_of: Mapping[str, int]

    def holds(self, other: Layout) -> bool:
        """Tell whether this layout can hold the content of a file with the other layout."""
        return set(other.orders) <= set(self.orders) and all(
            length <= self.bytes_of[name] for name, length in other.bytes_of.items()
        )


Event = tuple[str, str, str]
"""Time, kind and text of an event."""


def day_file(folder: Path, day: date) -> Path:
    """Return the path of the file of a day."""
    return folder / f"arctrue-{day.isoformat()}.nxs"


def copy_of(path: Path) -> Path:
    """Return the path of a day's copy, which contains the turns that the record lacks while the
    day's file is extended."""
    return path.with_name(f"{path.name}.copy")


def recorded_days(record: Path) -> dict[date, int]:
    """Return the days (UTC) that have turns in the record, each with the id of its last turn.

    Raises sqlite3.Error.
    """
    with snapshot(record) as unchanging:
        return days_in(unchanging)


def days_in(record: sqlite3.Connection) -> dict[date, int]:
    """Return the days (UTC) that have turns, each with the id of its last turn."""
    query = "SELECT substr(recorded, 1, 10), max(id) FROM turn GROUP BY 1 ORDER BY 1"
    return {date.fromisoformat(day): int(last) for day, last in record.execute(query)}


def write_missing_days(record: Path, folder: Path) -> list[Path]:
    """Write the file of each day whose file lacks turns of the record; return the written files.

    A file keeps turns that the record lacks: turns that the recorder has deleted because of the
    record's limits, and turns of another record. Raises sqlite3.Error, OSError, MissingExtraError.
    """
    with snapshot(record) as unchanging:
        return write_days(unchanging, folder)


def write_days(record: sqlite3.Connection, folder: Path, without: date | None = None) -> list[Path]:
    """Write the missing files as write_missing_days does, except that of the day ``without``."""
    written = []
    identity, last_ids = record_identity(record), days_in(record)
    copied = {
        path.name.split(".")[0].partition("-")[2]
        for path in folder.glob("arctrue-????-??-??.nxs.copy")
    }
    for day in sorted({*last_ids, *map(date.fromisoformat, copied)} - {without}):
        path = day_file(folder, day)
        if day.isoformat() in copied or not _has(path, identity, last_ids[day]):
            write_whole_day(record, day, path, (copy_of(path), path))
            copy_of(path).unlink(missing_ok=True)
            written.append(path)
    return written


def turns_of_file(path: Path) -> int:
    """Return the number of turns in a day's file; 0 if it is missing or cannot be read."""
    with _opened(path, swmr=True) as file:
        return 0 if file is None else int(file["entry/turns/id"].size)


def write_day(record: Path, day: date, path: Path) -> None:
    """Write all turns recorded on ``day`` (UTC) to ``path``.

    Turns of an earlier file that the record lacks come first. Raises sqlite3.Error, OSError,
    MissingExtraError.
    """
    with snapshot(record) as unchanging:
        write_whole_day(unchanging, day, path, (path,))


def write_whole_day(
    record: sqlite3.Connection, day: date, path: Path, earlier: Sequence[Path]
) -> None:
    """Write a day's turns to ``path``, after those turns of earlier files that the record lacks.

    Raises UnfinishedFileError, sqlite3.Error.
    """
    try:
        with contextlib.ExitStack() as stack:
            files = [stack.enter_context(_opened(file)) for file in earlier]
            unfinished = stack.enter_context(whole_file(path))
            file = _new_file(unfinished)
            _fill(file, record, day, [one for one in files if one is not None])
            file.close()
    except (OSError, RuntimeError) as error:
        raise UnfinishedFileError(None, hdf5_reason(error), str(path)) from error


class UnfinishedFileError(OSError):
    """Raised if a day's file could not be written; ``strerror`` contains the reason.

    While the error exists, HDF5 does not close the file. A program ends with os._exit, because the
    attempt to close the file can end in a segmentation fault.
    """


def hdf5_reason(error: Exception) -> str:
    """Return the reason of an error; for an error of HDF5, the system's message."""
    if system := re.search("error message = '([^']+)'", str(error)):
        return system[1]
    return (error.strerror if isinstance(error, OSError) else None) or str(error)


def open_day(record: sqlite3.Connection, day: date, path: Path) -> tuple[Any, Layout]:
    """Write a day's turns to ``path``; return the file, which others can read while it is extended,
    and its layout.

    The day's copy is written first if the earlier file has turns or events that neither the copy
    nor the record has.
    """
    copy = copy_of(path)
    with _opened(path) as earlier, _opened(copy) as copied:
        lost = earlier is not None and _has_more(earlier, record, day, copied)
    if lost:
        write_whole_day(record, day, copy, (copy, path))
    with _opened(copy) as copied, whole_file(path) as unfinished:
        file = _new_file(unfinished)
        layout = _fill(file, record, day, [] if copied is None else [copied])
        file.swmr_mode = True
        file.flush()
    return file, layout


def _new_file(path: Path) -> Any:
    """Return a new file, which is not closed after an error: the attempt to close a file that could
    not be written, for example on a full disk, can end in a segmentation fault."""
    return h5py.File(path, "w", libver=LIBVER, locking=LOCKING)


def _fill(file: Any, record: sqlite3.Connection, day: date, earlier: list[Any]) -> Layout:
    """Write a day to a new file; return its layout."""
    start_s = midnight_s(day)
    ids, times_s = _ids_and_times(record, day)
    events = [event for one in earlier for event in _events_of_file(one)]
    events = list(dict.fromkeys([*events, *events_in(record, day)]))
    layout = _layout(record, day, earlier, events)
    file.attrs["default"] = "entry"
    _make_layout(file, day, layout)
    entry = file["entry"]
    present = _keys(ids, times_s)
    for one in earlier:
        keys = _keys_of_file(one)
        rows = np.flatnonzero(~np.isin(keys, present))
        for at in range(0, rows.size, _BLOCK):
            _copy(one["entry"], entry, rows[at : at + _BLOCK])
        present = np.concatenate([present, keys[rows]])
    entry.attrs[_RECORD] = record_identity(record)
    entry.attrs[_FIRST_ROW] = entry["turns/id"].size
    for at in range(0, ids.size, _BLOCK):
        block = ids[at : at + _BLOCK]
        where = "id BETWEEN ? AND ? AND recorded LIKE ?"
        turns = turns_in(record, where, int(block[0]), int(block[-1]), f"{day}T%")
        append_turns(entry, turns, start_s, layout)
    append_events(entry, events)
    return layout


def _layout(
    record: sqlite3.Connection, day: date, earlier: list[Any], events: list[Event]
) -> Layout:
    """Return the layout of a file with the day's turns of the record and of earlier files."""
    orders = {*_orders(record, day), *(order for one in earlier for order in _orders_of_file(one))}
    longest = ", ".join(f"max(length(CAST({name} AS BLOB)))" for name in _TEXTS)
    query = f"SELECT {longest} FROM turn WHERE recorded LIKE ?"
    found = record.execute(query, (f"{day}T%",)).fetchone()
    lengths = {name: value or 0 for name, value in zip(_TEXTS, found, strict=True)}
    for name in _TEXTS:
        for one in earlier:
            lengths[name] = max(lengths[name], _longest(one["entry/turns"].get(name)))
    for name, length in {**lengths, **needed_layout([], events).bytes_of}.items():
        lengths[name] = _BYTES[name]
        while lengths[name] < length:
            lengths[name] *= 2
    return Layout(tuple(sorted(orders)), lengths)


def needed_layout(turns: list[RecordedTurn], events: list[Event]) -> Layout:
    """Return the smallest layout of a file that can contain turns and events."""
    orders = {order for turn in turns for order, *_ in turn.fields["harmonics"]}
    texts = {name: _texts(turns, name) for name in _TEXTS} if turns else {}
    for place, name in enumerate(_EVENT):
        texts[name] = [event[place].encode() for event in events]
    lengths = {name: max(map(len, values), default=0) for name, values in texts.items()}
    return Layout(tuple(sorted(orders)), lengths)


def _longest(texts: Any) -> int:
    """Return the number of bytes of the longest text of a column; 0 if the column is missing."""
    if texts is None:
        return 0
    fixed = texts.dtype.kind == "S"
    return int(texts.dtype.itemsize) if fixed else max(map(len, texts[:]), default=0)


def _texts(turns: list[RecordedTurn], name: str) -> list[bytes]:
    values = [turn.fields[name] for turn in turns]
    return [(json.dumps(v) if name == "alarms" else str(v)).encode() for v in values]


def midnight_s(day: date) -> float:
    """Return the beginning of a day (UTC) in seconds since 1970."""
    return datetime(day.year, day.month, day.day, tzinfo=UTC).timestamp()


def _make_layout(file: Any, day: date, layout: Layout) -> None:
    start = datetime(day.year, day.month, day.day, tzinfo=UTC)
    entry = _group(file, "entry", "NXentry")
    entry.attrs["default"] = "orders"
    entry["title"] = "Telemetry of an ArcTrue device, one row per turn"
    entry["start_time"] = _iso(start)
    entry["end_time"] = _iso(start + timedelta(days=1))
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
        _growing(turns, name, _text_type(layout, name), ())
    table = _group(entry, "orders", "NXdata")
    table.attrs.update({"signal": "amplitude", "axes": ["time", "order"]})
    table["time"] = turns["time"]
    table["order"] = np.array(layout.orders, dtype=np.int64)
    for name, unit in _OF_ORDER.items():
        _growing(table, name, "f8", (len(layout.orders),), unit)
    table["phase"].attrs["long_name"] = "error = amplitude · cos(order · angle + phase)"
    _linked(instrument, "head2", "NXpositioner", turns["separation_deg"], "angle after head 1")
    _linked(instrument, "die", "NXsensor", turns["temperature_c"], "temperature of the die")
    _linked(instrument, "table", "NXsensor", turns["table_c"], "temperature of the table")
    events = _group(entry, "events", "NXcollection")
    for name in _EVENT:
        _growing(events, name, _text_type(layout, name), ())


def _text_type(layout: Layout, name: str) -> Any:
    return h5py.string_dtype("utf-8", layout.bytes_of[name])


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
    columns = max(max(width, default=1), 1)
    chunk = max(_CHUNK_BYTES // (np.dtype(kind).itemsize * columns), 1)
    made = parent.create_dataset(
        name,
        (0, *width),
        kind,
        maxshape=(None, *(max(w, 1) for w in width)),
        chunks=(chunk, *(max(w, 1) for w in width)),
    )
    made.attrs.update({**({"units": unit} if unit else {}), **attributes})


def append_turns(entry: Any, turns: list[RecordedTurn], start_s: float, layout: Layout) -> None:
    """Append turns that the layout can hold. A reader that finds the id of a turn finds all its
    values: the id is written when they are in the file."""
    group, table = entry["turns"], entry["orders"]
    _extend(group["time"], np.array([turn.recorded_s - start_s for turn in turns]))
    _extend(group["turn"], np.array([turn.fields["turn"] for turn in turns]))
    for name in _NUMBERS:
        _extend(group[name], np.array([turn.fields[name] for turn in turns], dtype=np.float64))
    for name in _TEXTS:
        _extend(group[name], np.array(_texts(turns, name), dtype=group[name].dtype))
    values = np.full((len(_OF_ORDER), len(turns), len(layout.orders)), np.nan)
    columns = {order: column for column, order in enumerate(layout.orders)}
    for row, turn in enumerate(turns):
        for order, *harmonic in turn.fields["harmonics"]:
            values[:, row, columns[order]] = harmonic
    for name, part in zip(_OF_ORDER, values, strict=True):
        _extend(table[name], part)
    entry.file.flush()
    _extend(group["id"], np.array([turn.id for turn in turns]))
    entry.file.flush()


def append_events(entry: Any, events: list[Event]) -> None:
    """Append events that the layout can hold."""
    for place, name in enumerate(_EVENT):
        column = entry["events"][name]
        _extend(column, np.array([event[place].encode() for event in events], dtype=column.dtype))
    entry.file.flush()


def _extend(dataset: Any, values: Any) -> None:
    before = dataset.shape[0]
    dataset.resize(before + len(values), axis=0)
    dataset[before:] = values
    dataset.flush()  # raises an error on a full disk; the end of an unflushed dataset would not


def events_in(record: sqlite3.Connection, day: date, after_turn: int = 0) -> list[Event]:
    """Return the events of a day that happened after a turn was recorded, oldest first."""
    query = (
        "SELECT recorded, kind, text FROM event WHERE after_turn >= ? AND recorded LIKE ? "
        "ORDER BY id"
    )
    rows = record.execute(query, (after_turn, f"{day}T%"))
    return [(str(a), str(b), str(c)) for a, b, c in rows]


def _events_of_file(file: Any) -> list[Event]:
    columns = [file[f"entry/events/{name}"].asstr()[:].tolist() for name in _EVENT]
    return list(zip(*columns, strict=True))


def _copy(source: Any, entry: Any, rows: Any) -> None:
    """Append the turns of an earlier file; a column that this file lacks gets NaN for a number and
    an empty text for a text."""
    turns, table = source["turns"], source["orders"]
    for name, column in entry["turns"].items():
        if name in turns:
            # A list, because files of version 0.1 have texts of variable length.
            _extend(column, np.array(turns[name][rows].tolist(), dtype=column.dtype))
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
    return [int(order) for order in file["entry/orders/order"][:]]


def _has_more(file: Any, record: sqlite3.Connection, day: date, copied: Any) -> bool:
    """Tell whether a file has turns or events that neither the record nor the copy has."""
    keys, events = _keys(*_ids_and_times(record, day)), set(events_in(record, day))
    if copied is not None:
        keys = np.concatenate([keys, _keys_of_file(copied)])
        events |= set(_events_of_file(copied))
    more = ~np.isin(_keys_of_file(file), keys)
    return bool(more.any()) or not events.issuperset(_events_of_file(file))


def _keys_of_file(file: Any) -> Any:
    turns = file["entry/turns"]
    return _keys(turns["id"][:], turns["time"][:])


def _keys(ids: Any, times_s: Any) -> Any:
    """Return a number that identifies each turn, (n,), computed from id and time.

    Turns of different records may have the same id, but not the same time.
    """
    return (ids << _MILLISECOND_BITS) | np.rint(1000.0 * times_s).astype(np.int64)


def _ids_and_times(record: sqlite3.Connection, day: date) -> tuple[Any, Any]:
    """Return ids, (n,), and seconds since midnight, (n,), of the turns of a day in the record."""
    start_s = midnight_s(day)
    query = "SELECT id, recorded FROM turn WHERE recorded LIKE ? ORDER BY id"
    rows = [
        (number, datetime.fromisoformat(recorded).timestamp() - start_s)
        for number, recorded in record.execute(query, (f"{day}T%",))
    ]
    ids, times_s = [row[0] for row in rows], [row[1] for row in rows]
    return np.array(ids, dtype=np.int64), np.array(times_s, dtype=np.float64)


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
        if attributes.get(_RECORD) != identity:
            return False
        if _LAST_ID in attributes:
            return int(attributes[_LAST_ID]) >= last
        own = file["entry/turns/id"][int(attributes[_FIRST_ROW]) :]
        return int(own.max(initial=0)) >= last


@contextlib.contextmanager
def _opened(path: Path, *, swmr: bool = False) -> Iterator[Any]:
    """Yield the open file of a day, or None if it is missing, damaged or of another kind.

    A file that is being extended, or whose writer was killed, is only opened with ``swmr``.
    """
    file = None
    for mode in (False, True) if swmr else (False,):
        with contextlib.suppress(OSError):
            file = h5py.File(path, "r", swmr=mode, locking=LOCKING)
            break
    try:
        whole = file is not None and all(name in file for name in _WHOLE)
        yield file if whole else None
    finally:
        if file is not None:
            file.close()


def _iso(moment: datetime) -> str:
    return moment.isoformat(timespec="milliseconds").replace("+00:00", "Z")
