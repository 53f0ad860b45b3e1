"""Tests of the uncertainty budget against the example of the GUM, and of the size of each
contribution."""

from __future__ import annotations

import json
import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner, Result
from sim.tests.workbench.small_sets import REFERENCE_NOISE, measurement_set, paper_error

from arctrue.calibration.calibration import CalibrationSettings, calibrate
from arctrue.cli import main
from arctrue.measurement import MeasurementSet, Reference, Table, write_measurement_set
from arctrue.metrology.budget import (
    REVERSAL,
    Budget,
    Contribution,
    reference_budget,
    separation_slope,
    two_heads_budget,
)
from arctrue.metrology.correction import Correction
from arctrue.report.document import COLUMNS, LINES, Rows, table_lines, text_page


def _run(*words: object) -> Result:
    return CliRunner().invoke(main, ["budget", *(str(word) for word in words)])


def test_the_end_gauge_of_the_gum() -> None:
    """The example of the end gauge in JCGM 100:2008, H.1 (see table H.1) has u = 32 nm and 16
    effective degrees of freedom (17 before rounding); the budget gives the same."""
    lines = [(25.0, 18), (9.7, 25.6), (2.9, 50), (16.6, 2)]
    made = Budget(
        "",
        tuple(Contribution("", "", "", "normal", u, 1.0, nu) for u, nu in lines),
        (), (), (),
    )  # fmt: skip
    assert made.u_arcsec == pytest.approx(32.0, abs=0.5)
    assert 16.0 <= made.degrees_of_freedom < 18.0
    # A rectangular half-width is divided by √3.
    assert Contribution("", "", "B", "rectangular", 1.0, 2.0).u_arcsec == pytest.approx(1.1547)


def test_the_sensitivity_to_the_head_separation() -> None:
    """A second calibration with an α larger by 30″ changes the correction by 30 times the slope,
    which is the stated change per arcsecond of α."""
    made = measurement_set(runs=2, turns=2, reference=False)
    settings = CalibrationSettings(separation="nominal")
    first = calibrate(made, settings)
    moved = replace(made.table, head_separation_deg=33.0 + 30.0 / 3600.0)
    second = calibrate(replace(made, table=moved), settings)
    applied = np.array([verdict.applied for verdict in first.verdicts])
    kept = np.tile(applied, 2)
    change = (second.estimate.values - first.estimate.values)[kept]
    rms = math.sqrt(0.5 * float(np.sum(change**2)))
    # The difference and the slope disagree by a third of a percent, because the step of α is finite
    # and the error is a function of the reading.
    assert separation_slope(first) * 30.0 == pytest.approx(rms, rel=0.01)


def test_two_heads_against_the_disc(tmp_path: Path) -> None:
    """The remaining error of the disc after the correction is within U; the budget has the
    contributions that the set states."""
    made = measurement_set(runs=2, turns=2)
    made = replace(made, table=replace(made.table, index_detection_arcsec=2.0))
    calibration = calibrate(made)
    budget = two_heads_budget(made, calibration)
    by_name = {one.quantity: one for one in budget.contributions}
    place = by_name["index mark, place of detection between the heads"]
    assert (place.size_arcsec, place.distribution) == (2.0, "normal")
    assert by_name["reading of head 1, resolution"].u_arcsec == pytest.approx(
        1_296_000 / 2**24 / math.sqrt(12.0)
    )
    disc = np.arange(3600) * (2.0 * np.pi / 3600)
    error = paper_error(disc, np.full(3600, 20.0), 0.0)
    reading = disc + error * np.pi / 648_000.0
    applied = np.array([verdict.applied for verdict in calibration.verdicts])
    values = np.where(np.tile(applied, 2), calibration.estimate.values, 0.0)
    orders = calibration.estimate.orders
    cosine, sine = np.split(values, 2)
    phase = np.multiply.outer(reading, orders)
    left = error - np.cos(phase) @ cosine - np.sin(phase) @ sine
    assert float(np.std(left)) < budget.expanded_arcsec
    assert budget.expanded_arcsec < 0.3, "U is not so large that it hides the error"
    assert "the budget holds" in budget.checks[0]
    # The next two sets have 2″ of reversal error, or 2″ of order 40, which the calibration does not
    # fit.
    turned = measurement_set(runs=2, turns=2, reversal_arcsec=2.0)
    found = two_heads_budget(turned, calibrate(turned))
    half = {one.quantity: one.u_arcsec for one in found.contributions}[REVERSAL]
    assert half == pytest.approx(1.0, abs=0.05)
    assert "the budget holds" in found.checks[0]
    assert made.reference is not None
    wave = made.reference.error_arcsec + 2.0 * np.cos(
        40 * np.radians(made.reference.target_deg) + 0.3
    )
    other = replace(made, reference=replace(made.reference, error_arcsec=wave))
    assert "lacks a contribution" in two_heads_budget(other, calibrate(other)).checks[0]


def test_the_rule_of_a_table_follows_all_lines_of_its_heading() -> None:
    heading = " ".join(["word"] * 30)
    lines = table_lines(Rows("", (heading, "u"), [("name", "1.00")]))
    assert " ".join(line.removesuffix("u").strip() for line in lines[:-2]) == heading
    assert lines[-2] == "-" * COLUMNS
    assert lines[-1].split() == ["name", "1.00"]


def test_a_page_of_the_pdf_holds_its_lines() -> None:
    page = text_page(["x" * COLUMNS] * LINES)
    extent = page.texts[0].get_window_extent()
    assert extent.x1 < page.bbox.x1 * 0.97
    assert extent.y0 > page.bbox.y0


def _reference_alone(**changes: object) -> MeasurementSet:
    made = measurement_set(cycles=6, runs=1, turns=1, **changes)  # type: ignore[arg-type]
    assert made.reference is not None
    stated = replace(made.reference, standard_uncertainty_arcsec=0.12, instrument="polygon")
    return replace(made, capture=None, reference=stated)


def test_a_reference_alone(tmp_path: Path) -> None:
    write_measurement_set(tmp_path / "set", _reference_alone(reversal_arcsec=2.0))
    done = _run(tmp_path / "set", "--json", tmp_path / "b.json", "--out", tmp_path / "out")
    assert done.exit_code == 0, done.output
    data = json.loads((tmp_path / "b.json").read_text())
    lines = {one["quantity"]: one for one in data["contributions"]}
    repeat = lines["repeatability, through the fit"]
    # The set has 48 combinations of station and direction with six visits each. The tolerance is
    # five standard errors of a standard deviation.
    assert repeat["degrees_of_freedom"] == 240
    assert repeat["size_arcsec"] == pytest.approx(REFERENCE_NOISE, rel=5 / math.sqrt(2 * 240))
    # At even stations every row has the mean leverage: nine coefficients divided by 288 rows.
    assert repeat["sensitivity"] == pytest.approx(math.sqrt(9 / 288), rel=1e-3)
    assert lines["reversal error, half of it"]["u_arcsec"] == pytest.approx(1.0, abs=0.05)
    assert lines["remaining error at the targets after the correction"]["u_arcsec"] < 0.1
    assert lines["reference instrument"]["u_arcsec"] == 0.12
    assert data["u_arcsec"] == pytest.approx(
        math.sqrt(sum(one["u_arcsec"] ** 2 for one in lines.values()))
    )
    assert data["expanded_arcsec"] == pytest.approx(2 * data["u_arcsec"])
    for ending in ("md", "html"):
        page = (tmp_path / "out" / f"budget.{ending}").read_text()
        for text in (data["set"]["sha256"], data["program"], f"{data['expanded_arcsec']:.4f}"):
            assert text in page
    assert (tmp_path / "out" / "budget.pdf").read_bytes().startswith(b"%PDF")


def test_the_remaining_error_is_that_of_the_targets() -> None:
    """Over 300 random tables, the mean square of the stated remaining error equals that of the
    error that each target has in addition to the fitted orders.

    The bound is 4 standard deviations: an estimate has 24 − 15 degrees of freedom for the means,
    whose variance is 0.1² + 0.1²/3.
    """
    random, number, size = np.random.default_rng(2), 300, 0.1
    target, orders = np.tile(np.arange(24) * 15.0, 3), np.arange(1, 8)
    phase = np.outer(np.radians(target), orders)
    columns = np.hstack([np.ones((target.size, 1)), np.cos(phase), np.sin(phase)])
    found = []
    for _ in range(number):
        of_target = np.tile(size * random.standard_normal(24), 3)
        error = 20.0 * np.cos(np.radians(target)) + of_target
        error += size * random.standard_normal(target.size)
        values = np.linalg.lstsq(columns, error, rcond=None)[0]
        made = MeasurementSet(
            Table(counts_per_rev=1 << 24),
            reference=Reference(
                target,
                error,
                head1_counts=np.rint(target / 360.0 * 2**24).astype(np.int64),
                standard_uncertainty_arcsec=0.1,
            ),
            title="targets",
        )
        pairs = np.stack([values[1:8], values[8:]], axis=1)
        budget = reference_budget(made, Correction(orders, pairs, 0.0, (), ()))
        lines = {one.quantity: one.u_arcsec for one in budget.contributions}
        found.append(lines["remaining error at the targets after the correction"] ** 2)
    spread = (size**2 + size**2 / 3.0) * np.sqrt(2.0 / 9.0) + size**2 / 3.0 * np.sqrt(2.0 / 48.0)
    assert np.mean(found) == pytest.approx(size**2, abs=4.0 * spread / np.sqrt(number))


def test_what_the_set_does_not_state_is_said(tmp_path: Path) -> None:
    made = _reference_alone()
    assert made.reference is not None
    made = replace(made, reference=replace(made.reference, standard_uncertainty_arcsec=None))
    write_measurement_set(tmp_path / "set", made)
    done = _run(tmp_path / "set")
    assert done.exit_code == 0, done.output
    assert "not stated: the reference instrument" in done.output
    assert "a lower limit" in done.output


def test_rows_that_are_too_few_and_models_that_do_not_fit(tmp_path: Path) -> None:
    made = _reference_alone()
    assert made.reference is not None
    few = replace(made, reference=made.reference.where(np.arange(288) < 5))
    wide = Correction(np.arange(1, 4), np.ones((3, 2)), 0.0, (), ())
    with pytest.raises(ValueError, match="5 rows for 7 coefficients"):
        reference_budget(few, wide)
    write_measurement_set(tmp_path / "two", measurement_set(runs=1, turns=1))
    (tmp_path / "m.toml").write_text('schema = 1\n[[effect]]\nname = "graduation_harmonics"\n')
    done = _run(tmp_path / "two", "--model", tmp_path / "m.toml")
    assert done.exit_code == 2
    assert "reference run alone" in done.stderr
