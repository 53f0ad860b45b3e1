"""``measurement.toml``: what was measured, and with what."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path, PurePosixPath, PureWindowsPath
from typing import Any, Literal

from arctrue.measurement.errors import MeasurementError
from arctrue.measurement.measurement_set import SCHEMA
from arctrue.printable import is_printable, one_line
from arctrue.toml_file import TomlContentError, read_toml

FILE_NAME = "measurement.toml"

LARGEST = 2**63
"""Of any number of the file; NaN is not within it."""

Kind = Literal["text", "file", "whole", "number"]


@dataclass(frozen=True)
class Key:
    """Type and range of one key: ``low`` itself is allowed only where ``closed``."""

    kind: Kind
    low: float = -math.inf
    high: float = math.inf
    closed: bool = True


KEYS: Mapping[str, Mapping[str, Key]] = {
    "": {"schema": Key("whole"), "title": Key("text")},
    "table": {
        "counts_per_rev": Key("whole", low=4, high=2**62),
        "grating_lines": Key("whole", low=1),
        "disc_diameter_mm": Key("number", low=0, closed=False),
        "head_separation_deg": Key("number", low=-360, high=360, closed=False),
        "index_detection_arcsec": Key("number", low=0, high=3600),
        "drive_gear_teeth": Key("number", low=0, closed=False),
        "faces": Key("whole", low=1),
        "index_repeatability_counts": Key("number", low=0),
    },
    "capture": {"file": Key("file"), "clock_hz": Key("number", low=0, closed=False)},
    "reference": {
        "file": Key("file"),
        "instrument": Key("text"),
        "faces": Key("whole", low=1),
        "standard_uncertainty_arcsec": Key("number", low=0),
        "clock_offset_s": Key("number"),
    },
    "origin": {"command": Key("text"), "program": Key("text")},
}
_KIND_NAMES = {
    "text": "text",
    "file": "text",
    "whole": "a whole number",
    "number": "a finite number",
}


@dataclass(frozen=True)
class Description:
    """Checked keys by section ("" is the top), the unknown ones, and warnings about them."""

    path: Path
    values: Mapping[str, Mapping[str, Any]]
    sections: frozenset[str]
    other: Mapping[str, Any]
    warnings: tuple[str, ...]


def read_description(folder: Path) -> Description:
    """Read and check ``folder``/measurement.toml; MeasurementError names file and key."""
    path = folder / FILE_NAME
    if not folder.is_dir():
        what = "is a file, expected a folder" if folder.exists() else "no such folder"
        raise MeasurementError("missing", folder, f"{what} with a {FILE_NAME}")
    try:
        content = read_toml(path)
    except FileNotFoundError as error:
        raise MeasurementError("missing", path, "no such file; every set needs one") from error
    except OSError as error:
        raise MeasurementError("missing", path, f"cannot be read: {error.strerror}") from error
    except TomlContentError as error:
        raise MeasurementError("format", path, str(error)) from error

    values: dict[str, dict[str, Any]] = {section: {} for section in KEYS}
    other: dict[str, Any] = {}
    sections: set[str] = set()
    for name, value in content.items():
        if name in KEYS:
            if not isinstance(value, dict):
                raise MeasurementError(
                    "value", path, f"{name}: expected a section [{name}], found {value!r}"
                )
            sections.add(name)
            _take(path, name, value, values[name], other)
        else:
            _take(path, "", {name: value}, values[""], other)
    schema = values[""].get("schema")
    if schema is None:
        raise MeasurementError("missing", path, f"schema: is missing; expected schema = {SCHEMA}")
    if schema != SCHEMA:
        raise MeasurementError(
            "value", path, f"schema: this program reads schema {SCHEMA}, found {schema}"
        )
    warnings = tuple(f"{path}: {one_line(key)}: is not known and is not used" for key in other)
    return Description(path, values, frozenset(sections), other, warnings)


def _take(
    path: Path,
    section: str,
    content: Mapping[str, Any],
    values: dict[str, Any],
    other: dict[str, Any],
) -> None:
    for name, value in content.items():
        dotted = f"{section}.{name}" if section else name
        key = KEYS[section].get(name)
        if key is None:
            other[dotted] = value
        else:
            values[name] = _checked(path, dotted, key, value)


def _checked(path: Path, dotted: str, key: Key, value: Any) -> Any:
    if key.kind in ("text", "file"):
        right = isinstance(value, str)
    else:
        right = (
            isinstance(value, int if key.kind == "whole" else int | float)
            and not isinstance(value, bool)
            and abs(value) <= LARGEST
        )
    if not right:
        raise MeasurementError(
            "value", path, f"{dotted}: expected {_KIND_NAMES[key.kind]}, found {value!r}"
        )
    if isinstance(value, str):
        _check_text(path, dotted, key.kind, value)
        return value
    inside = key.low <= value <= key.high if key.closed else key.low < value < key.high
    if not inside:
        low = "at least" if key.closed else "more than"
        limits = [f"{low} {key.low:g}"] if math.isfinite(key.low) else []
        if math.isfinite(key.high):
            limits.append(f"{'at most' if key.closed else 'less than'} {key.high:g}")
        raise MeasurementError(
            "value", path, f"{dotted}: expected {' and '.join(limits)}, found {value!r}"
        )
    return value


def _check_text(path: Path, dotted: str, kind: Kind, value: str) -> None:
    if not is_printable(value):
        raise MeasurementError(
            "value", path, f"{dotted}: expected one line of printable text, found {value!r}"
        )
    if kind == "file" and not _stays_inside(value):
        raise MeasurementError(
            "value",
            path,
            f"{dotted}: expected a file in the set's own folder, found {value!r}: "
            "copy or link the file into the folder, and name it without ..",
        )


def _stays_inside(name: str) -> bool:
    """True if ``name`` is a relative path without "..", read as a path of any system."""
    windows, posix = PureWindowsPath(name), PurePosixPath(name)
    return not (windows.anchor or posix.is_absolute() or ".." in windows.parts + posix.parts)
