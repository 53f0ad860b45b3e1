"""Tests which captures count as captures at one speed and in one direction."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from sim.tests.workbench.small_sets import measurement_set

from arctrue.workbench.effects.conditions import one_velocity
from arctrue.workbench.observations import Observations
from arctrue.workbench.observations.build import observations_of

EVERY_SPEED = observations_of(measurement_set(turns=1, reference=False))


def _at(*speeds_rad_s: float) -> Observations:
    rows = EVERY_SPEED.capture
    assert rows is not None
    speed = np.resize(speeds_rad_s, rows.run.size)
    return replace(EVERY_SPEED, capture=replace(rows, speed_rad_s=speed))


@pytest.mark.parametrize("scale", [1e-6, 1e-3, 1.0, 100.0])
def test_a_ratio_of_speeds_counts_and_not_their_size(scale: float) -> None:
    """The ratio decides whether two speeds differ, so that a slow table, such as a telescope at
    7·10⁻⁵ rad/s, has as many speeds as a fast one."""
    assert one_velocity(_at(0.4 * scale, -0.4 * scale, 0.2 * scale, -0.2 * scale)) == []
    assert one_velocity(_at(0.4 * scale, -0.4 * scale)) == []
    assert one_velocity(_at(0.4 * scale, 0.401 * scale)) != []
    assert one_velocity(_at(0.4 * scale)) != []
    assert one_velocity(_at(0.0)) != []
