"""Makes columns from arrays in memory, for the readers of NumPy, Parquet, HDF5 and MAT files."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from arctrue.importing.file_content import FileContent
from arctrue.measurement import MeasurementError


def recording_of(path: Path, format_name: str, arrays: Mapping[str, NDArray[Any]]) -> FileContent:
    """Return equally long columns; a matrix becomes numbered columns (``name.1``).

    A structured array gives one column per field. Single numbers are ignored. Raises
    MeasurementError if no rows remain, and for arrays of unequal length or of more than two
    dimensions, and for integers of 2⁶³ or more.
    """
    columns: dict[str, NDArray[Any]] = {}
    for name, array in arrays.items():
        if array.dtype.names:
            for field in array.dtype.names:
                columns[f"{name}.{field}" if name else field] = _plain(path, field, array[field])
        elif array.ndim == 2:
            for place in range(array.shape[1]):
                key = f"{name}.{place + 1}" if name else str(place + 1)
                columns[key] = _plain(path, key, array[:, place])
        elif array.ndim == 1:
            columns[name or "1"] = _plain(path, name or "1", array)
        elif array.ndim > 2:
            raise MeasurementError(
                "format", path, f"expected rows and columns, found an array {array.shape}",
                column=name or None,
            )  # fmt: skip
    sizes = {name: column.size for name, column in columns.items()}
    if not sizes or not max(sizes.values()):
        raise MeasurementError("empty", path, "holds no columns of numbers")
    if len(set(sizes.values())) > 1:
        listed = ", ".join(f"{name} {size}" for name, size in sizes.items())
        raise MeasurementError("format", path, f"its columns are not equally long: {listed}")
    note = f"{path.name}: {max(sizes.values())} rows of {len(columns)} columns ({format_name})"
    return FileContent(path, format_name, columns, notes=(note,))


def _plain(path: Path, name: str, array: NDArray[Any]) -> NDArray[Any]:
    if array.ndim != 1:
        raise MeasurementError(
            "format", path, f"expected a column, found an array {array.shape}", column=name
        )
    kind = array.dtype.kind
    if kind in "iub":
        largest = int(array.max()) if array.size else 0
        if largest >= 2**63:
            raise MeasurementError(
                "value", path, f"{largest} does not fit into 64 bits", column=name
            )
        return array.astype(np.int64)
    if kind == "f":
        return array.astype(np.float64)
    if kind == "M":
        return np.datetime_as_string(array, unit="us")
    if kind == "S":
        return np.char.decode(array, "utf-8", "replace")
    return np.array(
        [
            item.decode("utf-8", "replace") if isinstance(item, bytes) else str(item)
            for item in array.tolist()
        ]
    )
