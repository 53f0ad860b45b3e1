"""Tests that small files are refused if their unpacked content would exceed the limit of memory."""

from __future__ import annotations

import gzip
import io
import tempfile
import zipfile
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pyarrow as pa  # type: ignore[import-untyped]
import pyarrow.parquet as pa_parquet  # type: ignore[import-untyped]
import pytest
import scipy.io

from arctrue.importing import ReadSettings, read_recording
from arctrue.importing.choices import Choices
from arctrue.importing.readers import unpacked_size
from arctrue.measurement import MeasurementError

SMALLER = 1_000_000
"""Limit of the unpacked size in bytes, which these tests set."""
ROWS = 200_000


def _archive(path: Path) -> None:
    np.savez_compressed(path, a=np.zeros(ROWS))


def _archive_of_untrue_headers(path: Path) -> None:
    """Write an array whose header states more rows than the file has."""
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


def _text_in_gzip(path: Path) -> None:
    path.write_bytes(gzip.compress(b"0,0\n" * ROWS * 2))


def _array_in_gzip(path: Path) -> None:
    inside = io.BytesIO()
    np.save(inside, np.zeros(ROWS))
    path.write_bytes(gzip.compress(inside.getvalue()))


def _rows_that_grow(path: Path) -> None:
    """Write a file with numbers that take two bytes in the file and eight bytes in memory."""
    path.write_bytes(gzip.compress(b"0,0\n" * (SMALLER // 8)))


def _wide_text_in_gzip(path: Path) -> None:
    """Write a column of texts, one of which is long: in an array of fixed width every row takes as
    much memory."""
    path.write_bytes(gzip.compress(b"0,a\n" * 1000 + b"0," + b"a" * 2000 + b"\n"))


def _objects_in_gzip(path: Path) -> None:
    """Write a file of empty JSON objects, which take three bytes each."""
    path.write_bytes(gzip.compress(b"{}\n" * (SMALLER // 4)))


def _samples_in_gzip(path: Path) -> None:
    path.write_bytes(gzip.compress(b"overrun\n" + b"1 2\n" * (SMALLER // 5)))


def _mat(path: Path) -> None:
    scipy.io.savemat(path, {"a": np.zeros(ROWS)}, do_compression=True)


def _mat_of_small_numbers(path: Path) -> None:
    scipy.io.savemat(path, {"a": np.zeros(ROWS, dtype=np.uint8)}, do_compression=True)


def _mat_struct(path: Path) -> None:
    scipy.io.savemat(path, {"a": {"b": np.zeros(ROWS, dtype=np.uint8)}}, do_compression=True)


def _mat_73(path: Path) -> None:
    h5py = pytest.importorskip("h5py")
    with h5py.File(path, "w", userblock_size=512) as file:
        # Each value has one byte, and no value is written, so that the file stores only the shape.
        data = file.create_dataset("a", shape=(1, ROWS), dtype="u1", chunks=(1, 1000))
        data.attrs["MATLAB_class"] = np.bytes_("uint8")
    with path.open("r+b") as raw:
        raw.write(b"MATLAB 7.3 MAT-file, Platform: GLNXA64".ljust(124) + b"\x00\x02IM")


def _hdf5(path: Path) -> None:
    h5py = pytest.importorskip("h5py")
    with h5py.File(path, "w") as file:
        # No value is written, so that the file stores only the shape.
        file.create_dataset("a", shape=(ROWS,), dtype="f8", chunks=(1000,))


@pytest.mark.parametrize(
    ("name", "write"),
    [
        ("a.npz", _archive),
        ("a.npz", _archive_of_untrue_headers),
        ("a.npy", _array_of_an_untrue_header),
        ("a.parquet", _parquet),
        ("a.h5", _hdf5),
        ("a.csv.gz", _text_in_gzip),
        ("a.npy.gz", _array_in_gzip),
        ("a.csv.gz", _rows_that_grow),
        ("a.csv.gz", _wide_text_in_gzip),
        ("a.jsonl.gz", _objects_in_gzip),
        ("a.txt.gz", _samples_in_gzip),
        ("a.mat", _mat),
        ("a.mat", _mat_of_small_numbers),
        ("a.mat", _mat_struct),
        ("a.mat", _mat_73),
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


def test_unpacking_stops_at_the_limit(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Unpacking a gzip file stops at the limit, before the file fills the disk."""
    path = tmp_path / "a.csv.gz"
    path.write_bytes(gzip.compress(b"\0" * 100_000_000))
    monkeypatch.setattr(unpacked_size, "MOST_BYTES", SMALLER)
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path / "packed"))
    (tmp_path / "packed").mkdir()
    largest = 0
    usual = unpacked_size.refuse_above_limit

    def watched(file: Path, size: int) -> None:
        nonlocal largest
        largest = max(largest, size)
        usual(file, size)

    monkeypatch.setattr("arctrue.importing.gzip_file.refuse_above_limit", watched)
    with pytest.raises(MeasurementError, match="unpacks to"):
        read_recording(path, "", ReadSettings(), Choices(lambda asked: ""))
    assert largest < 3 * SMALLER
    assert list((tmp_path / "packed").iterdir()) == []
