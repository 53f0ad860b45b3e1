"""Tests that every equation, section, figure and table that the source tree cites is in the
paper."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[3]
FOLDERS = ("rtl", "tb", "sim", "firmware", "formal", "scripts", "docs")
ENDINGS = {".vhd", ".rdl", ".py", ".c", ".h", ".cpp", ".sv", ".md", ".j2", ".toml"}

# Numbers of the equations, sections, figures and tables of Shao, Zhu, Huang, Xue and Zhu (2025),
# read from the paper.
PAPER = {
    "equation": {*map(str, range(1, 18)), *(f"A.{n}" for n in range(1, 6))},
    "figure": {
        *map(str, range(1, 12)),
        "A.1",
        "A.2",
        *(f"{n}{p}" for n in (4, 10, 11) for p in "ab"),
    },
    "table": {"1", "2", "3"},
    "section": {"1", "2", "2.1", "2.2", "3", "3.1", "3.2", "3.3", "4", "5"},
}
OTHER_SOURCES = (
    "UG585, table 25-6",
    "IEEE 1149.1 figure 6-1",
    "Seber and Wild, Nonlinear Regression, section 2.1",
    "table 4 K warmer",
    "Table 7, Monday",
)
"""Texts that cite other documents, or that only look like a citation."""

NUMBER = r"\(?(?:A\. ?)?\d{1,2}(?:\.\d+)?(?: ?[ab]\b)?\)?"
WORDS = {
    "equation": r"equations?|eqs?\.",
    "figure": r"figures?|figs?\.",
    "table": r"tables?",
    "section": r"sections?",
}
CITATION = {
    kind: re.compile(
        rf"\b(?:{words})\s+({NUMBER}(?:(?:, and|,| and| to|–|-) ?{NUMBER})*)", re.IGNORECASE
    )
    for kind, words in WORDS.items()
}


def plain(text: str) -> str:
    """Return the text without line breaks, comment marks and citations of other documents."""
    joined = " ".join(re.sub(r"^\s*(?:--|//|/?\*|#)+ ?", "", line) for line in text.splitlines())
    joined = re.sub(r"\s+", " ", joined)
    for other in OTHER_SOURCES:
        joined = joined.replace(other, "")
    return joined


def citations(text: str) -> Iterator[tuple[str, str]]:
    """Yield the kind and the number of every citation in the text; a range yields both of its
    ends."""
    for kind, pattern in CITATION.items():
        for found in pattern.finditer(text):
            for number in re.findall(NUMBER, found[1]):
                yield kind, re.sub(r"[() ]", "", number)


def sources() -> list[Path]:
    own = Path(__file__).name
    found = [path for folder in FOLDERS for path in sorted((ROOT / folder).rglob("*"))]
    return [
        path
        for path in [*found, ROOT / "README.md"]
        if path.suffix in ENDINGS and path.name != own and "generated" not in path.parts
    ]


def test_citations_are_found() -> None:
    text = plain("-- Sections 2.2 and\n-- 3.3, figures 3 and 5 to 7; equations (10) to (12), (A.1)")
    assert list(citations(text)) == [
        ("equation", "10"),
        ("equation", "12"),
        ("equation", "A.1"),
        ("figure", "3"),
        ("figure", "5"),
        ("figure", "7"),
        ("section", "2.2"),
        ("section", "3.3"),
    ]


def test_every_citation_is_in_the_paper() -> None:
    wrong, number = [], 0
    for path in sources():
        for kind, cited in citations(plain(path.read_text(encoding="utf-8"))):
            number += 1
            if cited not in PAPER[kind]:
                wrong.append(f"{path.relative_to(ROOT)}: {kind} {cited}")
    assert wrong == []
    assert number > 100, "the search finds the citations"


PLACES = {
    # Section 2.2 defines b and the iterations, section 3.3 defines the circuit, the appendix the
    # bounds, and equation (9) defines A_n.
    "rtl/formats/number_formats_pkg.vhd": [
        "sections 2.2 and 3.3 and appendix",
        "A_n of equation (9)",
    ],
    "rtl/decoder/quadrature_decoder.vhd": ["section 3.1 and figures 4 and 5"],
    "rtl/compensation/delay_line.vhd": ["section 3.3"],
    "rtl/core/compensation_pipeline.vhd": ["Section 3.3 and figure 7"],
    "rtl/core/arctrue_core.vhd": ["figures 3 and 5 to 7 and section 3"],
    "rtl/sampler/sampler.vhd": ["section 3.2"],
    "rtl/phase/phase_unit.vhd": ["figure 8 and section 3.3"],
    "rtl/harmonic/harmonic_unit.vhd": ["figure 9 and section 3.3"],
    "rtl/compensation/error_compensation.vhd": ["equation (8), θ_com = R − ε(R)"],
    # Equation (2) is the reading R = θ + ε(θ); equation (1) defines the deviation of the table.
    "rtl/encoder_source/encoder_source.vhd": ["ε of equation (2)"],
    "rtl/encoder_source/encoder_source_head.vhd": ["R = θ + ε(θ), equation (2)"],
    # ε is a sum of the cosines in equation (9).
    "sim/arctrue/workbench/effects/catalogue/graduation_harmonics.py": ["(4), (5) and (9)"],
    "sim/arctrue/workbench/effects/fit_context.py": ["equation (9)"],
    "sim/arctrue/calibration/transfer_function.py": ["equation (6)"],
}
"""Places of the paper that each file must cite, because they describe the subject of the file."""


@pytest.mark.parametrize("name", PLACES)
def test_a_file_cites_the_place_that_it_comes_from(name: str) -> None:
    text = plain((ROOT / name).read_text(encoding="utf-8"))
    for citation in PLACES[name]:
        assert citation in text
