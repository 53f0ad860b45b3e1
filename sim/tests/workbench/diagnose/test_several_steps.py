"""Tests that the diagnosis finds several steps of one record: lost counts of an encoder, and jumps
at equal intervals. The sets are computed from the definitions, with plain numpy."""

from __future__ import annotations

import numpy as np
import pytest

from arctrue.measurement import MeasurementSet, Reference, Table
from arctrue.workbench.diagnose.diagnosis import Diagnosis
from arctrue.workbench.diagnose.jumps import Jump, interval_s, whole_counts
from arctrue.workbench.diagnose.report import sentences
from arctrue.workbench.inference.forward.events import search_steps
from arctrue.workbench.inference.forward.noise_of_record import noise_with
from arctrue.workbench.inference.forward.record import record_of
from arctrue.workbench.noise import kernel_fit
from arctrue.workbench.noise.kernel import KernelNoise
from tests.workbench.base_diagnosis import diagnosis_of
from tests.workbench.noisy_logs import NULLS

WITHIN_U = 4.0
"""Accepted deviation of a size in standard uncertainties; a normal value exceeds it with a
probability of 6·10⁻⁵."""
COUNT_ARCSEC = 1_296_000.0 / 16_384.0
SLIPS_S = (9.0, 22.0, 31.0)
DITHER_S, DITHERS = 300.0, 8


def _autoregressive(random: np.random.Generator, rows: int, memory: float) -> np.ndarray:
    """Return noise of standard deviation 1 whose correlation falls to 1/e in ``memory`` rows."""
    kept = np.exp(-1.0 / memory)
    found = random.normal(size=rows)
    for row in range(1, rows):
        found[row] = kept * found[row - 1] + np.sqrt(1.0 - kept**2) * found[row]
    return found


@pytest.fixture(scope="module")
def slips() -> Diagnosis:
    """Five turns in 40 s against an encoder with 16,384 counts, which loses one count at each of
    three instants; the noise of 10″ is coloured."""
    random = np.random.default_rng(21)
    time_s = 0.025 * np.arange(1600)
    target_deg = 45.0 * time_s
    angle = np.radians(target_deg)
    error = 100.0 * np.cos(angle + 0.4) + 20.0 * np.cos(2.0 * angle) + 10.0 * np.cos(3.0 * angle)
    error += 10.0 * _autoregressive(random, time_s.size, 3.0)
    for instant_s in SLIPS_S:
        error += COUNT_ARCSEC * (time_s > instant_s)
    reference = Reference(target_deg, error, time_s=time_s, direction=np.ones(time_s.size))
    return diagnosis_of(MeasurementSet(Table(counts_per_rev=16_384), reference=reference))


def test_three_lost_counts_are_three_jumps(slips: Diagnosis) -> None:
    """Each lost count is a jump with its instant and size. Its first row is not masked."""
    assert slips.verdict == "unknown"
    steps = sorted(slips.detections.steps, key=lambda step: step.time_s or 0.0)
    assert [step.time_s for step in steps] == pytest.approx(SLIPS_S, abs=0.05)
    for step in steps:
        assert abs(step.size_arcsec - COUNT_ARCSEC) < WITHIN_U * step.sigma_arcsec
    masked = [item.row - 2 for item in slips.observations.masked]
    assert not set(masked) & {round(at / 0.025) + 1 for at in SLIPS_S}
    assert slips.detections.slow is None


def test_whole_counts_are_stated(slips: Diagnosis) -> None:
    said = " ".join(sentences(slips))
    assert "something jumped 3 times" in said
    assert "each by a whole number of counts (1, 1, 1; a count is 79.1″)" in said
    assert "count_slip would look the same and cannot be tested" in said


def test_jumps_at_equal_intervals() -> None:
    """A guide star log whose dithers were not removed: eight jumps, 300 s apart, in white noise of
    0.7″."""
    random = np.random.default_rng(22)
    time_s = 3.0 * np.arange(800)
    sizes = np.array([4.1, -6.5, 2.9, 7.0, -3.2, -5.0, 2.2, 3.7])
    instants = 150.0 + DITHER_S * np.arange(DITHERS)
    error = 0.7 * random.normal(size=time_s.size)
    error += (time_s[:, np.newaxis] >= instants) @ sizes
    reference = Reference(time_s * (360.0 / 86_164.1), error, time_s=time_s)
    found = diagnosis_of(MeasurementSet(Table(), reference=reference))
    assert found.verdict == "unknown"
    steps = sorted(found.detections.steps, key=lambda step: step.time_s or 0.0)
    assert [step.time_s for step in steps] == pytest.approx(instants.tolist(), abs=3.0)
    for step, size in zip(steps, sizes, strict=True):
        assert abs(step.size_arcsec - size) < WITHIN_U * step.sigma_arcsec
    said = " ".join(sentences(found))
    assert "something jumped 8 times at equal intervals of 300 s, farthest at 1050 s by " in said
    assert "slow change" not in said


def test_thirty_jumps_are_many_jumps() -> None:
    """Thirty jumps of 10 σ with both signs, at random instants at least 25 rows apart: the verdict
    states a number, the first instants and no slow change. Every jump is found at its row."""
    random = np.random.default_rng(1)
    time_s = 3.0 * np.arange(1500)
    rows = 25 * np.sort(random.choice(np.arange(1, 60), 30, replace=False))
    error = 0.7 * random.normal(size=time_s.size)
    error += (np.arange(1500)[:, np.newaxis] >= rows) @ random.choice([-7.0, 7.0], 30)
    reference = Reference(time_s * (360.0 / 86_164.1), error, time_s=time_s)
    found = diagnosis_of(MeasurementSet(Table(), reference=reference))
    assert found.verdict == "unknown"
    steps = sorted(found.detections.steps, key=lambda step: step.time_s or 0.0)
    assert [step.time_s for step in steps] == pytest.approx((3.0 * rows).tolist(), abs=3.0)
    for step in steps:
        assert abs(abs(step.size_arcsec) - 7.0) < WITHIN_U * step.sigma_arcsec
    said = " ".join(sentences(found))
    assert "something jumped at least 30 times, first at 150 s, 375 s, 450 s;" in said
    assert "The record contains at least 30 jumps" in said
    assert "slow change" not in said


@pytest.mark.parametrize("kind", ["random walk", "walk, t with 2 degrees", "white, heavy tails"])
def test_noise_has_no_steps(kind: str) -> None:
    """Three logs of noise alone contain no step. The search may find one in 1 % of the logs, so
    that one of the nine logs has a step with a probability of 9 %; the seeds are fixed."""
    for number in range(3):
        random = np.random.default_rng((5, number))
        time_s = 3.0 * np.arange(400)
        error = NULLS[kind](random, time_s)
        one, none = np.zeros(time_s.size, dtype=np.int64), np.zeros((time_s.size, 0))
        record = record_of(time_s, time_s, one, error, none, in_time=True)
        assert search_steps(record, none, noise_with(record, none)) == []


def test_each_fit_of_the_noise_is_made_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """No fit of the noise begins a second time at the same start for the same rows and columns,
    except the two usual starts without the last step: the search began there before it found this
    step."""
    random = np.random.default_rng(23)
    time_s = 3.0 * np.arange(400)
    error = random.normal(size=time_s.size)
    error += 20.0 * (time_s[:, np.newaxis] >= [301.0, 601.0, 901.0]).sum(axis=1)
    one, none = np.zeros(time_s.size, dtype=np.int64), np.zeros((time_s.size, 0))
    record = record_of(time_s, time_s, one, error, none, in_time=True)
    noise = noise_with(record, none)
    fitted = kernel_fit.fit_from
    made: list[tuple[bytes, bytes]] = []

    def counted(rows: kernel_fit.Rows, start: KernelNoise) -> kernel_fit.KernelFit:
        made.append((rows.values.tobytes(), start.logs.tobytes()))
        return fitted(rows, start)

    monkeypatch.setattr(kernel_fit, "fit_from", counted)
    assert len(search_steps(record, none, noise)) == 3
    assert len(made) - len(set(made)) <= 2


def _jumps(times_s: list[float], counts: list[float], sigma_counts: float) -> list[Jump]:
    return [
        Jump(size * COUNT_ARCSEC, sigma_counts * COUNT_ARCSEC, at, None, None, 50.0)
        for at, size in zip(times_s, counts, strict=True)
    ]


@pytest.mark.parametrize(
    ("counts", "sigma", "expected"),
    [
        ([1.02, -2.03], 0.02, [1, -2]),
        ([1.02, -2.09], 0.02, []),  # 4.5 standard uncertainties from −2
        ([1.02], 0.02, []),  # 12 % of all sizes are as near to a whole number
        ([1.001], 0.005, [1]),
        ([0.01, 1.0], 0.02, []),
    ],
)
def test_whole_numbers_of_counts(counts: list[float], sigma: float, expected: list[int]) -> None:
    jumps = _jumps([10.0 * at for at in range(len(counts))], counts, sigma)
    assert whole_counts(jumps, COUNT_ARCSEC) == expected
    assert whole_counts(jumps, None) == []


@pytest.mark.parametrize(
    ("times_s", "expected"),
    [
        ([100.0, 203.0, 301.0, 402.0], 101.0),
        ([100.0, 200.0, 300.0], None),
        ([100.0, 200.0, 320.0, 420.0], None),
    ],
)
def test_equal_intervals(times_s: list[float], expected: float | None) -> None:
    assert interval_s(_jumps(times_s, [1.0] * len(times_s), 0.1)) == expected
