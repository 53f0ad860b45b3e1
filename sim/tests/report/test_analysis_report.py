"""Tests that ``arctrue report`` writes one self-contained file, and every figure as a separate file
next to it."""

from __future__ import annotations

import json
import re
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import pytest
from click.testing import CliRunner, Result

from arctrue.cli import main
from arctrue.measurement import write_measurement_set
from arctrue.report.display import FIGURES
from tests.workbench.small_sets import measurement_set, paper_error

MOST_BYTES = 5_000_000
"""Largest permitted size of the page in bytes, so that it can be sent by e-mail."""


@pytest.fixture(scope="module")
def written(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Result]:
    folder = tmp_path_factory.mktemp("report")
    made = measurement_set(paper_error, runs=2, cycles=2, turns=1, reversal_arcsec=2.0)
    write_measurement_set(folder / "set", made)
    words = ["report", str(folder / "set"), "--out", str(folder / "out"), "--unit", "urad"]
    answer = CliRunner().invoke(main, [*words, "--json", str(folder / "diagnosis_output.json")])
    return folder, answer


def test_the_page_needs_no_other_file(written: tuple[Path, Result]) -> None:
    folder, answer = written
    assert answer.exit_code == 0, answer.output
    page = folder / "out" / "report.html"
    text = page.read_text(encoding="utf-8")
    assert page.stat().st_size < MOST_BYTES
    links = re.findall(r'(?:src|href)="([^"]*)"', text)
    assert all(link.startswith(("#", "data:image/png;base64,")) for link in links)
    assert "<script" not in text
    assert not re.search(r"@import|url\((?!#)", text)


def test_every_section_and_figure_is_there(written: tuple[Path, Result]) -> None:
    folder, _ = written
    text = (folder / "out" / "report.html").read_text(encoding="utf-8")
    for section in ("set", "fit", "where", "finding", "missing", "ladder", "device"):
        assert f'<section id="{section}">' in text
    pictures = re.findall(r"<svg.*?</svg>", text, re.DOTALL)
    assert len(pictures) == len(FIGURES)
    assert all(ElementTree.fromstring(picture).attrib["aria-label"] for picture in pictures)
    for name in FIGURES:
        assert (folder / "out" / f"{name}.png").read_bytes().startswith(b"\x89PNG")
        ElementTree.parse(folder / "out" / f"{name}.svg")
    assert "µrad" in text
    assert "SHA-256" in text


def test_it_says_what_diagnose_says(written: tuple[Path, Result]) -> None:
    folder, _ = written
    reported = json.loads((folder / "diagnosis_output.json").read_text(encoding="utf-8"))
    text = (folder / "out" / "report.html").read_text(encoding="utf-8")
    assert reported["named"] == "hysteresis"
    assert f"Verdict: {reported['verdict']}" in text
    assert '<li class="candidate named">' in text


def test_an_unknown_condition_is_refused(written: tuple[Path, Result], tmp_path: Path) -> None:
    folder, _ = written
    words = ["report", str(folder / "set"), "--out", str(tmp_path), "--against", "moon"]
    answer = CliRunner().invoke(main, words)
    assert answer.exit_code == 2
    assert "--against moon: expected one of angle" in answer.stderr
    assert list(tmp_path.iterdir()) == []
