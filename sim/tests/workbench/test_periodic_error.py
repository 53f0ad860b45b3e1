"""Tests of the effect periodic_error, a sine (line) of any order or frequency without a known
cause; the effect states σ only if the data determine it."""

from __future__ import annotations

import numpy as np
import pytest

from arctrue.measurement import MeasurementSet, Reference, Table
from arctrue.workbench.diagnose.diagnosis import Diagnosis, diagnose
from arctrue.workbench.diagnose.report import sentences
from arctrue.workbench.effects.registry import built_in
from arctrue.workbench.inference.fit import fit
from arctrue.workbench.inference.line_spectrum import line_spectrum
from arctrue.workbench.inference.residuals import Residuals
from arctrue.workbench.model.growth import add_effect
from arctrue.workbench.model.model import default_model
from arctrue.workbench.observations import Observations
from arctrue.workbench.observations.build import observations_of
from tests.workbench.small_sets import measurement_set

EFFECTS = built_in()
NOISE_ARCSEC = 0.2


def _reference(
    lines: list[tuple[float, float]] = (),  # type: ignore[assignment]
    *,
    in_time: tuple[float, float] | None = None,
    speeds_deg_s: tuple[float, ...] = (2.0,),
    turns: float = 3.0,
    teeth: float | None = None,
    step_deg: float = 1.0,
) -> Observations:
    """Return a set of one head against a moving reference. ``lines`` gives order and amplitude of
    each sine in the angle; ``in_time`` gives frequency and amplitude of a sine in time."""
    random = np.random.default_rng(11)
    targets, times, runs = [], [], []
    start = 0.0
    for run, speed in enumerate(speeds_deg_s):
        target = np.arange(round(turns * 360.0 / step_deg)) * step_deg
        targets.append(target)
        times.append(start + target / speed)
        runs.append(np.full(target.size, run))
        start = float(times[-1][-1]) + 60.0
    target, time = np.concatenate(targets), np.concatenate(times)
    error = 4.0 * np.cos(np.radians(target) + 0.3)
    for order, size in lines:
        error += size * np.cos(order * np.radians(target) + 0.9)
    if in_time is not None:
        error += in_time[1] * np.cos(2.0 * np.pi * in_time[0] * time + 0.4)
    error += random.normal(0.0, NOISE_ARCSEC, target.size)
    reference = Reference(
        target_deg=target, error_arcsec=error, time_s=time, run=np.concatenate(runs)
    )
    table = Table(drive_gear_teeth=teeth)
    return observations_of(MeasurementSet(table, None, reference, title="one head"))


def _diagnosed(observations: Observations) -> Diagnosis:
    return diagnose(observations, default_model().terms(EFFECTS), EFFECTS)


def test_a_line_of_a_real_order_is_named_with_its_order() -> None:
    order, size, turns = 37.43, 0.6, 3.0
    found = _diagnosed(_reference([(order, size)], turns=turns))
    assert found.named is not None
    assert found.named.name == "periodic_error"
    parameters = found.named.parameters()
    # The Cramér–Rao bound of a frequency is from Rife and Boorstyn, IEEE Trans. Inf. Theory 20
    # (1974) 591.
    rows = turns * 360
    least_sigma = np.sqrt(6.0 / rows) * NOISE_ARCSEC / (np.pi * size * turns)
    assert parameters["order"].sigma == pytest.approx(least_sigma, rel=0.25)
    assert parameters["order"].value == pytest.approx(order, abs=4.0 * least_sigma)
    assert parameters["amplitude"].value == pytest.approx(
        size, abs=4.0 * NOISE_ARCSEC * np.sqrt(2.0 / rows)
    )
    # At 2 °/s, the only speed, the line has 37.43 periods in 180 s.
    assert parameters["period_time"].value == pytest.approx(180.0 / order, rel=1e-3)
    assert parameters["frequency"].value == pytest.approx(order / 180.0, rel=1e-3)
    relative = parameters["order"].sigma / parameters["order"].value
    assert parameters["period"].sigma == pytest.approx(relative * 360.0 / order, rel=0.01)


@pytest.mark.large
def test_without_a_disc_nothing_is_said_of_one() -> None:
    """An integer order in a set with only a reference may come from the encoder, a gear or a motor,
    so that the answer must not name the disc."""
    said = " ".join(sentences(_diagnosed(_reference([(40.0, 0.6)]))))
    assert "Missing: periodic_error." in said
    assert "disc" not in said
    assert "ruled" not in said
    assert "one speed cannot show which" in said


@pytest.mark.large
def test_two_speeds_tell_an_order_from_a_frequency() -> None:
    fast_and_slow = (2.0, 3.4)
    in_angle = _diagnosed(_reference([(37.43, 0.6)], speeds_deg_s=fast_and_slow))
    in_time = _diagnosed(_reference(in_time=(0.137, 0.6), speeds_deg_s=fast_and_slow))
    for found, parameter, value in ((in_angle, "order", 37.43), (in_time, "frequency", 0.137)):
        assert found.named is not None
        assert found.named.name == "periodic_error"
        assert found.named.parameters()[parameter].value == pytest.approx(value, rel=1e-3)
    assert "fixed to time" in " ".join(sentences(in_time))
    assert "fixed to the angle or to the drive" in " ".join(sentences(in_angle))


def test_it_is_added_again_for_the_next_line() -> None:
    observations = _reference([(37.43, 0.6), (61.8, 0.4)])
    model = default_model()
    for _ in range(2):
        model, solution = add_effect(model, "periodic_error", {}, observations, EFFECTS, "set")
    orders = [entry.search["order"] for entry in model.effects if entry.name == "periodic_error"]
    assert orders == pytest.approx([37.43, 61.8], abs=0.02)
    assert [step.action for step in model.history] == ["fit", "add", "add"]
    held_out = [step.heldout_rms_arcsec["reference"] for step in model.history]
    assert held_out[0] > held_out[1] > held_out[2]
    left = solution.reference_residual_arcsec()
    assert left is not None
    assert float(np.sqrt(np.mean(left**2))) == pytest.approx(NOISE_ARCSEC, rel=0.06)


@pytest.mark.large
def test_a_drive_of_a_broken_tooth_count_has_its_own_name() -> None:
    """The diagnosis names the drive if the set states its 53.71 periods per turn, which worm, belt
    and motor together make."""
    found = _diagnosed(_reference([(53.71, 0.6)], teeth=53.71))
    assert found.named is not None
    assert found.named.name == "drive_gear_error"
    assert found.effect_class == ["drive_gear_error"]
    assert found.named.effect.lanes(np.array([0.1, 0.2]), {}, found.observations, None) == []


def test_nothing_is_named_in_noise_alone() -> None:
    assert _diagnosed(_reference(speeds_deg_s=(2.0, 3.4))).named is None


def test_a_line_in_the_capture_goes_through_periods_within_a_run() -> None:
    """The search excludes a sine that is so slow that it only fits the offsets of runs half an hour
    apart."""
    observations = observations_of(measurement_set(turns=2, reference=False))
    rows = observations.capture
    assert rows is not None
    residuals = Residuals(fit(default_model().terms(EFFECTS), observations))
    longest_s = max(float(np.ptp(rows.time_s[rows.run == run])) for run in range(rows.runs))
    found = line_spectrum(residuals, capture=True, in_time=True)
    assert found is not None
    # The search begins at four periods in the longest run, rounded up by at most one step of the
    # rates.
    assert 4.0 <= found.rates[0] * longest_s < 4.0 + longest_s * (found.rates[1] - found.rates[0])
    assert float(np.ptp(rows.time_s)) > 20.0 * longest_s
