"""Tests of the error sources against their equations, and of the covariance against simulated
calibrations."""

from __future__ import annotations

import json
import math
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner
from scipy import stats

from arctrue.base.units import ARCSEC_PER_RAD, RAD_PER_ARCSEC, arcsec_per_count
from arctrue.calibration.capture_check import WholeTurns
from arctrue.calibration.least_squares import least_squares
from arctrue.calibration.transfer_function import noise_gain
from arctrue.cli import main
from arctrue.metrology.budget import Contribution
from arctrue.report.charts.error_budget_picture import plot_error_budget
from arctrue.report.error_budget_page import error_budget_page
from arctrue.studies.error_budget import chain
from arctrue.studies.error_budget.chain import (
    HEAD_SEPARATION_RAD,
    NOISE_ARCSEC,
    ORDERS,
    SAMPLES,
    Method,
    Source,
    run_chain,
)
from arctrue.studies.error_budget.drawn import drawn_calibrations
from arctrue.studies.error_budget.experiment import closure_budget
from arctrue.studies.error_budget.sources import SOURCES
from arctrue.studies.methods.polygon_closure import Closure, closure, spread_shifts
from arctrue.studies.monte_carlo.inputs import CASES
from arctrue.studies.monte_carlo.plan import TrialPlan
from arctrue.table import DiscEccentricity, RotaryTable, TableState, two_heads

ROOT = Path(__file__).resolve().parents[4]
STORED = ROOT / "docs" / "data" / "calibration-budget.json"
FOUND = json.loads(STORED.read_text(encoding="utf-8"))
COUNTS = 1 << 24


def rms(source: Source | None, method: Method = "least_squares", draw: int = 1) -> float:
    sources = () if source is None else (source,)
    return run_chain(sources, method, np.random.default_rng(draw)).rms_arcsec


def test_without_a_source_nothing_is_left() -> None:
    assert rms(None) < 1e-4
    assert rms(None, "paper") < 1e-4


def test_the_approximation_leaves_half_the_square_of_the_eccentricity() -> None:
    """The neglected term (a²/2) sin 2θ is 0.036″ RMS with the eccentricity a = 144″; the other
    orders add a tenth of this."""
    amplitude = 144.1
    expected = amplitude**2 / 2.0 / ARCSEC_PER_RAD / math.sqrt(2.0)
    assert rms("approximation", "paper") == pytest.approx(expected, rel=0.1)
    assert rms("approximation") < 1e-4


def test_uneven_steps_hurt_the_dft_alone() -> None:
    """Uneven steps disturb only the DFT: their ripple of order 7 moves a part of order 1 (144″)
    into orders 6 and 8, which TF(n) magnifies."""
    assert 0.05 < rms("uneven", "paper") < 0.15
    assert rms("uneven") < 1e-4


def test_two_roundings_of_a_count() -> None:
    """Reading and output are each rounded to a count, with the RMS 1/√12 count: 0.0315″
    together."""
    expected = arcsec_per_count(COUNTS) * math.sqrt(2.0 / 12.0)
    assert rms("quantisation") == pytest.approx(expected, rel=0.05)


def test_the_latency_is_the_angle_travelled() -> None:
    """The latency of 400 ns from pin to pin (docs/paper.md) causes 0.0432″ at 30°/s."""
    paper = json.loads((ROOT / "docs" / "data" / "paper.json").read_text(encoding="utf-8"))
    (table_1,) = (one["values"] for one in paper["items"] if one["label"] == "Table 1")
    assert table_1["pin_to_pin_ns"] == 400.0
    travelled = table_1["pin_to_pin_ns"] * 1e-9 * 30.0 * 3600.0
    assert rms("latency") == pytest.approx(travelled, rel=1e-2)
    (row,) = (one for one in SOURCES if one.source == "latency")
    assert row.size.startswith("400 ns")


def test_the_place_of_the_index_is_drawn_as_it_is_printed(monkeypatch: pytest.MonkeyPatch) -> None:
    """The place of the index has a rectangular distribution within ± 50″; a normal distribution
    with the same σ would have 8 % outside."""
    monkeypatch.setattr(chain, "SAMPLES", 60)
    monkeypatch.setattr(chain, "SCORED_ANGLES", 1)
    off = [
        run_chain(("alpha",), "paper", np.random.default_rng(draw)).estimate.head_separation_rad
        - HEAD_SEPARATION_RAD
        for draw in range(200)
    ]
    arcsec = np.array(off) * ARCSEC_PER_RAD
    assert np.abs(arcsec).max() <= 50.0 + 0.1
    assert stats.kstest(arcsec, stats.uniform(-50.0, 100.0).cdf).pvalue > 1e-3
    (row,) = (one for one in SOURCES if one.source == "alpha")
    assert "± 50″, rectangular" in row.size


def test_heat_is_the_centre_that_moved() -> None:
    """The centre moves by 0.9 µm/K · 2 K/h · 12 s during a turn. Divided by the radius of 53.975
    mm, this is the amplitude of order 1."""
    moved = 0.9e-6 * 2.0 / 3600.0 * 12.0
    expected = moved / 53.975e-3 * ARCSEC_PER_RAD / math.sqrt(2.0)
    assert rms("heat") == pytest.approx(expected, rel=1e-2)


def test_subdivision_is_that_of_its_harmonics() -> None:
    """The subdivision error equals that of its harmonics: per signal period, an offset p causes an
    error of p once, and gain and phase errors p cause p/2 twice, in radians of the period."""
    radian = 1_296_000 / (2.0 * math.pi * 16384)
    once, twice = 0.01 * math.sqrt(2.0), 0.005 * math.sqrt(2.0)
    expected = radian * math.hypot(once, twice) / math.sqrt(2.0)
    assert rms("subdivision") == pytest.approx(expected, rel=0.02)


def test_noise_is_that_of_the_transfer_function() -> None:
    """The simulated noise equals the noise that the transfer function predicts. The mean comes from
    8 draws; the bound is 4 standard deviations of the mean square, nearly all of which comes from
    order 11."""
    gain = noise_gain(ORDERS, HEAD_SEPARATION_RAD)
    expected = NOISE_ARCSEC**2 * 4.0 / SAMPLES * np.sum(gain**2)
    found = [rms("noise", draw=draw) ** 2 for draw in range(8)]
    scatter = np.sqrt(2.0 * np.sum(gain**4) / 2.0) / np.sum(gain**2) * expected
    assert np.mean(found) == pytest.approx(expected, abs=4.0 * scatter / math.sqrt(8.0))


def test_the_page_s_noise_is_the_expected_one_within_its_stated_spread() -> None:
    """The page's noise equals the expected noise, which the test computes without TF(n), from the
    covariance of a fit with the columns of both heads."""
    angle = np.arange(SAMPLES) * (2.0 * np.pi / SAMPLES)
    there = angle + HEAD_SEPARATION_RAD
    columns = np.hstack(
        [
            wave(np.multiply.outer(there, ORDERS)) - wave(np.multiply.outer(angle, ORDERS))
            for wave in (np.cos, np.sin)
        ]
    )
    components = 2.0 * NOISE_ARCSEC**2 * np.linalg.inv(columns.T @ columns)
    expected = math.sqrt(0.5 * np.trace(components))
    for one in FOUND["methods"].values():
        (noise,) = (row for row in one["sources"] if row["source"] == "noise")
        assert noise["expected_arcsec"] == pytest.approx(expected, rel=1e-3)
        assert noise["rms_arcsec"] == pytest.approx(expected, abs=3.0 * noise["u_rms_arcsec"])
        # A mean square with about two degrees of freedom has the relative spread 1, which is 0.5 in
        # the RMS; the bound allows half as much in addition.
        assert noise["u_rms_arcsec"] < 0.75 * expected / math.sqrt(FOUND["draws"])
    assert f"{expected:.4f}″" in (ROOT / "docs" / "calibration-budget.md").read_text("utf-8")


def test_the_page_calls_the_covariance_s_uncertainty_partial() -> None:
    """The page calls only the second value an expanded uncertainty U (k = 2); that value comes from
    the calibrations with all sources."""
    section = error_budget_page(FOUND).split("## At every angle")[1].split("\n## ")[0]
    of_covariance, of_all_sources = section.split("Only this second value")
    assert "*partial* uncertainty" in of_covariance
    assert "expanded" not in of_covariance
    assert "U (k = 2)" not in of_covariance
    assert "an expanded uncertainty U (k = 2) of the corrected angle" in of_all_sources


def test_the_covariance_at_every_angle_covers_drawn_calibrations() -> None:
    """The ratio of the scatter to the stated u is 1 within 5 of its standard deviations, for 150
    draws of noise and index."""
    table = RotaryTable(
        two_heads(), (DiscEccentricity(30e-6, 1.0),), noise_rad=0.5 * RAD_PER_ARCSEC
    )
    samples, orders, detection = 600, np.arange(1, 5), 20.0
    state = TableState.at_rest(np.arange(samples) * (2.0 * np.pi / samples))
    angle = np.radians(np.arange(0.0, 360.0, 30.0))
    random = np.random.default_rng(7)
    curves, stated = [], []
    for _ in range(150):
        counts = [table.counts(head, state, random) for head in (0, 1)]
        off = round(random.normal(0.0, detection) / arcsec_per_count(COUNTS))
        turn = WholeTurns(0, 1, counts[0], counts[1] + off, COUNTS / samples)
        estimate, _ = least_squares(
            [turn], COUNTS, HEAD_SEPARATION_RAD, orders, "measured",
            index_detection_arcsec=detection,
        )  # fmt: skip
        curves.append(estimate.error_arcsec(angle))
        stated.append(estimate.u_error_arcsec(angle))
    ratio = np.std(curves, axis=0, ddof=1) / np.sqrt(np.mean(np.square(stated), axis=0))
    np.testing.assert_allclose(ratio, 1.0, atol=5.0 / math.sqrt(2.0 * 149))
    # Only applied orders contribute; without any order the uncertainty is 0.
    assert estimate.u_error_arcsec(angle, np.zeros(4, dtype=bool)).max() == 0.0


def test_the_sources_add_up_to_the_whole() -> None:
    """The sources are independent: the sum of their variances equals the variance of the whole
    within 4 standard errors, plus 5 % for their interaction."""
    for one in FOUND["methods"].values():
        whole = one["whole"]
        assert one["sum_arcsec"] == pytest.approx(
            whole["rms_arcsec"], abs=4.0 * whole["u_rms_arcsec"] + 0.05 * whole["rms_arcsec"]
        )
        squares = sum(row["rms_arcsec"] ** 2 for row in one["sources"])
        assert one["sum_arcsec"] == pytest.approx(math.sqrt(squares))


def test_the_polygon_shows_the_axis_and_agrees_without_it() -> None:
    still, moves = (FOUND["experiment"]["compared"][name]["e_n"] for name in
                    ("axis at rest", "axis moves"))  # fmt: skip
    # The probability that more than 4 of 24 values exceed the limit, each with 4.55 %, is 0.4 %.
    assert sum(abs(value) > 1.0 for value in still) <= 4
    assert max(map(abs, moves)) > 2.0


def test_closing_the_circle_adds_no_scatter_to_the_closure() -> None:
    """The u of the table equals the u that the test propagates from each reading through the
    least-squares solution."""
    cycles, faces = 4, 6
    face = (np.arange(faces) - np.array(spread_shifts(cycles, faces))[:, None]) % faces
    errors = np.random.default_rng(3).normal(0.0, 1.0, (cycles, faces))
    found = closure(errors, face)
    through = np.stack(
        [
            closure(unit.reshape(cycles, faces), face).table_arcsec
            for unit in np.eye(cycles * faces)
        ],
        axis=1,
    )
    np.testing.assert_allclose(through @ errors.ravel(), found.table_arcsec, atol=1e-12)
    assert np.abs(through.sum(axis=0)).max() < 1e-12
    expected = found.scatter_arcsec * np.linalg.norm(through, axis=1)
    np.testing.assert_allclose(found.u_table_arcsec, expected, rtol=1e-9)
    # The degrees of freedom are the number of readings minus the number of fitted values. The fit
    # has the errors of the faces and of the table, each without their mean, and one offset for each
    # cycle.
    assert found.degrees_of_freedom == cycles * faces - 2 * (faces - 1) - cycles


def test_closure_budget_is_the_root_of_its_lines() -> None:
    closed = Closure(np.zeros(24), np.zeros(24), np.full(24, 0.03), 0.09, 100)
    budget = closure_budget(closed, COUNTS)
    first = budget.contributions[0]
    assert isinstance(first, Contribution)
    assert first.u_arcsec == pytest.approx(0.03)
    half = arcsec_per_count(COUNTS) / 2.0 / math.sqrt(3.0)
    assert budget.u_arcsec == pytest.approx(math.sqrt(0.03**2 + 0.05**2 + half**2), rel=1e-4)


def test_page_and_json_agree(tmp_path: Path) -> None:
    page = (ROOT / "docs" / "calibration-budget.md").read_text(encoding="utf-8")
    assert page == error_budget_page(FOUND), "arctrue error-sources --page ..."
    assert plot_error_budget(FOUND, tmp_path).stat().st_size > 10_000


def test_drawn_calibrations_hold_where_the_covariance_knows_the_input() -> None:
    """The stated noise is right within 4/√(2·100·n) for 100 trials, where n orders contribute. The
    test assumes n = 1, the smallest number."""
    cases = {one["case"]: one for one in FOUND["monte_carlo"]["cases"]}
    for name in ("noise", "ripple", "lanes"):
        one = cases[name]
        assert one["stated_uncertainty"] == "holds"
        off_by = one["deviation_arcsec"] / one["stated_arcsec"] - 1.0
        assert abs(off_by) < 4.0 / math.sqrt(2.0 * one["trials"])
    for name in ("radial_motion", "temperature"):
        assert cases[name]["stated_uncertainty"] == "too small"


def test_monte_carlo_s_folder_is_read_and_an_empty_one_refused(tmp_path: Path) -> None:
    folder = tmp_path / "mc"
    TrialPlan(1, 1, runs=1, samples=200).campaign(folder).run(workers=1)
    found = drawn_calibrations(folder)
    assert found["plan"]["samples"] == 200
    assert [one["case"] for one in found["cases"]] == list(CASES)
    assert all(one["trials"] == 1 for one in found["cases"])
    empty = tmp_path / "empty"
    empty.mkdir()
    answer = CliRunner().invoke(
        main,
        ["error-sources", "--from", str(STORED), "--monte-carlo", str(empty)],
    )
    assert answer.exit_code == 2, answer.output


def test_from_wants_its_own_json(tmp_path: Path) -> None:
    other = tmp_path / "other.json"
    other.write_text("[1]", encoding="utf-8")
    answer = CliRunner().invoke(main, ["error-sources", "--from", str(other)])
    assert answer.exit_code == 2
    assert "expected a file that `arctrue error-sources --json` wrote" in answer.output
