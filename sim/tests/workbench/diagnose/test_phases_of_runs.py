"""Tests that the diagnosis describes a line with a phase of its own in each run as a line, and an
oscillation that noise drives as an oscillation."""

from __future__ import annotations

import numpy as np
import pytest

from arctrue.measurement import MeasurementSet, Reference, Table
from arctrue.workbench.diagnose.report import sentences
from arctrue.workbench.diagnose.report_json import diagnosis_data
from arctrue.workbench.effects.registry import built_in
from arctrue.workbench.inference.design_matrix import Term
from arctrue.workbench.inference.fit import fit
from arctrue.workbench.inference.forward.own_phases import line_of_runs
from arctrue.workbench.inference.solution import Solution
from arctrue.workbench.observations.build import observations_of
from tests.workbench.base_diagnosis import diagnosis_of
from tests.workbench.noisy_logs import NULLS, driven_oscillator

SIZE, NOISE = 5.0, 2.0
SPEEDS = (2.0, 3.1, -2.0)
"""Speeds in degrees per second of three runs over a turn, of 180 s, 116 s and 180 s."""


def _clock(rate_hz: float, speeds: tuple[float, ...]) -> tuple[np.ndarray, ...]:
    """Return run, time and angle of rows at an even rate, with pauses of 20 s between the runs."""
    run, time_s, angle_deg = [], [], []
    start_s = 0.0
    for number, speed in enumerate(speeds):
        own = np.arange(int(360.0 / abs(speed) * rate_hz)) / rate_hz
        run.append(np.full(own.size, number))
        time_s.append(start_s + own)
        angle_deg.append(speed * own if speed > 0.0 else 360.0 + speed * own)
        start_s += own.size / rate_hz + 20.0
    return np.concatenate(run), np.concatenate(time_s), np.concatenate(angle_deg)


def _set(
    error_arcsec: np.ndarray, run: np.ndarray, time_s: np.ndarray, angle_deg: np.ndarray
) -> MeasurementSet:
    error = error_arcsec + 15.0 * np.cos(np.radians(angle_deg) + 1.0)
    reference = Reference(target_deg=angle_deg, error_arcsec=error, time_s=time_s, run=run)
    return MeasurementSet(Table(), None, reference)


def _line(
    seed: int, hz: float, rate_hz: float, speeds: tuple[float, ...] = SPEEDS
) -> MeasurementSet:
    random = np.random.default_rng(seed)
    rows = _clock(rate_hz, speeds)
    phase = random.uniform(0.0, 2.0 * np.pi, len(speeds))[rows[0]]
    error = SIZE * np.cos(2.0 * np.pi * hz * rows[1] + phase)
    return _set(error + NOISE * random.normal(size=phase.size), *rows)


def _solution(measurement: MeasurementSet) -> Solution:
    base = [Term(built_in()["graduation_harmonics"](), {})]
    return fit(base, observations_of(measurement))


@pytest.mark.parametrize("hz", [0.03, pytest.param(0.4, marks=pytest.mark.large), 1.97])
@pytest.mark.parametrize("seed", [0, *(pytest.param(n, marks=pytest.mark.large) for n in (1, 2))])
def test_frequency_and_amplitude_of_each_run(hz: float, seed: int) -> None:
    """An amplitude is known to √(2/460 rows) of the noise of 2″, 0.13″, in the shortest run; the
    frequency to √6·0.13″/(π·5″·116 s) = 2·10⁻⁴ Hz. The limits are four times these values."""
    found = line_of_runs(_solution(_line(seed, hz, 4.0)), hz + 1e-3, 0.01)
    assert found is not None
    assert found.hz == pytest.approx(hz, abs=8e-4)
    assert found.amplitudes_arcsec == pytest.approx([SIZE] * 3, abs=0.6)


def test_the_verdict_describes_one_line() -> None:
    """Rows every 0.25 s show the line of 1.97 Hz; its alias at 1/0.25 s − 1.97 Hz has the period
    0.4926 s. At the speed of the first run the line has order 354.6, which an earlier version
    listed as a second line of single rows."""
    found = diagnosis_of(_line(1, 1.97, 4.0))
    assert found.verdict == "unknown"
    said = sentences(found)
    assert "a line of 0.5076 s (1.97 Hz), 5" in said[0]
    assert "with a phase of its own in each run" in said[0]
    periods = "0.4926 s or 0.1675 s"
    assert f"every 0.25 s: a line with a period of {periods} would look the same" in said[1]
    assert "Single rows" not in " ".join(said)
    assert "noise-driven" not in " ".join(said)
    assert diagnosis_data(found, [])["findings"]["oscillation"]["own_phase_in_each_run"]


@pytest.mark.parametrize("seed", [1, 3])
def test_a_fast_line_with_a_phase_in_each_run_is_no_pair_of_lines(seed: int) -> None:
    """Two runs of 36 s and 15 s with 100 rows a second: with one phase, the line of 12.5 Hz is two
    lines at other frequencies. Where the two phases fit one line at a frequency within 1/36 s, as
    with seed 2, nothing separates the two."""
    found = diagnosis_of(_line(seed, 12.5, 100.0, (10.0, 24.0)))
    assert found.verdict == "unknown"
    said = sentences(found)[0]
    assert "a line of 0.08 s (12.5 Hz)" in said
    assert "with a phase of its own in each run" in said


@pytest.mark.parametrize("hz", [0.05, pytest.param(0.4, marks=pytest.mark.large)])
@pytest.mark.parametrize("constant_s", [pytest.param(22.0, marks=pytest.mark.large), 90.0])
def test_an_oscillation_that_noise_drives_is_no_line(hz: float, constant_s: float) -> None:
    """The oscillation loses its phase within an eighth or a half of the longest run."""
    random = np.random.default_rng(10)
    rows = _clock(3.0, SPEEDS)
    shaken = driven_oscillator(random, rows[1], 1.0 / hz, np.pi * hz * constant_s)
    error = 3.5 * shaken + 0.7 * random.normal(size=shaken.size)
    assert line_of_runs(_solution(_set(error, *rows)), hz, 0.01) is None


@pytest.mark.parametrize("kind", ["white", "OU 30 s", "random walk"])
def test_noise_has_no_line_of_runs(kind: str) -> None:
    random = np.random.default_rng(11)
    rows = _clock(3.0, SPEEDS)
    solution = _solution(_set(NULLS[kind](random, rows[1]), *rows))
    assert line_of_runs(solution, 0.05, 0.01) is None


def test_a_line_with_one_phase_is_not_one_of_runs() -> None:
    """From noise alone, each of two further phases gains one on average; this is no line with a
    phase in each run."""
    random = np.random.default_rng(12)
    rows = _clock(4.0, SPEEDS)
    error = SIZE * np.cos(2.0 * np.pi * 0.4 * rows[1]) + NOISE * random.normal(size=rows[1].size)
    assert line_of_runs(_solution(_set(error, *rows)), 0.4, 0.01) is None


def test_an_order_at_two_speeds_is_not_a_line_of_runs() -> None:
    """Order 72 has 0.4 Hz in the runs at 2°/s, and 0.62 Hz in the run at 3.1°/s."""
    random = np.random.default_rng(13)
    rows = _clock(4.0, SPEEDS)
    error = SIZE * np.cos(72.0 * np.radians(rows[2]) + np.array([0.0, 2.0, 4.0])[rows[0]])
    error += NOISE * random.normal(size=rows[1].size)
    assert line_of_runs(_solution(_set(error, *rows)), 0.4, 0.01) is None
