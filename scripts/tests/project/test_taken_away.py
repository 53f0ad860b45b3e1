"""Tests that the stored figures of each effect's compensation agree with a new simulation and
export."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import pytest
from click.testing import CliRunner

from arctrue.calibration.calibration import objections
from arctrue.cli import main
from arctrue.gateware.coefficient_file import read_coefficient_file
from arctrue.measurement import write_measurement_set
from arctrue.report.taken_away_table import stored
from arctrue.studies.simulate.experiment import short
from arctrue.studies.simulate.simulated_set import Wanted, simulate_set
from arctrue.workbench.effects.registry import built_in
from arctrue.workbench.model.growth import fitted
from arctrue.workbench.model.model import ModelEffect, default_model
from arctrue.workbench.model.model_file import write_model
from arctrue.workbench.observations.build import observations_of
from scripts.measure_taken_away import (
    OF_THE_MEAN,
    SEED,
    _fresh_turns,
    left_in_mean_arcsec,
    measure,
    measured_effects,
)

TAKERS = {
    "lanes": "lanes",
    "none": "nothing",
    "modulators": "lanes by condition",
    "local_table": "local table",
    "reference": "reference",
}


def test_every_effect_has_been_measured() -> None:
    assert list(stored()["effects"]) == measured_effects()


def test_what_can_be_taken_away_is() -> None:
    """If lanes, a condition, the firmware's thermal model or a local table corrects an effect, at
    most a small share of the effect, or 0.03″, remains.

    The limit of 0.03″ is three standard uncertainties of the lanes' sum, about 0.01″ each for a set
    with a sixth of the samples. For periodic_error the lanes have the orders that the search finds,
    which are not integers.
    """
    for name, row in stored()["effects"].items():
        declared = built_in()[name].compensation
        by = row["taken_away_by"]
        if by == "not in the output":
            assert row["part_arcsec"] == 0.0, name
        elif by in ("lanes", "firmware's model", "lanes by condition", "local table"):
            whose = {taker: kind for kind, taker in TAKERS.items()}
            assert declared == whose.get(by, "lanes"), name
            assert row["left_with_arcsec"] < max(0.05 * row["part_arcsec"], 0.03), name
        elif name == "periodic_error":
            assert by == "lanes of real orders"
            assert row["left_with_arcsec"] < 0.25 * row["part_arcsec"]
        else:
            assert by == TAKERS[declared], name


def test_nobody_takes_away_what_the_page_says_is_left() -> None:
    for name, row in stored()["effects"].items():
        if row["taken_away_by"] == "nothing":
            assert row["left_with_arcsec"] > 0.8 * row["part_arcsec"] > 0.0, name


def test_the_mean_takes_away_what_moves_axis_and_centre() -> None:
    """The mean of four heads leaves at most 0.03″, the limit of the lanes, of each effect whose
    page names it; head 1 has more than 2″."""
    named = [
        name for name, effect in built_in().items() if "weighted mean" in effect.compensation_note
    ]
    rows = stored()["effects"]
    assert sorted(named) == sorted(OF_THE_MEAN)
    assert sorted(named) == sorted(name for name in rows if "left_in_mean_arcsec" in rows[name])
    for name in named:
        assert rows[name]["left_in_mean_arcsec"] < 0.03 < 2.0 < rows[name]["part_arcsec"], name


@pytest.mark.parametrize("name", ["bearing_ball_pass"])
def test_the_stored_figures_of_the_mean_are_measured(name: str) -> None:
    found = left_in_mean_arcsec(name, _fresh_turns(SEED))
    assert found == pytest.approx(stored()["effects"][name]["left_in_mean_arcsec"], abs=0.003)


@pytest.mark.parametrize(
    "name",
    [
        pytest.param("thermal_eccentricity", marks=pytest.mark.large),
        "hysteresis",
        pytest.param("latency", marks=pytest.mark.large),
    ],
)
def test_the_stored_figures_are_measured(name: str) -> None:
    """A new measurement gives the stored figures; on another processor the last digits may
    differ."""
    found, before = measure(name).data(), stored()["effects"][name]
    assert found["taken_away_by"] == before["taken_away_by"]
    for key in ("part_arcsec", "left_without_arcsec", "left_with_arcsec"):
        assert found[key] == pytest.approx(before[key], rel=0.05, abs=0.003), key


def test_an_error_of_the_reference_judges_no_correction(tmp_path: Path) -> None:
    """An error of the reference is not counted as an error of the correction: with a polygon
    mounted 200″ eccentric, the right correction increases the raw error of the reference run."""
    made = simulate_set([Wanted("polygon_eccentricity", 200.0)], short(), 3)
    write_measurement_set(tmp_path / "set", made.measurement)
    model, path = tmp_path / "model.toml", tmp_path / "coefficients.toml"
    observations = observations_of(made.measurement)
    base = default_model()
    grown = replace(base, effects=[*base.effects, ModelEffect("polygon_eccentricity")])
    settled, _ = fitted(grown, observations, built_in())
    write_model(model, settled)
    words = ["export", str(tmp_path / "set"), "--model", str(model), "--coefficients", str(path)]
    result_file = tmp_path / "result.json"
    answer = CliRunner().invoke(main, [*words, "--json", str(result_file)])
    assert answer.exit_code == 0, answer.output
    assert "not evaluated: polygon_eccentricity" in answer.output
    written = read_coefficient_file(path)
    assert any("rises" in text for text in objections(made.measurement, written))
    rows = {
        row["effect"]: row for row in json.loads(result_file.read_text(encoding="utf-8"))["effects"]
    }
    assert rows["polygon_eccentricity"]["by"] == "reference"
    # The RMS of an order is 1/√2 of its amplitude.
    assert rows["polygon_eccentricity"]["part_arcsec"] == pytest.approx(200 / 2**0.5, rel=0.01)
    assert rows["graduation_harmonics"]["by"] == "lanes"
    assert rows["graduation_harmonics"]["left_arcsec"] < 0.05
