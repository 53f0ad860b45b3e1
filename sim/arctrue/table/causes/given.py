"""A cause from values that somebody gives: each declares its keys, units, defaults and limits."""

from __future__ import annotations

import cmath
import math
from typing import Annotated

import numpy as np
from msgspec import Meta, Struct

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
from arctrue.typed_content import NotNegative, Number, Positive
from arctrue.units import RAD_PER_ARCSEC

HEADS = two_heads()
MICROMETRE_M = 1e-6
STROKE_DEG = 1.0
"""Travel after a reversal in which a bearing's friction goes over, where none is given."""

Order = Annotated[int, Meta(ge=1)]
HeadNumber = Annotated[int, Meta(ge=1, le=2)]
Half = Annotated[float, Meta(ge=-0.5, le=0.5)]


class Given(Struct, frozen=True, forbid_unknown_fields=True):
    """Values of a cause, by their keys in an ``[[effect]]`` of a scenario."""

    cause: str

    def physical(self, lines: int) -> PhysicalEffect:
        """The cause, on a disc of ``lines``. Raises ValueError for values that do not agree."""
        raise NotImplementedError


def _rising(key: str, instants_s: tuple[float, ...], least: int) -> None:
    if len(instants_s) < least or list(instants_s) != sorted(set(instants_s)):
        expected = "rising instants" if least == 1 else "two or more rising instants"
        raise ValueError(f"{key}: expected {expected}, found {list(instants_s)}")


def _ellipse(
    forward_um: float, backward_um: float, direction_deg: float
) -> tuple[complex, complex]:
    phase = math.radians(direction_deg)
    return (
        cmath.rect(forward_um * MICROMETRE_M, phase),
        cmath.rect(backward_um * MICROMETRE_M, phase),
    )


class Graduation(Given, frozen=True):
    order: Order
    arcsec: Number
    phase_deg: Number = 0.0

    def physical(self, lines: int) -> PhysicalEffect:
        size, phase = self.arcsec * RAD_PER_ARCSEC, math.radians(self.phase_deg)
        return GraduationHarmonics((self.order,), (size,), (phase,))


class Eccentric(Given, frozen=True):
    um: Number
    direction_deg: Number = 0.0

    def physical(self, lines: int) -> PhysicalEffect:
        return DiscEccentricity(self.um * MICROMETRE_M, math.radians(self.direction_deg))


class Turn(Given, frozen=True):
    arcsec: Number
    head: HeadNumber = 2

    def physical(self, lines: int) -> PhysicalEffect:
        return BracketTurn(self.head - 1, HEADS[self.head - 1], self.arcsec * RAD_PER_ARCSEC)


class Distortion(Given, frozen=True):
    head: HeadNumber
    cosine_offset: Half = 0.0
    sine_offset: Half = 0.0
    gain_difference: Half = 0.0
    phase_error_deg: Annotated[float, Meta(ge=-45, le=45)] = 0.0

    def physical(self, lines: int) -> PhysicalEffect:
        return SignalDistortion(
            self.head - 1,
            lines,
            self.cosine_offset,
            self.sine_offset,
            self.gain_difference,
            math.radians(self.phase_error_deg),
        )


class Radial(Given, frozen=True):
    order: Order
    forward_um: Number
    backward_um: Number = 0.0
    direction_deg: Number = 0.0

    def physical(self, lines: int) -> PhysicalEffect:
        ellipse = _ellipse(self.forward_um, self.backward_um, self.direction_deg)
        return RadialMotion(self.order, *ellipse)


class Balls(Given, frozen=True):
    order: Positive
    forward_um: Number
    backward_um: Number = 0.0
    direction_deg: Number = 0.0

    def physical(self, lines: int) -> PhysicalEffect:
        return BallPass(
            self.order, *_ellipse(self.forward_um, self.backward_um, self.direction_deg)
        )


class Belt(Given, frozen=True):
    order: Positive
    um: Number
    direction_deg: Number = 0.0
    phase_deg: Number = 0.0

    def physical(self, lines: int) -> PhysicalEffect:
        return BeltPull(
            self.order,
            self.um * MICROMETRE_M,
            math.radians(self.direction_deg),
            math.radians(self.phase_deg),
        )


class Vibration(Given, frozen=True):
    head: HeadNumber
    arcsec: Number
    hz: Positive
    phase_deg: Number = 0.0

    def physical(self, lines: int) -> PhysicalEffect:
        head = self.head - 1
        phases = (math.radians(self.phase_deg),)
        return BracketVibration(head, HEADS[head], self.arcsec * RAD_PER_ARCSEC, self.hz, phases)


class WindUp(Given, frozen=True):
    arcsec: Number
    stroke_deg: NotNegative = STROKE_DEG

    def physical(self, lines: int) -> PhysicalEffect:
        return ShaftWindUp(self.arcsec * RAD_PER_ARCSEC, math.radians(self.stroke_deg))


class Skew(Given, frozen=True):
    us: Number

    def physical(self, lines: int) -> PhysicalEffect:
        return SamplingSkew(self.us * 1e-6)


class Latency(Given, frozen=True):
    us: NotNegative

    def physical(self, lines: int) -> PhysicalEffect:
        return ReadingLatency(self.us * 1e-6)


class Expansion(Given, frozen=True):
    arcsec_per_k: Number
    head: HeadNumber = 2

    def physical(self, lines: int) -> PhysicalEffect:
        head = self.head - 1
        return BracketExpansion(head, HEADS[head], self.arcsec_per_k * RAD_PER_ARCSEC)


class Thermal(Given, frozen=True):
    um_per_k: Number
    direction_deg: Number = 0.0

    def physical(self, lines: int) -> PhysicalEffect:
        direction_rad = math.radians(self.direction_deg)
        return ThermalCentre(cmath.rect(self.um_per_k * MICROMETRE_M, direction_rad))


class Creeping(Given, frozen=True):
    um_per_turn: Number
    direction_deg: Number = 0.0

    def physical(self, lines: int) -> PhysicalEffect:
        direction_rad = math.radians(self.direction_deg)
        return CreepingCentre(cmath.rect(self.um_per_turn * MICROMETRE_M, direction_rad))


class Bump(Given, frozen=True):
    arcsec: Number
    place_deg: Number
    width_deg: Positive
    power: Positive = 2.0
    skew: Annotated[float, Meta(ge=-0.9, le=0.9)] = 0.0

    def physical(self, lines: int) -> PhysicalEffect:
        return GraduationBump(
            self.arcsec * RAD_PER_ARCSEC,
            math.radians(self.place_deg),
            math.radians(self.width_deg),
            self.power,
            self.skew,
        )


class Gear(Given, frozen=True):
    teeth: Order
    arcsec: Number
    phase_deg: Number = 0.0
    wobble_rad: Number = 0.0
    wobble_phase_deg: Number = 0.0

    def physical(self, lines: int) -> PhysicalEffect:
        return GearMesh(
            self.teeth,
            (self.arcsec * RAD_PER_ARCSEC,),
            (math.radians(self.phase_deg),),
            self.wobble_rad,
            math.radians(self.wobble_phase_deg),
        )


class Warm(Given, frozen=True):
    order: Order
    arcsec_per_k: Number
    phase_deg: Number = 0.0

    def physical(self, lines: int) -> PhysicalEffect:
        rate = self.arcsec_per_k * RAD_PER_ARCSEC
        return WarmLobes(self.order, rate, math.radians(self.phase_deg))


class Centrifugal(Given, frozen=True):
    order: Order
    arcsec_s2: Number
    phase_deg: Number = 0.0

    def physical(self, lines: int) -> PhysicalEffect:
        rate = self.arcsec_s2 * RAD_PER_ARCSEC
        return CentrifugalLobes(self.order, rate, math.radians(self.phase_deg))


class Settling(Given, frozen=True):
    arcsec: Number
    time_constant_s: Positive
    head: HeadNumber = 2

    def physical(self, lines: int) -> PhysicalEffect:
        head, angle = self.head - 1, self.arcsec * RAD_PER_ARCSEC
        # "Each run" is the time in which pauses count in full: see course.py.
        return SettlingBracket(head, HEADS[head], angle, self.time_constant_s, each_run=True)


class Faces(Given, frozen=True):
    arcsec: Annotated[tuple[Number, ...], Meta(min_length=1)]

    def physical(self, lines: int) -> PhysicalEffect:
        return PolygonFaces(tuple(np.multiply(self.arcsec, RAD_PER_ARCSEC).tolist()))


class Mounting(Given, frozen=True):
    um: Number
    flatness_um: Number
    face_mm: Positive
    tilt_arcsec: Number
    roll_deg: Number
    phase_deg: Number = 0.0

    def physical(self, lines: int) -> PhysicalEffect:
        return PolygonMounting(
            self.um * MICROMETRE_M,
            self.flatness_um * MICROMETRE_M,
            self.face_mm * 1e-3,
            self.tilt_arcsec * RAD_PER_ARCSEC,
            float(np.deg2rad(self.roll_deg)),
            math.radians(self.phase_deg),
        )


class Gain(Given, frozen=True):
    percent: Number

    def physical(self, lines: int) -> PhysicalEffect:
        return AutocollimatorScale(self.percent / 100)


class Drift(Given, frozen=True):
    arcsec_per_h: Number

    def physical(self, lines: int) -> PhysicalEffect:
        return InstrumentDrift(self.arcsec_per_h * RAD_PER_ARCSEC / 3600)


class Flat(Given, frozen=True):
    um: Number
    width_deg: Positive
    direction_deg: Number = 0.0
    place_deg: Number = 0.0

    def physical(self, lines: int) -> PhysicalEffect:
        return FlatTrack(
            self.um * MICROMETRE_M,
            math.radians(self.direction_deg),
            math.radians(self.place_deg),
            math.radians(self.width_deg),
        )


class SawTooth(Given, frozen=True):
    order: Order
    um: Number
    direction_deg: Number = 0.0
    phase_deg: Number = 0.0
    rise: Annotated[float, Meta(ge=0.01, le=0.99)] = 0.9

    def physical(self, lines: int) -> PhysicalEffect:
        return SawToothMotion(
            self.order,
            self.um * MICROMETRE_M,
            math.radians(self.direction_deg),
            math.radians(self.phase_deg),
            self.rise,
        )


class WarmFast(Given, frozen=True):
    order: Order
    arcsec_s2_per_k: Number
    phase_deg: Number = 0.0

    def physical(self, lines: int) -> PhysicalEffect:
        rate = self.arcsec_s2_per_k * RAD_PER_ARCSEC
        return WarmFastLobes(self.order, rate, math.radians(self.phase_deg))


class Sticking(Given, frozen=True):
    head: HeadNumber
    arcsec: Number
    slips_s: tuple[Number, ...]

    def __post_init__(self) -> None:
        _rising("slips_s", self.slips_s, 2)

    def physical(self, lines: int) -> PhysicalEffect:
        head, angle = self.head - 1, self.arcsec * RAD_PER_ARCSEC
        return StickingBracket(head, HEADS[head], angle, self.slips_s)


class Loosening(Given, frozen=True):
    head: HeadNumber
    arcsec: Number
    knocks_s: tuple[Number, ...]

    def __post_init__(self) -> None:
        _rising("knocks_s", self.knocks_s, 1)

    def physical(self, lines: int) -> PhysicalEffect:
        head, angle = self.head - 1, self.arcsec * RAD_PER_ARCSEC
        return LooseningHead(head, HEADS[head], angle, self.knocks_s)


class Wearing(Given, frozen=True):
    order: Order
    um_per_turn: Number
    direction_deg: Number = 0.0
    phase_deg: Number = 0.0

    def physical(self, lines: int) -> PhysicalEffect:
        return WearingTrack(
            self.order,
            self.um_per_turn * MICROMETRE_M,
            math.radians(self.direction_deg),
            math.radians(self.phase_deg),
        )


class Leaning(Given, frozen=True):
    head: HeadNumber
    arcsec: Number
    stroke_deg: Positive = STROKE_DEG

    def physical(self, lines: int) -> PhysicalEffect:
        head, angle = self.head - 1, self.arcsec * RAD_PER_ARCSEC
        return LeaningBracket(head, HEADS[head], angle, math.radians(self.stroke_deg))
