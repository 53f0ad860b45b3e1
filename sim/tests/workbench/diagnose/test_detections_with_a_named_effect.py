"""Tests that the diagnosis lists a detection only if it remains when the named effect is in the
model.

The set is computed from the geometry: a rotary reference at 360 stations shows an error with the
signal period (16,384 lines). At these stations, k · 16,384 periods per turn look like the smallest
order |k · 16,384 − 360 m| with an integer m: 176 for k = 1.
"""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from sim.tests.workbench.base_diagnosis import diagnosis_of
from sim.tests.workbench.small_sets import ALPHA, ARCSEC, COUNTS_PER_REV, LINES

from arctrue.measurement import Capture, MeasurementSet, Reference, Table
from arctrue.workbench.diagnose.diagnosis import Diagnosis, diagnose
from arctrue.workbench.diagnose.report import sentences
from arctrue.workbench.diagnose.report_json import diagnosis_data
from arctrue.workbench.effects.registry import built_in
from arctrue.workbench.model.model import default_model
from arctrue.workbench.observations.build import observations_of

TURN_S = 0.196
SAMPLES_A_TURN, TURNS, STATIONS = 3000, 2, 360
NOISE_ARCSEC = 0.1
FIRST_ARCSEC, SECOND_ARCSEC = 0.6, 0.2
ALIAS = 176


@cache
def _found(belt_arcsec: float = 0.0) -> Diagnosis:
    return diagnosis_of(_set(belt_arcsec))


def _set(belt_arcsec: float) -> MeasurementSet:
    """Return a set with one run of two turns; ``belt_arcsec`` is the amplitude of a sine of order
    61.3 in the reference."""
    random = np.random.default_rng(1)

    def reading(disc: np.ndarray, phase: float) -> np.ndarray:
        value = disc + ARCSEC * (90.0 * np.cos(disc + 0.4) + 0.8 * np.cos(3 * disc - 2.0))
        first = FIRST_ARCSEC * np.cos(LINES * value + phase)
        second = SECOND_ARCSEC * np.cos(2 * LINES * value + 1.0)
        noise = random.normal(0.0, NOISE_ARCSEC, disc.size)
        return np.asarray(value + ARCSEC * (first + second + noise))

    size = SAMPLES_A_TURN * TURNS
    angle = 0.01 + np.arange(size) * 2.0 * np.pi / SAMPLES_A_TURN
    heads = [
        np.floor(reading(angle + offset, phase) / (2.0 * np.pi) * COUNTS_PER_REV).astype(np.int64)
        for offset, phase in ((0.0, 0.3), (ALPHA, 1.1))
    ]
    capture = Capture(
        run=np.zeros(size, dtype=np.int64),
        time_s=np.arange(size) * TURN_S / SAMPLES_A_TURN,
        head1_counts=heads[0],
        head2_counts=heads[1],
        temperature_c=np.full(size, 20.0),
    )
    target = np.arange(STATIONS) * 2.0 * np.pi / STATIONS
    counts = np.floor(reading(target, 0.3) / (2.0 * np.pi) * COUNTS_PER_REV).astype(np.int64)
    error = (counts * 2.0 * np.pi / COUNTS_PER_REV - target) / ARCSEC
    belt = belt_arcsec * np.cos(61.3 * target)
    reference = Reference(
        target_deg=np.degrees(target),
        error_arcsec=error + belt + random.normal(0.0, NOISE_ARCSEC, STATIONS),
        run=np.zeros(STATIONS, dtype=np.int64),
        time_s=TURN_S + target / (2.0 * np.pi) * TURN_S,
        cycle=np.zeros(STATIONS, dtype=np.int64),
        direction=np.ones(STATIONS, dtype=np.int64),
        head1_counts=counts,
        temperature_c=np.full(STATIONS, 20.0),
        instrument="rotary reference",
        standard_uncertainty_arcsec=NOISE_ARCSEC,
    )
    table = Table(counts_per_rev=COUNTS_PER_REV, grating_lines=LINES, head_separation_deg=33.0)
    return MeasurementSet(table, capture, reference, "alias")


def test_an_alias_of_the_named_effect_is_no_finding_of_its_own() -> None:
    found = _found()
    assert [found.verdict, *found.effect_class] == ["named", "subdivision_error"]
    detections = found.detections
    assert detections.oscillation is None
    assert detections.causes == ()
    assert detections.steps == ()
    assert found.further == []
    words = " ".join(sentences(found))
    assert "explains a further part" not in words
    assert "an error remains" not in words


def test_the_alias_is_stated_to_be_the_named_effect() -> None:
    found = _found()
    seen = diagnosis_data(found, [])["findings"]["same_as_cause"]
    assert seen["cause"] == "subdivision_error"
    assert seen["seen_as"]
    assert "The reference shows the same error as subdivision_error" in " ".join(sentences(found))


@pytest.mark.large
def test_a_line_that_the_named_effect_does_not_make_stays_a_detection() -> None:
    """A sine of 0.5″ that the named effect does not explain stays a detection: 0.5″ are five
    standard uncertainties of one row, and 360 rows show the sine."""
    found = _found(belt_arcsec=0.5)
    assert [found.verdict, *found.effect_class] == ["named", "subdivision_error"]
    orders = [line.rate for cause in found.detections.causes for line in cause.lines]
    assert any(abs(order - 61.3) < 1.0 for order in orders)


@pytest.mark.large
def test_an_error_that_follows_the_speed_does_not_jump_from_run_to_run() -> None:
    """An error that follows the speed is not reported as a jump from run to run; it grows with the
    speed squared, to 8″ in the fastest of four runs of a turn each."""
    random = np.random.default_rng(3)
    speeds = (5.0, 10.0, 20.0, 40.0)
    rows = 200
    start = np.cumsum([0.0, *(360.0 / speed + 5.0 for speed in speeds[:-1])])
    turn = np.linspace(0.0, 360.0, rows)
    time_s = np.concatenate([at + turn / speed for at, speed in zip(start, speeds, strict=True)])
    speed = np.repeat(speeds, rows)
    error = 8.0 * (speed / 40.0) ** 2 + 0.4 * random.normal(size=speed.size)
    reference = Reference(
        target_deg=np.tile(turn, len(speeds)),
        error_arcsec=error,
        time_s=time_s,
        run=np.repeat(np.arange(len(speeds)), rows),
    )
    measured = MeasurementSet(Table(), None, reference, title="speeds")
    effects = built_in()
    found = diagnose(observations_of(measured), default_model().terms(effects), effects)
    assert found.verdict == "unknown"
    assert found.description is not None
    assert "speed" in found.description
    assert found.detections.steps == ()
