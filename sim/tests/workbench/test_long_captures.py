"""Tests that the diagnosis of a long capture, which searches in a part of the rows and then fits
every row, gives the same answer as a search in all rows."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner
from sim.tests.workbench.small_sets import RUNS, SAMPLES_A_TURN, measurement_set, paper_error

from arctrue.base.progress import SHOW_ROWS
from arctrue.cli import _progress, main
from arctrue.measurement import MeasurementSet, write_measurement_set
from arctrue.workbench.diagnose.data_faults import data_faults
from arctrue.workbench.diagnose.diagnosis import diagnose
from arctrue.workbench.effects.registry import built_in
from arctrue.workbench.inference import design_matrix, scan
from arctrue.workbench.inference.design_matrix import BLOCK_ROWS, Term
from arctrue.workbench.inference.every_row import channel_figures, on_every_row
from arctrue.workbench.inference.fit import fit
from arctrue.workbench.inference.residuals import Residuals
from arctrue.workbench.inference.search import places_of
from arctrue.workbench.model.growth import fitted
from arctrue.workbench.model.model import Model, ModelEffect
from arctrue.workbench.model.model_file import read_model
from arctrue.workbench.numeric.least_squares import WhitenedRows
from arctrue.workbench.observations import Observations, part
from arctrue.workbench.observations.build import observations_of

EFFECTS = built_in()
TURNS = 12
ROWS = len(RUNS) * TURNS * SAMPLES_A_TURN
LIMIT = 20_000
"""Largest number of the 57,600 rows that the diagnosis searches; it permits two pairs of turns of
each run."""


def _warm_error(disc, temperature, speed):  # type: ignore[no-untyped-def]
    return paper_error(disc, temperature, speed) + 0.2 * (temperature - 20.0) * np.cos(disc + 0.7)


@pytest.fixture(scope="module")
def warm() -> MeasurementSet:
    return measurement_set(_warm_error, turns=TURNS)


@pytest.fixture
def in_part(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(part, "MOST_ROWS", LIMIT)


def _graduation() -> Term:
    return Term(EFFECTS["graduation_harmonics"](), {})


def _within_sigma(first: dict[str, object], other: dict[str, object]) -> None:
    for name, item in first.items():
        there = other[name]
        # Part and whole share rows: their values differ by less than the uncertainty from the part.
        assert abs(item.value - there.value) < 4.0 * max(item.sigma, there.sigma), name  # type: ignore[attr-defined]


def test_the_part_is_whole_turns_of_every_run(warm: MeasurementSet, in_part: None) -> None:
    observations = observations_of(warm)
    rows = observations.capture
    assert rows is not None
    assert observations.stored is not None
    assert observations.capture_rows == ROWS
    assert 0.9 * LIMIT < rows.run.size <= LIMIT
    assert set(np.unique(rows.run)) == set(range(len(RUNS)))
    _, counts = np.unique(rows.revolution, return_counts=True)
    # The steps are free of noise; the angle of the first sample determines whether a turn has one
    # row more.
    assert np.all(np.abs(counts - SAMPLES_A_TURN) <= 1)
    again = observations_of(warm).capture
    assert again is not None
    np.testing.assert_array_equal(rows.time_s, again.time_s)


@pytest.mark.large
@pytest.mark.parametrize("block_rows", [BLOCK_ROWS, 10**6])
def test_every_row_gives_the_fit_of_the_whole(warm: MeasurementSet, block_rows: int) -> None:
    """The fit in blocks of rows equals one fit of all rows; both use the noise of the part.

    With one block, both compute the same sum. With several blocks, the fit ignores the correlation
    of the noise between two blocks, which changes a coefficient by less than 5 % of its σ.
    """
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(part, "MOST_ROWS", LIMIT)
        observations = observations_of(warm)
    searched = fit([_graduation()], observations)
    all_rows = observations_of(warm)
    noise = searched.noise.on(all_rows)
    whole = fit([_graduation()], all_rows, searched.context, noise=noise)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(design_matrix, "BLOCK_ROWS", block_rows)
        streamed = on_every_row(searched)
    assert streamed.every_row
    # The criterion counts the rows that are in the likelihood.
    penalty = (streamed.rank + streamed.searched) * np.log(all_rows.rows)
    assert streamed.bic == pytest.approx(penalty - 2.0 * streamed.log_likelihood, rel=1e-12)
    figures, expected = (channel_figures(item, "capture") for item in (streamed, whole))
    assert figures is not None
    assert expected is not None
    assert figures.rows == expected.rows == ROWS
    sigma = np.sqrt(np.diag(whole.covariance))
    if block_rows > ROWS:
        np.testing.assert_allclose(streamed.coefficients, whole.coefficients, atol=1e-7)
        np.testing.assert_allclose(streamed.covariance, whole.covariance, rtol=1e-5, atol=1e-12)
        assert figures.rms_arcsec == pytest.approx(expected.rms_arcsec, rel=1e-9)
        assert figures.peak_arcsec == pytest.approx(expected.peak_arcsec, rel=1e-9)
    else:
        np.testing.assert_array_less(
            np.abs(streamed.coefficients - whole.coefficients), 0.05 * sigma
        )
        np.testing.assert_allclose(np.sqrt(np.diag(streamed.covariance)), sigma, rtol=0.01)
        assert figures.rms_arcsec == pytest.approx(expected.rms_arcsec, rel=1e-3)
    away = (searched.coefficients - whole.coefficients) / np.sqrt(np.diag(searched.covariance))
    # The model lacks the thermal effect, so that the residual is not white; the part is still
    # representative.
    assert np.sqrt(np.mean(away**2)) < 2.0


@pytest.mark.large
def test_verdict_and_values_of_a_part_are_those_of_the_whole(warm: MeasurementSet) -> None:
    found = []
    for limit in (10**9, LIMIT):
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(part, "MOST_ROWS", limit)
            observations = observations_of(warm)
        result = diagnose(observations, [_graduation()], EFFECTS)
        assert result.verdict == "named"
        assert result.named is not None
        found.append((result.named.name, result.named.parameters()))
    assert found[0][0] == found[1][0] == "thermal_eccentricity"
    _within_sigma(found[0][1], found[1][1])  # type: ignore[arg-type]


def _with_slip(row: int, counts: int) -> MeasurementSet:
    made = measurement_set(turns=TURNS)
    capture = made.capture
    assert capture is not None
    heads = capture.head2_counts.copy()
    end = (row // (TURNS * SAMPLES_A_TURN) + 1) * TURNS * SAMPLES_A_TURN
    heads[row:end] += counts
    return replace(made, capture=replace(capture, head2_counts=heads))


@pytest.mark.large
def test_a_slip_between_the_stretches_is_found_at_its_row(in_part: None) -> None:
    made = _with_slip(20_000, 16)
    assert made.capture is not None
    observations = observations_of(made)
    assert observations.capture is not None
    instant = made.capture.time_s[20_000]
    run_times = observations.capture.time_s[observations.capture.run == 1]
    assert np.min(np.abs(run_times - instant)) > 1.0, "the part must not hold the slip itself"
    model = Model([ModelEffect("graduation_harmonics"), ModelEffect("count_slip")])
    grown, _ = fitted(model, observations, EFFECTS)
    assert grown.effects[1].search == {"run": 1.0, "instant": instant}
    assert grown.effects[1].parameters["counts"].value == pytest.approx(16.0, abs=0.2)


def test_a_fault_that_the_part_does_not_show_is_reported(in_part: None) -> None:
    made = measurement_set(turns=TURNS)
    assert made.capture is not None
    assert data_faults(observations_of(made)) == []
    heads1, heads2 = made.capture.head1_counts.copy(), made.capture.head2_counts.copy()
    heads1[20_000:28_800] += 50_000
    heads2[20_000:28_800] += 50_000
    broken = replace(made.capture, head1_counts=heads1, head2_counts=heads2)
    found = data_faults(observations_of(replace(made, capture=broken)))
    assert len(found) >= 1
    assert "run 1" in found[0]
    assert "row 20000" in found[0]


@pytest.mark.large
def test_a_vibration_is_found_window_by_window(
    monkeypatch: pytest.MonkeyPatch, in_part: None
) -> None:
    """The search finds a vibration in windows of 9 s, in runs of 144 s of which only a part is
    kept."""
    monkeypatch.setattr(scan, "LONGEST_WINDOW", 900)
    made = measurement_set(
        turns=TURNS,
        runs=2,
        reference=False,
        head2_only=lambda time, speed: 0.1 * np.cos(2.0 * np.pi * 7.3123 * time),
    )
    observations = observations_of(made)
    assert observations.stored is not None
    found = places_of(EFFECTS["vibration"](), Residuals(fit([_graduation()], observations)))
    # The tolerance is a tenth of the resolution 1/144 s of the run.
    assert found[0].nonlinear["frequency"] == pytest.approx(7.3123, abs=0.0007)


def test_run_offsets_that_are_not_written_out_sum_like_columns() -> None:
    random = np.random.default_rng(3)
    rows, shared, runs = 500, 4, 7
    columns, measured = random.normal(size=(rows, shared)), random.normal(size=rows)
    run = np.sort(random.integers(0, runs - 1, rows))
    ones = random.uniform(0.5, 2.0, rows)
    design = np.hstack([columns, ones[:, np.newaxis] * np.eye(runs)[run]])
    gram, moment = np.zeros((shared + runs,) * 2), np.zeros(shared + runs)
    for block in (slice(0, 123), slice(123, 123), slice(123, rows)):
        inside = WhitenedRows(columns[block], ones[block], run[block], runs)
        gram += inside.gram
        moment += inside.moment(measured[block])
    np.testing.assert_allclose(gram, design.T @ design, atol=1e-9)
    np.testing.assert_allclose(moment, design.T @ measured, atol=1e-9)


def _many_runs(runs: int) -> Observations:
    made = measurement_set(turns=TURNS, runs=1, reference=False)
    assert made.capture is not None
    run = np.arange(made.capture.run.size) * runs // made.capture.run.size
    return observations_of(replace(made, capture=replace(made.capture, run=run)))


def test_many_short_runs_all_stay_in_the_part(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(part, "MOST_ROWS", 6_000)
    observations = _many_runs(20)
    assert observations.capture is not None
    _, counts = np.unique(observations.capture.run, return_counts=True)
    assert counts.size == 20
    assert counts.min() >= part.LEAST_ROWS_A_RUN
    solution = on_every_row(fit([_graduation()], observations))
    assert solution.run_offsets_arcsec.size == 20


def test_dense_turns_are_thinned_evenly() -> None:
    # A run has 2 turns of 100,000 rows. A pair of whole turns exceeds the limit, but every eighth
    # row of the pair does not.
    revolution = np.repeat([0, 1], 100_000).astype(np.int32)
    pieces = part._stretches(revolution, 0, 25_000, np.random.default_rng(1))
    assert pieces == [(0, 200_000, 8)]


@pytest.mark.large
def test_progress_of_a_pass_is_reported(warm: MeasurementSet, in_part: None) -> None:
    reported: list[tuple[int, int]] = []
    observations = observations_of(warm)
    shown = SHOW_ROWS.set(lambda done, total: reported.append((done, total)))
    on_every_row(fit([_graduation()], observations))
    SHOW_ROWS.reset(shown)
    rows = observations.capture_rows
    assert reported[-1] == (rows, rows)
    assert len(reported) == -(-rows // BLOCK_ROWS)


@pytest.mark.large
def test_the_command_judges_all_rows_and_tells_how_far_it_is(
    warm: MeasurementSet, tmp_path: Path, in_part: None, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(_progress, "SECONDS_BETWEEN_LINES", -1.0)
    monkeypatch.setattr(_progress, "LONG_FILE_BYTES", 0)
    write_measurement_set(tmp_path / "set", warm)
    out, model = tmp_path / "c.json", tmp_path / "m.toml"
    added = CliRunner().invoke(
        main, ["add", "thermal_eccentricity", str(tmp_path / "set"), "--model", str(model)]
    )
    assert added.exit_code == 0, added.output
    done = CliRunner().invoke(
        main,
        ["compare", str(tmp_path / "set"), "--model", str(model), "--no-fit", "--json", str(out)],
    )
    assert done.exit_code == 0, done.output
    assert "reading capture.csv: 100 % of" in done.stderr
    assert f"comparing: 100 % of {ROWS:,} rows" in done.stderr
    channel = json.loads(out.read_text(encoding="utf-8"))["channels"]["capture"]
    assert channel["rows"] == ROWS
    # The stored figures also come from every row and the same coefficients. Only the noise, which
    # determines the weights of the runs' offsets, is estimated again.
    assert read_model(model).history[-1].rms_arcsec["capture"] == pytest.approx(
        channel["rms_arcsec"], rel=1e-3
    )
