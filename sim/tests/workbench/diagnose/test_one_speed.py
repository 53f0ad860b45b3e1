"""What two heads at one speed cannot tell from an axis motion gets no name."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray
from sim.tests.workbench.base_diagnosis import diagnosis_of
from sim.tests.workbench.small_sets import measurement_set, paper_error

Float = NDArray[np.float64]
LOBES_ARCSEC_S2 = 2.0
"""0.55″ at 30°/s, four times the noise of a row; the reference stands still and shows none."""


def _lobes(disc: Float, temperature: Float, speed: float) -> Float:
    """A disc that the centrifugal force stretches in three lobes."""
    return paper_error(disc, temperature, speed) + LOBES_ARCSEC_S2 * speed**2 * np.cos(3.0 * disc)


@pytest.mark.parametrize(("runs", "verdict"), [(2, "ambiguous"), (3, "unknown")])
def test_a_disc_that_stretches_with_the_speed_is_no_axis_motion(runs: int, verdict: str) -> None:
    """Two runs have one speed, of both signs; the third is three times as fast."""
    found = diagnosis_of(measurement_set(_lobes, runs=runs))
    assert found.verdict == verdict
    if verdict == "ambiguous":
        assert found.next_measurement is not None
        assert "speed" in found.next_measurement
