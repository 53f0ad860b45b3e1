"""Tests that a reference whose offset changes between its cycles is not adequate, and no slow
change; the readings are added to a plain set."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from arctrue.measurement import MeasurementSet
from arctrue.workbench.diagnose.report import sentences
from tests.workbench.base_diagnosis import diagnosis_of
from tests.workbench.small_sets import measurement_set

STATIONS, CYCLES = 24, 20


def _with(added_arcsec: NDArray[np.float64]) -> MeasurementSet:
    """Return a set with two runs of ten cycles of 24 stations; this error is added to its
    reference."""
    made = measurement_set(cycles=CYCLES // 2, seed=2)
    reference = made.reference
    assert reference is not None
    assert reference.error_arcsec.size == STATIONS * CYCLES
    cycle = np.arange(STATIONS * CYCLES) // STATIONS
    error = reference.error_arcsec + added_arcsec
    return replace(made, reference=replace(reference, error_arcsec=error, cycle=cycle))


@pytest.mark.parametrize("seed", [1, 2, 7])
def test_a_mirror_that_moves_between_the_cycles(seed: int) -> None:
    """Offsets of 0.6″ between cycles, four times the noise of a reading. With seed 2, the change
    from one run to the other looks like a reversal error, but is no larger than the others."""
    of_runs = np.random.default_rng(seed).normal(0.0, 0.6, (2, CYCLES // 2))
    # Both runs have the same mean: their difference would look like a reversal error.
    moved = (of_runs - of_runs.mean(axis=1, keepdims=True)).ravel()
    found = diagnosis_of(_with(np.repeat(moved, STATIONS)))
    assert found.verdict == "unknown"
    assert found.findings.cycles is not None
    # The mean of 24 readings of 0.15″ has u = 0.03″; the model takes the mean of all cycles.
    assert found.findings.cycles.rms_arcsec == pytest.approx(float(np.std(moved)), abs=0.1)
    said = " ".join(sentences(found))
    assert "changes from cycle to cycle by" in said
    assert "slow change" not in said


@pytest.mark.parametrize("seed", [3, 4, 5])
def test_a_walk_of_the_reference_is_no_change_between_cycles(seed: int) -> None:
    """A random walk moves within the cycles as much as between them."""
    walk = np.cumsum(np.random.default_rng(seed).normal(0.0, 0.12, STATIONS * CYCLES))
    assert diagnosis_of(_with(walk)).findings.cycles is None


def test_white_noise_is_no_change_between_cycles() -> None:
    assert diagnosis_of(_with(np.zeros(STATIONS * CYCLES))).findings.cycles is None
