"""Tests that the diagnosis reports a slow change of unknown form with its size and duration."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from arctrue.measurement import MeasurementSet, Reference, Table
from arctrue.workbench.diagnose.report import sentences
from arctrue.workbench.diagnose.report_json import diagnosis_data
from arctrue.workbench.diagnose.rules.leaves_more import leaves_a_larger_slow_change
from arctrue.workbench.effects.registry import built_in
from arctrue.workbench.inference.forward.slow import SlowChange
from tests.workbench.base_diagnosis import diagnosis_of


def _reference(error_arcsec: np.ndarray, step_s: float, turns: float) -> MeasurementSet:
    rows = error_arcsec.size
    reference = Reference(
        target_deg=np.mod(np.arange(rows) / rows * turns * 360.0, 360.0),
        error_arcsec=error_arcsec,
        time_s=np.arange(rows) * step_s,
        run=np.zeros(rows, dtype=np.int64),
    )
    return MeasurementSet(Table(), None, reference)


@pytest.mark.parametrize(
    ("rows", "turns"), [(144, 4.0), pytest.param(1500, 0.01, marks=pytest.mark.large)]
)
@pytest.mark.parametrize("periods", [1.6, 2.3])
def test_of_stations_and_of_a_log(rows: int, turns: float, periods: float) -> None:
    """The diagnosis reports an error that rises and falls by 3″ in 0.3″ of noise, in a set of
    stations and in a log; the search first removes a straight drift."""
    random = np.random.default_rng(3)
    share = np.arange(rows) / rows
    error = 1.5 * np.cos(2.0 * np.pi * periods * share) + 0.3 * random.normal(size=rows)
    found = diagnosis_of(_reference(error, 3.0, turns))
    slow = found.detections.slow
    assert slow is not None
    assert slow.length == pytest.approx(3.0 * (rows - 1))
    drift = np.polyval(np.polyfit(share, error, 1), share)
    # The size is smaller than the whole curve, and larger than half of the part that remains after
    # the removal of a straight line.
    assert 0.5 * float(np.ptp(error - drift)) < slow.size_arcsec < float(np.ptp(error))
    assert any(text.startswith("A slow change of unknown form") for text in sentences(found))
    assert diagnosis_data(found, [])["findings"]["slow_change"]["length_s"] == slow.length


@pytest.mark.parametrize("rows", [144, pytest.param(1500, marks=pytest.mark.large)])
def test_white_noise_has_none(rows: int) -> None:
    random = np.random.default_rng(4)
    error = random.normal(size=rows)
    assert diagnosis_of(_reference(error, 3.0, 4.0)).detections.slow is None


@pytest.mark.large
def test_a_chirp_is_not_silent() -> None:
    """The diagnosis reports a chirp of 1″, from 12 to 36 periods per hour in 0.3″ of noise, as
    unknown; the chirp is neither a steady sine nor noise of a known kind."""
    random = np.random.default_rng(5)
    time_s = np.arange(1500) * 2.4
    share = time_s / 3600.0
    error = np.cos(2.0 * np.pi * (12.0 + 12.0 * share) * share) + 0.3 * random.normal(size=1500)
    found = diagnosis_of(_reference(error, 2.4, 0.01))
    assert found.verdict == "unknown"
    assert found.detections.causes == ()


@pytest.mark.parametrize(
    ("name", "slow_arcsec", "refused"),
    [
        # A straight line with an RMS of 1″ has ends √12″ = 3.46″ apart.
        ("reference_drift", 3.6, True),
        ("reference_drift", 3.3, False),
        ("reference_drift", None, False),
        ("count_slip", 3.6, False),
        ("periodic_error", 3.6, False),
    ],
)
def test_a_drift_is_not_named_where_a_larger_slow_change_remains(
    name: str, slow_arcsec: float | None, refused: bool
) -> None:
    """In an earlier version, the error of a servo that wanders by 2.2° was named a drift of 1.3°
    over the record."""
    slow = None if slow_arcsec is None else SlowChange(slow_arcsec, 100.0)
    left = SimpleNamespace(survey=SimpleNamespace(detections=SimpleNamespace(slow=slow)))
    best = SimpleNamespace(effect=built_in()[name](), moved_arcsec={"reference": 1.0})
    case: Any = SimpleNamespace(best=best, with_best=left)
    found = leaves_a_larger_slow_change(case)
    assert (found is not None) is refused
    if found is not None:
        assert found.verdict == "unknown"
        assert found.resembles is best
