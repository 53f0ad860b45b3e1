"""Test of a hidden scratch on the disc, which a gateware with LOCAL_TABLE corrects."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

from arctrue.gateware.capability import EVERYTHING
from arctrue.gateware.coefficient_file import read_coefficient_file

from .small import INTERPOLATION, LINES, run_small

COUNTS = LINES * INTERPOLATION
HEIGHT_ARCSEC = 20.0 * math.sqrt((1 << 24) / COUNTS)
"""Height of the scratch: 20″ with the paper's 2²⁴ counts per turn. The hidden scratch has the same
slope at every scale, so that its height grows with the square root of the size of a count."""


@pytest.mark.large
def test_a_scratch_is_taken_away_to_a_tenth(tmp_path: Path) -> None:
    """The local table reduces the scratch to a tenth of its height: captures with a sample every
    0.3° show its place and width, and the test compares every edge of the output."""
    result = run_small("graduation_defect", tmp_path)
    assert result.diagnosed.effect == "graduation_defect"
    found = result.diagnosed.model.effects[-1].parameters
    assert abs(abs(found["height"].value) - HEIGHT_ARCSEC) < 0.1 * HEIGHT_ARCSEC
    held = read_coefficient_file(tmp_path / "coefficients.toml", EVERYTHING)
    assert held.extension is not None
    assert held.extension.local_table is not None
    left = result.judged_arcsec()
    assert left["paper"] > 0.9 * HEIGHT_ARCSEC
    assert left["unit_left_out"] > 0.8 * HEIGHT_ARCSEC, "an empty table corrects nothing"
    assert left["corrected"] <= 0.1 * HEIGHT_ARCSEC
