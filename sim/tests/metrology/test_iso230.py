"""Tests of the figures of ISO 230-2 against published figures and against a computation in this
module, and of the command ``arctrue iso230``."""

from __future__ import annotations

import json
import re
import statistics
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner
from sim.tests.workbench.small_sets import measurement_set, paper_error

from arctrue.cli import main
from arctrue.measurement import MeasurementSet, write_measurement_set
from arctrue.metrology.iso230 import Contributions, of_reference, positioning

# A test of a linear axis by the Paul Scherrer Institute, in nm: github.com/paulscherrerinstitute/
# ecmccfg, examples/test/fat_sat/report.md at 072a917e, section "ISO230-2 calculations". The test
# does not use the report's R and E over the axis: they are the larger of R↑ and R↓ and the smaller
# of E↑ and E↓, while the standard (3.17, 3.20) takes the largest Rᵢ and the range over both
# directions.
PUBLISHED_UP = (
    (-81.02, -102.02, -87.02, -92.02, -100.02),
    (-87.02, -97.02, -97.02, -95.02, -82.02),
    (-72.02, -90.02, -88.02, -87.02, -87.02),
    (-102.02, -86.02, -86.02, -93.02, -78.02),
    (-100.02, -112.02, -129.02, -109.02, -97.02),
)
PUBLISHED_DOWN = (
    (-99.02, -94.02, -82.02, -91.02, -94.02),
    (-103.02, -104.02, -95.02, -111.02, -93.02),
    (-86.02, -102.02, -91.02, -76.02, -99.02),
    (-72.02, -92.02, -95.02, -103.02, -81.02),
    (-104.02, -126.02, -130.02, -141.02, -107.02),
)
PUBLISHED_FIGURES = {
    "A↑": 64.28, "A↓": 88.81, "A": 88.81, "R↑": 50.33, "R↓": 62.90, "E↑": 24.6, "E↓": 33.0,
    "M": 27.7, "B": 12.2, "B̄": 5.4,
}  # fmt: skip
PUBLISHED_R = (35.17, 37.72, 41.70, 48.71, 68.82)
PUBLISHED_B = (-0.4, 9.6, 6.0, -0.4, 12.2)
ROUNDED = 0.011
"""Largest rounding error of a published figure, or of the sum of two."""


def test_the_published_example_is_found_again() -> None:
    deviation = np.concatenate([np.ravel(PUBLISHED_UP), np.ravel(PUBLISHED_DOWN)])
    target = np.tile(np.repeat([0.0, 20.0, 40.0, 60.0, 80.0], 5), 2)
    found = positioning(target, np.repeat([1, -1], 25), deviation)
    figures = found.figures()
    for name, value in PUBLISHED_FIGURES.items():
        assert figures[name] == pytest.approx(value, abs=ROUNDED), name
    np.testing.assert_allclose(found.repeatability_arcsec, PUBLISHED_R, atol=ROUNDED)
    np.testing.assert_allclose(found.reversal_arcsec, PUBLISHED_B, atol=ROUNDED)
    assert figures["R"] == pytest.approx(max(PUBLISHED_R), abs=ROUNDED)
    assert found.objections == ("5 targets, 8 or more are required",)


def _direct(made: MeasurementSet) -> dict[str, float]:
    """Return the figures, computed from the rows with Python's standard library by the definitions
    in clause 3 of ISO 230-2."""
    run = made.reference
    assert run is not None
    assert run.direction is not None
    cells: dict[tuple[float, int], list[float]] = {}
    for target, side, error in zip(
        run.target_deg.tolist(), run.direction.tolist(), run.error_arcsec.tolist(), strict=True
    ):
        cells.setdefault((target % 360.0, side), []).append(-error)
    targets = sorted({target for target, _ in cells})
    mean = {cell: statistics.fmean(values) for cell, values in cells.items()}
    s = {cell: statistics.stdev(values) for cell, values in cells.items()}
    both = [(mean[t, 1] + mean[t, -1]) / 2 for t in targets]
    reversal = [mean[t, 1] - mean[t, -1] for t in targets]
    return {
        "A": max(mean[c] + 2 * s[c] for c in cells) - min(mean[c] - 2 * s[c] for c in cells),
        "R": max(
            max(2 * s[t, 1] + 2 * s[t, -1] + abs(b), 4 * s[t, 1], 4 * s[t, -1])
            for t, b in zip(targets, reversal, strict=True)
        ),
        "E": max(mean.values()) - min(mean.values()),
        "M": max(both) - min(both),
        "B": max(abs(b) for b in reversal),
        "B̄": statistics.fmean(reversal),
    }


def test_a_run_of_the_table_against_the_definitions() -> None:
    made = measurement_set(reversal_arcsec=2.0)
    assert made.reference is not None
    found = of_reference(made.reference)
    assert not found.objections
    figures = found.figures()
    for name, value in _direct(made).items():
        assert figures[name] == pytest.approx(value, abs=1e-9), name
    # A deviation has the opposite sign of the reading's error: where the reading is too large, the
    # table has turned too little.
    assert figures["B̄"] == pytest.approx(-2.0, abs=4 * 0.15 / np.sqrt(12 * 24))
    truth = paper_error(np.radians(found.target_deg), np.full(24, 20.0), 0.0)
    assert np.abs(found.mean_arcsec + truth).max() < 5 * 0.15 / np.sqrt(12)


def test_what_the_run_lacks_is_said_and_the_rest_is_given() -> None:
    made = measurement_set(cycles=3)
    run = made.reference
    assert run is not None
    few = of_reference(run)
    assert few.objections == (
        "24 of 24 targets have fewer than 5 approaches ↑ (the fewest: 3)",
        "24 of 24 targets have fewer than 5 approaches ↓ (the fewest: 3)",
    )
    assert np.isfinite(list(few.figures().values())).all()
    assert run.direction is not None
    one = of_reference(run.where(run.direction == 1))
    assert one.objections[0] == "one direction only (↑), both are required"
    figures = one.figures()
    assert np.isfinite([figures[name] for name in ("A↑", "R↑", "E↑")]).all()
    assert np.isnan([figures[name] for name in ("A", "R", "E", "M", "B", "B̄", "A↓")]).all()
    once = of_reference(run.where(np.arange(48 * 3) < 48)).figures()
    assert np.isfinite([once[name] for name in ("E", "M", "B")]).all()
    assert np.isnan([once[name] for name in ("A", "R")]).all()
    unsaid = of_reference(replace(run, direction=None))
    assert "does not state the direction of approach" in unsaid.objections[0]
    masked = of_reference(replace(run, mask=run.target_deg >= 90.0))
    assert masked.target_deg.max() < 90.0


def test_uncertainties_by_random_numbers() -> None:
    """The figures M, E↑ and B of simulated runs scatter by the uncertainties that the formulas
    give.

    The two extremes are far apart, so that the same targets always determine the range. The
    tolerance of 5 % is three standard errors of a standard deviation from 2000 draws.
    """
    random = np.random.default_rng(3)
    device, drift, runs, draws = 0.3, 0.2, 5, 2000
    true = np.array([0.0, 100.0, -100.0, 0.0, 1.0, 2.0, 3.0, 4.0])
    reference = random.normal(0.0, device, (draws, 8, 1, 1))
    reading = random.normal(0.0, drift, (draws, 8, 2, runs))
    mean = (true[None, :, None, None] + reference + reading).mean(axis=3)
    expanded = Contributions(device, drift).expanded(runs)
    m = np.ptp(mean.mean(axis=2), axis=1)
    e = np.ptp(mean[:, :, 0], axis=1)
    b = mean[:, 0, 0] - mean[:, 0, 1]
    for name, values in (("M", m), ("E↑", e), ("B", b)):
        assert 2.0 * values.std() == pytest.approx(expanded[name], rel=0.05), name
    assert np.isnan(Contributions(None, drift).expanded(runs)["A"])
    assert Contributions.from_drift(None, 1.2).environment_arcsec == pytest.approx(0.3464, abs=1e-4)


def _run(*words: object) -> str:
    done = CliRunner().invoke(main, ["iso230", *(str(word) for word in words)])
    assert done.exit_code == 0, done.output
    return done.output


def test_the_command_gives_figures_before_and_after_a_model(tmp_path: Path) -> None:
    made = measurement_set(reversal_arcsec=2.0, turns=1, runs=2)
    assert made.reference is not None
    made = replace(made, reference=replace(made.reference, standard_uncertainty_arcsec=0.15))
    write_measurement_set(tmp_path / "set", made)
    model = tmp_path / "model.toml"
    grown = CliRunner().invoke(
        main, ["add", "hysteresis", str(tmp_path / "set"), "--model", str(model)]
    )
    assert grown.exit_code == 0, grown.output
    printed = _run(
        tmp_path / "set", "--model", model, "--json", tmp_path / "f.json", "--drift", 0.2,
        "--out", tmp_path / "out",
    )  # fmt: skip
    assert "According to ISO 230-2." in printed
    assert "fitted to this run" in printed
    data = json.loads((tmp_path / "f.json").read_text())
    before, after = (data[key]["over_the_turn_arcsec"] for key in ("measured", "corrected"))
    assert before["M"] > 150.0
    # Only the scatter remains: 0.15″ per reading, 12 readings per mean, 24 targets.
    assert after["M"] < 6 * 0.15 / np.sqrt(12) + 0.1
    assert after["B"] < 6 * 0.15 / np.sqrt(3)
    assert after["R↑"] == pytest.approx(before["R↑"], abs=0.05)
    assert data["expanded_uncertainty_arcsec"]["M"] == pytest.approx(
        2 * np.sqrt(2 * 0.15**2 + (0.2**2 / 12) / 6), rel=1e-6
    )
    page = (tmp_path / "out" / "iso230.md").read_text()
    assert f"{before['A']:.3f}" in page
    assert data["set"]["sha256"] in page
    html = (tmp_path / "out" / "iso230.html").read_text()
    assert f"{before['A']:.3f}" in html
    assert not re.search(r'(src|href)="?http|url\((?!#)', html), "the page needs no other file"
    assert (tmp_path / "out" / "iso230.pdf").read_bytes().startswith(b"%PDF")


def test_a_set_without_a_reference_run_is_reported(tmp_path: Path) -> None:
    write_measurement_set(tmp_path / "set", measurement_set(reference=False, turns=1, runs=1))
    done = CliRunner().invoke(main, ["iso230", str(tmp_path / "set")])
    assert done.exit_code == 2
    assert "need a reference run" in done.stderr
