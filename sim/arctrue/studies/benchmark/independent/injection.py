"""Makes scenes without any cause, and for each effect one cause that can be injected at a given
size."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from arctrue.studies.benchmark.independent.causes.cause import Cause
from arctrue.studies.benchmark.independent.causes.disc import (
    AxisMotion,
    Backlash,
    BallPass,
    Defect,
    HighOrder,
    WarmCentre,
)
from arctrue.studies.benchmark.independent.causes.heads import (
    HeadStandsOff,
    LateHead,
    OldReading,
    Shaking,
    SubdivisionError,
    WarmBracket,
)
from arctrue.studies.benchmark.independent.causes.reference import (
    AngleLine,
    Creep,
    Faces,
    FirstOrderOfReference,
    GainOfReference,
    GearError,
)
from arctrue.studies.benchmark.independent.conditions import stations
from arctrue.studies.benchmark.independent.designs import slip
from arctrue.studies.benchmark.independent.geometry import any_disc
from arctrue.studies.benchmark.independent.noise import any_noise
from arctrue.studies.benchmark.independent.scene import Scene
from arctrue.studies.benchmark.independent.world import independent_worlds

Random = np.random.Generator


@dataclass(frozen=True, slots=True)
class Injection:
    """Functions for one effect: one makes the scene in which a diagnosis searches for the effect,
    the other draws a cause."""

    scene: Callable[[Random, int], Scene]
    """Function that makes a scene without any cause, from a random generator and the largest number
    of rows in a run."""
    cause: Callable[[Random, Scene], Cause]


def rms_arcsec(scene: Scene, cause: Cause) -> dict[str, float]:
    """Return the RMS of the cause by channel; in the reference, the mean is removed first."""
    shown, without = scene.channels([cause]), scene.channels([])
    found = {}
    for channel, values in shown.items():
        signal = values - without[channel]
        if channel == "reference":
            signal = signal - signal.mean()
        found[channel] = float(np.sqrt(np.mean(signal**2)))
    return found


def _world(name: str) -> Callable[[Random, int], Scene]:
    return lambda random, rows: independent_worlds()[name].draw(random, False, rows)


def _geared(random: Random, rows: int) -> Scene:
    """Draw a scene with 72 unevenly spaced stations, which are approached from both sides, and with
    a drive whose tooth count is stated."""
    places = np.arange(72) + random.uniform(-0.3, 0.3, 72)
    at = stations(places * (2 * np.pi / 72), 4, True, 6.0)
    sigma = float(random.uniform(0.05, 0.4))
    return Scene(
        any_disc(random),
        stations=at,
        reference_noise=any_noise(random, sigma, float(np.ptp(at.at.time_s)), 6.0),
        table={"drive_gear_teeth": float(random.integers(25, 90))},
        reference={"standard_uncertainty_arcsec": round(sigma, 3)},
    )


def _phase(random: Random) -> float:
    return float(random.uniform(0, 2 * np.pi))


def _shaking(random: Random, scene: Scene) -> Cause:
    step_s = max(float(run.time_s[1] - run.time_s[0]) for run in scene.runs)
    return Shaking.drawn(random, len(scene.runs), step_s, float(scene.runs[0].time_s[-1]))


def _creep(random: Random, scene: Scene) -> Cause:
    return Creep.drawn(random, float(np.ptp(scene.reference_at().time_s)))


def _defect(random: Random, scene: Scene) -> Cause:
    """Draw a defect with a half width of 2°; the first 20 orders absorb about a seventh of its
    RMS."""
    return Defect(1.0, _phase(random), float(np.radians(2.0)))


def _gear(random: Random, scene: Scene) -> Cause:
    return GearError(1.0, scene.table["drive_gear_teeth"], (_phase(random), _phase(random)))


def _line(random: Random, scene: Scene) -> Cause:
    return AngleLine(1.0, float(random.integers(21, 80)) + random.uniform(0.2, 0.8), _phase(random))


_BOTH, _MOVING = _world("heads_and_polygon"), _world("moving_reference")
INJECTIONS = {
    "high_order_graduation": Injection(_BOTH, lambda random, _: HighOrder.drawn(random)),
    "head_angle_error": Injection(_BOTH, lambda random, _: HeadStandsOff.drawn(random)),
    "subdivision_error": Injection(_BOTH, lambda random, _: SubdivisionError.drawn(random)),
    "radial_error_motion": Injection(_BOTH, lambda random, _: AxisMotion.drawn(random)),
    "bearing_ball_pass": Injection(_BOTH, lambda random, _: BallPass.drawn(random)),
    "vibration": Injection(_BOTH, _shaking),
    "hysteresis": Injection(_BOTH, lambda random, _: Backlash.drawn(random)),
    "timing_skew": Injection(_BOTH, lambda random, _: LateHead.drawn(random)),
    "latency": Injection(_MOVING, lambda random, _: OldReading.drawn(random)),
    "thermal_head_drift": Injection(_BOTH, lambda random, _: WarmBracket.drawn(random)),
    "thermal_eccentricity": Injection(_BOTH, lambda random, _: WarmCentre.drawn(random)),
    "count_slip": Injection(_BOTH, lambda random, scene: slip(random, list(scene.runs))),
    "graduation_defect": Injection(_BOTH, _defect),
    "drive_gear_error": Injection(_geared, _gear),
    "polygon_face_error": Injection(_BOTH, lambda random, _: Faces.drawn(random, 24)),
    "polygon_eccentricity": Injection(_BOTH, lambda random, _: FirstOrderOfReference.drawn(random)),
    "autocollimator_gain": Injection(_BOTH, lambda random, _: GainOfReference.drawn(random)),
    "reference_drift": Injection(_BOTH, _creep),
    "periodic_error": Injection(_MOVING, _line),
}
"""Injections by the name of the injected effect."""
