"""Tests of ``latency``: a reading that is late by τ changes the constant and every order.

This module calculates the motion without the project's simulator.
"""

from __future__ import annotations

import numpy as np
import pytest

from arctrue.measurement import MeasurementSet, Reference, Table
from arctrue.workbench.diagnose.diagnosis import diagnose
from arctrue.workbench.effects.registry import built_in
from arctrue.workbench.inference.design_matrix import Term
from arctrue.workbench.inference.fit import fit
from arctrue.workbench.observations import Observations
from arctrue.workbench.observations.build import observations_of

EFFECTS = built_in()
NOISE_ARCSEC = 0.3
ARCSEC_PER_DEG = 3600.0
Float = np.ndarray


def _error_arcsec(angle_rad: Float) -> Float:
    return (
        90.0 * np.cos(angle_rad + 0.4)
        + 3.0 * np.cos(3.0 * angle_rad - 1.0)
        + 25.0 * np.cos(20.0 * angle_rad + 2.0)
    )


def _observations(passes: list[tuple[float, float]], delay_s: float) -> Observations:
    """Return passes of one turn each with a row every half degree; ``passes`` states the first and
    the last speed of each pass in °/s.

    At a constant acceleration a, ω² = ω₀² + 2aθ. The reading at time t shows the angle of the time
    t − τ and the error at that angle.
    """
    random = np.random.default_rng(5)
    parts: list[tuple[Float, ...]] = []
    start = 0.0
    for number, (first, last) in enumerate(passes):
        way, sense = np.arange(720) * 0.5, np.sign(first)
        acceleration = (last**2 - first**2) / 720.0
        speed = np.sqrt(first**2 + 2.0 * acceleration * way)
        since = way / (0.5 * (abs(first) + speed))
        before = abs(first) * (since - delay_s) + 0.5 * acceleration * (since - delay_s) ** 2
        target = way if sense > 0.0 else 360.0 - way
        then = before if sense > 0.0 else 360.0 - before
        error = (then - target) * ARCSEC_PER_DEG + _error_arcsec(np.radians(then))
        parts.append((np.full(720, number), start + since, np.full(720, sense), target, error))
        start += float(since[-1]) + 30.0
    run, time, sense, target, error = (
        np.concatenate(column) for column in zip(*parts, strict=True)
    )
    reference = Reference(
        target_deg=target,
        error_arcsec=error + random.normal(0.0, NOISE_ARCSEC, error.size),
        run=run.astype(np.int64),
        time_s=time,
        direction=sense.astype(np.int64),
    )
    return observations_of(MeasurementSet(Table(), None, reference, title="old readings"))


def _base() -> Term:
    return Term(EFFECTS["graduation_harmonics"](), {})


@pytest.mark.parametrize("delay_us", [300.0, 5000.0])
def test_the_delay_takes_the_constant_and_its_coupling_to_every_order(delay_us: float) -> None:
    """The delay explains the constant at each speed and the change of every order. At 90 °/s a
    delay of 5 ms changes the phase of order 20 by 9°; a constant per speed cannot describe this
    change of 3.9″."""
    observations = _observations([(20.0, 20.0), (90.0, 90.0), (-45.0, -45.0)], delay_us * 1e-6)
    latency = EFFECTS["latency"]()
    solution = fit([_base(), Term(latency, {})], observations)
    left = solution.reference_residual_arcsec()
    assert left is not None
    # 2,160 rows with 42 coefficients determine the scatter to 1.5 %.
    assert float(np.sqrt(np.mean(left**2))) == pytest.approx(NOISE_ARCSEC, rel=0.06)
    found = solution.parameters()[-1]["latency"]
    assert found.sigma < 2.0
    assert found.value == pytest.approx(delay_us, abs=4.0 * found.sigma)


@pytest.mark.large
def test_ramps_tell_a_delay_from_a_reversal_error() -> None:
    """Ramps separate a delay from a reversal error, because the table accelerates in both
    directions. At one constant speed the two effects would look the same."""
    found = diagnose(_observations([(10.0, 60.0), (-10.0, -60.0)], 300e-6), [_base()], EFFECTS)
    assert found.verdict == "named"
    assert found.named is not None
    assert found.named.name == "latency"
    latency = found.named.parameters()["latency"]
    assert latency.value == pytest.approx(300.0, abs=4.0 * latency.sigma + 3.0)


def _fast_log(delay_s: float) -> Observations:
    """Return a log with a row every millisecond: the speed rises to 2,700 °/s, stays constant,
    falls to a fifth, and falls further.

    Between two corners of the speed the acceleration a is constant, and the delayed angle is
    before(t) = θ − ωτ + aτ²/2.
    """
    time = np.arange(2000) * 1e-3
    corners, speeds = [0.0, 0.6, 1.0, 1.6, 2.0], [135.0, 2700.0, 2700.0, 540.0, 135.0]
    speed = np.interp(time, corners, speeds)
    way = np.concatenate([[0.0], np.cumsum(0.5 * (speed[1:] + speed[:-1]) * 1e-3)])
    before = way - speed * delay_s + 0.5 * np.gradient(speed, time) * delay_s**2
    error = (before - way) * ARCSEC_PER_DEG + _error_arcsec(np.radians(before))
    noise = np.random.default_rng(6).normal(0.0, 20.0, time.size)
    reference = Reference(target_deg=way, error_arcsec=error + noise, time_s=time)
    return observations_of(MeasurementSet(Table(), None, reference, title="a fast log"))


@pytest.mark.large
def test_what_a_delay_leaves_is_judged_with_the_orders_that_it_bent() -> None:
    """A delay is judged with the orders of a fit that contains the delay: at 2,700 °/s a delay of
    100 µs is 970″, so that a fit without the delay gives wrong orders.

    If the fit used these wrong orders to compute the columns of the delay, a residual that no
    effect causes would exceed the noise of 20″.
    """
    found = diagnose(_fast_log(100e-6), [_base()], EFFECTS)
    assert found.named is not None, found.decision.unlike
    assert found.named.name == "latency"
    assert not found.further


def test_readings_every_sixteenth_of_a_second_are_not_at_standstill() -> None:
    """Stations 1.8° apart are read every 0.06 s: a table that stops needs longer. One speed is not
    enough for a delay."""
    target = np.tile(np.arange(200) * 1.8, 5)
    for step_s, words in ((0.06, "more than one speed"), (4.0, "stands still at its stations")):
        reference = Reference(
            target_deg=target,
            error_arcsec=np.cos(np.radians(target)),
            run=np.repeat(np.arange(5), 200),
            time_s=step_s * np.arange(target.size),
            direction=np.ones(target.size, dtype=np.int64),
        )
        observations = observations_of(MeasurementSet(Table(), None, reference))
        assert words in " ".join(EFFECTS["latency"]().missing(observations))
