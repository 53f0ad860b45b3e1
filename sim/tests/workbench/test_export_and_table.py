"""Tests which orders the export leaves out, and that it refuses a model of another table."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from sim.tests.command_line import arctrue as _run

from arctrue.gateware.coefficient_file import read_coefficient_file
from arctrue.measurement import MeasurementSet, write_measurement_set
from arctrue.workbench.model.model_file import read_model

from .small_sets import measurement_set, paper_error


@pytest.fixture(scope="module")
def made() -> MeasurementSet:
    return measurement_set(paper_error)


@pytest.fixture(scope="module")
def folder(made: MeasurementSet, tmp_path_factory: pytest.TempPathFactory) -> Path:
    place = tmp_path_factory.mktemp("made") / "set"
    write_measurement_set(place, made)
    return place


@pytest.fixture(scope="module")
def model(folder: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    place = tmp_path_factory.mktemp("model") / "model.toml"
    answer = _run("add", "hysteresis", folder, "--model", place)
    assert answer.exit_code == 0, answer.output
    return place


def _without_table(model: Path, place: Path) -> Path:
    text = model.read_text(encoding="utf-8")
    place.write_text(re.sub(r"\[table\]\n(\w.*\n)+", "", text), encoding="utf-8")
    return place


def test_only_significant_orders_have_a_lane(folder: Path, model: Path, tmp_path: Path) -> None:
    """The file has a lane (the correction of one order) only for each significant order: the set
    has the orders of ``paper_error``, while the model has twenty orders."""
    answer = _run("export", folder, "--model", model, "--out", tmp_path)
    assert answer.exit_code == 0, answer.output
    held = read_coefficient_file(tmp_path / "coefficients.toml")
    disc = np.arange(4096) * (2.0 * np.pi / 4096)
    spectrum = np.abs(np.fft.rfft(paper_error(disc, np.full(4096, 20.0), 0.0))) / 2048
    there = np.flatnonzero(spectrum > 0.01)
    assert held.orders[held.amplitudes != 0].tolist() == there[there > 0].tolist()
    assert "not significant" in answer.output


def test_lanes_that_double_the_error_are_refused(
    made: MeasurementSet, folder: Path, model: Path, tmp_path: Path
) -> None:
    """The export refuses coefficients that increase the error: the test reverses the sign of the
    reference errors, as if they came from another disc."""
    assert made.reference is not None
    assert made.capture is not None
    other = tmp_path / "other"
    turned = replace(made.reference, error_arcsec=-made.reference.error_arcsec)
    write_measurement_set(other, replace(made, reference=turned))
    out = tmp_path / "out"
    answer = _run("export", other, "--model", model, "--out", out, "--json", tmp_path / "e.json")
    assert answer.exit_code == 1, answer.output
    assert "rises" in answer.stderr
    assert not (out / "coefficients.toml").exists()
    assert '"file": null' in (tmp_path / "e.json").read_text()
    forced = _run("export", other, "--model", model, "--out", out, "--force")
    assert forced.exit_code == 0, forced.output
    assert (out / "coefficients.toml").exists()

    # Without a reference the export checks the coefficients against the capture, as the firmware
    # does: it refuses a capture with exchanged heads.
    swapped = replace(
        made.capture,
        head1_counts=made.capture.head2_counts,
        head2_counts=made.capture.head1_counts,
    )
    heads = tmp_path / "heads"
    write_measurement_set(heads, replace(made, capture=swapped, reference=None))
    answer = _run("export", heads, "--out", tmp_path / "heads_out")
    assert answer.exit_code == 1, answer.output
    assert "swapped" in answer.stderr
    alone = tmp_path / "alone"
    write_measurement_set(alone, replace(made, reference=None))
    assert _run("export", alone, "--out", tmp_path / "alone_out").exit_code == 0


@pytest.mark.parametrize(
    ("command", "options", "said"),
    [
        ("export", "--format csv --lanes 3", "--lanes is for the gateware"),
        ("export", "--format csv --modulators", "--modulators is for the gateware"),
        ("export", "--format csv --temperatures 10 30", "--temperatures is for the gateware"),
        ("export", "--format csv --sensor-lag 5", "--sensor-lag is for the gateware"),
        ("export", "--local-table --mean m.toml --lanes 3", "--lanes does not apply to --mean"),
        ("export", "--local-table --mean m.toml --json j", "--json does not apply to --mean"),
        ("export", "--temperature 20 --sensor-lag 5", "--temperature fixes the lanes"),
        ("export", "--temperature 20 --temperatures 10 30", "--temperature fixes the lanes"),
        ("export", "--temperatures 30 10", "found 30 and 10 °C"),
        ("export", "--reversal-width 2", "give --modulators"),
        ("budget", "--temperature 30", "--temperature is for a set with a reference run alone"),
        ("iso230", "--temperature 30", "give its --model"),
    ],
)
def test_an_option_that_would_change_nothing_is_refused(
    folder: Path, tmp_path: Path, command: str, options: str, said: str
) -> None:
    answer = _run(command, folder, "--out", tmp_path / "out", *options.split())
    assert answer.exit_code == 2, answer.output
    assert said in answer.stderr
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize("rows", [1, 2, 500])
def test_a_capture_that_leaves_a_part_of_the_turn_is_refused(
    made: MeasurementSet, tmp_path: Path, rows: int
) -> None:
    """The export fits the paper's twenty orders only to a whole turn: the fixture has 1,200 samples
    a turn, so that 500 leave 210°."""
    assert made.capture is not None
    first = made.capture.where(np.arange(made.capture.run.size) < rows)
    write_measurement_set(tmp_path / "part", replace(made, capture=first, reference=None))
    for name in ("gateware", "csv"):
        out = tmp_path / "out"
        answer = _run("export", tmp_path / "part", "--format", name, "--out", out)
        assert answer.exit_code == 2, answer.output
        missing = 360.0 - 0.3 * (rows - 1)
        assert f"no row over {missing:.1f}° of the turn" in answer.stderr
        assert not out.exists()
    # The stations of the reference, 15° apart, cannot distinguish order 4 from order 20.
    write_measurement_set(tmp_path / "both", replace(made, capture=first))
    answer = _run("export", tmp_path / "both", "--out", tmp_path / "both_out")
    assert answer.exit_code == 2, answer.output
    assert "no row over 15.0° of the turn" in answer.stderr


def test_a_model_of_another_table_is_refused(
    made: MeasurementSet, folder: Path, model: Path, tmp_path: Path
) -> None:
    table = read_model(model).table
    assert table is not None
    assert (table.counts_per_rev, table.head_separation_deg) == (1 << 24, pytest.approx(33.0))
    assert made.capture is not None
    apart = tmp_path / "apart"
    write_measurement_set(apart, replace(made, table=replace(made.table, head_separation_deg=32.9)))
    before = model.read_bytes()
    for words in (
        ("compare", apart),
        ("diagnose", apart),
        ("add", "thermal_eccentricity", apart),
        ("drop", "hysteresis", apart),
        ("export", apart, "--out", tmp_path),
    ):
        answer = _run(*words, "--model", model)
        assert answer.exit_code == 2, (words, answer.output)
        assert "another table: 33° between the heads, the set 32.9°" in answer.stderr
        assert "Traceback" not in answer.output
    assert model.read_bytes() == before
    reported = _run("compare", apart, "--model", model, "--other-table")
    assert reported.exit_code == 0, reported.output
    assert "another table" in reported.stderr

    counts = tmp_path / "counts"
    coarse = replace(
        made.capture,
        head1_counts=made.capture.head1_counts // 4,
        head2_counts=made.capture.head2_counts // 4,
    )
    write_measurement_set(
        counts,
        replace(
            made,
            table=replace(made.table, counts_per_rev=1 << 22),
            capture=coarse,
            reference=None,
        ),
    )
    answer = _run("compare", counts, "--model", model)
    assert answer.exit_code == 2
    assert "16777216 counts a turn, the set 4194304" in answer.stderr


@pytest.mark.large
def test_an_old_model_file_loads_with_a_warning(folder: Path, model: Path, tmp_path: Path) -> None:
    old = _without_table(model, tmp_path / "old.toml")
    assert read_model(old).table is None
    answer = _run("compare", folder, "--model", old)
    assert answer.exit_code == 0, answer.output
    assert "names no table" in answer.stderr
