"""Tests that the diagnosis names no effect for run offsets that scatter more than the index should.

The offsets scatter by ±20 counts, as if the index mark were detected to ±1.5″; the prior of an
index is ±1 count. Four runs have four offsets: too few to show a mean, or an influence of speed or
temperature, in this scatter.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from sim.tests.workbench.base_diagnosis import diagnosis_of
from sim.tests.workbench.small_sets import measurement_set

from arctrue.measurement import MeasurementSet

OF_THE_RUNS = {"timing_skew", "head_angle_error", "thermal_head_drift"}


def _scattered(offsets: list[int]) -> MeasurementSet:
    """Return the plain set with these counts added to head 2, one value per run."""
    made = measurement_set(turns=2, cycles=4)
    capture = made.capture
    assert capture is not None
    shift = np.array(offsets, dtype=np.int64)[capture.run]
    return replace(made, capture=replace(capture, head2_counts=capture.head2_counts + shift))


@pytest.mark.parametrize("offsets", [[-20, -15, -14, -5], [20, -14, 12, 18], [-5, -20, 19, -13]])
def test_offsets_of_a_poor_index_have_no_name(offsets: list[int]) -> None:
    found = diagnosis_of(_scattered(offsets))
    assert found.named is None
    assert not OF_THE_RUNS & set(found.effect_class)


def test_a_skew_within_a_good_index_keeps_its_name() -> None:
    """The diagnosis names a skew of 3 µs if the index is good: the skew gives 0.32, −0.32 and 0.97″
    at 30, −30 and 90 °/s, which are four to twelve counts."""
    found = diagnosis_of(measurement_set(head2_only=lambda time, speed: 0 * time + 0.62 * speed))
    assert found.named is not None
    assert found.named.name == "timing_skew"
