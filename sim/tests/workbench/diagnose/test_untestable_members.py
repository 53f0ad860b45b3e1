"""Tests that a class has the effects that a set cannot test and that would look the same."""

from __future__ import annotations

import numpy as np
import pytest

from arctrue.measurement import MeasurementSet, Reference, Table
from tests.workbench.base_diagnosis import diagnosis_of

NOISE, DEG_S, HALF = 0.8, 24.0, 6.0


def _one_speed(seed: int, step_deg: float, *, times: bool = True) -> MeasurementSet:
    """Return whole turns on the move at one speed, three in each direction, with ±HALF by
    direction; rows every ``step_deg``."""
    random = np.random.default_rng(seed)
    rows = round(360.0 / step_deg)
    pieces, start_s, start_deg = [], 0.0, 0.0
    for number in range(6):
        sign = 1.0 if number % 2 == 0 else -1.0
        way = step_deg * np.arange(rows)
        pieces.append(
            np.column_stack([
                np.full(rows, number), start_s + way / DEG_S, start_deg + sign * way,
                np.full(rows, sign),
            ])
        )  # fmt: skip
        start_s += float(way[-1]) / DEG_S + 3.1
        start_deg += sign * float(way[-1])
    run, time_s, target, direction = np.vstack(pieces).T
    angle = np.radians(target)
    error = 8.0 * np.cos(angle + 0.3) + 3.0 * np.cos(2.0 * angle) + HALF * direction
    reference = Reference(
        target,
        error + random.normal(0.0, NOISE, run.size),
        run=run.astype(np.int64),
        time_s=time_s if times else None,
        direction=direction,
    )
    return MeasurementSet(Table(), None, reference)


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_a_reversal_error_at_one_speed_may_be_a_delay(seed: int) -> None:
    """Rows 1.2° and 0.05 s apart: no servo stops at each. A delay of 69 µs causes the same ±6″."""
    found = diagnosis_of(_one_speed(seed, 1.2))
    assert found.verdict == "ambiguous"
    assert found.decision.effect_class == ["hysteresis", "latency"]
    assert found.decision.look_alikes == {"latency": ["a reference run at more than one speed"]}
    assert found.next_measurement is not None
    assert "more than one speed" in found.next_measurement
