"""Tests that an error which follows a temperature through a lag is described with this lag, and
that a period of the temperature is no line of the machine."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from arctrue.measurement import MeasurementSet, Reference, Table
from arctrue.workbench.diagnose.diagnosis import Diagnosis
from arctrue.workbench.diagnose.report import diagnosis_data, sentences
from tests.workbench.base_diagnosis import diagnosis_of

LAG_S, ARCSEC_K = 240.0, 5.0
STATIONS, TURNS, STEP_S = 60, 8, 15.0


@cache
def _found(seed: int, lag_s: float) -> Diagnosis:
    """Return the diagnosis of 8 turns; the body's temperature is integrated in steps of 1 s."""
    random = np.random.default_rng(seed)
    time_s = STEP_S * np.arange(STATIONS * TURNS)
    every_s = np.arange(0.0, time_s[-1] + 1.0)

    def room(at_s: np.ndarray) -> np.ndarray:
        slow = 2.0 * np.sin(2.0 * np.pi * at_s / 3100.0)
        return np.asarray(20.0 + slow + 0.8 * np.sin(2.0 * np.pi * at_s / 1100.0 + 1.0))

    body = room(every_s)
    for second in range(1, body.size):
        if lag_s:
            body[second] = body[second - 1] + (room(every_s[second]) - body[second - 1]) / lag_s
    angle = 2.0 * np.pi * np.arange(time_s.size) / STATIONS
    error = 30.0 * np.cos(angle + 1.0) + 9.0 * np.cos(2.0 * angle)
    error += ARCSEC_K * (np.interp(time_s, every_s, body) - 20.0)
    reference = Reference(
        target_deg=np.degrees(angle),
        error_arcsec=error + random.normal(size=time_s.size),
        time_s=time_s,
        run=np.zeros(time_s.size, dtype=np.int64),
        temperature_c=np.round(room(time_s), 2),
    )
    return diagnosis_of(MeasurementSet(Table(), None, reference))


@pytest.mark.parametrize("seed", range(2))
def test_the_lag_and_the_size_are_stated(seed: int) -> None:
    """480 readings of 1″ give a size at ±1.4 K of about 0.05″/K and a lag of about 5 s."""
    found = _found(seed, LAG_S)
    assert found.verdict == "unknown"
    assert found.lag is not None
    assert found.lag.time_constant_s == pytest.approx(LAG_S, rel=0.1)
    assert found.lag.size == pytest.approx(ARCSEC_K, rel=0.05)
    said = " ".join(sentences(found))
    assert "with a lag of about 2" in said
    assert "periodic_error explains" not in said
    assert "slow change of unknown form" not in said
    assert diagnosis_data(found, [])["lag_s"] == found.lag.time_constant_s


def test_without_a_lag_none_is_stated() -> None:
    found = _found(3, 0.0)
    assert found.verdict == "unknown"
    assert found.lag is None
    assert "4.9″/K" in " ".join(sentences(found))
