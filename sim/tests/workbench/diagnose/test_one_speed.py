"""Tests that two speeds separate an axis motion from a disc that stretches with the speed.

With two heads at one speed, and a reference at standstill, both are a difference between capture
and reference at one order, so that no test can separate them.
"""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray
from sim.tests.workbench.base_diagnosis import diagnosis_of
from sim.tests.workbench.small_sets import measurement_set, paper_error

from arctrue.workbench.effects.catalogue.radial_error_motion import RadialErrorMotion
from arctrue.workbench.observations.build import observations_of

Float = NDArray[np.float64]
LOBES_ARCSEC_S2 = 2.0
"""Error in arcseconds per squared speed: 0.55″ at 30°/s, four times the noise of a row. The
reference is read at standstill and does not contain this error."""


def _lobes(disc: Float, temperature: Float, speed: float) -> Float:
    """Return the error of a disc that the centrifugal force stretches in three lobes."""
    return paper_error(disc, temperature, speed) + LOBES_ARCSEC_S2 * speed**2 * np.cos(3.0 * disc)


@pytest.mark.large
def test_a_disc_that_stretches_with_the_speed_is_no_axis_motion() -> None:
    """The diagnosis names no axis motion for the stretched disc, because the last of three runs is
    three times as fast as the other two."""
    found = diagnosis_of(measurement_set(_lobes, runs=3))
    assert found.verdict == "unknown"


@pytest.mark.large
def test_one_speed_does_not_choose_between_disc_and_axis() -> None:
    """The runs are up and down at 30°/s. The diagnosis asks for another speed."""
    found = diagnosis_of(measurement_set(_lobes, runs=2))
    assert found.verdict == "ambiguous"
    assert found.effect_class[0] == "radial_error_motion"
    assert found.next_measurement_kind == "speed"


@pytest.mark.parametrize(("runs", "lacking"), [(2, ["runs at more than one speed"]), (3, [])])
def test_an_axis_motion_needs_two_speeds(runs: int, lacking: list[str]) -> None:
    made = measurement_set(runs=runs, cycles=1, turns=1)
    assert RadialErrorMotion().variety(observations_of(made)) == lacking
