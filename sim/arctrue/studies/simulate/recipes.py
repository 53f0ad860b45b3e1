"""How large each cause is and what else chance decides about it; names as in the catalogue.

Sizes are those that have been seen on real tables. A recipe says what happens to the table, the
counters or the instrument; it knows nothing of how the workbench describes the same effect.
"""

from __future__ import annotations

import cmath
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from arctrue.studies.simulate.experiment import Experiment
from arctrue.table.causes.autocollimator_scale import AutocollimatorScale
from arctrue.table.causes.ball_pass import BallPass
from arctrue.table.causes.base import PhysicalEffect
from arctrue.table.causes.belt_half_order import BeltPull
from arctrue.table.causes.bracket_expansion import BracketExpansion
from arctrue.table.causes.bracket_turn import BracketTurn
from arctrue.table.causes.bracket_vibration import BracketVibration
from arctrue.table.causes.centrifugal_lobes import CentrifugalLobes
from arctrue.table.causes.gear_mesh import GearMesh
from arctrue.table.causes.graduation_bump import GraduationBump
from arctrue.table.causes.graduation_harmonics import GraduationHarmonics
from arctrue.table.causes.instrument_drift import InstrumentDrift
from arctrue.table.causes.lost_counts import LostCounts
from arctrue.table.causes.polygon_faces import PolygonFaces
from arctrue.table.causes.polygon_mounting import PolygonMounting
from arctrue.table.causes.radial_motion import RadialMotion
from arctrue.table.causes.reading_latency import ReadingLatency
from arctrue.table.causes.sampling_skew import SamplingSkew
from arctrue.table.causes.settling_bracket import SettlingBracket
from arctrue.table.causes.shaft_wind_up import ShaftWindUp
from arctrue.table.causes.signal_distortion import SignalDistortion
from arctrue.table.causes.thermal_centre import ThermalCentre
from arctrue.table.causes.warm_lobes import WarmLobes
from arctrue.table.measurement_set import GRATING_LINES
from arctrue.table.rotary_table import two_heads
from arctrue.units import RAD_PER_ARCSEC

Random = np.random.Generator
Build = Callable[[float, Random, Experiment], list[PhysicalEffect]]

HEADS = two_heads()
MICROMETRE_M = 1e-6
POLYGON_FACES = 24
POLYGON_OFFSET_M = 1e-6
POLYGON_FLATNESS_M = 0.03e-6
POLYGON_FACE_WIDTH_M = 10e-3
AUTOCOLLIMATOR_ROLL_RAD = float(np.deg2rad(1.0))
GEAR_TEETH = (62, 90, 100, 180, 225)
"""None a multiple of the faces: such a gear could not be seen on the polygon."""


@dataclass(frozen=True, slots=True)
class Recipe:
    """One cause with its range of sizes."""

    name: str
    unit: str
    """Of the size."""
    low: float
    high: float
    build: Build
    in_catalogue: bool = True
    parts: tuple[str, ...] = ()
    """Of a cause that is in no catalogue: what it is made of."""

    def draw_size(self, random: Random) -> float:
        """A size between low and high, as likely in each octave."""
        return float(np.exp(random.uniform(np.log(self.low), np.log(self.high))))


def _angle(random: Random) -> float:
    return float(random.uniform(0.0, 2 * np.pi))


def _sign(random: Random) -> float:
    return float(random.choice([-1.0, 1.0]))


def _vector(size: float, random: Random) -> complex:
    return cmath.rect(size, _angle(random))


def _high_order(size: float, random: Random, _: Experiment) -> list[PhysicalEffect]:
    while True:
        order = int(random.integers(21, 240))
        # Two heads 33° apart are blind near multiples of 120/11.
        if abs(np.exp(1j * order * np.deg2rad(33.0)) - 1.0) > 0.5:
            break
    return [GraduationHarmonics((order,), (size * RAD_PER_ARCSEC,), (_angle(random),))]


def _head_angle(size: float, random: Random, _: Experiment) -> list[PhysicalEffect]:
    # A larger α turns head 2 the other way: docs/architecture.md, "Head geometry".
    return [BracketTurn(1, HEADS[1], -_sign(random) * size * RAD_PER_ARCSEC)]


def _subdivision(size: float, random: Random, _: Experiment) -> list[PhysicalEffect]:
    # An offset of the share p of the amplitude errs by p of a radian of the signal period.
    period_rad = size * RAD_PER_ARCSEC * GRATING_LINES
    found: list[PhysicalEffect] = []
    for head in (0, 1):
        offset = _vector(period_rad * random.uniform(0.6, 1.0), random)
        second = _vector(2 * period_rad * random.uniform(0.2, 0.5), random)
        found.append(
            SignalDistortion(
                head, GRATING_LINES, offset.real, offset.imag, second.real, second.imag
            )
        )
    return found


def _radial(size: float, random: Random, _: Experiment) -> list[PhysicalEffect]:
    order, share = int(random.integers(2, 9)), random.uniform(0.0, 1.0)
    metres = size * MICROMETRE_M
    return [
        RadialMotion(order, _vector(metres * share, random), _vector(metres * (1 - share), random))
    ]


def _ball_pass(size: float, random: Random, experiment: Experiment) -> list[PhysicalEffect]:
    turns = sum(run.duration_s * abs(run.speed_rad_s) for run in experiment.runs) / (2 * np.pi)
    while True:
        order = float(np.round(random.uniform(0.35, 14.0), 2))
        # Nearer to a multiple of one half it cannot be told from a whole or half order.
        if abs(2 * order - round(2 * order)) / 2 > 2 / max(turns, 12.0):
            break
    share, metres = random.uniform(0.0, 1.0), size * MICROMETRE_M
    return [BallPass(order, _vector(metres * share, random), _vector(metres * (1 - share), random))]


def _vibration(size: float, random: Random, experiment: Experiment) -> list[PhysicalEffect]:
    phases = tuple(_angle(random) for _ in range(max(len(experiment.runs), 1)))
    frequency, head = float(random.uniform(3.0, 120.0)), int(random.integers(2))
    return [BracketVibration(head, HEADS[head], size * RAD_PER_ARCSEC, frequency, phases)]


def _hysteresis(size: float, random: Random, _: Experiment) -> list[PhysicalEffect]:
    return [ShaftWindUp(_sign(random) * size / 2 * RAD_PER_ARCSEC)]


def _skew(size: float, random: Random, _: Experiment) -> list[PhysicalEffect]:
    return [SamplingSkew(_sign(random) * size * 1e-6)]


def _latency(size: float, random: Random, _: Experiment) -> list[PhysicalEffect]:
    return [ReadingLatency(size * 1e-6)]


def _head_drift(size: float, random: Random, _: Experiment) -> list[PhysicalEffect]:
    return [BracketExpansion(1, HEADS[1], _sign(random) * size * RAD_PER_ARCSEC)]


def _thermal_centre(size: float, random: Random, _: Experiment) -> list[PhysicalEffect]:
    return [ThermalCentre(_vector(size * MICROMETRE_M, random))]


def _slip(size: float, random: Random, experiment: Experiment) -> list[PhysicalEffect]:
    run = int(random.integers(max(len(experiment.runs), 1)))
    instant = float(random.uniform(0.15, 0.85)) * experiment.runs[run].duration_s
    counts = int(_sign(random)) * max(1, round(size))
    return [LostCounts(int(random.integers(2)), run, instant, counts)]


def _defect(size: float, random: Random, _: Experiment) -> list[PhysicalEffect]:
    width = float(np.deg2rad(np.exp(random.uniform(np.log(0.1), np.log(2.0)))))
    return [GraduationBump(_sign(random) * size * RAD_PER_ARCSEC, _angle(random), width)]


def _gear(size: float, random: Random, _: Experiment) -> list[PhysicalEffect]:
    teeth = int(random.choice(GEAR_TEETH))
    return [GearMesh(teeth, (size * RAD_PER_ARCSEC,), (_angle(random),))]


def _faces(size: float, random: Random, _: Experiment) -> list[PhysicalEffect]:
    errors = random.normal(0.0, size * RAD_PER_ARCSEC, POLYGON_FACES)
    return [PolygonFaces(tuple((errors - errors.mean()).tolist()))]


def _polygon_mounting(size: float, random: Random, _: Experiment) -> list[PhysicalEffect]:
    tilt = size * RAD_PER_ARCSEC / np.sin(AUTOCOLLIMATOR_ROLL_RAD)
    return [
        PolygonMounting(
            POLYGON_OFFSET_M,
            POLYGON_FLATNESS_M,
            POLYGON_FACE_WIDTH_M,
            float(tilt),
            AUTOCOLLIMATOR_ROLL_RAD,
            _angle(random),
        )
    ]


def _gain(size: float, random: Random, _: Experiment) -> list[PhysicalEffect]:
    return [AutocollimatorScale(_sign(random) * size / 100)]


def _drift(size: float, random: Random, _: Experiment) -> list[PhysicalEffect]:
    return [InstrumentDrift(_sign(random) * size * RAD_PER_ARCSEC / 3600)]


def _warm(size: float, random: Random, _: Experiment) -> list[PhysicalEffect]:
    return [WarmLobes(2, size * RAD_PER_ARCSEC, _angle(random))]


def _centrifugal(size: float, random: Random, _: Experiment) -> list[PhysicalEffect]:
    return [CentrifugalLobes(3, size * RAD_PER_ARCSEC, _angle(random))]


def _half_order(size: float, random: Random, _: Experiment) -> list[PhysicalEffect]:
    # The difference sees most along the bisector of the heads and nothing across it. Towards
    # head 1 (0°) or head 2 (−33°) that head sees nothing: as if the other had an error alone.
    along = -np.deg2rad(16.5) + _sign(random) * random.uniform(0.55, 1.0)
    order = float(random.choice([0.5, 1.5, 2.5]))
    return [BeltPull(order, size * MICROMETRE_M, float(along), _angle(random))]


def _settling(size: float, random: Random, _: Experiment) -> list[PhysicalEffect]:
    each_run = bool(random.integers(2))
    tau_s = float(random.uniform(4.0, 15.0) if each_run else random.uniform(20.0, 60.0))
    angle = _sign(random) * size * RAD_PER_ARCSEC
    return [SettlingBracket(1, HEADS[1], angle, tau_s, each_run)]


_ALL = (
    Recipe("high_order_graduation", "arcsec", 0.1, 1.0, _high_order),
    Recipe("head_angle_error", "arcsec", 2.0, 60.0, _head_angle),
    Recipe("subdivision_error", "arcsec", 0.06, 2.4, _subdivision),
    Recipe("radial_error_motion", "um", 0.1, 2.0, _radial),
    Recipe("bearing_ball_pass", "um", 0.1, 1.0, _ball_pass),
    Recipe("vibration", "arcsec", 0.1, 1.0, _vibration),
    Recipe("hysteresis", "arcsec", 0.2, 5.0, _hysteresis),
    Recipe("timing_skew", "us", 1.0, 20.0, _skew),
    Recipe("latency", "us", 2.0, 50.0, _latency),
    Recipe("thermal_head_drift", "arcsec/K", 0.1, 1.0, _head_drift),
    Recipe("thermal_eccentricity", "um/K", 0.1, 0.9, _thermal_centre),
    Recipe("count_slip", "counts", 4.0, 64.0, _slip),
    Recipe("graduation_defect", "arcsec", 0.5, 5.0, _defect),
    Recipe("drive_gear_error", "arcsec", 0.3, 3.0, _gear),
    Recipe("polygon_face_error", "arcsec", 0.1, 0.5, _faces),
    Recipe("polygon_eccentricity", "arcsec", 0.1, 1.0, _polygon_mounting),
    Recipe("autocollimator_gain", "percent", 0.1, 1.0, _gain),
    Recipe("reference_drift", "arcsec/h", 0.3, 3.0, _drift),
    Recipe("warm_ovality", "arcsec/K", 0.1, 0.5, _warm, False, ("temperature", "order:2", "disc")),
    Recipe(
        "centrifugal_lobes",
        "arcsec/(rad/s)^2",
        0.1,
        0.5,
        _centrifugal,
        False,
        ("speed^2", "order:3", "disc"),
    ),
    Recipe("half_order", "um", 0.1, 1.0, _half_order, False, ("order:*", "stator")),
    Recipe("settling_bracket", "arcsec", 0.5, 3.0, _settling, False, ("settling", "head2")),
)

RECIPES = {recipe.name: recipe for recipe in _ALL}
"""By name."""
