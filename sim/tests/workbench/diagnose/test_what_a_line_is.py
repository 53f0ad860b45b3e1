"""Tests what the text of a diagnosis says about lines: the signal period of the grating, a line
fixed to time, and an order whose size follows the speed."""

from __future__ import annotations

import numpy as np
import pytest

from arctrue.measurement import MeasurementSet, Reference, Table
from arctrue.workbench.diagnose.diagnosis import Diagnosis
from arctrue.workbench.diagnose.report import sentences
from tests.workbench.base_diagnosis import diagnosis_of
from tests.workbench.noisy_logs import ornstein_uhlenbeck

OF_THE_ANGLE = "stator slots"
"""A cause that is fixed to the angle."""


def _spun(
    speeds_deg_s: list[float], turns: float, rows: int
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Return run, time, angle in degrees and speed of each row of runs at steady speeds, sampled at
    even steps; each run begins where the one before ended, after two seconds."""
    run, time_s, angle, speed = [], [], [], []
    now = place = 0.0
    for number, one in enumerate(speeds_deg_s):
        own = np.arange(rows) * (360.0 * turns / one / rows)
        run.append(np.full(rows, number))
        time_s.append(now + own)
        angle.append(place + one * own)
        speed.append(np.full(rows, one))
        now, place = now + 360.0 * turns / one + 2.0, place + 360.0 * turns
    return (np.concatenate(run), *(np.concatenate(one) for one in (time_s, angle, speed)))


def _diagnosed(
    run: np.ndarray,
    time_s: np.ndarray,
    angle: np.ndarray,
    error: np.ndarray,
    table: Table | None = None,
) -> Diagnosis:
    theta = np.radians(angle)
    own = 20.0 * np.cos(theta + 1.0) + 6.0 * np.cos(2.0 * theta)
    reference = Reference(target_deg=angle, error_arcsec=error + own, time_s=time_s, run=run)
    return diagnosis_of(MeasurementSet(table or Table(), None, reference))


@pytest.mark.large
def test_a_line_of_the_signal_period_is_said_to_be_of_the_grating() -> None:
    """The grating has 256 lines; the subdivision has errors of 12″ and 4″ in the first and second
    harmonic of the signal. The search for lines averages the rows, so that it does not reach order
    512."""
    random = np.random.default_rng(31)
    run, time_s, angle, _ = _spun([36.0], 1.5, 2400)
    theta = np.radians(angle)
    error = 12.0 * np.cos(256.0 * theta + 1.0) + 4.0 * np.cos(512.0 * theta + 2.0)
    error += 2.0 * random.normal(size=angle.size)
    found = _diagnosed(run, time_s, angle, error, Table(grating_lines=256))
    assert found.named is not None
    assert found.named.name == "periodic_error"
    assert found.signal_period is not None
    assert found.signal_period.multiple == 1
    assert set(found.signal_period.further) == {2}
    # The amplitude's standard uncertainty is 2″·√(2/2400) = 0.06″.
    assert found.signal_period.further[2].value == pytest.approx(4.0, abs=0.25)
    said = " ".join(sentences(found))
    assert "order is the number of grating lines" in said
    assert "order 512" in said
    assert OF_THE_ANGLE not in said
    assert found.next_measurement is not None
    assert "head1_counts" in found.next_measurement


@pytest.mark.large
def test_a_line_near_the_signal_period_is_not_of_the_grating() -> None:
    """Order 255 is 1.5 periods away from order 256 in a log of 1.5 turns, which separates them."""
    random = np.random.default_rng(32)
    run, time_s, angle, _ = _spun([36.0], 1.5, 2400)
    error = 12.0 * np.cos(255.0 * np.radians(angle)) + 2.0 * random.normal(size=angle.size)
    found = _diagnosed(run, time_s, angle, error, Table(grating_lines=256))
    assert found.named is not None
    assert found.signal_period is None
    assert OF_THE_ANGLE in " ".join(sentences(found))


def test_a_line_fixed_to_time_has_no_lane_and_no_cause_of_the_angle() -> None:
    """A building sways with 2.7 Hz and 5″ while a table turns at three speeds."""
    random = np.random.default_rng(33)
    run, time_s, angle, _ = _spun([60.0, 97.0, 150.0], 5.0, 1000)
    error = 5.0 * np.cos(2.0 * np.pi * 2.7 * time_s + 1.0) + 2.0 * random.normal(size=angle.size)
    found = _diagnosed(run, time_s, angle, error)
    assert found.named is not None
    assert found.named.nonlinear["frequency"] == pytest.approx(2.7, rel=0.001)
    said = " ".join(sentences(found))
    assert "The gateware cannot compensate it: a line fixed to time has no order" in said
    assert OF_THE_ANGLE not in said
    # The report states the size, which has an uncertainty of 2″·√(2/3000) = 0.05″.
    assert "amplitude 5." in said or "amplitude 4." in said


@pytest.mark.large
def test_an_order_that_follows_the_speed_has_no_side_lines() -> None:
    """Order 3 grows with the square of the speed. Over all runs it looks like two lines, one on
    each side of order 3, which are no errors of their own; another station would show nothing."""
    random = np.random.default_rng(34)
    run, time_s, angle, speed = _spun([60.0, 120.0, 240.0, 360.0], 3.0, 600)
    error = 12.0 * (speed / 360.0) ** 2 * np.cos(3.0 * np.radians(angle) + 1.0)
    error += 1.5 * ornstein_uhlenbeck(random, np.arange(angle.size, dtype=np.float64), 3.0)
    found = _diagnosed(run, time_s, angle, error)
    assert found.described is not None
    assert "speed^2" in found.described.effect.parts
    assert found.detections.causes == ()
    assert found.next_measurement is not None
    assert "further speeds" in found.next_measurement
