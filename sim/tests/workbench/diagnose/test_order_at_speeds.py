"""Tests that an order whose size grows with the speed is no line fixed to time, and that a line
fixed to time stays one next to such an order."""

from __future__ import annotations

import numpy as np
import pytest

from arctrue.measurement import MeasurementSet, Reference, Table
from arctrue.workbench.diagnose.report import sentences
from tests.workbench.base_diagnosis import diagnosis_of

SPEEDS_DEG_S = (90.0, 200.0, 400.0, 700.0)
ROWS_A_SECOND, NOISE = 60.0, 8.0


def _resolver(seed: int, line_hz: float = 0.0, line_arcsec: float = 0.0) -> MeasurementSet:
    """Return two turns up and down at each speed, with 10″ + 0.1″·|ω|/(°/s) of order 2, and a line
    fixed to time."""
    random = np.random.default_rng(seed)
    pieces, start_s, start_deg = [], 0.0, 0.0
    speeds = [sign * speed for speed in SPEEDS_DEG_S for sign in (1.0, -1.0)]
    for number, speed in enumerate(speeds):
        since = np.arange(int(720.0 / abs(speed) * ROWS_A_SECOND)) / ROWS_A_SECOND
        pieces.append(
            np.column_stack([
                np.full(since.size, number), start_s + since, start_deg + speed * since,
                np.full(since.size, speed),
            ])
        )  # fmt: skip
        start_s += float(since[-1]) + 3.1
        start_deg += speed * float(since[-1])
    run, time_s, target, speed = np.vstack(pieces).T
    angle = np.radians(target)
    error = 20.0 * np.cos(angle) + (10.0 + 0.1 * np.abs(speed)) * np.cos(2.0 * angle - 0.7)
    error += line_arcsec * np.cos(2.0 * np.pi * line_hz * time_s + 1.0)
    reference = Reference(
        target,
        error + random.normal(0.0, NOISE, run.size),
        run=run.astype(np.int64),
        time_s=time_s,
        direction=np.sign(speed),
    )
    return MeasurementSet(Table(), None, reference)


@pytest.mark.parametrize(
    "seed", [1, pytest.param(2, marks=pytest.mark.large), pytest.param(3, marks=pytest.mark.large)]
)
def test_an_order_that_grows_with_the_speed_is_not_fixed_to_time(seed: int) -> None:
    """Most rows are at 90°/s, where order 2 has 0.5 Hz."""
    found = diagnosis_of(_resolver(seed))
    assert found.verdict == "unknown"
    assert found.described is not None
    assert set(found.described.effect.parts) == {"speed", "order:2", "reference"}
    # 0.1″/(°/s) are 5.73″/(rad/s). Each speed has the standard uncertainty 8″·√(2/rows), 3″ at
    # 700°/s with 120 rows, so that the slope has 0.004″/(°/s) or 0.2″/(rad/s).
    assert found.described.parameters()["amplitude"].value == pytest.approx(5.73, abs=0.6)
    said = " ".join(sentences(found))
    assert "|speed| × order 2" in said
    assert "fixed to time" not in said


@pytest.mark.large
def test_a_line_fixed_to_time_remains_next_to_an_order_that_grows() -> None:
    found = diagnosis_of(_resolver(1, line_hz=0.7, line_arcsec=25.0))
    said = " ".join(sentences(found))
    assert found.named is None or found.named.nonlinear["frequency"] == pytest.approx(0.7, rel=0.01)
    assert "Hz (1.428" in said
    assert "fixed to time" in said
