"""Tests that the committed page follows from the committed JSON, and that the statements of the
page agree with the figures."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest

from arctrue.report.charts.methods_picture import plot_methods
from arctrue.report.methods_page import methods_page

ROOT = Path(__file__).resolve().parents[4]
FOUND = json.loads((ROOT / "docs" / "data" / "methods.json").read_text(encoding="utf-8"))


def test_page_and_json_agree() -> None:
    page = (ROOT / "docs" / "methods.md").read_text(encoding="utf-8")
    assert page == methods_page(FOUND), "arctrue methods --page docs/methods.md --json ..."


def test_the_page_says_what_the_figures_say() -> None:
    """The statements in the last section of the page agree with the figures."""
    by_name = {one["name"]: one for one in FOUND["methods"]}
    rms = {name: one["rms_arcsec"] for name, one in by_name.items()}
    later = {name: one["rms_later_arcsec"] for name, one in by_name.items()}
    mean = "mean_of_four_calibrated"
    assert rms[mean] < 0.05
    assert abs(later[mean] - rms[mean]) < 0.005
    assert all(later[name] > 0.5 for name, one in by_name.items() if one["output"] == "head 1")
    assert rms["four_heads_least_squares"] < 0.5 * rms["three_heads_least_squares"]
    pair, third, _, listed, every, _ = FOUND["places"]
    assert pair["worst_gain_to_128"] is None
    assert third["worst_gain_to_128"] is not None
    assert round(listed["worst_gain_to_128"], 1) == 1.2
    assert round(every["worst_gain_to_128"], 1) == 11.2
    # If the heads determine their own places, the uncertainty of a place is 3 to 4″ with the axis
    # at rest, and larger if the axis has unknown motions.
    least = [min(one["u_arcsec"]) for one in FOUND["own_places"]]
    assert least == sorted(least)
    assert 2.0 < least[0] < 5.0


def test_the_page_does_not_claim_every_method() -> None:
    """The first paragraph leads to the methods that are left out, and claims no completeness."""
    first = methods_page(FOUND).split("```")[0]
    assert re.search(r"(each|every|all) method", first) is None
    assert "(#left-out)" in first
    assert methods_page(FOUND).split("\n## Left out\n\n")[1].startswith("The comparison omits")


def test_the_picture_is_written(tmp_path: Path) -> None:
    text = plot_methods(FOUND, tmp_path).read_text(encoding="utf-8")
    assert "Two heads, least squares" in text


def test_every_method_is_on_the_page() -> None:
    page = methods_page(FOUND)
    for one in FOUND["methods"]:
        assert page.count(f"| {one['title']} |") == 2


# References that section 1 of the paper cites for each method.
CITED_FOR = {
    "TDR": {3, 4},
    "EDA": {5, 18, 19, 20, 21},
}


@pytest.mark.parametrize("abbreviation", CITED_FOR)
def test_a_reference_of_the_paper_is_that_of_its_method(abbreviation: str) -> None:
    for one in FOUND["methods"]:
        numbers: set[int] = set()
        for first, last in re.findall(r"\[(\d+)(?:–(\d+))?\]", one["source"]):
            numbers |= set(range(int(first), int(last or first) + 1))
        if f"({abbreviation})" in one["title"]:
            assert numbers == CITED_FOR[abbreviation], one["title"]
        else:
            assert not numbers & CITED_FOR[abbreviation], one["title"]
