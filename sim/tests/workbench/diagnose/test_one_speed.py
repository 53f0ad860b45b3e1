"""Tests that two speeds separate an axis motion from a disc that stretches with the speed.

With one speed, the diagnosis still wrongly names the stretched disc radial_error_motion;
docs/benchmark.md lists such sets.
"""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray
from sim.tests.workbench.base_diagnosis import diagnosis_of
from sim.tests.workbench.small_sets import measurement_set, paper_error

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
