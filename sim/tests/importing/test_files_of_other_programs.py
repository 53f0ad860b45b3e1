"""Tests that files of other programs are imported, or refused with a message that names the
remedy."""

from __future__ import annotations

import contextlib
import gzip
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import scipy.io
from click.testing import CliRunner, Result

from arctrue.cli import main
from arctrue.importing import Choices, ReadSettings, read_recording
from arctrue.importing.readers import delimited_text
from arctrue.importing.sexagesimal import sexagesimal
from arctrue.measurement import MeasurementError, Reference, read_measurement_set

ANGLE = np.concatenate([np.arange(0.0, 360.0, 2.0), np.arange(358.0, -2.0, -2.0)])
TIME_S = np.arange(ANGLE.size) * 0.5
ERROR_DEG = 0.01 * np.sin(np.deg2rad(ANGLE))
HEADER = "Zeit [s];Soll [°];Ist [°]"


def arctrue(*words: str | Path) -> Result:
    return CliRunner().invoke(main, ["import", *map(str, words)], catch_exceptions=False)


def _rows(time_s: np.ndarray = TIME_S) -> list[str]:
    rows = zip(time_s, ANGLE, ANGLE + ERROR_DEG, strict=True)
    return [f"{t:.3f};{a:.6f};{b:.6f}".replace(".", ",") for t, a, b in rows]


def _text(header: str = HEADER) -> str:
    return "\r\n".join([header, *_rows()]) + "\r\n"


def checked(tmp_path: Path, *words: str | Path) -> tuple[Reference, str]:
    """Import files; check that the rows are ANGLE and ERROR_DEG; return reference run and
    output."""
    done = arctrue(*words, tmp_path / "out")
    assert done.exit_code == 0, done.output
    found = read_measurement_set(tmp_path / "out").reference
    assert found is not None
    assert found.time_s is not None
    np.testing.assert_allclose(found.time_s, TIME_S, atol=1e-9)
    np.testing.assert_allclose(found.target_deg, ANGLE, atol=1e-6)
    # The error is the difference between two angles, each rounded by up to 0.5e-6 °: together
    # 0.0036″.
    np.testing.assert_allclose(found.error_arcsec, ERROR_DEG * 3600.0, atol=0.0037)
    return found, " ".join(done.output.split())


@pytest.mark.parametrize(
    ("encoding", "said"),
    [
        ("latin-1", "is not UTF-8; read as Windows-1252"),
        ("utf-16", "text in UTF-16"),
        ("utf-16-le", "text in UTF-16-LE, without its mark"),
        ("utf-16-be", "text in UTF-16-BE, without its mark"),
        ("utf-32", "text in UTF-32"),
        ("utf-8-sig", ""),
    ],
)
def test_every_encoding(tmp_path: Path, encoding: str, said: str) -> None:
    (tmp_path / "log.csv").write_bytes(_text().encode(encoding))
    _, output = checked(tmp_path, tmp_path / "log.csv")
    assert said in output


def test_a_latin_1_letter_after_a_megabyte(tmp_path: Path) -> None:
    # The letter that shows the encoding comes only after a megabyte.
    rows = "".join(f"{i};{i % 360};{i % 360}\n" for i in range(120_000))
    (tmp_path / "log.csv").write_bytes(
        (HEADER.replace("°", "deg") + "\n" + rows).encode() + b"# \xb0\n"
    )
    found = read_recording(tmp_path / "log.csv", "", ReadSettings(), Choices())
    assert found.rows == 120_000


@pytest.mark.parametrize("name", ["log.csv.gz", "log.gz"])
def test_a_packed_file(tmp_path: Path, name: str) -> None:
    (tmp_path / name).write_bytes(gzip.compress(_text().encode("latin-1")))
    checked(tmp_path, tmp_path / name)


def test_a_packed_file_names_itself_in_faults(tmp_path: Path) -> None:
    path = tmp_path / "bad.csv.gz"
    path.write_bytes(gzip.compress(b"1,2\n3,4\n5\n6,7\n"))
    with pytest.raises(MeasurementError, match=r"bad\.csv\.gz, row 3: expected 2 fields") as caught:
        read_recording(path, "", ReadSettings(), Choices())
    assert str(tmp_path) in str(caught.value)
    path.write_bytes(gzip.compress(b"1,2\n" * 1000)[:-10])
    with pytest.raises(MeasurementError, match=r"bad\.csv\.gz: cannot be unpacked"):
        read_recording(path, "", ReadSettings(), Choices())


def _mat_5(path: Path, compressed: bool = True) -> None:
    scipy.io.savemat(
        path,
        {"Zeit": TIME_S, "Soll": ANGLE, "Ist": ANGLE + ERROR_DEG, "fs": 2.0, "who": "bench 3"},
        do_compression=compressed,
    )


def _mat_5_plain(path: Path) -> None:
    _mat_5(path, compressed=False)


def _mat_5_struct(path: Path) -> None:
    log = {"Zeit": TIME_S, "Soll": ANGLE, "Ist": ANGLE + ERROR_DEG, "fs": 2.0}
    scipy.io.savemat(path, {"log": log, "remark": "bench 3"}, do_compression=True)


def _mat_73(path: Path) -> None:
    h5py = pytest.importorskip("h5py")
    with h5py.File(path, "w", userblock_size=512) as file:
        for name, values in {"Zeit": TIME_S, "Soll": ANGLE, "Ist": ANGLE + ERROR_DEG}.items():
            # n × 1 in MATLAB is stored as 1 × n in HDF5
            data = file.create_dataset(name, data=values[np.newaxis, :])
            data.attrs["MATLAB_class"] = np.bytes_("double")
        who = file.create_dataset("who", data=np.array([[98], [51]], dtype=np.uint16))
        who.attrs["MATLAB_class"] = np.bytes_("char")
        file.create_group("#refs#")
    head = b"MATLAB 7.3 MAT-file, Platform: GLNXA64".ljust(124) + b"\x00\x02IM"
    with path.open("r+b") as raw:
        raw.write(head)


def test_texts_of_any_length_in_hdf5_are_times(tmp_path: Path) -> None:
    """h5py returns such texts as an array of bytes objects."""
    h5py = pytest.importorskip("h5py")
    with h5py.File(tmp_path / "log.h5", "w") as file:
        times = [f"2026-01-31T12:00:{second:02d}" for second in range(8)]
        file.create_dataset("time", data=times, dtype=h5py.string_dtype())
        file["target_deg"], file["error_arcsec"] = np.arange(8.0) * 10.0, np.arange(8.0)
    words = ["--sign", "reading-true", tmp_path / "out"]
    done = arctrue(tmp_path / "log.h5", *words)
    assert done.exit_code == 0, done.output
    found = read_measurement_set(tmp_path / "out").reference
    assert found is not None
    assert found.time_s is not None
    np.testing.assert_allclose(found.time_s - found.time_s[0], np.arange(8.0), atol=1e-6)


@pytest.mark.parametrize("text", ["[" * 60000, '{"a":' * 30000])
def test_a_deeply_nested_file_is_refused(tmp_path: Path, text: str) -> None:
    (tmp_path / "log.json").write_text(text + "\n")
    done = arctrue(tmp_path / "log.json", tmp_path / "out")
    assert done.exit_code == 2
    assert "log.json" in done.output


@pytest.mark.parametrize("write", [_mat_5, _mat_5_plain, _mat_5_struct, _mat_73])
def test_mat_files(tmp_path: Path, write: Callable[[Path], None]) -> None:
    write(tmp_path / "log.mat")
    units = ("--unit", "time=s", "--unit", "target=deg", "--unit", "head1=deg")
    if write is _mat_5_struct:
        found, _ = checked(tmp_path, tmp_path / "log.mat", *units)
    else:
        found, said = checked(tmp_path, tmp_path / "log.mat", *units)
        assert "left out:" in said
        assert "who" in said
    assert found.direction is not None


def test_a_mat_file_of_two_structs_is_asked_for(tmp_path: Path) -> None:
    scipy.io.savemat(tmp_path / "a.mat", {"up": {"A": ANGLE}, "down": {"A": ANGLE}})
    done = arctrue(tmp_path / "a.mat", tmp_path / "out")
    assert done.exit_code == 2
    assert "--group up, --group down" in done.output
    found = read_recording(tmp_path / "a.mat", "", ReadSettings(group="down"), Choices())
    assert found.rows == ANGLE.size


def test_a_damaged_mat_file_is_a_sentence(tmp_path: Path) -> None:
    _mat_5(tmp_path / "a.mat")
    whole = (tmp_path / "a.mat").read_bytes()
    for length in range(130, len(whole), 97):
        (tmp_path / "cut.mat").write_bytes(whole[:length])
        with contextlib.suppress(MeasurementError):
            # The import may read a variable before the cut; any exception except MeasurementError
            # fails the test.
            found = read_recording(tmp_path / "cut.mat", "", ReadSettings(), Choices())
            assert set(found.columns) <= {"Zeit", "Soll", "Ist"}


@pytest.mark.parametrize(
    ("text", "degrees"),
    [
        ("12:30:36", 12.51),
        ("-0:30:00", -0.5),
        ("+359:59:59.9", 359.99997222222222),
        ("12°30'36\"", 12.51),
        ("12° 30′ 36,0″", 12.51),
        ("-12d30m36s", -12.51),
        ("12 30 36.0", 12.51),
        ("12:60:00", None),
        ("12:30:60", None),
        ("12:30", None),
        ("1:2:3:4", None),
        ("12", None),
    ],
)
def test_parts_of_sixty(text: str, degrees: float | None) -> None:
    found = sexagesimal(text)
    assert (found is None) == (degrees is None)
    if degrees is not None:
        assert found == pytest.approx(degrees, abs=1e-9)


def _sixty(angle: float, form: str) -> str:
    units = round(abs(angle) * 3_600_000.0)  # units of 0.001″
    degrees, left = divmod(units, 3_600_000)
    minutes, left = divmod(left, 60_000)
    return ("-" if angle < 0.0 else "") + form.format(degrees, minutes, left / 1000.0)


@pytest.mark.parametrize(
    "form",
    ["{}:{:02d}:{:06.3f}", "{}°{:02d}'{:06.3f}\"", "{}° {:02d}′ {:06.3f}″", "{} {:02d} {:06.3f}"],
)
@pytest.mark.parametrize("comma", [False, True])
def test_angles_in_degrees_minutes_and_seconds(tmp_path: Path, form: str, comma: bool) -> None:
    moved = ANGLE - 20.0  # so that some angles are negative
    lines = [
        f"{t:.3f};{_sixty(a, form)};{_sixty(a + e, form)}"
        for t, a, e in zip(TIME_S, moved, ERROR_DEG, strict=True)
    ]
    text = "\n".join(["Zeit [s];Soll;Ist", *lines]) + "\n"
    (tmp_path / "log.csv").write_text(text.replace(".", ",") if comma else text)
    done = arctrue(tmp_path / "log.csv", tmp_path / "out")
    assert done.exit_code == 0, done.output
    assert "Soll is in degrees, minutes and seconds" in " ".join(done.output.split())
    found = read_measurement_set(tmp_path / "out").reference
    assert found is not None
    np.testing.assert_allclose(found.target_deg, moved, atol=1e-6)  # 0.001″ is 3e-7 °
    np.testing.assert_allclose(found.error_arcsec, ERROR_DEG * 3600.0, atol=0.0011)


def test_parts_of_sixty_below_24_are_asked_for(tmp_path: Path) -> None:
    (tmp_path / "a.csv").write_text(
        "".join(f"{i // 60}:{i % 60:02d}:00,{i / 60:.6f}\n" for i in range(600))
    )
    words = (tmp_path / "a.csv", "--column", "target=1", "--column", "head1=2", "--unit")
    done = arctrue(*words, "head1=deg", tmp_path / "out")
    assert done.exit_code == 2
    assert "--unit target=deg, --unit target=hours" in done.output
    done = arctrue(*words, "head1=hours", "--unit", "target=hours", tmp_path / "out")
    assert done.exit_code == 0, done.output


def test_times_of_day_go_on_over_midnight(tmp_path: Path) -> None:
    seconds = 86_100 + 0.5 * np.arange(ANGLE.size) * 4.0
    lines = [
        f"{int(t) // 3600 % 24:02d}:{int(t) // 60 % 60:02d}:{t % 60:06.3f};{a:.6f};{a + e:.6f}"
        for t, a, e in zip(seconds, ANGLE, ERROR_DEG, strict=True)
    ]
    (tmp_path / "a.csv").write_text("\n".join(["Uhrzeit;Soll [deg];Ist [deg]", *lines]) + "\n")
    done = arctrue(tmp_path / "a.csv", tmp_path / "out")
    assert done.exit_code == 0, done.output
    found = read_measurement_set(tmp_path / "out").reference
    assert found is not None
    assert found.time_s is not None
    np.testing.assert_allclose(np.diff(found.time_s), 2.0, atol=1e-6)


@pytest.mark.parametrize("units", ["s;°;°", "[s];[°];[°]", "(s);(deg);(deg)"])
def test_a_row_of_units_under_the_header(tmp_path: Path, units: str) -> None:
    text = "\n".join(["Messung 4", "Zeit;Soll;Ist", units, *_rows()]) + "\n"
    (tmp_path / "log.csv").write_text(text)
    _, said = checked(tmp_path, tmp_path / "log.csv")
    assert "row 3 has the units" in said


def test_a_footer_is_left_out_and_said(tmp_path: Path) -> None:
    footer = ["Mittelwert;;0,0012", "", "Ende der Messung", "Dauer: 180 s; 361 Werte"]
    (tmp_path / "log.csv").write_text("\n".join([HEADER, *_rows(), *footer]) + "\n")
    _, said = checked(tmp_path, tmp_path / "log.csv")
    assert f"3 lines of words after the last row, from row {ANGLE.size + 2} on" in said
    assert "Mittelwert" in said


def test_a_preamble_with_numbers_is_no_row(tmp_path: Path) -> None:
    preamble = ["Abtastrate;2;Hz", "Zahl der Werte;361;", HEADER, "----;----;----"]
    (tmp_path / "log.csv").write_text("\n".join([*preamble, *_rows()]) + "\n")
    checked(tmp_path, tmp_path / "log.csv")


def test_words_between_rows_are_a_fault_with_their_place(tmp_path: Path) -> None:
    rows = _rows()
    rows[100:100] = ["Pause, weiter um 14 Uhr"]
    (tmp_path / "log.csv").write_text("\n".join([HEADER, *rows]) + "\n")
    done = arctrue(tmp_path / "log.csv", tmp_path / "out")
    assert done.exit_code == 2
    assert "log.csv, row 102: expected 3 fields, found 1: 'Pause, weiter um 14 Uhr'" in done.output


def test_a_repeated_header_is_left_out_and_said(tmp_path: Path) -> None:
    rows = _rows()
    rows[180:180] = ["Messung 4", HEADER]
    (tmp_path / "log.csv").write_text("\n".join(["Messung 4", HEADER, *rows]) + "\n")
    _, said = checked(tmp_path, tmp_path / "log.csv")
    assert "the lines above the rows are repeated, first at row 183" in said


def test_a_last_line_that_is_cut_off_is_left_out_and_said(tmp_path: Path) -> None:
    (tmp_path / "log.csv").write_text(_text() + "180,5;1")
    _, said = checked(tmp_path, tmp_path / "log.csv")
    assert "is cut off ('180,5;1') and left out" in said


def test_blocks_do_not_show(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    footer = ["Ende", "der Messung"]
    (tmp_path / "log.csv").write_text("\n".join([HEADER, *_rows(), *footer]) + "\n")
    for lines in (1, 7, 361, 362):
        monkeypatch.setattr(delimited_text, "BLOCK_LINES", lines)
        found = read_recording(tmp_path / "log.csv", "", ReadSettings(), Choices())
        assert found.rows == ANGLE.size
        assert found.lines is not None
        assert found.lines.tolist() == list(range(2, ANGLE.size + 2))
        np.testing.assert_allclose(found.columns["Soll [°]"], ANGLE, atol=1e-6)


@pytest.mark.parametrize("swaps", [1, 40, ANGLE.size])
def test_rows_out_of_order_are_sorted_and_said(tmp_path: Path, swaps: int) -> None:
    random = np.random.default_rng(3)
    order = np.arange(ANGLE.size)
    if swaps == ANGLE.size:
        random.shuffle(order)
    else:
        places = random.choice(ANGLE.size // 2, swaps, replace=False) * 2
        order[places], order[places + 1] = places + 1, places
    rows = np.array(_rows())[order]
    (tmp_path / "log.csv").write_text("\n".join([HEADER, *rows]) + "\n")
    found, said = checked(tmp_path, tmp_path / "log.csv")
    assert "the rows are sorted by time" in said
    assert found.run is not None
    assert found.run.max() == 1, "two runs: up and down"


def test_runs_that_begin_anew_are_not_mixed(tmp_path: Path) -> None:
    again = [row for _ in range(3) for row in _rows()]
    (tmp_path / "log.csv").write_text("\n".join([HEADER, *again]) + "\n")
    done = arctrue(tmp_path / "log.csv", tmp_path / "out")
    assert done.exit_code == 0, done.output
    assert "a new run begins there" in " ".join(done.output.split())
    found = read_measurement_set(tmp_path / "out").reference
    assert found is not None
    np.testing.assert_allclose(found.target_deg, np.tile(ANGLE, 3), atol=1e-6)
    assert found.run is not None
    assert found.run.max() == 5


def test_an_order_that_nobody_can_know_is_asked_for(tmp_path: Path) -> None:
    # Two explanations are possible: the second half was recorded before the first, or it is another
    # run.
    late = np.concatenate([TIME_S[:180] + 500.0, TIME_S[180:]])
    (tmp_path / "log.csv").write_text("\n".join([HEADER, *_rows(late)]) + "\n")
    words = (tmp_path / "log.csv",)
    done = arctrue(*words, tmp_path / "out")
    assert done.exit_code == 2
    assert "--order sort, --order runs" in done.output
    assert "first at row 182, from 589.5 to 90 s" in " ".join(done.output.split())
    done = arctrue(*words, "--order", "runs", tmp_path / "runs")
    assert done.exit_code == 0, done.output
    done = arctrue(*words, "--order", "sort", tmp_path / "sorted")
    assert done.exit_code == 0, done.output
    found = read_measurement_set(tmp_path / "sorted").reference
    assert found is not None
    assert found.time_s is not None
    assert (np.diff(found.time_s) > 0).all()


def test_what_stands_still_is_named_the_right_way_round(tmp_path: Path) -> None:
    still = np.full(ANGLE.size, 45.0)
    for name, target, head1 in (("target", still, ANGLE), ("head1", ANGLE, still)):
        np.savez(tmp_path / "a.npz", target_deg=target, head1_deg=head1)
        done = arctrue(tmp_path / "a.npz", tmp_path / "out")
        assert done.exit_code == 2
        assert f"{name} (column {name}_deg) stands still at 45°" in done.output
        assert "moves over 358°" in done.output
        assert "times as far" not in done.output
    np.savez(tmp_path / "a.npz", target_deg=still, head1_deg=still)
    done = arctrue(tmp_path / "a.npz", tmp_path / "out")
    assert done.exit_code == 2
    assert "neither target nor head1 moves" in done.output


def test_grad_is_asked_for(tmp_path: Path) -> None:
    rows = "".join(f"{a};{a + 0.01}\n" for a in ANGLE)
    (tmp_path / "a.csv").write_text("Soll [Grad];Ist [Grad]\n" + rows)
    done = arctrue(tmp_path / "a.csv", tmp_path / "out")
    assert done.exit_code == 2
    assert "Grad is degrees in German and gon in English" in done.output
    assert "--unit target=deg, --unit target=gon" in done.output


@pytest.mark.parametrize(
    ("head", "said"),
    [
        (b"PK\x03\x04....", "save the sheet of a workbook as CSV"),
        (b"BZh91AY", "bunzip2"),
        (b"\x00\x01\x02\x03" * 50, "is neither text nor a format"),
    ],
)
def test_other_files_are_answered_with_what_to_do(tmp_path: Path, head: bytes, said: str) -> None:
    (tmp_path / "a.xlsx").write_bytes(head)
    done = arctrue(tmp_path / "a.xlsx", tmp_path / "out")
    assert done.exit_code == 2
    assert said in done.output
