"""Tests that the page of the paper's experiment, its JSON and the equations agree, and that the
committed drawings equal those that the program draws."""

from __future__ import annotations

import dataclasses
import json
import re
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from arctrue.cli import main
from arctrue.report.charts.paper_drawings import DRAWINGS, draw_figures, drawing_name
from arctrue.report.paper_figures import expected_order_arcsec
from arctrue.report.paper_page import paper_page
from arctrue.studies.paper.equations import EQUATIONS
from arctrue.studies.paper.published import PUBLISHED
from arctrue.studies.paper.station_error import residual_orders

ROOT = Path(__file__).resolve().parents[4]
DOCS = ROOT / "docs"
FOUND = json.loads((DOCS / "data" / "paper.json").read_text(encoding="utf-8"))


def test_page_and_json_agree() -> None:
    page = (DOCS / "paper.md").read_text(encoding="utf-8")
    assert page == paper_page(FOUND), "arctrue paper --from docs/data/paper.json --page ..."


@pytest.mark.parametrize("make", EQUATIONS, ids=lambda make: make.__name__)
def test_equations_give_what_the_json_has(make) -> None:  # type: ignore[no-untyped-def]
    """The equations give the figures of the JSON to a millionth; smaller differences come from
    rounding errors, which differ from machine to machine."""
    item = make()
    stored = {one["label"]: one for one in FOUND["items"]}[item.label]
    for name, value in item.values.items():
        assert value == pytest.approx(stored["values"][name], rel=1e-6, abs=1e-9)


def test_every_equation_and_table_of_the_paper_is_there() -> None:
    labels = " ".join(one["label"] for one in FOUND["items"])
    numbers = {int(n) for n in re.findall(r"\((\d+)\)", labels)}
    assert numbers == set(range(1, 18))
    assert {int(n) for n in re.findall(r"\(A\.(\d)\)", labels)} == {1, 2, 3, 4, 5}
    page = paper_page(FOUND)
    assert all(f"Table {number}" in page for number in (1, 2, 3))


def test_figures_of_the_experiment_come_from_its_stations() -> None:
    """The test computes the span, the mean σ (the repeatability) and U again, from the stored
    values of the faces and the stored budget."""
    for one in FOUND["experiments"]:
        mean = np.array(one["after"]["mean_arcsec"])
        deviation = np.array(one["after"]["deviation_arcsec"])
        assert one["after"]["span_arcsec"] == pytest.approx([mean.min(), mean.max()])
        budget = one["budget"]
        assert budget["repeatability_arcsec"] == pytest.approx(deviation.mean())
        parts = [v for k, v in budget.items() if k not in ("combined_arcsec", "expanded_arcsec")]
        assert budget["expanded_arcsec"] == pytest.approx(2.0 * float(np.linalg.norm(parts)))


def test_the_first_run_has_the_paper_s_size() -> None:
    """The first run has 2²⁴ counts per turn and ten cycles; its remaining error lies between −1.3″
    and 1.6″."""
    first = FOUND["experiments"][0]
    given = first["settings"]["revolution"]
    assert given["lines"] * given["interpolation"] == 1 << 24
    assert first["settings"]["cycles"] == 10
    low, high = first["after"]["span_arcsec"]
    assert -1.3 < low < 0.0 < high < 1.6


def test_the_broken_line_of_fig_11_b_is_that_of_independent_faces() -> None:
    """The broken line of Fig. 11 b is the RMS amplitude of the orders of independent errors at 24
    faces, which the test simulates without order 12, because this order has only one component."""
    budget = PUBLISHED.budget
    face = np.hypot(budget.polygon_arcsec, budget.autocollimator_arcsec)
    drawn = np.random.default_rng(1).normal(0.0, face, (4000, PUBLISHED.faces))
    orders = np.array([residual_orders(row)[:11] for row in drawn])
    expected = expected_order_arcsec(dataclasses.asdict(PUBLISHED))
    # The squares of the 44,000 amplitudes are exponentially distributed, so that the RMS of the
    # amplitudes is known to 0.24 %.
    assert np.sqrt(np.mean(orders**2)) == pytest.approx(expected, rel=0.01)


def test_drawings_are_the_committed_ones(tmp_path: Path) -> None:
    for path in draw_figures(tmp_path):
        text = path.read_text(encoding="utf-8")
        assert text == (DOCS / "images" / path.name).read_text(encoding="utf-8"), path.name


def test_drawn_square_waves_are_those_of_the_paper() -> None:
    """The drawing of figure 4 has the levels 00, 10, 11, 01 while the reading rises."""
    text = (DOCS / "images" / drawing_name("4")).read_text(encoding="utf-8")
    levels = re.findall(r">([01]{2})</text>", text)
    assert levels[0:8:2] == ["00", "10", "11", "01"]
    assert set(DRAWINGS) == {"1", "3", "4", "5", "6", "7", "8", "9", "A1", "A2"}


def test_a_file_of_another_kind_is_refused(tmp_path: Path) -> None:
    other = tmp_path / "other.json"
    other.write_text('{"schema": 1}', encoding="utf-8")
    answer = CliRunner().invoke(main, ["paper", "--from", str(other)])
    assert answer.exit_code == 2
    assert "expected a file that `arctrue paper --json` wrote" in answer.output
