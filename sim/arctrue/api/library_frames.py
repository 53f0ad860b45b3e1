"""Reads the columns of pandas, xarray and HDF5 tables, with the units that they state."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from arctrue.api.frame import SET_COLUMNS, Frame
from arctrue.api.keywords import known_attributes
from arctrue.base.extras import optional
from arctrue.importing.readers.hdf5 import refuse_other_files
from arctrue.importing.readers.unpacked_size import refuse_above_limit
from arctrue.measurement import MeasurementError


def given(capture: Any, reference: Any) -> dict[str, Any]:
    """Return the arguments of a reader that are not None, by channel."""
    both = zip(SET_COLUMNS, (capture, reference), strict=True)
    return {name: argument for name, argument in both if argument is not None}


def pandas_frame(name: str, table: Any) -> Frame:
    """Return the columns of a pandas.DataFrame, with the units in its ``attrs``.

    Raises TypeError for another type, MeasurementError for two columns of the same name.
    """
    if not (hasattr(table, "columns") and hasattr(table, "__getitem__")):
        raise TypeError(
            f"{name}: expected a pandas.DataFrame, found {type(table).__name__}; "
            "from_arrays takes a dictionary of arrays"
        )
    names = list(table.columns)
    twice = sorted({str(one) for one in names if names.count(one) > 1})
    if twice:
        raise MeasurementError(
            "format", Path(name), "occurs twice; rename one of the two", column=twice[0]
        )
    stated = (getattr(table, "attrs", None) or {}).get("units", {})
    return Frame(name, {str(one): table[one] for one in names}, stated)


def xarray_frames(tables: Mapping[str, Any]) -> tuple[list[Frame], dict[str, Any]]:
    """Return the one-dimensional variables of an xarray.Dataset per channel, and the keywords in
    their attributes.

    Raises TypeError for another type, MeasurementError for variables with different dimensions.
    """
    frames: list[Frame] = []
    stated: dict[str, Any] = {}
    for name, table in tables.items():
        if not (hasattr(table, "variables") and hasattr(table, "sizes")):
            raise TypeError(f"{name}: expected an xarray.Dataset, found {type(table).__name__}")
        stated |= known_attributes(table.attrs)
        found = {str(key): item for key, item in table.variables.items() if item.ndim == 1}
        dimensions = sorted({str(item.dims[0]) for item in found.values()})
        if len(dimensions) > 1:
            raise MeasurementError(
                "format",
                Path(name),
                f"expected one dimension, found {', '.join(dimensions)}: select the variables "
                "of one of them",
            )
        frames.append(
            Frame(
                name,
                {key: _unpacked(item.values, item.attrs) for key, item in found.items()},
                {key: item.attrs.get("units") for key, item in found.items()},
            )
        )
    return frames, stated


def hdf5_frames(path: Path, groups: Mapping[str, str]) -> tuple[list[Frame], dict[str, Any]]:
    """Return the columns of one group of an HDF5 file per channel, and the keywords in the
    attributes of file and groups.

    ``groups``: the group of each channel; if empty, ``/capture`` and ``/reference`` are read.
    Raises MeasurementError, and MissingExtraError without h5py.
    """
    h5py = optional("h5py")
    frames: list[Frame] = []
    stated: dict[str, Any] = {}
    try:
        with h5py.File(path, "r") as opened:
            stated |= known_attributes(opened.attrs)
            groups = groups or {name: name for name in SET_COLUMNS if name in opened}
            if not groups:
                raise MeasurementError(
                    "missing",
                    path,
                    "has neither /capture nor /reference: name the groups, "
                    f"capture='/…'; there are {_groups(h5py, opened)}",
                )
            for name, place in groups.items():
                group = opened.get(place)
                if not isinstance(group, h5py.Group):
                    raise MeasurementError(
                        "missing",
                        path,
                        f"has no group {place}; there are {_groups(h5py, opened)}",
                    )
                stated |= known_attributes(group.attrs)
                frames.append(_hdf5_frame(h5py, path, name, group))
    except FileNotFoundError as error:
        raise MeasurementError("missing", path, "no such file") from error
    except OSError as error:
        raise MeasurementError("format", path, f"cannot be read as HDF5: {error}") from error
    return frames, stated


def _hdf5_frame(h5py: Any, path: Path, name: str, group: Any) -> Frame:
    """Return the one-dimensional datasets of a group, with the attribute ``units`` of each."""
    columns, units = {}, {}
    datasets = {key: item for key, item in group.items() if isinstance(item, h5py.Dataset)}
    refuse_above_limit(path, sum(item.nbytes for item in datasets.values() if item.ndim == 1))
    for key, item in datasets.items():
        if item.ndim != 1:
            continue
        refuse_other_files(path, item.name.strip("/"), item)
        columns[key] = _unpacked(np.asarray(item[()]), item.attrs)
        if "units" in item.attrs:
            units[key] = item.attrs["units"]
    return Frame(name, columns, units)


def _groups(h5py: Any, opened: Any) -> str:
    found: list[str] = []

    def visit(name: str, item: Any) -> None:
        if isinstance(item, h5py.Dataset) and item.ndim == 1:
            parent = "/" + name.rpartition("/")[0]
            if parent not in found:
                found.append(parent)

    opened.visititems(visit)
    return ", ".join(found) or "none with columns of numbers"


def _unpacked(values: NDArray[Any], attributes: Mapping[str, Any]) -> NDArray[Any]:
    """Return the values that a packed column stands for, with NaN for values that are missing.

    The attributes are those of the CF conventions (cfconventions.org, "Packed Data" and "Missing
    Data"): ``_FillValue``, ``missing_value``, ``scale_factor``, ``add_offset``.
    """
    if values.dtype.kind not in "iuf":
        return values
    given = {
        name: np.ravel(attributes[name])
        for name in ("_FillValue", "missing_value", "scale_factor", "add_offset")
        if name in attributes
    }
    absent = np.zeros(values.shape, dtype=np.bool_)
    for name in ("_FillValue", "missing_value"):
        if name in given and given[name].dtype.kind in "iuf":
            absent |= np.isin(values, given[name])
    if "scale_factor" in given or "add_offset" in given:
        scale, offset = given.get("scale_factor", [1.0]), given.get("add_offset", [0.0])
        values = values.astype(np.float64) * float(scale[0]) + float(offset[0])
    return np.where(absent, np.nan, values) if absent.any() else values
