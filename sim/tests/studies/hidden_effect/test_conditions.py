"""Tests that the workbench finds effects in proportion to a condition and exports them to lanes
(corrections of one order) whose amplitude follows the condition, and that the lanes remove them
from the output.

The turns that are simulated afterwards have another direction, speed or temperature than the
measured set; no coefficient is fitted to these turns.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from sim.tests.studies.hidden_effect.small import run_small, small_settings

from arctrue.studies.hidden_effect.cases import BETWEEN, CASES, SLOW
from arctrue.studies.hidden_effect.drive import CHANGE_TURN
from arctrue.studies.hidden_effect.result import HiddenResult
from arctrue.table import DISC_RADIUS_M

COARSER = 64
"""Factor by which the hidden effect is enlarged: 2²⁴ counts per turn divided by 2¹⁸."""
COUNT_ARCSEC = 1_296_000 / (1 << 18)
SPEED_RAD_S = np.radians(30.0)
LATENCY_ARCSEC = 28.0 * COUNT_ARCSEC
"""Error that the latency of 20 µs causes at 30°/s: 28 counts with 2²⁴ counts per turn. The case
enlarges the latency, so that the error has 28 counts at the small scale too."""
LAG_CLOCKS = 1.5 * (1 << 14) + 9 + 600
"""Largest lag of the modulator in clocks.

docs/entities/table_speed.md gives one and a half windows, a period of A and B (9 clocks at half the
speed) and a division; docs/entities/table_conditions.md gives two sweeps. Division and sweeps
together take at most 600 clocks.
"""


def latency_bound_arcsec() -> float:
    """Return the bound of the corrected error: two counts, plus the change of the latency's error
    while the speed changes during the modulator's lag."""
    scale = small_settings().revolution
    change_rad = CHANGE_TURN * 2.0 * np.pi
    change_s = change_rad / (0.5 * (1.0 + SLOW) * SPEED_RAD_S)
    rate = (1.0 - SLOW) * LATENCY_ARCSEC / change_s
    return float(2.0 * COUNT_ARCSEC + rate * LAG_CLOCKS / scale.clock_hz)


def modulators(result: HiddenResult) -> list[str]:
    extension = result.export.coefficients.extension
    assert extension is not None
    return sorted(name for _, name in extension.modulators)


@pytest.mark.large
def test_latency_while_the_speed_changes_by_a_half(tmp_path: Path) -> None:
    result = run_small("latency", tmp_path)
    assert result.diagnosed.effect == "latency"
    delay = result.diagnosed.model.effects[-1].parameters["latency"]
    assert delay.value == pytest.approx(20.0 * COARSER, abs=4.0 * delay.sigma)
    assert modulators(result) == ["speed"]
    left = result.judged_arcsec()
    assert left["corrected"] <= latency_bound_arcsec()
    # The speed changes by a half, so half of the latency's error changes within the turn; the test
    # subtracts the mean of the turn, which removes half of this change.
    assert left["unit_left_out"] >= 0.25 * LATENCY_ARCSEC > latency_bound_arcsec()


@pytest.mark.large
@pytest.mark.parametrize(
    ("name", "modulator", "size_arcsec"),
    [
        ("centrifugal_lobes", "speed_squared", 2.0 * COARSER * (BETWEEN * SPEED_RAD_S) ** 2),
        (
            "loose_centre",
            "direction",
            float(np.degrees(0.2e-6 * COARSER / DISC_RADIUS_M)) * 3600.0,
        ),
    ],
)
def test_a_wave_in_proportion_to_a_condition(
    name: str, modulator: str, size_arcsec: float, tmp_path: Path
) -> None:
    """The correction leaves at most one count of the effect; without it the error has the size that
    the geometry gives."""
    result = run_small(name, tmp_path)
    assert modulators(result) == [modulator]
    left = result.judged_arcsec()
    assert left["corrected"] <= COUNT_ARCSEC
    assert left["unit_left_out"] == pytest.approx(size_arcsec, rel=0.05)


@pytest.mark.large
def test_three_of_them_and_heat_at_once(tmp_path: Path) -> None:
    """In a warm backward turn with a changing speed, the error of the corrected output is at most
    the sum of the bounds of the single effects.

    The lobes follow the speed squared with the same lag as the latency; their error is a quarter
    of the latency's error and changes twice as fast with the speed.
    """
    result = run_small("all_at_once", tmp_path)
    added = [step.effect for step in result.diagnosed.ladder if step.action == "add"]
    assert len(added) == 4
    assert {"latency", "thermal_eccentricity"} <= set(added)
    assert modulators(result) == ["direction", "speed", "speed_squared"]
    left = result.judged_arcsec()
    bound = latency_bound_arcsec() + 3.0 * COUNT_ARCSEC
    assert left["corrected"] <= bound
    assert left["unit_left_out"] > 1.5 * bound
    assert left["paper"] > 4.0 * bound


def test_each_fresh_turn_has_conditions_of_its_own() -> None:
    """Every case has a fresh turn, with another speed, direction or temperature than the measured
    set."""
    for name in ("latency", "centrifugal_lobes", "loose_centre", "all_at_once", "warm_ovality"):
        case = CASES[name]
        fresh = (case.fresh.side, case.fresh.speed, case.fresh.temperature_c)
        assert fresh != (1, 1.0, (20.0, 20.0)) or case.fresh.second_speed is not None
