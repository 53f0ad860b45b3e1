"""Tests that the diagnosis finds two lines next to each other, and describes a line that only a
part of a log has; an oscillation that noise drives is neither."""

from __future__ import annotations

import numpy as np
import pytest

from arctrue.measurement import MeasurementSet, Reference, Table
from arctrue.workbench.diagnose.report import sentences
from arctrue.workbench.diagnose.report_json import diagnosis_data
from arctrue.workbench.inference.forward.oscillation import oscillation_of
from arctrue.workbench.inference.forward.record import Record, record_of
from arctrue.workbench.inference.forward.search import search_lines
from tests.workbench.base_diagnosis import diagnosis_of
from tests.workbench.noisy_logs import driven_oscillator, ornstein_uhlenbeck

NEAR_S = (181.0, 169.0)
"""Periods whose sum beats 3.5 times in 9,000 s."""
PART_S, BEGINS_S = 150.0, 3000.0


def _near(seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Return times and errors of a log with lines of 4″ and 3″."""
    random = np.random.default_rng(seed)
    time_s = np.cumsum(random.uniform(5.0, 7.0, 1500))
    error = 0.8 * ornstein_uhlenbeck(random, time_s, 8.0) + 0.3 * random.normal(size=time_s.size)
    for size, period_s in zip((4.0, 3.0), NEAR_S, strict=True):
        error += size * np.cos(2.0 * np.pi * time_s / period_s + random.uniform(0.0, 6.0))
    return time_s, error


def _part(seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Return times and errors of a log of 6,000 s with a line of 4″ in its second half."""
    random = np.random.default_rng(seed)
    time_s = np.cumsum(random.uniform(3.0, 5.0, 1500))
    error = 0.8 * ornstein_uhlenbeck(random, time_s, 6.0) + 0.3 * random.normal(size=time_s.size)
    line = 4.0 * np.cos(2.0 * np.pi * time_s / PART_S + random.uniform(0.0, 6.0))
    return time_s, error + np.where(time_s > BEGINS_S, line, 0.0)


def _record(time_s: np.ndarray, error_arcsec: np.ndarray) -> Record:
    one = np.zeros(time_s.size, dtype=np.int64)
    none = np.zeros((time_s.size, 0))
    return record_of(time_s, time_s, one, error_arcsec, none, in_time=True)


@pytest.mark.parametrize("seed", range(3))
def test_two_lines_next_to_each_other(seed: int) -> None:
    """Each line alone gains less over an oscillator than the limit; both are found, and no
    oscillation remains. The bound of 1 s of a period corresponds to 1/(4·span) of the rate, far
    above its uncertainty."""
    found = search_lines(_record(*_near(seed)))
    assert [1.0 / line.rate for line in found.lines] == pytest.approx(NEAR_S, abs=1.0)
    assert [line.amplitude_arcsec for line in found.lines] == pytest.approx([4.0, 3.0], abs=0.3)
    assert oscillation_of(found, "reference") is None


@pytest.mark.parametrize("seed", range(3))
def test_a_line_in_a_part_of_the_log(seed: int) -> None:
    """The description states when the line is present; an edge is known to some rows (of 4 s), the
    amplitude to √(2/750) of the noise of 0.85″."""
    time_s, error = _part(seed)
    found = oscillation_of(search_lines(_record(time_s, error)), "reference")
    assert found is not None
    assert found.present_s == pytest.approx((BEGINS_S, time_s[-1]), abs=25.0)
    assert 1.0 / found.hz == pytest.approx(PART_S, abs=1.0)
    assert found.amplitude_arcsec == pytest.approx(4.0, abs=0.3)
    assert found.rms_arcsec == pytest.approx(4.0 / 2.0, rel=0.1)


def test_the_words_state_the_part() -> None:
    """The words state from when on the line is present; at one speed this may be a time or an
    angle."""
    time_s, error = _part(0)
    reference = Reference(
        target_deg=time_s * 360.0 / 86_164.1,
        error_arcsec=error,
        time_s=time_s,
        run=np.zeros(time_s.size, dtype=np.int64),
    )
    found = diagnosis_of(MeasurementSet(Table(), None, reference))
    assert found.verdict == "unknown"
    said = sentences(found)[0]
    assert "which is present only from 300" in said
    assert "noise-driven" not in " ".join(sentences(found))
    assert diagnosis_data(found, [])["findings"]["oscillation"]["present_s"] is not None


@pytest.mark.parametrize("seed", range(2))
def test_an_oscillation_that_noise_drives(seed: int) -> None:
    """A resonance that keeps its phase for a twelfth of the log is neither two lines nor a line in
    a part."""
    random = np.random.default_rng(seed)
    time_s = np.cumsum(random.uniform(2.0, 4.0, 1200))
    shaken = driven_oscillator(random, time_s, 90.0, np.pi * 300.0 / 90.0)
    found = search_lines(_record(time_s, shaken + 0.2 * random.normal(size=time_s.size)))
    assert not found.lines
    oscillation = oscillation_of(found, "reference")
    assert oscillation is not None
    assert oscillation.present_s is None
