"""Draws each cause at random for a given size.

Sizes are those that have been seen on real tables. A draw says what happens to the table, the
counters or the instrument; it knows nothing of how the workbench describes the same effect. Draws
are not made easier: a gear may look like a polygon error, an order may be one to which two heads
are nearly blind.
"""

from __future__ import annotations

import cmath
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from arctrue.table.causes.autocollimator_scale import AutocollimatorScale
from arctrue.table.causes.autoregressive_noise import AutoregressiveNoise
from arctrue.table.causes.ball_pass import BallPass
from arctrue.table.causes.base import PhysicalEffect
from arctrue.table.causes.belt_half_order import BeltPull
from arctrue.table.causes.bracket_expansion import BracketExpansion
from arctrue.table.causes.bracket_turn import BracketTurn
from arctrue.table.causes.bracket_vibration import BracketVibration
from arctrue.table.causes.centrifugal_lobes import CentrifugalLobes
from arctrue.table.causes.flat_track import FlatTrack
from arctrue.table.causes.gear_mesh import GearMesh
from arctrue.table.causes.graduation_bump import GraduationBump
from arctrue.table.causes.graduation_harmonics import GraduationHarmonics
from arctrue.table.causes.index_scatter import IndexScatter
from arctrue.table.causes.instrument_drift import InstrumentDrift
from arctrue.table.causes.leaning_bracket import LeaningBracket
from arctrue.table.causes.loosening_head import LooseningHead
from arctrue.table.causes.lost_counts import LostCounts
from arctrue.table.causes.noise_by_angle import NoiseByAngle
from arctrue.table.causes.outliers import Outliers
from arctrue.table.causes.polygon_faces import PolygonFaces
from arctrue.table.causes.polygon_mounting import PolygonMounting
from arctrue.table.causes.power_law_noise import PowerLawNoise
from arctrue.table.causes.radial_motion import RadialMotion
from arctrue.table.causes.reading_latency import ReadingLatency
from arctrue.table.causes.relaxing_noise import RelaxingNoise
from arctrue.table.causes.sampling_skew import SamplingSkew
from arctrue.table.causes.saw_tooth_motion import SawToothMotion
from arctrue.table.causes.sensor_lag import SensorLag
from arctrue.table.causes.settling_bracket import SettlingBracket
from arctrue.table.causes.shaft_wind_up import ShaftWindUp
from arctrue.table.causes.signal_distortion import SignalDistortion
from arctrue.table.causes.sticking_bracket import StickingBracket
from arctrue.table.causes.swinging_speed import SwingingSpeed
from arctrue.table.causes.thermal_centre import ThermalCentre
from arctrue.table.causes.time_gaps import TimeGaps
from arctrue.table.causes.wandering_reference import WanderingReference
from arctrue.table.causes.warm_fast_lobes import WarmFastLobes
from arctrue.table.causes.warm_lobes import WarmLobes
from arctrue.table.causes.wearing_track import WearingTrack
from arctrue.table.causes.white_noise import WhiteNoise
from arctrue.table.rotary_table import GRATING_LINES, two_heads
from arctrue.units import RAD_PER_ARCSEC

Random = np.random.Generator


HEADS = two_heads()
MICROMETRE_M = 1e-6
GEAR_WOBBLE_RAD = 0.3
DRIFT_HOURS, DRIFT_KNOT_S = 12.0, 60.0
OUTLIER_ARCSEC = 2.0
"""Scale of Student's t: some twenty times the usual noise."""
POLYGON_FACES = 24
POLYGON_OFFSET_M = 1e-6
POLYGON_FLATNESS_M = 0.03e-6
POLYGON_FACE_WIDTH_M = 10e-3
AUTOCOLLIMATOR_ROLL_RAD = float(np.deg2rad(1.0))
GEAR_TEETH = (62, 72, 90, 100, 120, 180, 225)
"""72 and 120 are multiples of the 24 faces: all stations stand at the same place of a tooth."""


@dataclass(frozen=True, slots=True)
class Occasion:
    """What an entry may know of the measurement: its runs."""

    starts_s: tuple[float, ...]
    durations_s: tuple[float, ...]
    """Of each run of the capture."""
    speeds_rad_s: tuple[float, ...]

    @property
    def turns(self) -> float:
        """All runs together, in either direction."""
        travel = zip(self.durations_s, self.speeds_rad_s, strict=True)
        return sum(seconds * abs(speed) for seconds, speed in travel) / (2 * np.pi)

    @property
    def end_s(self) -> float:
        """End of the last run; 0 without one."""
        return self.starts_s[-1] + self.durations_s[-1] if self.starts_s else 0.0


Build = Callable[[float, Random, Occasion], list[PhysicalEffect]]


def _angle(random: Random) -> float:
    return float(random.uniform(0.0, 2 * np.pi))


def _sign(random: Random) -> float:
    return float(random.choice([-1.0, 1.0]))


def _log_uniform(low: float, high: float, random: Random) -> float:
    return float(np.exp(random.uniform(np.log(low), np.log(high))))


def _vector(size: float, random: Random) -> complex:
    return cmath.rect(size, _angle(random))


def high_order(size: float, random: Random, _: Occasion) -> list[PhysicalEffect]:
    order = int(random.integers(21, 240))
    return [GraduationHarmonics((order,), (size * RAD_PER_ARCSEC,), (_angle(random),))]


def head_angle(size: float, random: Random, _: Occasion) -> list[PhysicalEffect]:
    # A larger α turns head 2 the other way: docs/architecture.md, "Head geometry".
    return [BracketTurn(1, HEADS[1], -_sign(random) * size * RAD_PER_ARCSEC)]


def subdivision(size: float, random: Random, _: Occasion) -> list[PhysicalEffect]:
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


def radial(size: float, random: Random, _: Occasion) -> list[PhysicalEffect]:
    order, share = int(random.integers(2, 9)), random.uniform(0.0, 1.0)
    metres = size * MICROMETRE_M
    return [
        RadialMotion(order, _vector(metres * share, random), _vector(metres * (1 - share), random))
    ]


def ball_pass(size: float, random: Random, occasion: Occasion) -> list[PhysicalEffect]:
    order = float(np.round(random.uniform(0.35, 14.0), 2))
    share, metres = random.uniform(0.0, 1.0), size * MICROMETRE_M
    return [BallPass(order, _vector(metres * share, random), _vector(metres * (1 - share), random))]


def vibration(size: float, random: Random, occasion: Occasion) -> list[PhysicalEffect]:
    phases = tuple(_angle(random) for _ in range(max(len(occasion.durations_s), 1)))
    frequency, head = float(random.uniform(3.0, 120.0)), int(random.integers(2))
    return [BracketVibration(head, HEADS[head], size * RAD_PER_ARCSEC, frequency, phases)]


def hysteresis(size: float, random: Random, _: Occasion) -> list[PhysicalEffect]:
    angle = _sign(random) * size / 2 * RAD_PER_ARCSEC
    return [ShaftWindUp(angle, float(np.deg2rad(_log_uniform(0.2, 10.0, random))))]


def skew(size: float, random: Random, _: Occasion) -> list[PhysicalEffect]:
    return [SamplingSkew(_sign(random) * size * 1e-6)]


def latency(size: float, random: Random, _: Occasion) -> list[PhysicalEffect]:
    return [ReadingLatency(size * 1e-6)]


def head_drift(size: float, random: Random, _: Occasion) -> list[PhysicalEffect]:
    return [BracketExpansion(1, HEADS[1], _sign(random) * size * RAD_PER_ARCSEC)]


def thermal_centre(size: float, random: Random, _: Occasion) -> list[PhysicalEffect]:
    return [ThermalCentre(_vector(size * MICROMETRE_M, random))]


def slip(size: float, random: Random, occasion: Occasion) -> list[PhysicalEffect]:
    run = int(random.integers(max(len(occasion.durations_s), 1)))
    instant = float(random.uniform(0.15, 0.85)) * occasion.durations_s[run]
    counts = int(_sign(random)) * max(1, round(size))
    return [LostCounts(int(random.integers(2)), run, instant, counts)]


def defect(size: float, random: Random, _: Occasion) -> list[PhysicalEffect]:
    width = float(np.deg2rad(np.exp(random.uniform(np.log(0.1), np.log(2.0)))))
    height, place = _sign(random) * size * RAD_PER_ARCSEC, _angle(random)
    power, skew = _log_uniform(1.2, 6.0, random), float(random.uniform(-0.5, 0.5))
    return [GraduationBump(height, place, width, power, skew)]


def gear(size: float, random: Random, _: Occasion) -> list[PhysicalEffect]:
    teeth = int(random.choice(GEAR_TEETH))
    phase, wobble = _angle(random), float(random.uniform(0.0, GEAR_WOBBLE_RAD))
    return [GearMesh(teeth, (size * RAD_PER_ARCSEC,), (phase,), wobble, _angle(random))]


def faces(size: float, random: Random, _: Occasion) -> list[PhysicalEffect]:
    errors = random.normal(0.0, size * RAD_PER_ARCSEC, POLYGON_FACES)
    return [PolygonFaces(tuple((errors - errors.mean()).tolist()))]


def polygon_mounting(size: float, random: Random, _: Occasion) -> list[PhysicalEffect]:
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


def gain(size: float, random: Random, _: Occasion) -> list[PhysicalEffect]:
    return [AutocollimatorScale(_sign(random) * size / 100)]


def drift(size: float, random: Random, _: Occasion) -> list[PhysicalEffect]:
    rate = _sign(random) * size * RAD_PER_ARCSEC / 3600
    # The temperature walks: its steps scatter by a fifth of what the mean rate makes of them.
    knots_s = np.arange(0.0, DRIFT_HOURS * 3600.0, DRIFT_KNOT_S)
    steps = random.normal(0.0, 0.2 * abs(rate) * DRIFT_KNOT_S, knots_s.size - 1)
    turns = np.concatenate([[0.0], np.cumsum(steps)])
    return [InstrumentDrift(rate, tuple(knots_s.tolist()), tuple(turns.tolist()))]


def warm(size: float, random: Random, _: Occasion) -> list[PhysicalEffect]:
    return [WarmLobes(2, size * RAD_PER_ARCSEC, _angle(random))]


def centrifugal(size: float, random: Random, _: Occasion) -> list[PhysicalEffect]:
    return [CentrifugalLobes(3, size * RAD_PER_ARCSEC, _angle(random))]


def half_order(size: float, random: Random, _: Occasion) -> list[PhysicalEffect]:
    along = _sign(random) * float(random.uniform(0.0, np.pi))
    order = float(random.choice([0.5, 1.5, 2.5]))
    return [BeltPull(order, size * MICROMETRE_M, along, _angle(random))]


def settling(size: float, random: Random, _: Occasion) -> list[PhysicalEffect]:
    each_run = bool(random.integers(2))
    tau_s = float(random.uniform(4.0, 15.0) if each_run else random.uniform(20.0, 60.0))
    angle = _sign(random) * size * RAD_PER_ARCSEC
    return [SettlingBracket(1, HEADS[1], angle, tau_s, each_run)]


def flat(size: float, random: Random, _: Occasion) -> list[PhysicalEffect]:
    width = float(np.deg2rad(random.uniform(3.0, 10.0)))
    return [FlatTrack(size * MICROMETRE_M, _angle(random), _angle(random), width)]


def saw(size: float, random: Random, _: Occasion) -> list[PhysicalEffect]:
    order, rise = int(random.integers(2, 6)), float(random.uniform(0.8, 0.97))
    return [SawToothMotion(order, size * MICROMETRE_M, _angle(random), _angle(random), rise)]


def warm_fast(size: float, random: Random, _: Occasion) -> list[PhysicalEffect]:
    return [WarmFastLobes(int(random.integers(2, 6)), size * RAD_PER_ARCSEC, _angle(random))]


def _instants(mean_s: float, random: Random, occasion: Occasion) -> tuple[float, ...]:
    """Irregular instants from before the first run to after the last."""
    number = 3 + int(1.5 * occasion.end_s / mean_s)
    waits_s = random.gamma(4.0, mean_s / 4.0, number)
    instants = np.cumsum(waits_s) - 2.0 * mean_s
    beyond = int(np.searchsorted(instants, occasion.end_s)) + 2
    return tuple(instants[:beyond].tolist())


def sticking(size: float, random: Random, occasion: Occasion) -> list[PhysicalEffect]:
    head, mean_s = int(random.integers(2)), float(random.uniform(1.0, 6.0))
    slips = _instants(mean_s, random, occasion)
    return [StickingBracket(head, HEADS[head], size * RAD_PER_ARCSEC, slips)]


def loosening(size: float, random: Random, occasion: Occasion) -> list[PhysicalEffect]:
    head, mean_s = int(random.integers(2)), float(random.uniform(2.0, 8.0))
    knocks = _instants(mean_s, random, occasion)
    return [LooseningHead(head, HEADS[head], size * RAD_PER_ARCSEC, knocks)]


def wearing(size: float, random: Random, occasion: Occasion) -> list[PhysicalEffect]:
    rate = size * MICROMETRE_M / max(occasion.turns, 1.0)
    return [WearingTrack(int(random.integers(2, 7)), rate, _angle(random), _angle(random))]


def leaning(size: float, random: Random, _: Occasion) -> list[PhysicalEffect]:
    head, stroke = int(random.integers(2)), float(np.deg2rad(random.uniform(5.0, 60.0)))
    return [LeaningBracket(head, HEADS[head], _sign(random) * size * RAD_PER_ARCSEC, stroke)]


def white(size: float, _: Random, __: Occasion) -> list[PhysicalEffect]:
    return [WhiteNoise(head_rad=size * RAD_PER_ARCSEC)]


def by_angle(size: float, random: Random, _: Occasion) -> list[PhysicalEffect]:
    angles = (HEADS[0].angle_rad, HEADS[1].angle_rad)
    order, contrast = int(random.integers(1, 4)), float(random.uniform(0.6, 1.0))
    return [NoiseByAngle(angles, size * RAD_PER_ARCSEC, order, contrast, _angle(random))]


def pink(size: float, _: Random, __: Occasion) -> list[PhysicalEffect]:
    return [PowerLawNoise(size * RAD_PER_ARCSEC)]


def power_law(size: float, random: Random, _: Occasion) -> list[PhysicalEffect]:
    return [PowerLawNoise(size * RAD_PER_ARCSEC, float(random.uniform(0.5, 1.8)))]


def relaxing(size: float, random: Random, _: Occasion) -> list[PhysicalEffect]:
    constant_s = _log_uniform(0.05, 30.0, random)
    return [RelaxingNoise(size * RAD_PER_ARCSEC, constant_s)]


def autoregressive(size: float, random: Random, _: Occasion) -> list[PhysicalEffect]:
    return [AutoregressiveNoise(size * RAD_PER_ARCSEC, float(random.uniform(0.5, 0.98)))]


def outliers(size: float, _: Random, __: Occasion) -> list[PhysicalEffect]:
    return [Outliers(size / 100, OUTLIER_ARCSEC * RAD_PER_ARCSEC)]


def index(size: float, _: Random, __: Occasion) -> list[PhysicalEffect]:
    return [IndexScatter(round(size))]


def lag(size: float, _: Random, __: Occasion) -> list[PhysicalEffect]:
    return [SensorLag(size * 60.0)]


def wander(size: float, random: Random, _: Occasion) -> list[PhysicalEffect]:
    constant_s = _log_uniform(30.0, 1200.0, random)
    return [WanderingReference(size * RAD_PER_ARCSEC, constant_s)]


def gaps(size: float, random: Random, _: Occasion) -> list[PhysicalEffect]:
    return [TimeGaps(size / 100, _log_uniform(3.0, 100.0, random))]


def swing(size: float, random: Random, _: Occasion) -> list[PhysicalEffect]:
    return [SwingingSpeed(size / 100, int(random.integers(1, 9)), _angle(random))]
