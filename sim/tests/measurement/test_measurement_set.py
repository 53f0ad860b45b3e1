"""Tests the reader and the writer of measurement sets: contents, refusals and messages."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from arctrue.measurement import (
    Capture,
    MeasurementError,
    MeasurementSet,
    Reference,
    Table,
    csv_blocks,
    open_capture,
    read_measurement_set,
    write_measurement_set,
)

TOML = """schema = 1
title = "test"
[table]
counts_per_rev = 16777216
head_separation_deg = 33.0
"""
CAPTURE = """run,time_s,head1_counts,head2_counts,temperature_c
0,0.000,10,20,20.0
0,0.001,1410,1420,20.0
1,5.000,-5,9007199254740993,20.5
1,5.001,-1405,9007199254742393,20.5
"""
REFERENCE = """target_deg,error_arcsec,direction
0.0,1.5,1
15.0,-2.5,-1
"""


def write(folder: Path, toml: str = TOML, capture: str = CAPTURE, reference: str = "") -> Path:
    folder.mkdir(exist_ok=True)
    (folder / "measurement.toml").write_bytes(toml.encode())
    if capture:
        (folder / "capture.csv").write_bytes(capture.encode())
    if reference:
        (folder / "reference.csv").write_bytes(reference.encode())
    return folder


def fault(folder: Path) -> MeasurementError:
    with pytest.raises(MeasurementError) as caught:
        read_measurement_set(folder)
    return caught.value


def test_values_types_and_64_bits(tmp_path: Path) -> None:
    read = read_measurement_set(write(tmp_path, reference=REFERENCE))
    assert read.capture is not None
    assert read.capture.head2_counts.dtype == np.int64
    # A float cannot represent 2⁵³ + 1.
    assert read.capture.head2_counts.tolist() == [20, 1420, 9007199254740993, 9007199254742393]
    assert read.capture.temperature_c.tolist() == [20.0, 20.0, 20.5, 20.5]
    assert read.reference is not None
    assert read.reference.direction.tolist() == [1, -1]
    assert read.reference.head1_counts is None
    assert read.table == Table(counts_per_rev=16777216, head_separation_deg=33.0)
    assert read.warnings == ()


@pytest.mark.parametrize(
    "change",
    [
        lambda text: "\ufeff" + text,
        lambda text: text.replace("\n", "\r\n"),
        lambda text: text.replace(",", " , "),
        lambda text: text + "\n\n",
        lambda text: text.replace("\n0,0.001", "\n\n0,0.001"),
    ],
    ids=["BOM", "CRLF", "blanks", "blank lines at the end", "blank line"],
)
def test_harmless_differences(tmp_path: Path, change: Callable[[str], str]) -> None:
    read = read_measurement_set(write(tmp_path, "\ufeff" + TOML, change(CAPTURE)))
    assert read.capture is not None
    assert read.capture.head1_counts.tolist() == [10, 1410, -5, -1405]


def test_columns_in_another_order_and_unknown_ones(tmp_path: Path) -> None:
    text = "note,head2_counts,time_s,run,head1_counts\nabc,2,0.0,0,1\nx,4,0.1,0,3\n"
    read = read_measurement_set(write(tmp_path, capture=text))
    assert read.capture is not None
    assert read.capture.head1_counts.tolist() == [1, 3]
    assert read.capture.temperature_c is None
    assert any(
        "row 2, column note: expected a number, found 'abc'" in warning for warning in read.warnings
    )
    assert read.capture.conditions == {}


@pytest.mark.parametrize(
    ("old", "new", "row", "column", "words"),
    [
        (
            "0,0.001,1410,",
            "0,0.001,14x0,",
            3,
            "head1_counts",
            "expected a whole number, found '14x0'",
        ),
        ("0,0.001,1410,", "0,0.001,1410.5,", 3, "head1_counts", "expected a whole number"),
        ("0,0.001,1410,", "0,0.001,NaN,", 3, "head1_counts", "found 'NaN'"),
        ("0,0.001,1410,", "0,0.001,,", 3, "head1_counts", "the field is empty"),
        ("0,0.001,", "0,nan,", 3, "time_s", "expected a number, found 'nan'"),
        ("0,0.001,", "0,inf,", 3, "time_s", "expected a number, found 'inf'"),
        ("1420,20.0", "1420,warm", 3, "temperature_c", "found 'warm'"),
        ("1420,20.0", "1420", 3, "temperature_c", "expected 5 fields, found 4"),
        ("1420,20.0", "1420,20.0,7", 3, "temperature_c", "expected 5 fields, found 6"),
        (",-1405,", ",99999999999999999999,", 5, "head1_counts", "does not fit into 64 bits"),
        ("5.001", "4.999", 5, "time_s", "time runs backwards, from 5.0 to 4.999 s"),
        ("\n1,5.001", "\n0,5.001", 5, "run", "run 0 continues here"),
        ("head2_counts", "head_2", 1, "head2_counts", "is missing"),
        ("temperature_c", "run", 1, "run", "occurs twice"),
    ],
)
def test_bad_fields(tmp_path: Path, old: str, new: str, row: int, column: str, words: str) -> None:
    found = fault(write(tmp_path, capture=CAPTURE.replace(old, new, 1)))
    assert (found.row, found.column, found.file.name) == (row, column, "capture.csv")
    assert words in str(found)
    assert f"capture.csv, row {row}, column {column}" in str(found)


def test_rows_are_lines_of_the_file(tmp_path: Path) -> None:
    text = CAPTURE.replace("\n0,0.001", "\n\n\n0,0.001").replace("5.001", "4.999")
    assert fault(write(tmp_path, capture=text)).row == 7


def test_fault_far_into_a_long_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(csv_blocks, "BLOCK_BYTES", 4096)
    rows = [f"0,{i / 1000:.3f},{i * 1400},{i * 1400 + 7},20.0" for i in range(3000)]
    rows[2500] = rows[2500].replace("20.0", "hot")
    found = fault(write(tmp_path, capture=CAPTURE.splitlines()[0] + "\n" + "\n".join(rows) + "\n"))
    assert (found.row, found.column) == (2502, "temperature_c")
    rows[2500] = "0,2.400,1,2,20.0"
    write(tmp_path, capture=CAPTURE.splitlines()[0] + "\n" + "\n".join(rows) + "\n")
    found = fault(tmp_path)
    assert (found.fault, found.row) == ("time", 2502)


def test_blocks_join_to_the_whole(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(csv_blocks, "BLOCK_BYTES", 4096)
    rows = [f"{i // 1500},{i / 1000:.3f},{i * 1400},{i * 1400 + 7},20.0" for i in range(3000)]
    write(tmp_path, capture=CAPTURE.splitlines()[0] + "\n" + "\n".join(rows) + "\n")
    with open_capture(tmp_path) as blocks:
        sizes = [block["run"].size for block in blocks]
    assert len(sizes) > 10
    assert sum(sizes) == 3000
    read = read_measurement_set(tmp_path)
    assert read.capture is not None
    assert read.capture.head1_counts.tolist() == [i * 1400 for i in range(3000)]


@pytest.mark.parametrize("cut", ["1,5.0", "1,5.001,-14", "1"])
def test_cut_last_line_is_left_out_with_a_warning(tmp_path: Path, cut: str) -> None:
    text = "\n".join(CAPTURE.splitlines()[:-1]) + "\n" + cut
    read = read_measurement_set(write(tmp_path, capture=text))
    assert read.capture is not None
    assert read.capture.run.size == 3
    assert any("cut off" in warning and repr(cut) in warning for warning in read.warnings)


def test_whole_last_line_without_an_end_is_kept_with_a_warning(tmp_path: Path) -> None:
    read = read_measurement_set(write(tmp_path, capture=CAPTURE.rstrip()))
    assert read.capture is not None
    assert read.capture.run.size == 4
    assert any("may be cut off" in warning for warning in read.warnings)


@pytest.mark.parametrize("text", ["\n", CAPTURE.splitlines()[0] + "\n", CAPTURE.splitlines()[0]])
def test_empty_capture(tmp_path: Path, text: str) -> None:
    assert fault(write(tmp_path, capture=text)).fault == "empty"
    (tmp_path / "capture.csv").write_bytes(b"")
    assert fault(tmp_path).fault == "empty"


def test_capture_that_is_not_text(tmp_path: Path) -> None:
    write(tmp_path)
    (tmp_path / "capture.csv").write_bytes(CAPTURE.encode("utf-16"))
    assert fault(tmp_path).fault == "format"


@pytest.mark.parametrize(
    ("toml", "words"),
    [
        (TOML.replace("schema = 1", ""), "schema: is missing"),
        (
            TOML.replace("schema = 1", "schema = 2"),
            "schema that this program reads, found 2",
        ),
        (TOML.replace("16777216", '"many"'), "counts_per_rev: expected a whole number"),
        (TOML.replace("16777216", "1e7"), "counts_per_rev: expected a whole number"),
        (TOML.replace("16777216", "true"), "counts_per_rev: expected a whole number"),
        (
            TOML.replace("16777216", "3"),
            "expected a whole number from 4 to 2^62, found 3",
        ),
        (
            TOML.replace("33.0", "nan"),
            "expected a finite number above -360 and below 360",
        ),
        (TOML.replace("counts_per_rev = 16777216\n", ""), "table.counts_per_rev: is missing"),
        (TOML.replace("head_separation_deg = 33.0\n", ""), "head_separation_deg: is missing"),
        (TOML.replace("counts_per_rev", "counts_per_turn"), "table.counts_per_turn is not known"),
        (TOML.replace("[table]", "[table"), "is not TOML"),
        ("schema = 1\ntable = 5\n", "table: expected a table [table], found 5"),
        (TOML + '[capture]\nfile = "other.csv"\n', "other.csv: no such file"),
        (TOML + "[reference]\nfaces = 24\n", "reference.csv: no such file"),
    ],
)
def test_bad_description(tmp_path: Path, toml: str, words: str) -> None:
    found = fault(write(tmp_path, toml))
    assert words in str(found)
    assert "\n" not in str(found)


def test_missing_folder_file_and_data(tmp_path: Path) -> None:
    assert "no such folder" in str(fault(tmp_path / "nowhere"))
    assert "measurement.toml: no such file" in str(fault(tmp_path))
    assert "nothing was measured" in str(fault(write(tmp_path, capture="")))


def test_unknown_keys_are_kept_and_reported(tmp_path: Path) -> None:
    toml = TOML + 'colour = "red"\n[weather]\nwind = 3\n'
    read = read_measurement_set(write(tmp_path, toml))
    assert read.other == {"table.colour": "red", "weather": {"wind": 3}}
    assert len(read.warnings) == 2
    assert "the key table.colour is not known" in read.warnings[0]


def test_reference_alone_needs_no_table(tmp_path: Path) -> None:
    read = read_measurement_set(write(tmp_path, "schema = 1\n", "", REFERENCE))
    assert read.capture is None
    assert read.reference is not None


def test_reference_direction(tmp_path: Path) -> None:
    found = fault(write(tmp_path, reference=REFERENCE.replace("-2.5,-1", "-2.5,0")))
    assert (found.row, found.column) == (3, "direction")


def test_written_set_reads_the_same(tmp_path: Path) -> None:
    measurement = MeasurementSet(
        Table(counts_per_rev=2**24, grating_lines=16384, head_separation_deg=33.0),
        Capture(
            run=np.array([0, 0, 1]),
            time_s=np.array([0.0, 0.123456, 7.0]),
            head1_counts=np.array([-(2**62), 0, 2**53 + 1]),
            head2_counts=np.array([1, 2, 3]),
            temperature_c=np.array([20.125, 20.25, 20.5]),
            clock_hz=1e8,
        ),
        Reference(
            target_deg=np.array([0.0, 1.0 / 3.0]),
            error_arcsec=np.array([-150.123456, 1e-6]),
            cycle=np.array([0, 1]),
            direction=np.array([1, -1]),
            faces=24,
            instrument='a "good" one',
            standard_uncertainty_arcsec=0.15,
        ),
        title="Ümlaut",
    )
    write_measurement_set(tmp_path / "set", measurement)
    read = read_measurement_set(tmp_path / "set")
    assert (read.title, read.table, read.warnings) == (measurement.title, measurement.table, ())
    for part in ("capture", "reference"):
        for name, value in vars(getattr(measurement, part)).items():
            again = getattr(getattr(read, part), name)
            if isinstance(value, np.ndarray):
                assert again == pytest.approx(value, abs=1e-9), name
                assert again.dtype == value.dtype
            else:
                assert again == value, name
    assert read.capture is not None
    assert read.capture.head1_counts.tolist() == [-(2**62), 0, 2**53 + 1]


def test_writer_refuses_what_it_could_not_read(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="equally long"):
        Capture(np.zeros(2, int), np.zeros(2), np.zeros(2, int), np.zeros(3, int))
    large = Reference(np.array([0.0, 1e99]), np.zeros(2))
    with pytest.raises(ValueError, match=r"target_deg\[1\]: 1e\+99 is too large"):
        write_measurement_set(tmp_path, MeasurementSet(Table(), reference=large))
    bad = Reference(np.array([0.0, np.nan]), np.zeros(2))
    with pytest.raises(ValueError, match=r"target_deg\[1\]"):
        write_measurement_set(tmp_path, MeasurementSet(Table(), reference=bad))
    with pytest.raises(ValueError, match="needs a capture or a reference"):
        write_measurement_set(tmp_path, MeasurementSet(Table()))
