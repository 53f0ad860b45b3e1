"""Test of a hidden error with 71.4 periods per turn of the table, as a gear causes it. The gateware
is built with REAL_ORDERS, so that it can correct orders that are not integers."""

from __future__ import annotations

from pathlib import Path

import pytest

from arctrue.gateware.capability import EVERYTHING
from arctrue.gateware.coefficient_file import read_coefficient_file
from arctrue.studies.hidden_effect.cases import GEAR_TEETH

from .small import INTERPOLATION, LINES, run_small

COUNTS = LINES * INTERPOLATION
COUNT_ARCSEC = 1_296_000 / COUNTS
SIZE_ARCSEC = (1 << 24) / COUNTS
"""Amplitude of the hidden sine in arcseconds. It is 1″ with 2²⁴ counts per turn, and grows in
proportion to the angle of a count."""


@pytest.mark.large
def test_a_line_of_no_whole_order_is_taken_away(tmp_path: Path) -> None:
    """The diagnosis finds the sine of non-integer order in one turn of the reference. The core then
    corrects this sine, so that some turns later the output no longer contains it."""
    result = run_small("periodic_error", tmp_path)
    assert result.diagnosed.effect == "periodic_error"
    found = result.diagnosed.model.effects[-1].parameters
    # If the order is known to 0.001, the phase is right to a hundredth of a period after ten turns.
    assert found["order"].value == pytest.approx(GEAR_TEETH, abs=0.001)
    held = read_coefficient_file(tmp_path / "coefficients.toml", EVERYTHING)
    assert held.extension is not None
    ((lane, _),) = held.extension.turn_steps
    assert held.real_orders[lane] == pytest.approx(GEAR_TEETH, abs=0.001)
    left = result.judged_arcsec()
    assert left["paper"] > 0.9 * SIZE_ARCSEC
    assert left["unit_left_out"] > 0.9 * SIZE_ARCSEC, "without its lane the line remains"
    # The bound is one count of the output, one count of the reading, and the error of the
    # calibration's integer orders.
    assert left["corrected"] <= 3.0 * COUNT_ARCSEC
