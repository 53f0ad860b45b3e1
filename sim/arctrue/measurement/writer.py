"""Writes a measurement set to a folder."""

from __future__ import annotations

import csv
import io
import json
from collections.abc import Mapping
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import numpy as np
import tomli_w
from numpy.typing import NDArray

from arctrue.base.extras import installed, optional
from arctrue.base.whole_file import whole_file
from arctrue.measurement.csv_blocks import LARGEST_NUMBER
from arctrue.measurement.description import FILE_NAME, SECTIONS
from arctrue.measurement.mask_file import FILE_NAME as MASK_NAME
from arctrue.measurement.measurement_set import (
    CAPTURE_COLUMNS,
    CAPTURE_OPTIONAL,
    SCHEMA,
    WHOLE_COLUMNS,
    Capture,
    MeasurementSet,
    Reference,
)

_REFERENCE_ORDER = (
    "run",
    "time_s",
    "cycle",
    "direction",
    "target_deg",
    "head1_counts",
    "error_arcsec",
    "temperature_c",
    "u_arcsec",
    "mask",
)
FILES_OF_A_SET = ("capture.csv", "reference.csv", MASK_NAME)
"""Files that the reader takes as parts of a set because of their names."""
ROWS_TOGETHER = 1 << 14
SMALLEST_PLAIN, LARGEST_PLAIN = 1e-6, 1e10
"""Absolute values in this range, and 0, are written without an exponent; all other numbers have an
exponent."""
_DECIMALS = {"time_s": 6, "target_deg": 9, "error_arcsec": 6, "temperature_c": 3, "u_arcsec": 6}


def refuse_occupied(folder: Path) -> None:
    """Raise ValueError if ``folder`` holds a set or a file with the name of a part of a set.

    Such a file may be the user's only copy, and a new set would replace it.
    """
    if (folder / FILE_NAME).exists():
        raise ValueError(f"{folder}: already holds a measurement set; name a new folder")
    for name in FILES_OF_A_SET:
        if (folder / name).exists():
            raise ValueError(
                f"{folder}: already holds a {name}, which the new set would replace; "
                "name a new folder"
            )


def write_measurement_set(folder: Path | str, measurement: MeasurementSet) -> None:
    """Write a set to a folder.

    Times are rounded to 1 µs, targets to 10⁻⁹ °, errors and uncertainties to 10⁻⁶ ″, temperatures
    to 1 mK. If the folder holds a set, the new set replaces it completely: capture.csv,
    reference.csv and mask.csv are removed if the new set has no such part.

    Parameters
    ----------
    folder : Path or str
        The folder; it is created if it does not exist.
    measurement : MeasurementSet
        The set that is written.

    Raises
    ------
    ValueError
        If the set has neither capture nor reference, if a value is not finite or exceeds the
        reader's limit, or if a folder without a set holds a file with the name of a part of a set.
    OSError
        If the folder cannot be written.
    """
    if measurement.capture is None and measurement.reference is None:
        raise ValueError("a measurement set needs a capture or a reference run")
    folder = Path(folder)
    if not (folder / FILE_NAME).exists():
        refuse_occupied(folder)
    tables = {}
    if measurement.capture is not None:
        tables["capture.csv"] = _columns(measurement.capture, (*CAPTURE_COLUMNS, *CAPTURE_OPTIONAL))
    if measurement.reference is not None:
        tables["reference.csv"] = _columns(measurement.reference, _REFERENCE_ORDER)
    if (mask := _mask_file(measurement)) is not None:
        tables[MASK_NAME] = mask
    with ExitStack() as unfinished:
        # The description is moved to its final place last, because only a folder with a description
        # is a set.
        description = unfinished.enter_context(whole_file(folder / FILE_NAME))
        description.write_text(_description(measurement), encoding="utf-8")
        for name, table in tables.items():
            _write_csv(unfinished.enter_context(whole_file(folder / name)), table)
    for name in FILES_OF_A_SET:
        if name not in tables:
            (folder / name).unlink(missing_ok=True)


def _mask_file(measurement: MeasurementSet) -> dict[str, NDArray[Any]] | None:
    """Return the columns of mask.csv, which lists the rows that must be used although they look
    wrong; None if the set names no such rows.

    The masked rows are listed too, so that the file has all decisions of the user about rows.
    """
    parts = {"capture": measurement.capture, "reference": measurement.reference}
    decided = {
        name: (rows.trusted, np.zeros_like(rows.trusted) if rows.mask is None else rows.mask)
        for name, rows in parts.items()
        if rows is not None and rows.trusted is not None
    }
    lines = {name: np.flatnonzero(used | masked) for name, (used, masked) in decided.items()}
    size = sum(listed.size for listed in lines.values())
    if not size:
        return None
    columns = {f"{name}_row": np.zeros(size, dtype=np.int64) for name in lines}
    columns["mask"] = np.zeros(size, dtype=np.int64)
    start = 0
    for name, listed in lines.items():
        span = slice(start, start + listed.size)
        columns[f"{name}_row"][span] = listed + 2
        columns["mask"][span] = decided[name][1][listed]
        start = span.stop
    return columns


def _write_csv(path: Path, columns: Mapping[str, NDArray[Any]]) -> None:
    """Write a CSV file; with pyarrow the function is faster and gives the same text."""
    with path.open("wb") as file:
        file.write(_header(list(columns)).encode())
        if installed("pyarrow"):
            pa, pa_csv = optional("pyarrow"), optional("pyarrow.csv")
            options = pa_csv.WriteOptions(include_header=False, quoting_style="none")
            pa_csv.write_csv(pa.table(dict(columns)), file, options)
            return
        for start in range(0, len(next(iter(columns.values()))), ROWS_TOGETHER):
            block = [values[start : start + ROWS_TOGETHER].tolist() for values in columns.values()]
            rows = zip(*([number_text(item) for item in column] for column in block), strict=True)
            file.write("".join(",".join(row) + "\n" for row in rows).encode())


def number_text(value: float) -> str:
    """Return the shortest text that is read as the same number; pyarrow writes the same text."""
    if isinstance(value, int):
        return str(value)
    size = abs(value)
    if size != 0.0 and not SMALLEST_PLAIN <= size < LARGEST_PLAIN:
        return np.format_float_scientific(value, trim="-", exp_digits=1)
    return np.format_float_positional(value, trim="-")


def _description(measurement: MeasurementSet) -> str:
    lines = [f"schema = {SCHEMA}"]
    if measurement.title:
        lines.append(f"title = {json.dumps(measurement.title, ensure_ascii=False)}")
    if measurement.date is not None:
        lines.append(f'date = "{measurement.date.isoformat()}"')
    table = dict(vars(measurement.table))
    if measurement.table.head_places_deg is not None:
        # The second entry of the places is the separation.
        table.pop("head_separation_deg", None)
    sections: dict[str, Mapping[str, Any]] = {"table": table}
    further: dict[str, dict[str, Any]] = {}
    for dotted, value in measurement.other.items():
        section, _, key = dotted.partition(".")
        if section in SECTIONS and key:
            further.setdefault(section, {})[key] = value
        else:
            further.setdefault("", {})[dotted] = value
    own = further.pop("", {})
    if measurement.capture is not None:
        sections["capture"] = {"file": "capture.csv", "clock_hz": measurement.capture.clock_hz}
    if measurement.reference is not None:
        sections["reference"] = {
            "file": "reference.csv",
            "instrument": measurement.reference.instrument,
            "faces": measurement.reference.faces,
            "standard_uncertainty_arcsec": measurement.reference.standard_uncertainty_arcsec,
            "clock_offset_s": measurement.reference.clock_offset_s,
        }
    # Keys of other programs are written as they were read: single keys come first, tables below.
    alone = {key: value for key, value in own.items() if not isinstance(value, dict)}
    lines += tomli_w.dumps(alone).splitlines() if alone else []
    sections["origin"] = vars(measurement.origin)
    for name, keys in sections.items():
        entries = {key: value for key, value in keys.items() if value is not None}
        unknown = further.get(name, {})
        if entries or unknown:
            lines += ["", f"[{name}]"]
            lines += [f"{key} = {_toml(value)}" for key, value in entries.items()]
            lines += tomli_w.dumps(unknown).splitlines() if unknown else []
    tables = {key: value for key, value in own.items() if isinstance(value, dict)}
    lines += ["", *tomli_w.dumps(tables).splitlines()] if tables else []
    return "\n".join(lines) + "\n"


def _toml(value: str | float | tuple[str | float, ...]) -> str:
    if isinstance(value, tuple) and not any(isinstance(item, str) for item in value):
        return f"[{', '.join(map(repr, value))}]"
    if isinstance(value, tuple):
        return "[\n" + "".join(f"    {_toml(item)},\n" for item in value) + "]"
    return json.dumps(value, ensure_ascii=False) if isinstance(value, str) else repr(value)


def _columns(columns: Capture | Reference, names: tuple[str, ...]) -> dict[str, NDArray[Any]]:
    arrays: dict[str, NDArray[Any]] = {
        name: np.asarray(getattr(columns, name))
        for name in names
        if getattr(columns, name) is not None
    } | {name: np.asarray(values) for name, values in columns.conditions.items()}
    converted: dict[str, NDArray[Any]] = {}
    for name, array in arrays.items():
        if name in WHOLE_COLUMNS:
            converted[name] = array.astype(np.int64)
            continue
        bad = np.flatnonzero(~np.isfinite(array))
        if bad.size:
            raise ValueError(f"{name}[{bad[0]}]: {array[bad[0]]} is not a finite number")
        large = np.flatnonzero(np.abs(array) > LARGEST_NUMBER)
        if large.size:
            raise ValueError(
                f"{name}[{large[0]}]: {array[large[0]]:g} is too large; expected a number "
                f"within ±{LARGEST_NUMBER:g}, because no larger number can be read"
            )
        decimals = _DECIMALS.get(name)
        values = array.astype(np.float64)
        converted[name] = values if decimals is None else np.round(values, decimals)
    return converted


def _header(names: list[str]) -> str:
    line = io.StringIO()
    csv.writer(line, lineterminator="\n").writerow(names)
    return line.getvalue()
