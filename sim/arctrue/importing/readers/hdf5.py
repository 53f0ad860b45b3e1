"""Reads HDF5 files with the package h5py (``pip install 'arctrue[files]'``)."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from arctrue.base.extras import optional
from arctrue.importing.choices import Ambiguous, Choices
from arctrue.importing.file_content import FileContent
from arctrue.importing.reader import ReadSettings
from arctrue.importing.readers.arrays import recording_of
from arctrue.importing.readers.unpacked_size import refuse_above_limit
from arctrue.measurement import MeasurementError


def recognises(path: Path, head: bytes) -> bool:
    """Tell whether the file begins with the HDF5 signature."""
    return head.startswith(b"\x89HDF\r\n\x1a\n")


def read(path: Path, settings: ReadSettings, choices: Choices) -> FileContent:
    """Return the datasets of one group as columns, or the columns of one table (compound or
    two-dimensional dataset).

    ``settings.group`` names the group or the dataset; without it, the user must choose one if
    several contain data.

    Raises MeasurementError for a damaged file, an unknown group or a size above the limit, and
    :class:`~arctrue.base.extras.MissingExtraError`, a ValueError, without h5py.
    """
    h5py = optional("h5py")
    try:
        with h5py.File(path, "r") as file:
            found: dict[str, dict[str, Any]] = {}

            def visit(name: str, item: Any) -> None:
                if isinstance(item, h5py.Dataset) and item.ndim in (1, 2):
                    refuse_other_files(path, name, item)
                    parent, _, own = name.rpartition("/")
                    # The user selects a table like a group; any other dataset is a column of its
                    # group.
                    table = item.ndim == 2 or item.dtype.names
                    found.setdefault(name if table else parent, {})["" if table else own] = item

            file.visititems(visit)
            group = _group(path, settings.group.strip("/"), list(found), choices)
            refuse_above_limit(path, sum(item.nbytes for item in found[group].values()))
            arrays = {name: np.asarray(item[()]) for name, item in found[group].items()}
    except OSError as error:
        raise MeasurementError("format", path, f"cannot be read as HDF5: {error}") from error
    return recording_of(path, "hdf5", arrays)


def refuse_other_files(path: Path, name: str, item: Any) -> None:
    """Raise MeasurementError for a dataset whose values are in another file.

    Without this check a file from another machine could make the import read any file of this
    machine.
    """
    if item.external or item.is_virtual:
        raise MeasurementError(
            "value",
            path,
            f"/{name}: its values are stored in another file, which is not read: "
            "write them into this file (h5repack, or a copy with h5py)",
        )


def _group(path: Path, wanted: str, groups: list[str], choices: Choices) -> str:
    if not groups:
        raise MeasurementError("empty", path, "holds no columns of numbers")
    if not wanted and len(groups) > 1:
        wanted = choices.ask(
            Ambiguous("--group", f"{path}: several groups hold data.", [f"/{g}" for g in groups])
        ).strip("/")
    if not wanted and len(groups) == 1:
        return groups[0]
    if wanted not in groups:
        listed = ", ".join(f"/{name}" for name in groups)
        raise MeasurementError("missing", path, f"no data in /{wanted}; there are {listed}")
    return wanted
