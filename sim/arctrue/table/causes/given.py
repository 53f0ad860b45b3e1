"""A cause from values that somebody gives: each with its keys, units, defaults and limits."""

from __future__ import annotations

import cmath
import math
from typing import Protocol

import numpy as np

from arctrue.table.causes.autocollimator_scale import AutocollimatorScale
from arctrue.table.causes.ball_pass import BallPass
from arctrue.table.causes.base import PhysicalEffect
from arctrue.table.causes.belt_half_order import BeltPull
from arctrue.table.causes.bracket_expansion import BracketExpansion
from arctrue.table.causes.bracket_turn import BracketTurn
from arctrue.table.causes.bracket_vibration import BracketVibration
from arctrue.table.causes.centrifugal_lobes import CentrifugalLobes
from arctrue.table.causes.creeping_centre import CreepingCentre
from arctrue.table.causes.disc_eccentricity import DiscEccentricity
from arctrue.table.causes.flat_track import FlatTrack
from arctrue.table.causes.gear_mesh import GearMesh
from arctrue.table.causes.graduation_bump import GraduationBump
from arctrue.table.causes.graduation_harmonics import GraduationHarmonics
from arctrue.table.causes.instrument_drift import InstrumentDrift
from arctrue.table.causes.leaning_bracket import LeaningBracket
from arctrue.table.causes.loosening_head import LooseningHead
from arctrue.table.causes.polygon_faces import PolygonFaces
from arctrue.table.causes.polygon_mounting import PolygonMounting
from arctrue.table.causes.radial_motion import RadialMotion
from arctrue.table.causes.reading_latency import ReadingLatency
from arctrue.table.causes.sampling_skew import SamplingSkew
from arctrue.table.causes.saw_tooth_motion import SawToothMotion
from arctrue.table.causes.settling_bracket import SettlingBracket
from arctrue.table.causes.shaft_wind_up import ShaftWindUp
from arctrue.table.causes.signal_distortion import SignalDistortion
from arctrue.table.causes.sticking_bracket import StickingBracket
from arctrue.table.causes.thermal_centre import ThermalCentre
from arctrue.table.causes.warm_fast_lobes import WarmFastLobes
from arctrue.table.causes.warm_lobes import WarmLobes
from arctrue.table.causes.wearing_track import WearingTrack
from arctrue.table.rotary_table import two_heads
from arctrue.units import RAD_PER_ARCSEC

HEADS = two_heads()
MICROMETRE_M = 1e-6
STROKE_DEG = 1.0
"""Travel after a reversal in which a bearing's friction goes over, where none is given."""


class Values(Protocol):
    """Named values, asked for one by one; what is asked for and not as it should be is refused."""

    def number(
        self,
        key: str,
        default: float | None = None,
        *,
        low: float = -math.inf,
        high: float = math.inf,
        above: float | None = None,
    ) -> float:
        """A finite number."""

    def whole(
        self,
        key: str,
        default: int | None = None,
        *,
        low: float = -math.inf,
        high: float = math.inf,
    ) -> int:
        """A whole number."""

    def numbers(self, key: str) -> tuple[float, ...]:
        """Numbers, at least one."""


def _direction(values: Values) -> float:
    return math.radians(values.number("direction_deg", 0.0))


def _phase(values: Values, key: str = "phase_deg") -> float:
    return math.radians(values.number(key, 0.0))


def _arcsec(values: Values, key: str) -> float:
    return values.number(key) * RAD_PER_ARCSEC


def _head(values: Values, default: int | None = None) -> int:
    return values.whole("head", default, low=1, high=2) - 1


def graduation(values: Values, _: int) -> PhysicalEffect:
    return GraduationHarmonics(
        (values.whole("order", low=1),), (_arcsec(values, "arcsec"),), (_phase(values),)
    )


def eccentric(values: Values, _: int) -> PhysicalEffect:
    return DiscEccentricity(values.number("um") * MICROMETRE_M, _direction(values))


def bracket_turn(values: Values, _: int) -> PhysicalEffect:
    head = _head(values, 2)
    return BracketTurn(head, HEADS[head], _arcsec(values, "arcsec"))


def distortion(values: Values, lines: int) -> PhysicalEffect:
    return SignalDistortion(
        _head(values),
        lines,
        values.number("cosine_offset", 0.0, low=-0.5, high=0.5),
        values.number("sine_offset", 0.0, low=-0.5, high=0.5),
        values.number("gain_difference", 0.0, low=-0.5, high=0.5),
        math.radians(values.number("phase_error_deg", 0.0, low=-45, high=45)),
    )


def _ellipse(values: Values) -> tuple[complex, complex]:
    phase = _direction(values)
    forward = values.number("forward_um") * MICROMETRE_M
    backward = values.number("backward_um", 0.0) * MICROMETRE_M
    return cmath.rect(forward, phase), cmath.rect(backward, phase)


def radial(values: Values, _: int) -> PhysicalEffect:
    return RadialMotion(values.whole("order", low=1), *_ellipse(values))


def balls(values: Values, _: int) -> PhysicalEffect:
    return BallPass(values.number("order", above=0), *_ellipse(values))


def belt(values: Values, _: int) -> PhysicalEffect:
    return BeltPull(
        values.number("order", above=0),
        values.number("um") * MICROMETRE_M,
        _direction(values),
        _phase(values),
    )


def vibration(values: Values, _: int) -> PhysicalEffect:
    head = _head(values)
    return BracketVibration(
        head,
        HEADS[head],
        _arcsec(values, "arcsec"),
        values.number("hz", above=0),
        (_phase(values),),
    )


def wind_up(values: Values, _: int) -> PhysicalEffect:
    angle = _arcsec(values, "arcsec")
    return ShaftWindUp(angle, math.radians(values.number("stroke_deg", STROKE_DEG, low=0)))


def skew(values: Values, _: int) -> PhysicalEffect:
    return SamplingSkew(values.number("us") * 1e-6)


def latency(values: Values, _: int) -> PhysicalEffect:
    return ReadingLatency(values.number("us", low=0) * 1e-6)


def expansion(values: Values, _: int) -> PhysicalEffect:
    head = _head(values, 2)
    return BracketExpansion(head, HEADS[head], _arcsec(values, "arcsec_per_k"))


def thermal(values: Values, _: int) -> PhysicalEffect:
    rate = values.number("um_per_k") * MICROMETRE_M
    return ThermalCentre(cmath.rect(rate, _direction(values)))


def creeping(values: Values, _: int) -> PhysicalEffect:
    rate = values.number("um_per_turn") * MICROMETRE_M
    return CreepingCentre(cmath.rect(rate, _direction(values)))


def bump(values: Values, _: int) -> PhysicalEffect:
    return GraduationBump(
        _arcsec(values, "arcsec"),
        math.radians(values.number("place_deg")),
        math.radians(values.number("width_deg", above=0)),
        values.number("power", 2.0, above=0),
        values.number("skew", 0.0, low=-0.9, high=0.9),
    )


def gear(values: Values, _: int) -> PhysicalEffect:
    return GearMesh(
        values.whole("teeth", low=1),
        (_arcsec(values, "arcsec"),),
        (_phase(values),),
        values.number("wobble_rad", 0.0),
        _phase(values, "wobble_phase_deg"),
    )


def warm(values: Values, _: int) -> PhysicalEffect:
    return WarmLobes(values.whole("order", low=1), _arcsec(values, "arcsec_per_k"), _phase(values))


def centrifugal(values: Values, _: int) -> PhysicalEffect:
    return CentrifugalLobes(
        values.whole("order", low=1), _arcsec(values, "arcsec_s2"), _phase(values)
    )


def settling(values: Values, _: int) -> PhysicalEffect:
    head = _head(values, 2)
    angle, tau_s = _arcsec(values, "arcsec"), values.number("time_constant_s", above=0)
    # "Each run" is the time in which pauses count in full: see course.py.
    return SettlingBracket(head, HEADS[head], angle, tau_s, each_run=True)


def faces(values: Values, _: int) -> PhysicalEffect:
    return PolygonFaces(tuple(np.multiply(values.numbers("arcsec"), RAD_PER_ARCSEC).tolist()))


def polygon_mounting(values: Values, _: int) -> PhysicalEffect:
    return PolygonMounting(
        values.number("um") * MICROMETRE_M,
        values.number("flatness_um") * MICROMETRE_M,
        values.number("face_mm", above=0) * 1e-3,
        _arcsec(values, "tilt_arcsec"),
        float(np.deg2rad(values.number("roll_deg"))),
        _phase(values),
    )


def gain(values: Values, _: int) -> PhysicalEffect:
    return AutocollimatorScale(values.number("percent") / 100)


def drift(values: Values, _: int) -> PhysicalEffect:
    return InstrumentDrift(_arcsec(values, "arcsec_per_h") / 3600)


def flat_track(values: Values, _: int) -> PhysicalEffect:
    return FlatTrack(
        values.number("um") * MICROMETRE_M,
        _direction(values),
        _phase(values, "place_deg"),
        math.radians(values.number("width_deg", above=0)),
    )


def saw_tooth(values: Values, _: int) -> PhysicalEffect:
    return SawToothMotion(
        values.whole("order", low=1),
        values.number("um") * MICROMETRE_M,
        _direction(values),
        _phase(values),
        values.number("rise", 0.9, low=0.01, high=0.99),
    )


def warm_fast(values: Values, _: int) -> PhysicalEffect:
    return WarmFastLobes(
        values.whole("order", low=1), _arcsec(values, "arcsec_s2_per_k"), _phase(values)
    )


def sticking(values: Values, _: int) -> PhysicalEffect:
    head, slips_s = _head(values), values.numbers("slips_s")
    if len(slips_s) < 2 or list(slips_s) != sorted(set(slips_s)):
        raise ValueError(f"slips_s: expected two or more rising instants, found {list(slips_s)}")
    return StickingBracket(head, HEADS[head], _arcsec(values, "arcsec"), slips_s)


def loosening(values: Values, _: int) -> PhysicalEffect:
    head, knocks_s = _head(values), values.numbers("knocks_s")
    if list(knocks_s) != sorted(set(knocks_s)):
        raise ValueError(f"knocks_s: expected rising instants, found {list(knocks_s)}")
    return LooseningHead(head, HEADS[head], _arcsec(values, "arcsec"), knocks_s)


def wearing(values: Values, _: int) -> PhysicalEffect:
    return WearingTrack(
        values.whole("order", low=1),
        values.number("um_per_turn") * MICROMETRE_M,
        _direction(values),
        _phase(values),
    )


def leaning(values: Values, _: int) -> PhysicalEffect:
    head = _head(values)
    stroke = math.radians(values.number("stroke_deg", STROKE_DEG, above=0))
    return LeaningBracket(head, HEADS[head], _arcsec(values, "arcsec"), stroke)
