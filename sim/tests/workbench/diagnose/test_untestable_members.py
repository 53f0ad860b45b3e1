"""Tests that a class has the effects that a set cannot test and that would look the same."""

from __future__ import annotations

import numpy as np
import pytest

from arctrue.measurement import Capture, MeasurementSet, Reference, Table
from tests.workbench.base_diagnosis import diagnosis_of

ARCSEC = np.radians(1.0 / 3600.0)
COUNTS, ALPHA_DEG = 1 << 24, 33.0
NOISE, DEG_S, HALF = 0.8, 24.0, 6.0


def _one_speed(seed: int, step_deg: float, *, directed: bool = True) -> MeasurementSet:
    """Return whole turns on the move at one speed, three in each direction, with ±HALF by
    direction; rows every ``step_deg``. ``directed``: the set has the column direction."""
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
        time_s=time_s,
        direction=direction if directed else None,
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


def test_offsets_that_follow_the_motion_are_stated_without_the_column_direction() -> None:
    found = diagnosis_of(_one_speed(1, 1.2, directed=False))
    assert found.named is None
    said = " ".join(found.detections.sentences())
    # The mean of 300 readings of 0.8″ has u = 0.05″.
    assert "follows the direction: ±(6″) at 24°/s up and down" in said
    assert "its own zero" not in said


def _interpolated(lines: int, *, known: bool) -> MeasurementSet:
    """Return a capture of three runs of two turns, in which each head has an error of its own once
    per signal period, 0.6″ and 0.4″; ``known``: the set states the number of lines."""
    random = np.random.default_rng(1)
    columns = []
    start_s = 0.0
    for number, speed in enumerate((1.0, -1.0, 1.5)):
        angle = 0.3 * number + np.sign(speed) * np.arange(8000) * np.pi / 2000.0
        heads = []
        for place_deg, size, phase in ((0.0, 0.6, 0.3), (ALPHA_DEG, 0.4, 1.9)):
            disc = angle + np.radians(place_deg)
            disc = disc + ARCSEC * (2.5 * np.cos(disc + 0.4) + np.cos(3.0 * disc))
            disc += ARCSEC * (size * np.cos(lines * disc + phase) + 0.15 * random.normal(size=8000))
            heads.append(np.round(disc / (2.0 * np.pi) * COUNTS))
        times = start_s + np.abs(angle - angle[0]) / abs(speed)
        start_s = float(times[-1]) + 5.0
        columns.append(np.column_stack([np.full(8000, number), times, *heads]))
    run, time_s, head1, head2 = np.vstack(columns).T
    capture = Capture(run.astype(np.int64), time_s, head1.astype(np.int64), head2.astype(np.int64))
    stated = lines if known else None
    table = Table(counts_per_rev=COUNTS, head_separation_deg=ALPHA_DEG, grating_lines=stated)
    return MeasurementSet(table, capture, None)


@pytest.mark.parametrize("known", [False, pytest.param(True, marks=pytest.mark.large)])
def test_an_order_that_may_be_the_lines_is_no_sure_order_of_the_disc(known: bool) -> None:
    """R₂ − R₁ has one wave of order 1,024, of the disc or of the signals of 1,024 lines."""
    found = diagnosis_of(_interpolated(1024, known=known))
    assert found.verdict == "ambiguous"
    assert set(found.decision.effect_class) == {"high_order_graduation", "subdivision_error"}
    if not known:
        assert found.decision.look_alikes == {"subdivision_error": ["the key table.grating_lines"]}


@pytest.mark.large
def test_an_order_that_cannot_be_the_lines_keeps_its_name() -> None:
    """2²⁴ counts are no multiple of 500, 250 or 125 lines."""
    found = diagnosis_of(_interpolated(500, known=False))
    assert found.named is not None
    assert found.named.name == "high_order_graduation"
