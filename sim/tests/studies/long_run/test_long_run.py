"""Tests of the study of a long run: the page against its data, the thermal model of a known table,
and a small run."""

from __future__ import annotations

import dataclasses
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from msgspec import structs
from sim.tests.instrument.sizes import LANES, SAMPLES

from arctrue.base.json_text import plain
from arctrue.report.charts.long_run_picture import plot_long_run
from arctrue.report.long_run_page import long_run_page
from arctrue.studies.long_run.experiment import run_long, shortened
from arctrue.studies.long_run.learned_model import as_coefficients, learn, telemetry_orders
from arctrue.studies.long_run.truth import Truth
from arctrue.studies.scenario import Scenario, read_scenario
from arctrue.table import DISC_RADIUS_M

ROOT = Path(__file__).resolve().parents[4]
DOCS = ROOT / "docs"
SCENARIO = ROOT / "sim" / "scenarios" / "long_run.toml"
COUNTS = 1 << 14
TURNS = 30
STRATEGIES = ("single", "model")


@pytest.fixture(scope="module")
def scenario() -> Scenario:
    """Return the shipped scenario, shortened to 32 lines and fewer turns, with the core that other
    tests build."""
    short = shortened(read_scenario(SCENARIO, lines=32), TURNS)
    scale = structs.replace(short.scale, lanes=LANES, samples=SAMPLES)
    errors = structs.replace(short.errors, noise_arcsec=4.0)
    return dataclasses.replace(short, scale=scale, errors=errors)


@pytest.fixture(scope="module")
def found(scenario: Scenario) -> dict[str, Any]:
    result: dict[str, Any] = plain(run_long(scenario, strategies=("held", "average", "model")))
    return result


def expected_single_arcsec(found: dict[str, Any], scenario: Scenario, per_k: float) -> float:
    """Return the expected RMS error of a turn that is corrected with the coefficients of the
    preceding turn.

    The error has three independent parts: the change of order 1 from turn to turn with the
    temperature; the stated uncertainties of the corrected orders; and the orders from 3 on, which
    may remain uncorrected because they are below the noise of a turn.
    """
    change_k = np.diff(found["temperature_c"])[1:]
    behind = per_k**2 * np.mean(change_k**2) / 2.0
    noise = sum(u**2 for u in found["allan"]["u_arcsec"].values())
    error = Truth(scenario).error_arcsec(1)
    amplitude = 2.0 * np.abs(np.fft.rfft(error)) / error.size
    left_out = np.sum(amplitude[3:] ** 2) / 2.0
    return float(np.sqrt(behind + noise + left_out))


@pytest.mark.large
def test_recalibration_and_model_follow_what_held_coefficients_do_not(
    found: dict[str, Any], scenario: Scenario
) -> None:
    """Recalibration and the thermal model correct the error of a disc whose centre moves by 2 µm/K;
    constant coefficients do not. The motion and the radius of the lines give the expected slope."""
    per_k = np.degrees(2e-6 / DISC_RADIUS_M) * 3600
    order, *_ = found["model"]["orders"]
    assert order["order"] == 1
    assert order["slope_arcsec_per_k"] == pytest.approx(per_k, abs=4 * order["u_arcsec_per_k"])
    held = found["strategies"]["held"]
    # Warming by up to 5.4 K changes order 1 by 7.6″/K; with constant coefficients this leaves 29″
    # RMS at the end.
    last = per_k * (25.4 - found["temperature_c"][0]) / np.sqrt(2)
    assert held["left_arcsec"][-1] == pytest.approx(last, rel=0.15)
    # The test compares medians: the temperature changes 33 times as fast as in the long run, so
    # that a turn may by chance correct the weak order 11 and then leaves 24″. In docs/long-run.md
    # this happens in 4 of 1,000 turns.
    typical = {name: np.median(found["strategies"][name]["left_arcsec"][2:]) for name in STRATEGIES}
    # The median of a sum of squares is smaller than the mean of this sum.
    expected = expected_single_arcsec(found, scenario, per_k)
    assert typical["single"] < expected < np.median(held["left_arcsec"][2:]) / 2.0
    assert typical["model"] < typical["single"] / np.sqrt(2)


@pytest.mark.large
def test_the_page_of_a_run_is_that_of_its_json(found: dict[str, Any]) -> None:
    page = long_run_page(found)
    assert page == long_run_page(json.loads(json.dumps(found)))
    assert "| order 1 by the temperature model, the others by a running average |" in page


@pytest.mark.large
def test_a_short_run_claims_nothing_of_noise_and_trends(found: dict[str, Any]) -> None:
    """The report of a short run claims nothing about noise and trends: the run has only 30 turns,
    and the temperature changes so fast that every difference of two turns contains its
    influence."""
    for deviation in found["allan"]["deviation_arcsec"].values():
        deviation[-1] = None
    page = long_run_page(found)
    assert "the stated uncertainty is right." not in page
    assert "The run is too short for a line" in page


@pytest.mark.large
def test_lost_counts_come_back(found: dict[str, Any]) -> None:
    """The lost counts come back: at the index the core moves its zero and, with ``heal``, adds the
    lost counts again."""
    ((turn, _),) = found["events"].items()
    count_arcsec = 1_296_000 / found["counts_per_rev"]
    for one in found["strategies"].values():
        assert set(one["refused"].values()) <= {"index_error"}
        (alarmed,) = (number for number, said in one["alarms"].items() if "zero_lost" in said)
        assert 0 <= int(alarmed) - int(turn) <= 2
        assert abs(one["mean_arcsec"][int(turn) - 1]) > 5 * count_arcsec
        assert abs(one["mean_arcsec"][int(turn) + 2]) < count_arcsec


def test_what_is_left_of_an_uncorrected_turn_is_its_error(scenario: Scenario) -> None:
    """An uncorrected turn has the error of the paper's table, [−150.0″, 137.9″] at 20 °C; at the
    end of the run, 5 K warmer, order 1 has grown."""
    truth = Truth(scenario)
    first, last = truth.error_arcsec(1), truth.error_arcsec(TURNS)
    assert (first.min(), first.max()) == pytest.approx((-150.0, 137.9), abs=12.0)
    grown = 2 * (np.fft.rfft(last)[1] - np.fft.rfft(first)[1]) / last.size
    assert abs(grown) == pytest.approx(7.6 * 5.3, rel=0.15)


def test_the_model_learns_heat_and_leaves_creep_to_the_turns() -> None:
    rng = np.random.default_rng(3)
    turns = np.arange(1, 401)
    celsius = 20 + 3 * np.sin(turns / 60)
    warm, crept = 1.0 - 2.0j, 0.02 + 0.01j
    values = np.zeros((400, 3), dtype=np.complex128)
    values[:, 0] = 40 + warm * (celsius - 21.0)
    values[:, 2] = 3 + crept * turns
    values += 0.5 * (rng.normal(size=values.shape) + 1j * rng.normal(size=values.shape))
    (learned,) = learn(turns, values, celsius, 21.0)
    assert learned.order == 1
    assert abs(learned.slope_arcsec_per_k - warm) < 4 * learned.u_slope_arcsec_per_k
    bank = as_coefficients([learned], 21.0, COUNTS, 4)
    count_arcsec = 1_296_000 / COUNTS
    for warmth in (-2.0, 0.0, 3.0):
        lane = bank.at(21.0 + warmth)
        said = lane.amplitudes_counts[0] * np.exp(-1j * lane.phases_rad[0]) * count_arcsec
        expected = learned.cold_arcsec + warmth * learned.slope_arcsec_per_k
        # Amplitudes are rounded to 2⁻¹¹ count, and slopes to 2⁻²⁰ count per kelvin.
        assert abs(said - expected) < 2 * count_arcsec / 2**11


def test_a_temperature_that_only_rises_evenly_teaches_nothing() -> None:
    turns = np.arange(1, 101)
    with pytest.raises(ValueError, match="are not separable"):
        learn(turns, np.ones((100, 1), dtype=np.complex128), 20 + 0.01 * turns, 20.0)


def test_a_turn_that_is_reported_twice_counts_once() -> None:
    once = {"turn": 4, "harmonics": [[1, 2.0, 0.5, 0.1, 1]]}
    refused = {"turn": 5}
    turns, values = telemetry_orders([once, once, refused])
    assert turns.tolist() == [4]
    assert values[0, 0] == pytest.approx(2.0 * np.exp(-0.5j))


def test_only_one_leg_is_a_long_run(scenario: Scenario) -> None:
    two = dataclasses.replace(scenario, legs=scenario.legs * 2)
    with pytest.raises(ValueError, match="one leg"):
        shortened(two, 40)


def test_page_and_data_agree(tmp_path: Path) -> None:
    stored = json.loads((DOCS / "data" / "long-run.json").read_text(encoding="utf-8"))
    page = (DOCS / "long-run.md").read_text(encoding="utf-8")
    assert page == long_run_page(stored), "arctrue long-run sim/scenarios/long_run.toml --page ..."
    assert stored["turns"] == 1000
    assert stored["counts_per_rev"] == COUNTS
    assert "<svg" in plot_long_run(stored, tmp_path).read_text(encoding="utf-8")
