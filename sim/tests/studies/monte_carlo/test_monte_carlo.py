"""Tests that the Monte Carlo study finds the true error, evaluates coverage correctly, and runs as
a campaign."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner
from sim.tests.studies.campaign.loaded import loaded_by

from arctrue.base.units import ARCSEC_PER_RAD
from arctrue.cli import main
from arctrue.gateware.coefficients import Coefficients
from arctrue.report.monte_carlo_page import monte_carlo_page, where_off
from arctrue.studies.campaign.code_state import import_closure
from arctrue.studies.monte_carlo import trial as trial_module
from arctrue.studies.monte_carlo.inputs import CASES, INPUTS, QUIET, drawn
from arctrue.studies.monte_carlo.plan import TrialPlan
from arctrue.studies.monte_carlo.score import Covered, scored
from arctrue.studies.monte_carlo.trial import (
    ORDERS,
    components,
    drawn_table,
    run_trial,
    true_error,
)
from arctrue.table import angle_of_reading


def task(case: str, seed: int = 3, **more: Any) -> dict[str, Any]:
    usual = {"turns": 1, "runs": 1, "samples": 1000, "method": "least_squares"}
    return {"case": case, "seed": seed, **usual, **more}


def test_state_of_a_result_holds_all_that_a_trial_loads(tmp_path: Path) -> None:
    sources = TrialPlan(1, 1).campaign(tmp_path).sources
    files = set(import_closure(sources.modules))
    assert loaded_by(*sources.modules) <= files
    assert not any("workbench" in file.parts for file in files)


def test_truth_is_the_error_at_even_readings() -> None:
    # The expected values are computed independently: bisection in the geometry finds the angle at
    # which each reading appears.
    table = drawn_table(5, {**QUIET, **INPUTS["radial_motion"].draw(np.random.default_rng(1))})
    readings = np.arange(256) * (table.counts_per_rev / 256)
    angle = angle_of_reading(table, 0, readings)
    error = (readings * table.count_rad - angle) * ARCSEC_PER_RAD
    spectrum = np.fft.rfft(error)[1 : ORDERS + 1] / 128
    expected = np.concatenate([spectrum.real, -spectrum.imag])
    np.testing.assert_allclose(components(*true_error(table, 20.0)), expected, atol=1e-6)


def test_an_input_is_drawn_equally_in_every_case() -> None:
    alone = {name: drawn(7, name) for name in CASES if name != "all"}
    together = drawn(7, "all")
    assert drawn(7, "quantisation") == dict(QUIET)
    for name in INPUTS:
        own = INPUTS[name].draw(np.random.default_rng(0))
        assert {key: alone[name][key] for key in own} == {key: together[key] for key in own}
        assert any(alone[name][key] != QUIET[key] for key in own) or name == "lanes"


def test_white_noise_alone_is_covered_and_what_is_not_stated_is_not() -> None:
    trials = [run_trial(task("noise", seed)) for seed in range(25)]
    # χ² of two components has the mean 2, and the mean of 25·32 values scatters by 2/√800 = 0.07.
    # Because 96 lines of the spectrum determine the noise at each order, the mean rises by 1/95.
    assert np.mean([item["square"] for item in trials]) == pytest.approx(2.0, abs=0.5)
    moved = [run_trial(task("radial_motion", seed))["square"] for seed in range(25)]
    # 0.03 µm at a radius of 54 mm are 0.1″, about the noise of an order; the calibration does not
    # state this uncertainty.
    assert np.mean(np.array(moved)[:, 1:8]) > 4.0


def test_what_is_left_after_the_gateware_is_its_rounding() -> None:
    table = drawn_table(5, QUIET)
    reading, error = true_error(table, 20.0)
    cosine, sine = np.split(components(reading, error), 2)
    counts = np.hypot(cosine, sine) / (table.count_rad * ARCSEC_PER_RAD)
    orders = np.arange(1, ORDERS + 1)
    coefficients = Coefficients.from_harmonics(
        orders, counts, np.arctan2(-sine, cosine), table.counts_per_rev, ORDERS
    )
    left = trial_module._left_after_gateware(coefficients, reading, error, np.linspace(0, 6, 500))
    # The output is rounded by up to half a count. The bound has an additional twentieth of a count,
    # 0.004″. It covers the mean of 2,048 roundings (3σ: 0.0015″), the straight pieces of the truth
    # (0.0005″), the rounding of the coefficients and the CORDIC.
    assert np.abs(left).max() < 0.55 * table.count_rad * ARCSEC_PER_RAD
    without = trial_module._left_after_gateware(
        Coefficients.zero(table.counts_per_rev), reading, error, np.linspace(0, 6, 500)
    )
    assert np.abs(without).max() > 50.0


def test_stated_separation_is_that_of_its_distribution() -> None:
    found = run_trial(task("separation"))
    values = drawn(3, "separation")
    off, u = found["alpha"]
    # R₂ − R₁ contains the mounting error and, with the factor 1, the error of the place where head
    # 2 detects the index. R₂ − R₁ shows both errors to one count.
    assert off == pytest.approx(-values["detection_arcsec"], abs=0.3)
    assert u == pytest.approx(50 / np.sqrt(3), rel=1e-4)
    assert run_trial(task("noise"))["alpha"] is None


@pytest.mark.parametrize(
    ("hits", "verdict"), [(950, ""), (940, ""), (900, "too small"), (995, "too large")]
)
def test_coverage_is_judged_by_its_chance(hits: int, verdict: str) -> None:
    # The number of hits in 1000 trials at 95 % has a standard deviation of 6.9. If any of 35
    # figures may fail by chance with a probability of 1 %, each may deviate by 3.6 standard
    # deviations.
    assert Covered(hits, 1000, 35).verdict == verdict


def made_up(case: str, square: float, off: float) -> tuple[dict[str, Any], dict[str, Any]]:
    result = {
        "square": [square] * ORDERS,
        "deviation_arcsec2": [off**2] * ORDERS,
        "variance_arcsec2": [1.0] * ORDERS,
        "turn_arcsec": [off] * 36,
        "corrected_arcsec": [0.0] * 36,
        "u_turn_arcsec": [1.0] * 36,
        "alpha": [off, 1.0],
    }
    return {"case": case}, result


def test_the_page_says_where_it_is_off_and_where_nothing_is() -> None:
    good = [made_up("all", 9.0 if n < 10 else 1.0, 3.0 if n < 10 else 0.1) for n in range(200)]
    assert where_off(scored(good))[0].count("order") == 0
    bad = [made_up("noise", 9.0, 3.0) for _ in range(60)]
    found = scored([*good, *bad])
    assert found["noise"]["orders"][4]["stated_uncertainty"] == "too small"
    assert found["noise"]["turn"]["stated_uncertainty"] == "too small"
    summary = "\n".join(where_off(found))
    assert "noise: too small at orders 1 (0 %), 2 (0 %)" in summary
    header = {
        "plan": {"trials": 200, "seed": 1, "runs": 2, "turns": 1, "samples": 10, "method": "x"},
        "code": {"arctrue": "a", "numpy": "2"},
    }
    text = monte_carlo_page(header, found)
    assert summary in text
    assert "**0.0 (3e+03; 1e+03)**" in text


def test_a_refused_capture_is_counted() -> None:
    found = scored([({"case": "all"}, {"refused": "jump"}), made_up("all", 1.0, 0.0)])
    assert found["all"]["refused"] == {"jump": 1}
    assert found["all"]["orders"][0]["trials"] == 1
    only = scored([({"case": "all"}, {"refused": "jump"})])
    assert only["all"] == {"trials": 1, "refused": {"jump": 1}}


@pytest.mark.large
def test_command_shards_resumes_and_writes_the_page(tmp_path: Path) -> None:
    folder, text = tmp_path / "mc", tmp_path / "page.md"
    usual = ["monte-carlo", str(folder), "--trials=2", "--samples=400", "--runs=1", "--workers=1"]
    first = CliRunner().invoke(main, [*usual, "--shard=1/2"])
    assert first.exit_code == 0, first.output
    assert "8 of 16 trials are done" in first.output
    whole = CliRunner().invoke(main, [*usual, f"--page={text}", f"--json={tmp_path / 'a.json'}"])
    assert whole.exit_code == 0, whole.output
    assert "2 trials of each case, seed 1; 1 run of 1 turn" in text.read_text(encoding="utf-8")
    data = json.loads((tmp_path / "a.json").read_text(encoding="utf-8"))
    assert set(data) == set(CASES)
    lines = [*folder.glob("results*.jsonl")]
    assert sum(len(file.read_text().splitlines()) for file in lines) == 16
    other = CliRunner().invoke(main, [*usual, "--seed=2"])
    assert other.exit_code == 2
    assert "two states are not mixed" in other.output


def test_every_trial_has_a_seed_of_its_own() -> None:
    tasks = TrialPlan(50, 1).tasks()
    assert len({item["seed"] for item in tasks}) == 50
    assert len(tasks) == 50 * len(CASES)


def test_the_study_is_not_called_a_propagation_of_distributions() -> None:
    """The page does not call the study a propagation of distributions: JCGM 101 propagates the
    estimates of one measurement, and in this study every trial has another table."""
    root = Path(__file__).resolve().parents[4]
    texts = {name: (root / name).read_text(encoding="utf-8") for name in (
        "docs/monte-carlo.md", "docs/architecture.md", "docs/commands.md", "README.md",
    )}  # fmt: skip
    assert "coverage study over random tables" in texts["docs/monte-carlo.md"]
    assert "not the propagation of distributions" in texts["docs/monte-carlo.md"]
    for name, text in texts.items():
        assert not re.search(r"propagat\w+ distributions|by GUM supplement 1", text), name
