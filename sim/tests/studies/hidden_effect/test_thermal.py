"""Tests of two thermal effects: one is in the workbench's catalogue, the other is not."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from sim.tests.studies.hidden_effect.small import run_small

from arctrue.instrument import InstrumentError
from arctrue.studies.hidden_effect.cases import FRESH_C
from arctrue.studies.hidden_effect.follow import follow_warming
from arctrue.studies.hidden_effect.result import HiddenResult
from arctrue.table import DISC_RADIUS_M

COARSER = 64
"""Factor by which the hidden effect is enlarged: 2²⁴ counts per turn divided by 2¹⁸."""
HEATED_K = FRESH_C - 20.0
COUNT_ARCSEC = 1_296_000 / (1 << 18)
FOLLOWED_ARCSEC = 6.0
"""Largest permitted amplitude of order 1 in the output while the table warms; a count is 4.9″."""


@pytest.fixture(scope="module")
def centre(tmp_path_factory: pytest.TempPathFactory) -> HiddenResult:
    return run_small("thermal_eccentricity", tmp_path_factory.mktemp("centre"))


@pytest.fixture(scope="module")
def lobes(tmp_path_factory: pytest.TempPathFactory) -> HiddenResult:
    return run_small("warm_ovality", tmp_path_factory.mktemp("lobes"))


@pytest.mark.large
def test_thermal_eccentricity_is_named_with_its_rate(centre: HiddenResult) -> None:
    assert centre.diagnosed.effect == "thermal_eccentricity"
    rate = centre.diagnosed.model.effects[-1].parameters["amplitude"]
    # The amplitude of the error is the centre's shift divided by the disc's radius.
    geometry = np.rad2deg(COARSER * 0.4e-6 / DISC_RADIUS_M) * 3600
    assert rate.value == pytest.approx(geometry, abs=4 * rate.sigma + 0.005 * geometry)


@pytest.mark.large
def test_thermal_eccentricity_is_corrected_at_a_temperature_never_measured(
    centre: HiddenResult,
) -> None:
    geometry = np.rad2deg(COARSER * 0.4e-6 / DISC_RADIUS_M) * 3600 * HEATED_K
    # The paper's coefficients were fitted to the cold turn.
    assert centre.paper.amplitude_arcsec[0] == pytest.approx(geometry, rel=0.02)
    assert centre.corrected.amplitude_arcsec[0] < 0.5 * COUNT_ARCSEC
    follows = centre.diagnosed.export(4, None).coefficients
    assert follows.thermal is not None
    assert 1 in follows.thermal.orders
    at_once = centre.diagnosed.export(4, FRESH_C).coefficients
    readings = np.arange(0, 1 << 18, 997)
    worked_out = follows.at(FRESH_C).error_counts(readings)
    assert np.abs(worked_out - at_once.error_counts(readings)).max() < 0.1


@pytest.mark.parametrize("made", ["centre", pytest.param("lobes", marks=pytest.mark.large)])
def test_the_model_tells_a_capture_at_a_temperature_never_measured(
    made: str, request: pytest.FixtureRequest
) -> None:
    result: HiddenResult = request.getfixturevalue(made)
    left = result.fresh_capture_arcsec
    # The difference of two readings in whole counts has this RMS; the scatter of the coefficients
    # adds less than a tenth.
    whole_counts = COUNT_ARCSEC * np.sqrt(2.0 / 12.0)
    assert left["with"] < 1.1 * whole_counts
    assert left["without"] > 1.5 * left["with"]


@pytest.mark.large
def test_thermal_eccentricity_is_followed_while_the_table_warms(centre: HiddenResult) -> None:
    ways = follow_warming(centre, 3)
    held, every, by_host, alone = (
        np.array([turn.order1_arcsec for turn in ways[way]])
        for way in ("held", "every turn", "by temperature", "by the firmware")
    )
    heated = np.array([turn.temperature_c for turn in ways["held"]])
    rate = np.rad2deg(COARSER * 0.4e-6 / DISC_RADIUS_M) * 3600
    # With constant coefficients the error grows with the temperature after the first turn.
    np.testing.assert_allclose(np.diff(held), rate * np.diff(heated), rtol=0.1)
    # With a calibration after every turn the coefficients lag the warming by about a turn and a
    # half; the lag does not grow.
    turn_arcsec = rate * float(np.diff(heated).mean())
    assert np.all(every < 2.5 * turn_arcsec)
    assert every[-1] < 0.6 * held[-1]
    # With coefficients for the present temperature, only the change within a turn remains, and this
    # change does not grow.
    assert np.all(by_host < 0.15 * turn_arcsec + COUNT_ARCSEC)
    # If the firmware itself follows its thermometer, the core also corrects the change within a
    # turn.
    assert held.max() > 100.0
    assert np.all(alone < FOLLOWED_ARCSEC)


@pytest.mark.large
def test_a_thermometer_that_lags_is_followed_if_its_lag_is_stated(
    centre: HiddenResult,
) -> None:
    """The thermometer lags by 60 s, which is five turns. The correction follows the temperature if
    the file states this lag; if it does not, the captured turn contradicts the thermal model."""
    ways = ["by the firmware"]
    with pytest.raises(InstrumentError, match="worse_prediction"):
        follow_warming(centre, 3, ways=ways, sensor_lag_s=60.0, stated_lag_s=0.0)
    (turns,) = follow_warming(centre, 3, ways=ways, sensor_lag_s=60.0).values()
    left = np.array([turn.order1_arcsec for turn in turns])
    print("lagging, order 1:", left)
    assert np.all(left < FOLLOWED_ARCSEC), left


def test_an_effect_of_no_catalogue_becomes_an_effect_file(lobes: HiddenResult) -> None:
    diagnosis = lobes.diagnosed.diagnosis
    assert diagnosis.verdict == "unknown"
    assert set(lobes.diagnosed.data()["parts"]) == {"temperature", "order:2", "disc"}
    assert lobes.diagnosed.effect_file is not None
    assert "wave_orders = (2" in lobes.diagnosed.effect_file.read_text()
    size = lobes.diagnosed.model.effects[-1].parameters["amplitude"]
    assert size.value == pytest.approx(0.4 * COARSER, abs=4 * size.sigma + 0.02 * 0.4 * COARSER)


def test_what_of_it_lanes_can_correct(lobes: HiddenResult) -> None:
    # The firmware's coefficients contain order 2 of the cold turn, but not the thermal change of
    # order 2.
    assert lobes.paper.amplitude_arcsec[1] == pytest.approx(0.4 * COARSER * HEATED_K, rel=0.02)
    assert lobes.corrected.amplitude_arcsec[1] < 0.5 * COUNT_ARCSEC
    assert lobes.corrected.edges_rms_arcsec < 0.1 * lobes.paper.edges_rms_arcsec
    thermal = lobes.diagnosed.export(4, None).coefficients.thermal
    assert thermal is not None
    assert 2 in thermal.orders


def test_command(tmp_path: Path) -> None:
    from click.testing import CliRunner

    from arctrue.cli import main

    answer = CliRunner().invoke(main, ["hidden", "hysteresis", "--follow"])
    assert answer.exit_code == 2
    assert "thermal_eccentricity" in answer.output
