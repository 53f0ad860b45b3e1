"""Small files that unpack to very much are refused before they are unpacked."""

from __future__ import annotations

import io
import zipfile
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pyarrow as pa  # type: ignore[import-untyped]
import pyarrow.parquet as pa_parquet  # type: ignore[import-untyped]
import pytest

from arctrue.importing import ReadSettings, read_recording
from arctrue.importing.choices import Choices
from arctrue.importing.readers import unpacked_size
from arctrue.measurement import MeasurementError

SMALLER = 1_000_000
"""Bytes that these tests set as the limit."""
ROWS = 200_000


def _archive(path: Path) -> None:
    np.savez_compressed(path, a=np.zeros(ROWS))


def _archive_of_untrue_headers(path: Path) -> None:
    """The header of the array tells more rows than there are."""
    array = io.BytesIO()
    np.lib.format.write_array_header_1_0(
        array, {"descr": "<f8", "fortran_order": False, "shape": (10**15,)}
    )
    with zipfile.ZipFile(path, "w") as file:
        file.writestr("a.npy", array.getvalue())


def _array_of_an_untrue_header(path: Path) -> None:
    with path.open("wb") as file:
        np.lib.format.write_array_header_1_0(
            file, {"descr": "<f8", "fortran_order": False, "shape": (10**15,)}
        )


def _parquet(path: Path) -> None:
    pa_parquet.write_table(pa.table({"a": np.zeros(ROWS)}), path)


def _hdf5(path: Path) -> None:
    h5py = pytest.importorskip("h5py")
    with h5py.File(path, "w") as file:
        # No value was ever written: the file holds the shape alone.
        file.create_dataset("a", shape=(ROWS,), dtype="f8", chunks=(1000,))


@pytest.mark.parametrize(
    ("name", "write"),
    [
        ("a.npz", _archive),
        ("a.npz", _archive_of_untrue_headers),
        ("a.npy", _array_of_an_untrue_header),
        ("a.parquet", _parquet),
        ("a.h5", _hdf5),
    ],
)
def test_it_is_refused(
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    name: str,
    write: Callable[[Path], None],
) -> None:
    path = tmp_path / name
    write(path)
    assert path.stat().st_size < SMALLER
    monkeypatch.setattr(unpacked_size, "MOST_BYTES", SMALLER)
    with pytest.raises(MeasurementError, match=f"{name}: unpacks to .*; expected at most 1 MB"):
        read_recording(path, "", ReadSettings(), Choices(lambda asked: ""))
