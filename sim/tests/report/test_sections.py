"""Tests of the sentences about evidence, of angles in the reader's unit, and of the display
settings in the page's address."""

from __future__ import annotations

import pytest

from arctrue.report.display import DisplaySettings
from arctrue.report.sections import angle_text, evidence_in_words


@pytest.mark.parametrize(
    ("p_value", "said"),
    [
        (0.0, "less than one of a thousand million"),
        (2e-7, "less than one of a million"),
        (1.0 / 300.0, "in one of 300 such sets (p"),
        (0.02, "one of 50 such sets: too often to name the effect"),
        (0.9, "such a gain in most such sets"),
    ],
)
def test_evidence_says_how_rare_it_is(p_value: float, said: str) -> None:
    assert said in evidence_in_words(p_value, 12.3)


def test_angles_are_reported_in_the_unit_of_the_reader() -> None:
    # An arcsecond is 4.848 µrad.
    assert angle_text(DisplaySettings(), -1.0) == "−1.000″"
    assert angle_text(DisplaySettings(unit="urad"), -1.0) == "−4.85 µrad"
    assert angle_text(DisplaySettings(), None) == angle_text(DisplaySettings(), float("nan")) == "–"


def test_an_address_holds_the_view_and_nothing_else() -> None:
    display = DisplaySettings.of_query(
        {"unit": "urad", "along": "hz", "against": "temperature", "temperature": "21,5"}
    )
    again = display.query()
    assert again == "?unit=urad&against=temperature&along=hz&temperature=21.5"
    nonsense = DisplaySettings.of_query({"unit": "furlong", "along": "x", "temperature": "nan"})
    assert nonsense == DisplaySettings()
    assert nonsense.query() == ""
    assert display.query(unit="arcsec", along="order", against="", temperature_c=None) == ""
