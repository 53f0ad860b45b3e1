"""Tests that sets of one table are joined into one set, row by row."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner, Result
from sim.tests.workbench.small_sets import measurement_set

from arctrue.cli import main
from arctrue.measurement import (
    JoinError,
    MeasurementSet,
    joined,
    read_measurement_set,
    write_measurement_set,
)


@pytest.fixture
def pair() -> tuple[MeasurementSet, MeasurementSet]:
    return measurement_set(cycles=2, turns=1, seed=1), measurement_set(cycles=3, turns=1, seed=2)


def test_every_row_is_there_and_every_number_once(
    pair: tuple[MeasurementSet, MeasurementSet],
) -> None:
    whole, notes = joined(pair, times="after")
    assert whole.capture is not None
    assert whole.reference is not None
    for name in ("head1_counts", "head2_counts", "temperature_c"):
        parts = [getattr(item.capture, name) for item in pair]
        np.testing.assert_array_equal(getattr(whole.capture, name), np.concatenate(parts))
    runs = [np.unique(item.capture.run).size for item in pair if item.capture is not None]
    assert np.unique(whole.capture.run).size == sum(runs)
    assert whole.reference.cycle is not None
    assert np.unique(whole.reference.cycle).size == 5
    assert pair[0].capture is not None
    rows = pair[0].capture.run.size
    assert whole.capture.time_s[rows] > whole.capture.time_s[:rows].max()
    assert any("clock began anew" in note for note in notes)


def test_clocks_that_overlap_are_no_guess(pair: tuple[MeasurementSet, MeasurementSet]) -> None:
    with pytest.raises(JoinError, match="--times after"):
        joined(pair)
    kept, _ = joined(pair, times="keep")
    assert kept.capture is not None
    assert pair[1].capture is not None
    np.testing.assert_array_equal(
        kept.capture.time_s[-pair[1].capture.time_s.size :], pair[1].capture.time_s
    )


def test_another_table_and_the_same_rows_are_refused(
    pair: tuple[MeasurementSet, MeasurementSet],
) -> None:
    other = replace(pair[1], table=replace(pair[1].table, counts_per_rev=4096))
    with pytest.raises(JoinError, match=r"another table than .*counts_per_rev is 4096"):
        joined([pair[0], other], times="after")
    with pytest.raises(JoinError, match="same rows"):
        joined([pair[0], pair[0]], times="after")


def test_a_column_that_one_lacks(pair: tuple[MeasurementSet, MeasurementSet]) -> None:
    assert pair[1].capture is not None
    cold = replace(pair[1], capture=replace(pair[1].capture, temperature_c=None))
    with pytest.raises(JoinError, match="has no column temperature_c"):
        joined([pair[0], cold], times="after")
    whole, notes = joined([pair[0], cold], times="after", common_columns=True)
    assert whole.capture is not None
    assert whole.capture.temperature_c is None
    assert any("temperature_c is left out" in note for note in notes)


def test_uncertainties_that_differ_stand_in_the_rows(
    pair: tuple[MeasurementSet, MeasurementSet],
) -> None:
    parts = []
    for item, u in zip(pair, (0.1, 0.3), strict=True):
        assert item.reference is not None
        reference = replace(item.reference, standard_uncertainty_arcsec=u)
        parts.append(replace(item, reference=reference))
    whole, _ = joined(parts, times="after")
    assert whole.reference is not None
    assert whole.reference.u_arcsec is not None
    assert np.unique(whole.reference.u_arcsec).tolist() == [0.1, 0.3]


def run(*words: str | Path) -> Result:
    return CliRunner().invoke(main, ["join", *map(str, words)], catch_exceptions=False)


def test_the_command(tmp_path: Path, pair: tuple[MeasurementSet, MeasurementSet]) -> None:
    for name, item in zip("ab", pair, strict=True):
        write_measurement_set(tmp_path / name, item)
    text = (tmp_path / "a" / "measurement.toml").read_text()
    (tmp_path / "a" / "measurement.toml").write_text(
        "own = 1\n" + text.replace("[table]", '[table]\nserial = "T 7"')
    )
    words = (tmp_path / "a", tmp_path / "b", tmp_path / "out")
    done = run(*words)
    assert done.exit_code == 2
    assert "--times keep" in done.output
    assert not (tmp_path / "out").exists()
    done = run("--times", "after", *words)
    assert done.exit_code == 0, done.output
    found = read_measurement_set(tmp_path / "out")
    assert found.other == {"own": 1, "table.serial": "T 7"}, "keys of others are kept"
    assert found.origin.command is not None
    assert found.origin.command.startswith("arctrue join --times after ")
    whole, _ = joined(pair, times="after")
    assert found.capture is not None
    assert whole.capture is not None
    np.testing.assert_array_equal(found.capture.head1_counts, whole.capture.head1_counts)
