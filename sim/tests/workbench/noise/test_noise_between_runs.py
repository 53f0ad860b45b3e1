"""Tests that the slow noise of a reference continues from run to run, because no index separates
the runs."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from sim.tests.workbench.base_diagnosis import diagnosis_of
from sim.tests.workbench.small_sets import measurement_set

from arctrue.workbench.noise.law import NoiseLaw
from arctrue.workbench.noise.spectrum import Spectrum

FACES = 24
STEP_S = 8.0
SLOW = Spectrum(0.3, np.array([20.0, 400.0]), np.array([0.5, 2.0]))


def _passes(pause_s: float, count: int = 3) -> tuple[np.ndarray, np.ndarray]:
    """Return time and run number of each row, for passes over the faces with a pause after each."""
    run = np.repeat(np.arange(count), FACES)
    within = np.tile(np.arange(FACES) * STEP_S, count)
    return within + run * ((FACES - 1) * STEP_S + pause_s), run


def _covariance(clock: np.ndarray, run: np.ndarray, *, goes_on: bool) -> np.ndarray:
    law = NoiseLaw((SLOW,) * 3, np.arange(3), np.array([1.0, 1.0, 1.5]))
    noise = law.of(clock, run, np.zeros(clock.size), np.ones(clock.size), goes_on=goes_on)
    whitened = noise.whiten(np.eye(clock.size))
    return np.asarray(np.linalg.inv(whitened.T @ whitened))


def _written_out(clock: np.ndarray, run: np.ndarray) -> np.ndarray:
    apart = np.abs(clock[:, None] - clock)
    covariance = 0.3 * np.eye(clock.size)
    covariance += 0.5 * np.exp(-apart / 20.0) + 2.0 * np.exp(-apart / 400.0)
    scale = np.where(run == 2, 1.5, 1.0)
    return np.asarray(covariance * np.outer(scale, scale))


@pytest.mark.parametrize("pause_s", [STEP_S, 150.0])
def test_a_pass_continues_the_noise_of_the_one_before(pause_s: float) -> None:
    """The noise of a pass continues in the next pass: the covariance depends only on the time
    between two rows and on the scale of each row's run."""
    clock, run = _passes(pause_s)
    found = _covariance(clock, run, goes_on=True)
    np.testing.assert_allclose(found, _written_out(clock, run), rtol=1e-9)


@pytest.mark.parametrize(("pause_s", "goes_on"), [(STEP_S, False), (3600.0, True)])
def test_a_capture_and_a_pause_longer_than_the_runs_begin_anew(
    pause_s: float, goes_on: bool
) -> None:
    clock, run = _passes(pause_s)
    expected = _written_out(clock, run)
    expected[run[:, None] != run] = 0.0
    found = _covariance(clock, run, goes_on=goes_on)
    np.testing.assert_allclose(found, expected, rtol=1e-9, atol=1e-12)


def test_runs_with_other_steps_or_a_clock_that_goes_back_begin_anew() -> None:
    clock, run = _passes(STEP_S)
    clock = np.where(run == 1, clock[0] + 3.0 * (clock - clock[run == 1][0]), clock)
    law = NoiseLaw((SLOW,) * 3, np.arange(3), np.ones(3))
    noise = law.of(clock, run, np.zeros(clock.size), np.ones(clock.size), goes_on=True)
    assert noise.starts.tolist() == [0, FACES, 2 * FACES]


@pytest.mark.large
@pytest.mark.parametrize("seed", [1, 2, 3])
def test_a_stand_that_wanders_over_ten_passes_has_no_drift(seed: int) -> None:
    """The diagnosis finds no drift in the random walk of the reference's stand, 0.03″ per row; each
    pass over the faces is a separate run."""
    made = measurement_set(seed=seed, cycles=10, runs=1)
    reference = made.reference
    assert reference is not None
    walk = np.cumsum(np.random.default_rng(seed).normal(0.0, 0.03, reference.error_arcsec.size))
    assert reference.cycle is not None
    passes = replace(reference, run=reference.cycle, error_arcsec=reference.error_arcsec + walk)
    assert diagnosis_of(replace(made, reference=passes)).named is None
