"""Tests that the readers of damaged files return a set or a model, or raise an error with one
sentence that names the fault."""

from __future__ import annotations

import random
import re
import warnings
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner
from hypothesis import given, settings
from hypothesis import strategies as st

from arctrue.cli import main
from arctrue.measurement import MeasurementError, MeasurementSet, read_measurement_set
from arctrue.workbench.effects.base import Parameter
from arctrue.workbench.inference.design_matrix import Term
from arctrue.workbench.model.model import HistoryStep, Model, ModelEffect
from arctrue.workbench.model.model_file import ModelFileError, read_model, write_model
from arctrue.workbench.observations.build import observations_of

TOML = """schema = 1
title = "fuzzed"
[table]
counts_per_rev = 16777216
grating_lines = 16384
disc_diameter_mm = 107.95
head_separation_deg = 33.0
[capture]
file = "capture.csv"
clock_hz = 1e8
[reference]
file = "reference.csv"
faces = 24
standard_uncertainty_arcsec = 0.15
"""
CAPTURE = "run,time_s,head1_counts,head2_counts,temperature_c\n" + "".join(
    f"{row // 12},{0.1 * row:.1f},{row * 1398101},{row * 1398101 + 1537999},20.{row}\n"
    for row in range(24)
)
REFERENCE = "run,time_s,cycle,direction,target_deg,head1_counts,error_arcsec,temperature_c\n" + (
    "".join(
        f"0,{4.0 * row},0,1,{15.0 * row},{row * 699051},{0.1 * row:.2f},20.0\n" for row in range(24)
    )
)
NASTY = (
    "", " ", "nan", "-inf", "1e999", "1e308", "-1e308", "9223372036854775807",
    "9223372036854775808", "-9223372036854775808", "0x10", "1,5", '"', '"1"', "'", "\x00", "\ufeff",
    "½", "1_000", "+", "-", "1e", "--1", "true", "٣", "\r", "\n", "\r\n", ",,,,", "#", "=", "[",
    "]", "[[effect]]", "{}", "1979-05-27", "1" * 400,
)  # fmt: skip


def _damaged(text: bytes, chance: random.Random) -> bytes:
    """Return the text with one to three changes: bytes are changed, cut, doubled or inserted, a
    field is replaced, or two lines are exchanged."""
    data = bytearray(text)
    for _ in range(chance.randint(1, 3)):
        kind = chance.randrange(7)
        place = chance.randrange(len(data) + 1)
        if kind == 0 and data:
            data[min(place, len(data) - 1)] = chance.randrange(256)
        elif kind == 1:
            del data[place : place + chance.randint(1, 40)]
        elif kind == 2:
            data[place:place] = data[place : place + chance.randint(1, 60)]
        elif kind == 3:
            del data[place:]
        elif kind == 4:
            data[place:place] = chance.choice(NASTY).encode()
        else:
            lines = bytes(data).split(b"\n")
            index = chance.randrange(len(lines))
            fields = re.split(rb"[,=]", lines[index])
            if kind == 5:
                fields[chance.randrange(len(fields))] = chance.choice(NASTY).encode()
                mark = b"=" if b"=" in lines[index] else b","
                lines[index] = mark.join(fields)
            else:
                other = chance.randrange(len(lines))
                lines[index], lines[other] = lines[other], lines[index]
            data = bytearray(b"\n".join(lines))
    return bytes(data)


def _check_set(folder: Path, damaged: str) -> None:
    """Assert that a set has only finite rows, or that the reader's error names the folder of the
    set and, for a wrong value in a table, the column and the row."""
    found, fault = None, None
    try:
        found = read_measurement_set(folder)
    except MeasurementError as error:
        fault = error
    if found is not None:
        _check_rows(found)
    if fault is not None:
        assert str(folder) in str(fault)
        assert "\n" not in str(fault).replace(str(folder), ""), "one sentence"
    if (
        fault is not None
        and damaged.endswith(".csv")
        and fault.fault in ("value", "not_a_number", "time", "order")
    ):
        assert fault.column is not None
        data = (folder / damaged).read_bytes()
        assert 1 <= (fault.row or 0) <= data.count(b"\n") + data.count(b"\r") + 2


def _check_rows(found: MeasurementSet) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        try:
            observations = observations_of(found)
        except ValueError:
            return
    for rows in (observations.capture, observations.reference):
        if rows is None:
            continue
        for name, values in vars(rows).items():
            if isinstance(values, np.ndarray):
                assert np.all(np.isfinite(values)), name


SEEDS = st.integers(0, 2**32)


@pytest.mark.parametrize("damaged", ["measurement.toml", "capture.csv", "reference.csv"])
@settings(max_examples=200, deadline=None)
@given(seed=SEEDS)
def test_a_damaged_set_is_read_or_refused_with_its_place(
    tmp_path_factory: pytest.TempPathFactory, damaged: str, seed: int
) -> None:
    folder = tmp_path_factory.mktemp("set", numbered=True)
    files = {"measurement.toml": TOML, "capture.csv": CAPTURE, "reference.csv": REFERENCE}
    for name, text in files.items():
        data = text.encode()
        (folder / name).write_bytes(
            _damaged(data, random.Random(seed)) if name == damaged else data
        )
    _check_set(folder, damaged)


FIELDS = {
    "capture.csv": (CAPTURE, CAPTURE.splitlines()[0].split(",")),
    "reference.csv": (REFERENCE, REFERENCE.splitlines()[0].split(",")),
}
WRONG = st.sampled_from(
    [
        "",
        "nan",
        "NaN",
        "inf",
        "-Infinity",
        "1e999",
        "abc",
        "1.2.3",
        "0x1F",
        "½",
        "--1",
        "9" * 30,
        "1e13",
    ]
)


@settings(max_examples=80, deadline=None)
@given(
    file=st.sampled_from(sorted(FIELDS)),
    row=st.integers(2, 25),
    place=st.integers(0, 7),
    wrong=WRONG,
)
def test_a_wrong_field_is_named_by_file_row_and_column(
    tmp_path_factory: pytest.TempPathFactory, file: str, row: int, place: int, wrong: str
) -> None:
    folder = tmp_path_factory.mktemp("set", numbered=True)
    text, names = FIELDS[file]
    column = names[place % len(names)]
    lines = text.splitlines()
    fields = lines[row - 1].split(",")
    fields[names.index(column)] = wrong
    lines[row - 1] = ",".join(fields)
    (folder / "measurement.toml").write_text(TOML, encoding="utf-8")
    for name, (whole, _) in FIELDS.items():
        shown = "\n".join(lines) + "\n" if name == file else whole
        (folder / name).write_text(shown, encoding="utf-8")
    with pytest.raises(MeasurementError) as caught:
        read_measurement_set(folder)
    assert (caught.value.file.name, caught.value.row, caught.value.column) == (file, row, column)


def _model_text(folder: Path) -> bytes:
    channels = {"capture": 0.5, "reference": 0.2}
    model = Model(
        [
            ModelEffect(
                "graduation_harmonics",
                {"orders": [1, 2]},
                {},
                ["cos 1", "sin 1", "cos 2", "sin 2"],
                [1.0, 2.0, 3.0, 4.0],
                {"order_1_amplitude": Parameter(2.2, 0.1, "arcsec")},
            ),
            ModelEffect(
                "vibration", {}, {"frequency": 7.0}, ["cos run 0", "sin run 0"], [1.0, 0.0]
            ),
        ],
        ["effects"],
        [HistoryStep("fit", "graduation_harmonics", "set", channels, channels, channels, channels)],
        0.25,
    )
    write_model(folder / "whole.toml", model)
    return (folder / "whole.toml").read_bytes()


@settings(max_examples=400, deadline=None)
@given(seed=SEEDS)
def test_a_damaged_model_file_is_read_or_refused(
    tmp_path_factory: pytest.TempPathFactory, seed: int
) -> None:
    folder = tmp_path_factory.mktemp("model", numbered=True)
    path = folder / "m.toml"
    path.write_bytes(_damaged(_model_text(folder), random.Random(seed)))
    model, said = None, ""
    try:
        model = read_model(path)
    except ModelFileError as error:
        said = str(error)
    if model is None:
        assert str(path) in said
        return
    for entry in model.effects:
        assert len(entry.columns) == len(entry.coefficients)
        assert all(np.isfinite(entry.coefficients))


@pytest.mark.parametrize(
    "change",
    [
        lambda text: text.replace("capture.csv", "../capture.csv"),
        lambda text: text.replace("16777216", "4611686018427387904"),
        lambda text: text.replace("grating_lines = 16384", "grating_lines = 4611686018427387904"),
        lambda text: text.replace("33.0", "359.9999999"),
    ],
)
def test_the_commands_say_one_sentence(tmp_path: Path, change: Callable[[str], str]) -> None:
    (tmp_path / "measurement.toml").write_text(change(TOML), encoding="utf-8")
    (tmp_path / "capture.csv").write_text(CAPTURE, encoding="utf-8")
    (tmp_path / "reference.csv").write_text(REFERENCE, encoding="utf-8")
    for command in ("compare", "diagnose"):
        done = CliRunner().invoke(main, [command, str(tmp_path)])
        assert done.exit_code in (0, 2), (done.output, done.exception)
        assert done.exit_code == 0 or isinstance(done.exception, SystemExit)


def test_stored_models_of_any_shape_are_refused_by_name(tmp_path: Path) -> None:
    """If a model file is valid TOML but does not fit the effect, ``compare`` either succeeds or
    ends with exit code 2."""
    folder = tmp_path / "set"
    folder.mkdir()
    for name, text in {
        "measurement.toml": TOML, "capture.csv": CAPTURE, "reference.csv": REFERENCE
    }.items():  # fmt: skip
        (folder / name).write_text(text, encoding="utf-8")
    start = 'schema = 1\n[[effect]]\nname = "graduation_harmonics"\n'
    for body in (
        "settings = { orders = [] }",
        "settings = { orders = [0] }",
        "settings = { orders = [1.5] }",
        'settings = { orders = "x" }',
        "settings = { orders = [1000000000] }",
        "settings = { teeth = 3 }",
        "search = { order = 3 }",
        'columns = ["a"]\ncoefficients = [1]',
    ):
        path = tmp_path / "m.toml"
        path.write_text(start + body + "\n", encoding="utf-8")
        for options in ([], ["--no-fit"]):
            done = CliRunner().invoke(
                main, ["compare", str(folder), "--model", str(path), *options]
            )
            assert done.exit_code in (0, 2), (body, done.output, done.exception)
            assert done.exit_code == 0 or isinstance(done.exception, SystemExit), body


def test_terms_are_plain(tmp_path: Path) -> None:
    """The undamaged model file of the fuzz test gives a list of terms."""
    from arctrue.workbench.effects.registry import built_in

    (tmp_path / "m.toml").write_bytes(_model_text(tmp_path))
    terms = read_model(tmp_path / "m.toml").terms(built_in())
    assert [type(term) for term in terms] == [Term, Term]
