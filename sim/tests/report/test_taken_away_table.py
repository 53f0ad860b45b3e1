"""Tests that the demo's last page names the effects that the device can correct, from stored
figures."""

from __future__ import annotations

import json
import re
from html import unescape
from pathlib import Path

import pytest

from arctrue.report import taken_away_table as module
from arctrue.report.demo_page import page_templates
from arctrue.report.second_act_page import write_second_act_page
from arctrue.report.taken_away_table import TAKEN, stored, taken_away_table


def shown() -> str:
    template = page_templates().get_template("taken_away.html.j2")
    return unescape(template.render(taken_away=taken_away_table()))


def test_every_effect_is_in_its_place() -> None:
    """Each stored effect is in the table, with its figures, or in one of the two sentences."""
    text = shown()
    rows = dict(re.findall(r"<tr><td>(\w+)</td>(.*?)</tr>", text, re.DOTALL))
    for name, row in stored()["effects"].items():
        by, left = row["taken_away_by"], row["left_with_arcsec"]
        if by == "nothing" and "left_in_mean_arcsec" in row:
            by, left = "the mean", row["left_in_mean_arcsec"]
        assert (name in rows) == (by not in ("nothing", "not in the output", "reference")), name
        if name in rows:
            for value in (row["left_without_arcsec"], left):
                assert f"<td>{value:.3f}</td>" in rows[name]
            assert TAKEN[by].replace("`", "") in rows[name]
        else:
            sentence = "Nothing corrects" if by == "nothing" else "comes from"
            (names,) = re.findall(rf"{sentence} ([\w, ]+)\.", text)
            assert name in names.split(", ")


def test_the_figures_are_those_of_the_stored_file(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    row = {
        "simulated": "7 um",
        "part_arcsec": 1.0,
        "left_without_arcsec": 1.25,
        "left_with_arcsec": 0.125,
        "taken_away_by": "lanes of real orders",
    }
    other = {**row, "taken_away_by": "nothing"}
    mean = {**other, "left_in_mean_arcsec": 0.004}
    file = tmp_path / "stored.json"
    file.write_text(
        json.dumps({"effects": {"one": row, "two": other, "three": mean}}), encoding="utf-8"
    )
    monkeypatch.setattr(module, "STORED", file)
    text = " ".join(shown().split())
    assert "7 um</td><td>1.250</td> <td>0.125</td><td>lanes of a bitstream with REAL" in text
    assert "<td>0.004</td><td>the weighted mean of a bitstream with four heads" in text
    assert "Nothing corrects two." in text


def test_the_last_page_contains_the_table() -> None:
    environment = page_templates()
    assert environment.loader is not None
    source = environment.loader.get_source(environment, "second_act.html.j2")[0]
    assert '{% include "taken_away.html.j2" %}' in source
    assert "taken_away_table()" in Path(write_second_act_page.__code__.co_filename).read_text(
        encoding="utf-8"
    )
