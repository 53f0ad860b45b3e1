"""Tests the optional columns of a set (uncertainty, mask, conditions) and mask.csv."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from sim.tests.workbench.small_sets import measurement_set

from arctrue.measurement import MeasurementError, read_measurement_set, write_measurement_set

TOML = "schema = 1\n"
REFERENCE = """target_deg,error_arcsec,u_arcsec,mask,elevation_deg,site
0,1.5,0.2,0,40.5,A
15,-2.5,0.3,1,41.0,A
30,0.5,0.2,0, 42e0 ,B
"""


def _write(folder: Path, reference: str = REFERENCE, mask: str = "") -> Path:
    (folder / "measurement.toml").write_text(TOML, encoding="utf-8")
    (folder / "reference.csv").write_text(reference, encoding="utf-8")
    if mask:
        (folder / "mask.csv").write_text(mask, encoding="utf-8")
    return folder


def test_uncertainty_mask_and_conditions_are_read(tmp_path: Path) -> None:
    read = read_measurement_set(_write(tmp_path))
    assert read.reference is not None
    assert read.reference.u_arcsec is not None
    assert read.reference.u_arcsec.tolist() == [0.2, 0.3, 0.2]
    assert read.reference.mask is not None
    assert read.reference.mask.tolist() == [False, True, False]
    assert {name: values.tolist() for name, values in read.reference.conditions.items()} == {
        "elevation_deg": [40.5, 41.0, 42.0]
    }
    assert [warning for warning in read.warnings if "site" in warning] == [
        f"{tmp_path / 'reference.csv'}, row 2, column site: expected a number, found 'A'; "
        "the column is not used"
    ]


def test_they_are_written_as_they_were_read(tmp_path: Path) -> None:
    read = read_measurement_set(_write(tmp_path))
    (tmp_path / "again").mkdir()
    write_measurement_set(tmp_path / "again", read)
    again = read_measurement_set(tmp_path / "again")
    assert again.warnings == ()
    assert read.reference is not None
    assert again.reference is not None
    for name in ("error_arcsec", "u_arcsec", "mask"):
        assert np.array_equal(getattr(again.reference, name), getattr(read.reference, name)), name
    assert again.reference.conditions["elevation_deg"].tolist() == [40.5, 41.0, 42.0]


def test_rows_of_the_mask_file_are_written_as_they_were_read(tmp_path: Path) -> None:
    read = read_measurement_set(_write(tmp_path, mask="reference_row,mask\n2,1\n3,0\n"))
    write_measurement_set(tmp_path / "again", read)
    again = read_measurement_set(tmp_path / "again")
    assert again.warnings == ()
    assert again.reference is not None
    assert again.reference.mask is not None
    assert again.reference.trusted is not None
    assert again.reference.mask.tolist() == [True, False, False]
    assert again.reference.trusted.tolist() == [False, True, False]


def test_nothing_of_an_older_set_in_the_folder_becomes_part_of_the_new_one(tmp_path: Path) -> None:
    older = measurement_set(runs=1, cycles=1)
    write_measurement_set(tmp_path, older)
    (tmp_path / "mask.csv").write_text("capture_row,mask\n2,1\n", encoding="utf-8")
    write_measurement_set(tmp_path, replace(older, reference=None))
    read = read_measurement_set(tmp_path)
    assert read.reference is None
    assert read.capture is not None
    assert read.capture.mask is None
    assert sorted(path.name for path in tmp_path.iterdir()) == ["capture.csv", "measurement.toml"]


def test_a_file_that_belongs_to_no_set_is_neither_replaced_nor_removed(tmp_path: Path) -> None:
    (tmp_path / "reference.csv").write_text("raw\n", encoding="utf-8")
    with pytest.raises(ValueError, match=r"already holds a reference\.csv"):
        write_measurement_set(tmp_path, measurement_set(runs=1, cycles=0, reference=False))
    assert [path.name for path in tmp_path.iterdir()] == ["reference.csv"]
    assert (tmp_path / "reference.csv").read_text(encoding="utf-8") == "raw\n"


@pytest.mark.parametrize("field", ["", "nan", "inf", "0x10", "warm"])
def test_a_condition_that_is_no_number_somewhere_is_left_out(tmp_path: Path, field: str) -> None:
    read = read_measurement_set(_write(tmp_path, REFERENCE.replace("41.0", field)))
    assert read.reference is not None
    assert read.reference.conditions == {}
    assert any(
        f"row 3, column elevation_deg: expected a number, found '{field}'" in warning
        for warning in read.warnings
    )


@pytest.mark.parametrize(
    ("old", "new", "row", "column", "words"),
    [
        ("0.3,1,", "-0.3,1,", 3, "u_arcsec", "expected 0 or more, found -0.3"),
        ("0.3,1,", "0.3,2,", 3, "mask", "expected 0 or 1, found 2"),
        ("0.3,1,", "0.3,yes,", 3, "mask", "expected a whole number, found 'yes'"),
    ],
)
def test_bad_uncertainty_or_mask(
    tmp_path: Path, old: str, new: str, row: int, column: str, words: str
) -> None:
    with pytest.raises(MeasurementError) as caught:
        read_measurement_set(_write(tmp_path, REFERENCE.replace(old, new)))
    assert (caught.value.row, caught.value.column) == (row, column)
    assert words in str(caught.value)


def test_an_uncertainty_of_zero_is_reported_unless_its_row_is_masked(tmp_path: Path) -> None:
    """The reader warns that it cannot use a column with an uncertainty of 0 in a used row; a row
    that the column mask or mask.csv masks may have any uncertainty."""
    zero = REFERENCE.replace("0.5,0.2,0", "0.5,0.000,0")
    read = read_measurement_set(_write(tmp_path, zero))
    (said,) = [text for text in read.warnings if "u_arcsec" in text]
    assert f"{tmp_path / 'reference.csv'}, row 4, column u_arcsec: expected more than 0" in said
    assert "as in 1 of 3 rows; the column is not used" in said
    for text, mask in (
        (REFERENCE.replace("-2.5,0.3,1", "-2.5,0,1"), ""),
        (zero, "reference_row,mask\n4,1\n"),
        (REFERENCE, ""),
    ):
        (tmp_path / "mask.csv").unlink(missing_ok=True)
        read = read_measurement_set(_write(tmp_path, text, mask))
        assert not any("u_arcsec" in text for text in read.warnings)


@pytest.mark.parametrize(
    ("written", "meant"),
    [("uarcsec", "u_arcsec"), ("U_arcsec", "u_arcsec"), ("masked", "mask"), ("time", "time_s")],
)
def test_a_condition_that_is_spelt_like_a_missing_column_is_reported(
    tmp_path: Path, written: str, meant: str
) -> None:
    text = "target_deg,error_arcsec,load_nm,NAME\n0,1.5,2,0\n15,-2.5,3,1\n"
    read = read_measurement_set(_write(tmp_path, text.replace("NAME", written)))
    assert read.warnings == (
        f"{tmp_path / 'reference.csv'}: column {written} is taken as a condition of that name; "
        f"is {meant} meant?",
    )
    assert read_measurement_set(_write(tmp_path, text.replace("NAME", "duration_s"))).warnings == ()


def test_a_column_of_the_mask_file_that_is_not_known_is_reported_once(tmp_path: Path) -> None:
    text = "reference_row,mask,capture_rw\n2,1,7\n"
    read = read_measurement_set(_write(tmp_path, mask=text))
    reported = [warning for warning in read.warnings if "mask.csv" in warning]
    assert reported == [f"{tmp_path / 'mask.csv'}: column capture_rw is not known and is not used"]


@pytest.mark.parametrize("before", [0, 20000])
@pytest.mark.parametrize("with_pyarrow", [True, False])
def test_a_text_in_another_encoding_is_left_out_with_its_row(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, with_pyarrow: bool, before: int
) -> None:
    """The faulty text may lie in the part of the file that is read with the header, or behind
    it."""
    if not with_pyarrow:
        monkeypatch.setattr("arctrue.measurement.csv_blocks.installed", lambda name: False)
    (tmp_path / "measurement.toml").write_text(TOML, encoding="utf-8")
    head, *rows = ["target_deg,error_arcsec,who", "0,1,2", "10,2,Prüfer", "20,3,4"]
    text = "\n".join([head, *(f"{place},1,1" for place in range(before)), *rows, ""])
    (tmp_path / "reference.csv").write_bytes(text.encode("latin-1"))
    read = read_measurement_set(tmp_path)
    assert read.reference is not None
    assert read.reference.error_arcsec.size == before + 3
    assert read.warnings == (
        f"{tmp_path / 'reference.csv'}, row {before + 3}, column who: expected a number, found "
        "'Pr�fer'; the column is not used",
    )
    (tmp_path / "reference.csv").write_bytes(text.replace("who", "für").encode("latin-1"))
    with pytest.raises(MeasurementError, match=r"reference\.csv, row 1: is not text in UTF-8"):
        read_measurement_set(tmp_path)
    damaged = text.replace("10,2,", "10,ü,").encode("latin-1")
    (tmp_path / "reference.csv").write_bytes(damaged)
    with pytest.raises(MeasurementError, match=f"row {before + 3}, column error_arcsec"):
        read_measurement_set(tmp_path)


def test_a_mask_file_and_a_blank_line_before_a_row_are_refused(tmp_path: Path) -> None:
    """With a blank line before a row, a number in mask.csv would refer to another row than the same
    number that the commands print."""
    head, first, *rest = REFERENCE.splitlines()
    blank = "\n".join([head, first, "", *rest])
    _write(tmp_path, blank + "\n", "reference_row,mask\n4,1\n")
    with pytest.raises(MeasurementError, match=r"reference\.csv, row 3: is blank.*mask\.csv"):
        read_measurement_set(tmp_path)
    _write(tmp_path, REFERENCE + "\n\n", "reference_row,mask\n4,1\n")
    read = read_measurement_set(tmp_path).reference
    assert read is not None
    assert read.mask is not None
    assert read.mask.tolist() == [False, True, True]


def test_mask_file_has_the_last_word(tmp_path: Path) -> None:
    read = read_measurement_set(_write(tmp_path, mask="reference_row,mask\n2,1\n3,0\n"))
    assert read.reference is not None
    assert read.reference.mask is not None
    assert read.reference.mask.tolist() == [True, False, False]
    assert read.reference.trusted is not None
    assert read.reference.trusted.tolist() == [False, True, False]


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("reference_row,mask\n5,1\n", "row 2, column reference_row: expected a line of reference"),
        ("reference_row,mask\n1,1\n", "from 2 to 4, found 1"),
        ("reference_row,mask\n2,7\n", "row 2, column mask: expected 0 or 1, found 7"),
        ("mask\n1\n", "expected a column capture_row or reference_row"),
    ],
)
def test_a_bad_mask_file_is_reported(tmp_path: Path, text: str, words: str) -> None:
    with pytest.raises(MeasurementError, match=r"mask\.csv") as caught:
        read_measurement_set(_write(tmp_path, mask=text))
    assert words in str(caught.value)


def test_a_condition_that_occurs_twice_is_named_once_with_the_reason(tmp_path: Path) -> None:
    rows = "target_deg,error_arcsec,wind,wind\n0,1,2,3\n15,2,3,4\n"
    read = read_measurement_set(_write(tmp_path, rows))
    assert read.reference is not None
    assert read.reference.conditions == {}
    assert read.warnings == (
        f"{tmp_path / 'reference.csv'}, row 1, column wind: occurs 2 times and is not used; "
        "rename the columns",
    )
