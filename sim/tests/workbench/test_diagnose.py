"""Tests of the diagnosis on small sets; the tests, not the package, compute the hidden effects."""

from __future__ import annotations

import numpy as np
import pytest
from sim.tests.workbench.base_diagnosis import diagnosis_of
from sim.tests.workbench.small_sets import measurement_set, paper_error

from arctrue.workbench.effects.registry import built_in

EFFECTS = built_in()


def test_nothing_hidden_is_adequate() -> None:
    result = diagnosis_of(measurement_set())
    assert result.verdict == "adequate"
    assert result.named is None


@pytest.mark.large
def test_thermal_eccentricity_is_named_with_its_size() -> None:
    def error(disc, temperature, speed):  # type: ignore[no-untyped-def]
        return paper_error(disc, temperature, speed) + 0.4 * (temperature - 20.0) * np.cos(
            disc + 0.7
        )

    result = diagnosis_of(measurement_set(error))
    assert result.named is not None
    assert result.named.name == "thermal_eccentricity"
    found = result.named.parameters()
    assert found["amplitude"].value == pytest.approx(0.4, abs=4 * found["amplitude"].sigma + 0.005)
    assert found["phase"].value == pytest.approx(np.degrees(0.7), abs=2.0)


def test_subdivision_error_is_named() -> None:
    result = diagnosis_of(measurement_set(electrical=lambda phase: 0.4 * np.cos(phase + 1.0)))
    assert result.named is not None
    assert result.named.name == "subdivision_error"


def test_hysteresis_is_named_with_the_reversal_error() -> None:
    result = diagnosis_of(measurement_set(reversal_arcsec=0.8))
    assert result.named is not None
    assert result.named.name == "hysteresis"
    assert result.named.parameters()["reversal_error"].value == pytest.approx(0.8, abs=0.06)


def test_timing_skew_is_named_from_the_speeds() -> None:
    # A skew of 2 µs causes 0.65″ at 90°/s, seven times the assumed scatter of a run's offset.
    result = diagnosis_of(
        measurement_set(head2_only=lambda time, speed: speed * 2e-6 / np.pi * 648_000.0 + 0 * time)
    )
    assert result.named is not None
    assert result.named.name == "timing_skew"
    assert result.named.parameters()["skew"].value == pytest.approx(2.0, abs=0.3)


def test_an_effect_in_no_catalogue_is_unknown_with_its_parts() -> None:
    def error(disc, temperature, speed):  # type: ignore[no-untyped-def]
        return paper_error(disc, temperature, speed) + 0.4 * (temperature - 20.0) * np.cos(
            2 * disc + 0.7
        )

    result = diagnosis_of(measurement_set(error))
    assert result.verdict == "unknown"
    assert result.described.effect.parts == ["temperature", "order:2", "disc"]  # type: ignore[attr-defined]
    assert "order 2" in str(result.description)


@pytest.mark.large
def test_too_small_to_matter_is_said_not_named() -> None:
    # In 2,880 rows a reversal error of ±0.025″ is significant, although 0.025″ is less than half a
    # count; the diagnosis lists the error as negligible.
    result = diagnosis_of(measurement_set(reversal_arcsec=0.05, cycles=60))
    assert result.verdict == "adequate"
    assert [item.name for item in result.negligible] == ["hysteresis"]


def test_a_jump_of_both_heads_is_bad_data() -> None:
    good = measurement_set()
    assert good.capture is not None
    good.capture.head1_counts[5000:] += 5000
    good.capture.head2_counts[5000:] += 5000
    result = diagnosis_of(good)
    assert result.verdict == "bad_data"
    assert "run 1" in result.decision.faults[0]


@pytest.mark.large
def test_one_run_at_one_speed_does_not_choose_between_time_and_angle() -> None:
    # The oscillation has 39.75 periods per turn of 12 s. Three turns distinguish orders that differ
    # by 1/6, so that the oscillation is not taken for a half-integer order.
    frequency = 39.75 / 12.0
    result = diagnosis_of(
        measurement_set(
            runs=1,
            reference=False,
            head2_only=lambda time, speed: 0.6 * np.cos(2 * np.pi * frequency * time),
        )
    )
    assert result.verdict == "ambiguous"
    assert {"vibration", "bearing_ball_pass"} <= set(result.effect_class)
    assert result.next_measurement is not None
    assert "speed" in result.next_measurement


@pytest.mark.large
def test_the_same_seed_gives_the_same_diagnosis() -> None:
    first, second = (
        diagnosis_of(measurement_set(reversal_arcsec=0.8, runs=2, cycles=3)) for _ in range(2)
    )
    assert [item.p_corrected for item in first.candidates] == [
        item.p_corrected for item in second.candidates
    ]
