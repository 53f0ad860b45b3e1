"""Reads MAT files of MATLAB and Octave: level 5 (-v6, -v7), and level 7.3, which is HDF5."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from arctrue.importing.choices import Ambiguous, Choices
from arctrue.importing.file_content import FileContent
from arctrue.importing.reader import ReadSettings
from arctrue.importing.readers.arrays import recording_of
from arctrue.importing.readers.mat_sizes import unpacked_bytes
from arctrue.importing.readers.unpacked_size import refuse_above_limit
from arctrue.measurement import MeasurementError

LEVEL_5, LEVEL_73 = b"MATLAB 5.0 MAT-file", b"MATLAB 7.3 MAT-file"
MOST_ROWS_LYING = 16
"""A matrix with fewer rows than this, and with fewer rows than columns, has one quantity per row;
any other matrix has one quantity per column."""
NUMBER_BYTES = 8
"""Bytes of a number in memory; the file may store a number in one byte."""
TOP = "/"
_NUMBERS = ("int8", "int16", "int32", "int64", "uint8", "uint16", "uint32", "uint64",
            "single", "double", "logical", "char")  # fmt: skip
_OBJECTS = (
    "tables, timetables and other objects are in a form that only MATLAB reads: in MATLAB, "
    "s = table2struct(T, 'ToScalar', true); save('log.mat', '-struct', 's')"
)

Tree = dict[str, Any]
"""Arrays and structs by name; a struct contains arrays and structs in the same way."""


def recognises(path: Path, head: bytes) -> bool:
    """Tell whether the file begins with the text of level 5 or 7.3; in a file ``*.mat``, the
    version number and byte order of level 5 are enough."""
    return head.startswith((LEVEL_5, LEVEL_73)) or (
        path.suffix.lower() == ".mat" and head[124:128] in (b"\x00\x01IM", b"\x01\x00MI")
    )


def read(path: Path, settings: ReadSettings, choices: Choices) -> FileContent:
    """Read the vectors of the file, or of one struct (``settings.group``), as columns.

    A matrix becomes several columns. Only columns of the most frequent length are kept; other
    vectors and cells are left out, with a note. If several structs hold columns, the user chooses
    one. Raises MeasurementError for a damaged file, an unknown struct or a file above the limit,
    AmbiguousError, and ValueError for a file of level 7.3 if h5py is not installed.
    """
    left_out: list[str] = []
    with path.open("rb") as file:
        level_73 = file.read(len(LEVEL_73)) == LEVEL_73
    tree = _level_73(path, left_out) if level_73 else _level_5(path, left_out)
    groups: dict[str, dict[str, NDArray[Any]]] = {}
    notes: list[str] = []
    for name, item in tree.items():
        group, inside = (name, item) if isinstance(item, dict) else (TOP, {name: item})
        for column, array in _leaves(inside):
            found = _as_rows(np.asarray(array))
            if found is None:
                left_out.append(column if group == TOP else f"{group}.{column}")
                continue
            if found.ndim == 2 and len(found) != len(array):
                notes.append(f"{path.name}: {column} is transposed: each of its rows is a column")
            groups.setdefault(group, {})[column] = found
    group = _group(path, settings.group, groups, left_out, choices)
    arrays = _equally_long(groups[group], left_out)
    left_out += [name for name in groups if name != group]
    if left_out:
        notes.append(f"{path.name}: left out: {', '.join(left_out)}")
    recording = recording_of(path, "mat", arrays)
    return FileContent(path, "mat", recording.columns, notes=(*recording.notes, *notes))


def _leaves(tree: Mapping[str, Any], before: str = "") -> list[tuple[str, Any]]:
    found: list[tuple[str, Any]] = []
    for name, item in tree.items():
        full = f"{before}{name}"
        found += _leaves(item, f"{full}.") if isinstance(item, dict) else [(full, item)]
    return found


def _as_rows(array: NDArray[Any]) -> NDArray[Any] | None:
    """Return an array as (rows,) or (rows, columns); None if it cannot be a column."""
    if array.dtype.kind not in "iufbU" or array.ndim > 2 or array.size == 0:
        return None
    if array.ndim < 2 or 1 in array.shape:
        return np.ravel(array)
    lying = array.shape[0] < min(array.shape[1], MOST_ROWS_LYING)
    return array.T if lying else array


def _group(
    path: Path,
    wanted: str,
    groups: Mapping[str, Mapping[str, NDArray[Any]]],
    left_out: list[str],
    choices: Choices,
) -> str:
    with_rows = [name for name, columns in groups.items() if max(map(len, columns.values())) > 1]
    if not with_rows:
        more = f"; {', '.join(left_out)} cannot be read: {_OBJECTS}" if left_out else ""
        raise MeasurementError("empty", path, f"holds no columns of numbers{more}")
    if not wanted:
        if len(with_rows) == 1:
            return with_rows[0]
        asked = Ambiguous("--group", f"{path}: several structs hold data.", with_rows)
        wanted = choices.ask(asked)
    if wanted not in with_rows:
        listed = ", ".join(with_rows)
        raise MeasurementError("missing", path, f"no data in {wanted}; there are {listed}")
    return wanted


def _equally_long(
    columns: Mapping[str, NDArray[Any]], left_out: list[str]
) -> dict[str, NDArray[Any]]:
    """Return the columns of the most frequent length; a scalar is not a column."""
    lengths = Counter(len(array) for array in columns.values() if len(array) > 1)
    rows = max(lengths, key=lambda length: (lengths[length], length))
    for name, array in columns.items():
        if len(array) != rows:
            value = f" = {array.tolist()[0]}" if array.size == 1 else f" ({len(array)} rows)"
            left_out.append(f"{name}{value}")
    return {name: array for name, array in columns.items() if len(array) == rows}


def _level_5(path: Path, left_out: list[str]) -> Tree:
    from scipy.io import loadmat, whosmat

    total = unpacked_bytes(path)
    try:
        held = whosmat(path)
        wanted = [name for name, _, kind in held if kind in (*_NUMBERS, "struct")]
        left_out += [f"{name or 'an object'} ({kind})" for name, _, kind in held
                     if name not in wanted]  # fmt: skip
        numbers = sum(math.prod(shape) for _, shape, kind in held if kind in _NUMBERS)
        # The sizes of arrays inside a struct are unknown; each byte of the file may become a number
        # in memory.
        structs = total if any(kind == "struct" for _, _, kind in held) else 0
        refuse_above_limit(path, NUMBER_BYTES * max(numbers, structs))
        loaded = loadmat(path, variable_names=wanted, simplify_cells=True)
        return {name: item for name, item in loaded.items() if not name.startswith("__")}
    except MeasurementError:
        raise
    except Exception as error:  # a damaged file makes scipy raise arbitrary exceptions
        raise MeasurementError("format", path, f"cannot be read as MAT: {error}") from error


def _level_73(path: Path, left_out: list[str]) -> Tree:
    try:
        import h5py  # type: ignore[import-not-found,import-untyped,unused-ignore]
    except ImportError as error:
        raise ValueError(
            f"{path}: MAT of level 7.3 needs h5py: pip install 'arctrue[files]', "
            "or save('log.mat', '-v7') in MATLAB"
        ) from error
    size = 0

    def tree_of(group: Any, before: str) -> Tree:
        nonlocal size
        found: Tree = {}
        for name in group:
            if not before and name.startswith("#"):
                continue
            if isinstance(group.get(name, getlink=True), h5py.ExternalLink):
                left_out.append(f"{before}{name} (in another file)")
                continue
            item = group[name]
            kind = _text(item.attrs.get("MATLAB_class", ""))
            if isinstance(item, h5py.Group):
                found[name] = tree_of(item, f"{before}{name}.")
            elif kind in _NUMBERS and not item.external and not item.is_virtual:
                if item.attrs.get("MATLAB_empty", 0):
                    continue
                size += item.size * NUMBER_BYTES
                refuse_above_limit(path, size)
                # In HDF5, MATLAB stores each column of a matrix as a row.
                values = np.asarray(item[()]).T
                found[name] = _letters(values) if kind == "char" else values
            else:
                left_out.append(f"{before}{name} ({kind or 'of no class of MATLAB'})")
        return found

    try:
        with h5py.File(path, "r") as file:
            return tree_of(file, "")
    except (OSError, RuntimeError, KeyError) as error:
        raise MeasurementError("format", path, f"cannot be read as MAT: {error}") from error


def _text(value: Any) -> str:
    return value.decode("ascii", "replace") if isinstance(value, bytes) else str(value)


def _letters(codes: NDArray[Any]) -> NDArray[np.str_]:
    """Join each row of a matrix of characters to one text."""
    return np.array(["".join(map(chr, row)).rstrip() for row in np.atleast_2d(codes).tolist()])
