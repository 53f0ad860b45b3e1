"""Tests that ``arctrue import`` gives back the set from which the files in other formats were
written."""

from __future__ import annotations

import importlib
import json
import shlex
from collections.abc import Callable
from importlib.metadata import entry_points
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pa_parquet
import pytest
from click.testing import CliRunner, Result
from numpy.typing import NDArray

from arctrue.cli import main
from arctrue.importing import Choices, ReadSettings, Settings, import_recordings, read_recording
from arctrue.importing.choices import Ambiguous
from arctrue.measurement import MeasurementSet, read_measurement_set

DATA = Path(__file__).resolve().parents[3] / "docs" / "data"
Float = NDArray[np.float64]


def arctrue(*words: str | Path) -> Result:
    return CliRunner().invoke(main, ["import", *map(str, words)], catch_exceptions=False)


def imported(tmp_path: Path, *words: str | Path) -> MeasurementSet:
    done = arctrue(*words, tmp_path / "out")
    assert done.exit_code == 0, done.output
    return read_measurement_set(tmp_path / "out")


def refused(tmp_path: Path, *words: str | Path) -> str:
    done = arctrue(*words, tmp_path / "out")
    assert done.exit_code == 2, done.output
    assert not (tmp_path / "out").exists()
    return done.output


@pytest.fixture(scope="module")
def real() -> MeasurementSet:
    """Return a set that was recorded with a real motor encoder, forward and backward."""
    return read_measurement_set(DATA / "moteus_motor_encoder")


def _columns(real: MeasurementSet) -> tuple[Float, NDArray[np.int64], Float]:
    reference = real.reference
    assert reference is not None
    assert reference.head1_counts is not None
    return reference.target_deg, reference.head1_counts, reference.error_arcsec


def _csv(path: Path, target: Float, error: Float) -> None:
    lines = [f"{a:.9f},{b:.6f}" for a, b in zip(target, error, strict=True)]
    path.write_text("Az,Err\n" + "\n".join(lines) + "\n")


def _german(path: Path, target: Float, error: Float) -> None:
    lines = [f"{a:.9f};{b:.6f}".replace(".", ",") for a, b in zip(target, error, strict=True)]
    path.write_bytes(("\ufeffPrüfling 7\r\nAz;Err\r\n" + "\r\n".join(lines)).encode())


def _spaces(path: Path, target: Float, error: Float) -> None:
    lines = [f"  {a:.9f}   {b:.6e}" for a, b in zip(target, error, strict=True)]
    path.write_text("# a log\n#  Az Err\n" + "\n".join(lines) + "\n")


def _tabs(path: Path, target: Float, error: Float) -> None:
    lines = [f"{a:.9f}\t{b:.6f}" for a, b in zip(target, error, strict=True)]
    path.write_text("Az\tErr\n" + "\n".join(lines) + "\n")


def _json(path: Path, target: Float, error: Float) -> None:
    rows = [json.dumps({"Az": a, "Err": b}) for a, b in zip(target, error, strict=True)]
    path.write_text("\n".join(rows) + "\n")


def _structured(path: Path, target: Float, error: Float) -> None:
    rows = np.zeros(target.size, dtype=[("Az", "f8"), ("Err", "f8")])
    rows["Az"], rows["Err"] = target, error
    with path.open("wb") as file:
        np.save(file, rows)


def _archive(path: Path, target: Float, error: Float) -> None:
    np.savez(path, Az=target, Err=error)


def _parquet(path: Path, target: Float, error: Float) -> None:
    pa_parquet.write_table(pa.table({"Az": target, "Err": error}), path)


def _hdf5(path: Path, target: Float, error: Float) -> None:
    h5py = pytest.importorskip("h5py")
    with h5py.File(path, "w") as file:
        file["log/Az"], file["log/Err"] = target, error


@pytest.mark.parametrize(
    ("name", "write"),
    [
        ("a.csv", _csv),
        ("german.csv", _german),
        ("a.dat", _spaces),
        ("a.tsv", _tabs),
        ("a.jsonl", _json),
        ("a.npy", _structured),
        ("a.npz", _archive),
        ("a.parquet", _parquet),
        ("a.h5", _hdf5),
    ],
)
def test_every_format_gives_the_same_set(
    real: MeasurementSet,
    tmp_path: Path,
    name: str,
    write: Callable[[Path, Float, Float], None],
) -> None:
    target, _, error = _columns(real)
    write(tmp_path / name, target, error)
    found = imported(
        tmp_path,
        tmp_path / name,
        *("--column", "target=Az", "--unit", "target=deg"),
        *("--column", "error=Err", "--unit", "error=arcsec", "--sign", "reading-true"),
    ).reference
    assert found is not None
    np.testing.assert_allclose(found.target_deg, target, atol=2e-9)  # written to 1e-9 °
    np.testing.assert_allclose(found.error_arcsec, error, atol=2e-6)  # to 1e-6 ″
    assert found.direction is not None
    assert real.reference is not None
    # The direction agrees in every row, except for the row in which the motor stands at the turning
    # point.
    assert np.count_nonzero(found.direction != real.reference.direction) <= 1


@pytest.mark.parametrize(
    ("unit", "per_turn"),
    [
        ("deg", 360.0),
        ("rad", 2 * np.pi),
        ("gon", 400.0),
        ("arcsec", 1_296_000.0),
        ("turns", 1.0),
        ("counts", 65536.0),
        ("hours", 24.0),
    ],
)
def test_units_and_wraps(real: MeasurementSet, tmp_path: Path, unit: str, per_turn: float) -> None:
    target, counts, _ = _columns(real)
    wrapped = np.mod(target, 360.0) / 360.0 * per_turn
    np.savez(tmp_path / "a.npz", ref=wrapped, enc=np.mod(counts, 65536))
    found = imported(
        tmp_path,
        tmp_path / "a.npz",
        *("--column", "target=ref", "--unit", f"target={unit}", "--counts-per-rev", "65536"),
        *("--column", "head1=enc", "--unit", "head1=counts"),
    ).reference
    assert found is not None
    assert found.head1_counts is not None
    expected = (counts / 65536.0 - target / 360.0 + 0.5) % 1.0 - 0.5
    np.testing.assert_allclose(found.error_arcsec, expected * 1_296_000.0, atol=1e-5)
    assert found.run is not None
    assert found.run.max() == 1, "two runs: up and down"


def test_two_heads_that_wrap_become_a_capture(tmp_path: Path) -> None:
    turns = np.concatenate([np.linspace(0.1, 3.4, 4000), np.linspace(3.4, 0.1, 4000)])
    counts = np.round(turns * (1 << 20)).astype(np.int64)
    second = counts + round(90 / 360 * (1 << 20))
    rows = np.column_stack([np.arange(8000) * 5.0, counts % (1 << 20), second % (1 << 20)])
    np.save(tmp_path / "a.npy", rows)
    options = ["--column", "time=1", "--unit", "time=ms", "--column", "head1=2"]
    options += ["--column", "head2=3", "--unit", "head1=counts", "--unit", "head2=counts"]
    options += ["--column", "target=none", "--counts-per-rev", str(1 << 20), "--separation", "90"]
    found = imported(tmp_path, tmp_path / "a.npy", *options)
    assert found.capture is not None
    assert found.warnings == ()
    for run, span in ((0, slice(0, 4000)), (1, slice(4000, 8000))):
        here = found.capture.run == run
        assert np.count_nonzero(here) == 4000
        moved = found.capture.head1_counts[here] - found.capture.head1_counts[here][0]
        np.testing.assert_array_equal(moved, counts[span] - counts[span][0])
    apart = found.capture.head2_counts - found.capture.head1_counts
    np.testing.assert_array_equal(apart, second - counts)
    assert found.capture.time_s[-1] == pytest.approx(7999 * 0.005)


def four_heads(tmp_path: Path) -> tuple[Path, np.ndarray]:
    """Write counts of four heads that restart at each turn, under the column names of a set."""
    turns = np.linspace(0.1, 3.4, 4000)
    apart = np.round(np.array([0.0, 64.3, 177.0, 257.9]) / 360.0 * (1 << 20)).astype(np.int64)
    counts = np.round(turns * (1 << 20)).astype(np.int64)[:, None] + apart
    rows = np.column_stack([np.arange(4000) * 0.005, counts % (1 << 20)])
    named = "time_s," + ",".join(f"head{head}_counts" for head in range(1, 5))
    np.savetxt(
        tmp_path / "a.csv",
        rows,
        delimiter=",",
        header=named,
        comments="",
        fmt=["%.3f"] + 4 * ["%d"],
    )
    return tmp_path / "a.csv", counts


def test_four_heads_that_wrap_become_a_capture(tmp_path: Path) -> None:
    path, counts = four_heads(tmp_path)
    options = ["--counts-per-rev", str(1 << 20), "--places", "0,64.3,177,257.9"]
    found = imported(tmp_path, path, *options)
    assert found.capture is not None
    assert found.table.head_places_deg == (0.0, 64.3, 177.0, 257.9)
    assert len(found.capture.heads) == 4
    for head, expected in zip(found.capture.heads, counts.T, strict=True):
        np.testing.assert_array_equal(head - found.capture.heads[0], expected - counts[:, 0])


def test_places_for_another_number_of_heads_are_refused(tmp_path: Path) -> None:
    path, _ = four_heads(tmp_path)
    words = [str(path), str(tmp_path / "set"), "--counts-per-rev", str(1 << 20)]
    answer = CliRunner().invoke(main, ["import", *words, "--separation", "64.3"])
    assert answer.exit_code == 2
    assert "a place for each of the 4 heads" in " ".join(answer.output.split())


def test_the_sign_is_never_guessed(real: MeasurementSet, tmp_path: Path) -> None:
    target, counts, error = _columns(real)
    np.savez(tmp_path / "a.npz", target_deg=target, error_arcsec=-error)
    said = refused(tmp_path, tmp_path / "a.npz")
    assert "--sign reading-true, --sign true-reading" in said
    found = imported(tmp_path, tmp_path / "a.npz", "--sign", "true-reading").reference
    assert found is not None
    np.testing.assert_allclose(found.error_arcsec, error, atol=2e-6)
    # If the file also contains the reading, the import finds the sign and reports it.
    both = {"target_deg": target, "error_arcsec": -error, "head1_counts": counts}
    np.savez(tmp_path / "b.npz", **both)
    words = [tmp_path / "b.npz", "--counts-per-rev", "65536", tmp_path / "second"]
    done = arctrue(*words)
    assert "true-reading, as head1 and target show" in done.output
    other = read_measurement_set(tmp_path / "second").reference
    assert other is not None
    np.testing.assert_allclose(other.error_arcsec, error, atol=2e-6)


def test_a_unit_that_is_not_said_is_refused_and_a_wrong_one_found(tmp_path: Path) -> None:
    target = np.linspace(0.0, 300.0, 500)
    np.savez(tmp_path / "a.npz", A=target, B=target + 0.001)
    words = [tmp_path / "a.npz", "--column", "target=A", "--column", "head1=B"]
    assert "--unit target=deg, --unit target=rad" in refused(tmp_path, *words)
    said = refused(tmp_path, *words, "--unit", "target=gon", "--unit", "head1=deg")
    assert "head1 moves 1.111 times as far as target" in said


def test_unnamed_columns_are_listed(tmp_path: Path) -> None:
    (tmp_path / "a.txt").write_text("".join(f"{i} {i * i}\n" for i in range(50)))
    said = refused(tmp_path, tmp_path / "a.txt")
    assert "--column target=1, --column target=2, --column target=none" in said


def test_a_reference_that_counts_the_other_way_and_another_zero(tmp_path: Path) -> None:
    angle = np.concatenate([np.arange(0.0, 360.0, 15.0), np.arange(345.0, -15.0, -15.0)])
    error = 0.002 * np.sin(np.deg2rad(angle))
    np.savez(tmp_path / "a.npz", target_deg=-angle + 100.0, head1_deg=angle + error)
    words = [tmp_path / "a.npz"]
    assert "--zero shift, --zero keep" in refused(tmp_path, *words)
    done = arctrue(*words, "--zero", "shift", tmp_path / "out")
    assert "target counts in the opposite direction" in done.output
    found = read_measurement_set(tmp_path / "out").reference
    assert found is not None
    np.testing.assert_allclose(found.error_arcsec, (error - error.mean()) * 3600.0, atol=1e-3)
    assert found.cycle is not None
    assert found.direction is not None
    assert set(found.cycle) == {0}
    np.testing.assert_array_equal(found.direction, np.repeat([1, -1], 24))


def test_missing_values_name_their_place(tmp_path: Path) -> None:
    (tmp_path / "a.csv").write_text("target_deg,error_arcsec\n1,2\n2,\n3,4\n4,abc\n")
    words = [tmp_path / "a.csv", "--sign", "reading-true"]
    assert "a.csv, row 5, column error_arcsec: expected a number, found 'abc'" in refused(
        tmp_path, *words
    )
    (tmp_path / "a.csv").write_text("target_deg,error_arcsec\n1,2\n2,\n3,4\n4,5\n")
    assert "a.csv, row 3, column error_arcsec: the value is missing" in refused(tmp_path, *words)
    found = imported(tmp_path, *words, "--missing", "drop").reference
    assert found is not None
    assert found.target_deg.tolist() == [1.0, 3.0, 4.0]


def test_a_wrong_field_among_decimal_commas_names_its_row(tmp_path: Path) -> None:
    rows = [f"{i},5;{i},25" for i in range(60)]
    rows[40] = "40,5;abc"
    (tmp_path / "a.csv").write_text("target_deg;error_arcsec\n" + "\n".join(rows) + "\n")
    words = [tmp_path / "a.csv", "--sign", "reading-true", "--decimal", "comma"]
    output = refused(tmp_path, *words)
    assert "a.csv, row 42, column error_arcsec: expected a number, found 'abc'" in output


def test_times_of_day_continue_past_midnight_although_one_is_missing(tmp_path: Path) -> None:
    clock = [*(f"23:59:{second}" for second in range(50, 60)), "", "00:00:01", "00:00:02"]
    rows = [f"{time},{10 * i},{i % 3}" for i, time in enumerate(clock)]
    (tmp_path / "a.csv").write_text("time,target_deg,error_arcsec\n" + "\n".join(rows) + "\n")
    words = [tmp_path / "a.csv", "--sign", "reading-true", "--missing", "drop"]
    found = imported(tmp_path, *words).reference
    assert found is not None
    assert found.time_s is not None
    passed = found.time_s - found.time_s[0]
    assert passed.tolist() == [*map(float, range(10)), 11.0, 12.0]


def test_the_command_is_written_and_repeats_the_import(
    real: MeasurementSet, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    target, _, error = _columns(real)
    np.savez(tmp_path / "a file.npz", target_deg=target, error_arcsec=error)
    answers = iter(["true-reading"])
    asked: list[str] = []

    def answer(question: Ambiguous) -> str:
        asked.append(question.option)
        return next(answers)

    monkeypatch.setattr(importlib.import_module("arctrue.cli.import_"), "refuse", answer)
    first = imported(tmp_path, tmp_path / "a file.npz", "--title", "Axis 3")
    assert asked == ["--sign"]
    assert first.origin.command is not None
    words = shlex.split(first.origin.command)
    assert words[:2] == ["arctrue", "import"]
    monkeypatch.undo()
    done = CliRunner().invoke(main, [*words[1:-1], str(tmp_path / "again")], catch_exceptions=False)
    assert done.exit_code == 0, done.output
    texts = [(tmp_path / name / "reference.csv").read_text() for name in ("out", "again")]
    assert texts[0] == texts[1]


def test_the_command_repeats_places_and_zeros(tmp_path: Path) -> None:
    (tmp_path / "a.csv").write_text(
        "target_deg,head1_counts,head2_counts\n" + "".join(f"{n},{n},{n}\n" for n in range(40))
    )
    words = ["--places", "0,64.5", "--clock-offset", "0", "--counts-per-rev", "360"]
    command = imported(tmp_path, tmp_path / "a.csv", *words).origin.command
    assert command is not None
    typed = shlex.split(command)
    for option, value in (("--places", "0.0,64.5"), ("--clock-offset", "0.0")):
        assert typed[typed.index(option) + 1] == value


def test_a_dry_run_writes_nothing(real: MeasurementSet, tmp_path: Path) -> None:
    target, _, error = _columns(real)
    np.savez(tmp_path / "a.npz", target_deg=target, error_arcsec=error)
    words = [tmp_path / "a.npz", "--sign", "reading-true", "--dry-run", tmp_path / "out"]
    done = arctrue(*words)
    assert done.exit_code == 0, done.output
    assert "2,119 rows" in done.output
    assert not (tmp_path / "out").exists()


def test_a_column_of_the_set_as_name_is_refused(tmp_path: Path) -> None:
    """A condition named temperature_c would be read again as the temperature, without a unit."""
    rows = "".join(f"{i},{i % 7},{293 + i / 100}\n" for i in range(40))
    (tmp_path / "a.csv").write_text("target_deg,error_arcsec,T_K\n" + rows)
    words = [tmp_path / "a.csv", "--sign", "reading-true"]
    for name, quantity in (("temperature_c", "temperature"), ("time_s", "time")):
        output = refused(tmp_path, *words, "--column", f"{name}=T_K")
        assert f"use --column {quantity}=T_K" in " ".join(output.split())
    read = imported(tmp_path, *words, "--column", "temperature=T_K").reference
    assert read is not None
    assert read.temperature_c is not None
    assert np.allclose(read.temperature_c, 19.85 + np.arange(40) / 100, atol=1e-9)


@pytest.mark.parametrize("name", ["capture.csv", "reference.csv", "mask.csv"])
def test_a_file_with_the_name_of_a_part_of_a_set_is_not_replaced(tmp_path: Path, name: str) -> None:
    """The recorded file lies in OUT itself; the import must not replace it by a part of the set."""
    recorded = tmp_path / name
    text = "target_deg,error_arcsec,operator\n" + "".join(f"{i}0,{i},Ann\n" for i in range(36))
    recorded.write_text(text)
    done = arctrue(recorded, "--sign", "reading-true", tmp_path)
    assert done.exit_code == 2
    assert f"already holds a {name}" in done.output
    assert recorded.read_text() == text
    assert [path.name for path in tmp_path.iterdir()] == [name]


def test_the_readers_are_entry_points() -> None:
    named = {point.name for point in entry_points(group="arctrue.readers")}
    assert {"text", "json", "numpy", "parquet", "hdf5", "phd2", "linuxcnc", "epics"} <= named


def test_two_logs_on_different_clocks_are_brought_together(tmp_path: Path) -> None:
    random = np.random.default_rng(4)
    time_s = np.arange(0.0, 60.0, 0.01)

    def angle(t: Float) -> Float:  # in turns; the speed varies and does not repeat
        return 0.05 * t + 0.004 * np.sin(0.9 * t) + 0.003 * np.sin(0.37 * t * np.sqrt(2.0) + 1.0)

    late = 0.00137  # seconds by which the reference's clock is late, in addition to 1,000 s
    reference_time_s = np.arange(5.0, 55.0, 0.023)
    error = 20.0 / 1_296_000.0 * np.sin(2 * np.pi * angle(time_s))
    np.savez(tmp_path / "enc.npz", t=time_s, A=angle(time_s) + error)
    np.savez(
        tmp_path / "ref.npz",
        t=reference_time_s - 1000.0 - late,
        R=angle(reference_time_s) + random.normal(0.0, 1e-7, reference_time_s.size),
    )
    settings = Settings(
        columns={"time": "t", "head1": "A", "target": "R"},
        units={"time": "s", "head1": "turns", "target": "turns"},
    )
    choices = Choices()
    read = [
        read_recording(tmp_path / name, "", ReadSettings(), choices)
        for name in ("enc.npz", "ref.npz")
    ]
    found = import_recordings(read, settings, choices)
    assert found.clocks is not None
    # The speed varies by only ±0.005 turn/s, so that the table's error of 20″ changes the estimated
    # offset.
    assert abs(found.clocks.offset_s - 1000.0 - late) < max(5 * found.clocks.u_s, 1e-4)
    assert found.clocks.u_s < 2e-3
    assert any(note.startswith("clocks: +1000.00") for note in found.notes)
    reference = found.measurement.reference
    assert reference is not None
    expected = 20.0 * np.sin(np.deg2rad(reference.target_deg))
    rest = reference.error_arcsec - expected
    assert np.std(rest) < 5.0


def test_logs_at_constant_speed_ask_for_the_offset(tmp_path: Path) -> None:
    time_s = np.arange(0.0, 20.0, 0.01)
    np.savez(tmp_path / "enc.npz", time_s=time_s, head1_turns=0.1 * time_s)
    np.savez(tmp_path / "ref.npz", time_s=time_s[5:-5], target_turns=0.1 * time_s[5:-5])
    words = [tmp_path / "enc.npz", tmp_path / "ref.npz"]
    assert "constant speed" in refused(tmp_path, *words)
    found = imported(tmp_path, *words, "--clock-offset", "0").reference
    assert found is not None
    assert np.abs(found.error_arcsec).max() < 1e-3
