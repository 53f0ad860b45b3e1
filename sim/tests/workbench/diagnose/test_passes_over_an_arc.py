"""Tests that passes over a short arc share the smooth error of the disc, so that no verdict takes
this error for a discovery.

The sets are computed in this module, with plain numpy.
"""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from arctrue.measurement import MeasurementSet, Reference, Table
from arctrue.workbench.diagnose.diagnosis import Diagnosis, diagnose
from arctrue.workbench.diagnose.report import sentences
from arctrue.workbench.diagnose.shared_curve import shared_curve
from arctrue.workbench.effects.registry import built_in
from arctrue.workbench.inference.fit import fit
from arctrue.workbench.model.growth import settle
from arctrue.workbench.model.model import default_model
from arctrue.workbench.numeric.arc_curve import arc_curves
from arctrue.workbench.observations.build import observations_of

Float = NDArray[np.float64]
EFFECTS = built_in()
NOISE_ARCSEC = 0.3


def _disc(angle_deg: Float, random: np.random.Generator) -> Float:
    """Return an eccentricity of 8″, an ovality of 3″ and the orders 3 to 6 of 0.5″."""
    sizes = [8.0, 3.0, 0.5, 0.5, 0.5, 0.5]
    phases = random.uniform(0.0, 2.0 * np.pi, len(sizes))
    waves = [
        size * np.cos(order * np.radians(angle_deg) + phase)
        for order, (size, phase) in enumerate(zip(sizes, phases, strict=True), start=1)
    ]
    return np.asarray(np.sum(waves, axis=0))


def _passes(
    arc_deg: float,
    places: int,
    passes: int,
    *,
    to_and_fro: bool = True,
    step_s: float = 1.0,
) -> tuple[Float, Float, Float, NDArray[np.int64]]:
    """Return angles, directions, times and the numbers of the passes."""
    number = np.repeat(np.arange(passes), places)
    direction = np.where((number % 2 == 0) | (not to_and_fro), 1.0, -1.0)
    up = np.tile(np.linspace(0.0, arc_deg, places), passes)
    angle = np.where(direction > 0.0, up, arc_deg - up)
    return angle, direction, step_s * np.arange(angle.size, dtype=np.float64), number


def _diagnosed(
    angle: Float, direction: Float, time_s: Float, number: NDArray[np.int64], error: Float,
    table: Table | None = None,
) -> Diagnosis:  # fmt: skip
    counts = None if table is None or table.counts_per_rev is None else table.counts_per_rev
    reference = Reference(
        angle,
        error,
        run=number,
        time_s=time_s,
        direction=direction.astype(np.int64),
        head1_counts=None if counts is None else np.round(angle / 360.0 * counts).astype(np.int64),
    )
    observations = observations_of(MeasurementSet(table or Table(), None, reference, title="arc"))
    return diagnose(observations, settle(default_model(), observations, EFFECTS), EFFECTS)


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_the_disc_alone_is_no_discovery(seed: int) -> None:
    """In 20 passes upwards over half a turn, at one speed, the diagnosis makes no discovery: the
    only error is the smooth error of the disc."""
    random = np.random.default_rng(seed)
    passes = _passes(180.0, 225, 20, to_and_fro=False, step_s=0.2)
    error = _disc(passes[0], random) + random.normal(0.0, NOISE_ARCSEC, passes[0].size)
    found = _diagnosed(*passes, error)
    assert found.verdict in ("cannot_tell", "adequate")
    # The model leaves the noise; the curves take about 27 of 4,500 degrees of freedom.
    left = found.channels["reference"].residual_rms_arcsec
    assert left == pytest.approx(NOISE_ARCSEC, rel=0.05)
    assert not found.detections.causes
    assert not found.detections.steps


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_a_worm_over_a_third_of_a_turn(seed: int) -> None:
    """The passes cover 120°; the error of a worm wheel is 1″, and the set states its 90 teeth."""
    random = np.random.default_rng(seed)
    passes = _passes(120.0, 151, 6)
    worm = np.cos(90.0 * np.radians(passes[0]) + random.uniform(0.0, 6.28))
    error = _disc(passes[0], random) + worm + random.normal(0.0, NOISE_ARCSEC, worm.size)
    found = _diagnosed(*passes, error, Table(drive_gear_teeth=90))
    assert found.named is not None
    assert found.named.name == "drive_gear_error"
    (size,) = [item for key, item in found.named.parameters().items() if "amplitude" in key]
    # u of an amplitude: 0.3″·√(2/906).
    assert size.value == pytest.approx(1.0, abs=5 * NOISE_ARCSEC * (2 / 906) ** 0.5)


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_a_reversal_error_over_half_a_turn(seed: int) -> None:
    """The directions differ by 2″ in 8 passes."""
    random = np.random.default_rng(seed)
    passes = _passes(178.0, 112, 8)
    error = _disc(passes[0], random) + passes[1] + random.normal(0.0, NOISE_ARCSEC, 896)
    found = _diagnosed(*passes, error)
    assert found.effect_class[:1] == ["hysteresis"]
    assert found.described is None


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_a_slope_that_starts_again_is_no_jump(seed: int) -> None:
    """Each of two passes upwards over 2°, with 800 rows, begins the same slope of 3″ again, with a
    subdivision error of 1.5″ and a period of 0.1°."""
    random = np.random.default_rng(seed)
    passes = _passes(2.0, 800, 2, to_and_fro=False)
    angle = passes[0]
    error = 1.5 * angle + 1.5 * np.sin(3600.0 * np.radians(angle)) + random.normal(0.0, 0.2, 1600)
    found = _diagnosed(*passes, error, Table(counts_per_rev=3600 * 1024, grating_lines=3600))
    assert not found.detections.steps
    assert found.effect_class[:1] == ["subdivision_error"]


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_a_drift_of_the_time_stays_a_drift(seed: int) -> None:
    """The curve that the passes share contains no drift: 4″ over ten passes to and fro."""
    random = np.random.default_rng(seed)
    passes = _passes(100.0, 101, 10)
    drift = 4.0 * passes[2] / passes[2][-1]
    error = _disc(passes[0], random) + drift + random.normal(0.0, NOISE_ARCSEC, drift.size)
    found = _diagnosed(*passes, error)
    assert found.effect_class[:1] == ["reference_drift"]


def test_a_single_pass_shares_nothing() -> None:
    random = np.random.default_rng(1)
    passes = _passes(100.0, 400, 1)
    error = _disc(passes[0], random) + random.normal(0.0, NOISE_ARCSEC, 400)
    assert not any("share a smooth curve" in text for text in sentences(_diagnosed(*passes, error)))


@pytest.mark.parametrize(("arc_deg", "curves"), [(60.0, 13), (240.0, 34)])
def test_noise_is_no_curve(arc_deg: float, curves: int) -> None:
    """In noise without a curve, a curve is stated with a probability of 0.27 % per draw; the test
    makes five draws per arc. The stated size excludes the noise, which alone has the size √13·u or
    √34·u."""
    stated, squares = 0, []
    for seed in range(5):
        passes = _passes(arc_deg, 61, 6)
        error = np.random.default_rng(seed).normal(0.0, NOISE_ARCSEC, passes[0].size)
        reference = Reference(
            passes[0], error, run=passes[3], time_s=passes[2], direction=passes[1].astype(np.int64)
        )
        observations = observations_of(MeasurementSet(Table(), None, reference))
        base = fit(settle(default_model(), observations, EFFECTS), observations)
        stated += len(shared_curve(base))
        (size,) = [one["curve_rms"].value for one in base.parameters() if "curve_rms" in one]
        # The square of the size has the standard deviation √(2·curves)·u² in noise alone.
        squares.append(size**2 * 61 * 6 / NOISE_ARCSEC**2)
    assert stated == 0
    assert np.mean(squares) < 3.0 * (2.0 * curves / 5.0) ** 0.5


@pytest.mark.parametrize("arc_deg", [2.0, 45.0, 120.0, 251.0])
def test_the_curves_contain_every_order_of_the_arc(arc_deg: float) -> None:
    """Ordinary least squares by the curves leaves less than 0.01″ of an eccentricity of 150″, and
    of each order with the sizes of a disc."""
    angle = np.radians(np.linspace(0.0, arc_deg, 777))
    curves = arc_curves(angle, tuple(range(1, 21)), 0.0, arc_deg)
    columns = np.column_stack([np.ones(angle.size), curves])
    for order, size in ((1, 150.0), (2, 20.0), (7, 2.0), (20, 1.0)):
        error = size * np.cos(order * angle + 1.0)
        left = error - columns @ np.linalg.lstsq(columns, error, rcond=None)[0]
        assert float(np.std(left)) < 0.01
    assert np.sqrt(np.mean(curves**2, axis=0)) == pytest.approx(1.0, abs=0.02)
    # Twice the product of length and bandwidth, and the logarithmic rest of Slepian's theorem.
    assert curves.shape[1] <= 2 * 20 * arc_deg / 360.0 + 10
