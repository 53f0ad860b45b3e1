"""Tests that an error which follows a temperature through a lag is described with this lag, and
that a period of the temperature is no line of the machine."""

from __future__ import annotations

from functools import cache
from typing import Any, cast

import numpy as np
import pytest
from numpy.typing import NDArray

from arctrue.measurement import MeasurementSet, Reference, Table
from arctrue.workbench.diagnose.candidate import Candidate
from arctrue.workbench.diagnose.diagnosis import Diagnosis
from arctrue.workbench.diagnose.lag import Lag, lag_of
from arctrue.workbench.diagnose.report import sentences
from arctrue.workbench.diagnose.report_json import diagnosis_data
from arctrue.workbench.effects.first_order_lag import behind
from arctrue.workbench.effects.product_of_parts import ProductOfParts
from arctrue.workbench.effects.registry import built_in
from arctrue.workbench.inference.design_matrix import Term
from arctrue.workbench.inference.fit import fit
from arctrue.workbench.observations.build import observations_of
from tests.workbench.base_diagnosis import diagnosis_of

Float = NDArray[np.float64]
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


class _Described:
    """A stand-in for a candidate whose effect is the product of a recorded column alone."""

    effect = ProductOfParts(column="room_degC", column_zero=0.0, fixed_to="reference", orders=[])


def _lag(recorded: Float, error: Float, time_s: Float) -> Lag | None:
    """Return the lag behind a recorded column, with the places of a table in the model."""
    angle = 2.0 * np.pi * np.arange(time_s.size) / STATIONS
    reference = Reference(
        target_deg=np.degrees(angle),
        error_arcsec=error + 3.0 * np.cos(angle),
        time_s=time_s,
        run=np.zeros(time_s.size, dtype=np.int64),
        conditions={"room_degC": recorded},
    )
    base = [Term(built_in()["graduation_harmonics"](orders=[1, 2]), {})]
    solution = fit(base, observations_of(MeasurementSet(Table(), None, reference)))
    return lag_of(cast(Candidate, cast(Any, _Described())), solution)


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("share", [0.05, 0.1, 0.2])
def test_a_noisy_or_coarse_column_is_no_lag(share: float, seed: int) -> None:
    """The error follows the true temperature at once; the column has white noise, or display steps,
    of a share of the amplitude."""
    random = np.random.default_rng(seed)
    time_s = 10.0 * np.arange(2000)
    true = np.sin(2.0 * np.pi * time_s / 5000.0)
    noisy = true + share * random.normal(size=time_s.size)
    error = 10.0 * true + 2.0 * share * random.normal(size=time_s.size)
    assert _lag(noisy, error, time_s) is None
    assert _lag(share * np.round(true / share), error, time_s) is None


def test_a_lag_is_found_behind_a_noisy_column() -> None:
    """The bound is that of the clean column, 10 %; the steps of 10 s are far below the lag."""
    random = np.random.default_rng(5)
    time_s = 10.0 * np.arange(2000)
    true = np.sin(2.0 * np.pi * time_s / 5000.0)
    error = 10.0 * behind(true, time_s, 500.0) + 0.2 * random.normal(size=time_s.size)
    found = _lag(true + 0.05 * random.normal(size=time_s.size), error, time_s)
    assert found is not None
    assert found.time_constant_s == pytest.approx(500.0, rel=0.1)


@pytest.mark.large
def test_a_long_record_is_averaged() -> None:
    """The search averages 150,000 rows to 20,000; an averaged row covers 1/400 of the lag."""
    random = np.random.default_rng(6)
    time_s = np.arange(150_000.0)
    true = np.sin(2.0 * np.pi * time_s / 37_000.0)
    error = 10.0 * behind(true, time_s, 3000.0) + 0.5 * random.normal(size=time_s.size)
    found = _lag(true, error, time_s)
    assert found is not None
    assert found.time_constant_s == pytest.approx(3000.0, rel=0.02)
