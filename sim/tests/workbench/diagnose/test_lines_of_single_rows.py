"""Tests that the list of regular errors contains lines that are too fast for the averaged rows of
the search. In an earlier version the list for a long log lacked some of the largest lines."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.signal import lfilter

from arctrue.measurement import MeasurementSet, Reference, Table
from arctrue.workbench.diagnose.detections import Detections
from arctrue.workbench.diagnose.regular import detections_of
from arctrue.workbench.effects.registry import built_in
from arctrue.workbench.inference.design_matrix import Term
from arctrue.workbench.inference.fit import fit
from arctrue.workbench.inference.forward.fast_lines import fast_lines, sizes_of
from arctrue.workbench.observations.build import observations_of
from tests.workbench.noisy_logs import driven_oscillator, ornstein_uhlenbeck

ROWS, STEP_S, TURN_S = 9000, 0.4, 3600.0
LINES = {9.1: 2.0, 33.0: 1.5, 2.7: 1.0}
"""Periods in seconds and amplitudes. The search averages 6 rows, 2.4 s; it covers periods above
9.6 s."""


def _detections(random: np.random.Generator, error_arcsec: np.ndarray) -> Detections:
    time_s = STEP_S * np.arange(ROWS)
    angle = 2.0 * np.pi * time_s / TURN_S
    slow = 2.0 * ornstein_uhlenbeck(random, time_s, 60.0) + 0.5 * random.normal(size=ROWS)
    reference = Reference(
        target_deg=np.degrees(angle),
        error_arcsec=error_arcsec + 50.0 * np.cos(angle + 1.0) + slow,
        time_s=time_s,
        run=np.zeros(ROWS, dtype=np.int64),
    )
    effects = built_in()
    base = [Term(effects["graduation_harmonics"](), {})]
    observed = observations_of(MeasurementSet(Table(), None, reference))
    return detections_of(fit(base, observed), effects)


@pytest.mark.parametrize("seed", range(2))
def test_each_line_is_listed_with_its_size(seed: int) -> None:
    """With white noise of 0.5″ and the slow noise, an amplitude at 9.1 s has 2u = 0.1″."""
    random = np.random.default_rng(seed)
    time_s = STEP_S * np.arange(ROWS)
    error = sum(
        size * np.cos(2.0 * np.pi * time_s / period + random.uniform(0.0, 6.0))
        for period, size in LINES.items()
    )
    found = _detections(random, np.asarray(error))
    listed = {}
    for cause in found.causes:
        listed |= {round(cause.period_s(line), 1): line.amplitude_arcsec for line in cause.lines}
    listed |= {round(line.period_s, 1): line.amplitude_arcsec for line in found.fast}
    assert sorted(listed) == sorted(LINES)
    for period_s, size in LINES.items():
        assert listed[period_s] == pytest.approx(size, abs=0.2)
    assert "Single rows show lines too fast" in " ".join(found.sentences())


def test_an_oscillation_that_noise_drives_is_no_line() -> None:
    """A resonance of 2.7 s that keeps its phase for 60 s of an hour has no phase of its own."""
    random = np.random.default_rng(5)
    time_s = STEP_S * np.arange(ROWS)
    shaken = driven_oscillator(random, time_s, 2.7, np.pi * 60.0 / 2.7)
    assert _detections(random, shaken).fast == ()


def _resonance(random: np.random.Generator, rows: int, hz: float, quality: float) -> np.ndarray:
    """Return the motion of a resonance that noise drives, 1.5″ RMS, in rows at each second."""
    radius = np.exp(-np.pi * hz / quality)
    turn = [1.0, -2.0 * radius * np.cos(2.0 * np.pi * hz), radius**2]
    found = lfilter([1.0], turn, random.normal(size=rows + 2_000))[2_000:]
    return np.asarray(1.5 * found / found.std())


@pytest.mark.parametrize("quality", [12.0, 40.0, 100.0])
def test_the_peaks_of_a_narrow_resonance_are_no_lines(quality: float) -> None:
    """The resonance keeps its phase for 35 to 290 s of 3,000 s. A line is stated by chance in one
    of a hundred searches, so that 3 of 20 have a probability of 0.001."""
    stated = 0
    for seed in range(20):
        random = np.random.default_rng([4, seed])
        left = _resonance(random, 3_000, 0.11, quality) + random.normal(0.0, 0.5, 3_000)
        place, stretch = np.arange(3_000.0), np.zeros(3_000, dtype=np.int64)
        stated += bool(sizes_of(list(fast_lines(place, stretch, left, 0.1)), place, stretch, left))
    assert stated < 3


def test_a_fast_line_next_to_a_larger_slow_line_is_stated() -> None:
    """A line of 5″ is just below the band of the averaged rows, 10/span from a line of 0.4″."""
    random = np.random.default_rng(8)
    place, stretch = np.arange(3_000.0), np.zeros(3_000, dtype=np.int64)
    left = random.normal(0.0, 0.5, 3_000) + 5.0 * np.cos(2.0 * np.pi * 0.198 * place)
    left += 0.4 * np.cos(2.0 * np.pi * (0.198 + 10.0 / 3_000.0) * place + 1.0)
    lines = list(fast_lines(place, stretch, left, 0.0))
    (found,) = sizes_of(lines, place, stretch, left, 0.2)
    assert found.amplitude_arcsec == pytest.approx(0.4, abs=0.06)


@pytest.mark.parametrize("apart", [3, 12, 300])
def test_two_lines_near_each_other_are_stated(apart: int) -> None:
    """Two lines of 0.4″ and 0.3″ in white noise of 0.5″: u of an amplitude is 0.013″."""
    random = np.random.default_rng(6)
    place, stretch = np.arange(3_000.0), np.zeros(3_000, dtype=np.int64)
    rates = [0.2103, 0.2103 + apart / 3_000.0]
    left = random.normal(0.0, 0.5, 3_000)
    for rate, size in zip(rates, (0.4, 0.3), strict=True):
        left += size * np.cos(2.0 * np.pi * rate * place + 0.7)
    found = sizes_of(list(fast_lines(place, stretch, left, 0.1)), place, stretch, left)
    assert [item.rate for item in found] == pytest.approx(rates, abs=0.3 / 3_000.0)
    assert [item.amplitude_arcsec for item in found] == pytest.approx([0.4, 0.3], abs=0.06)
