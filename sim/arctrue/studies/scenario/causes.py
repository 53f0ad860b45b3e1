"""The causes that a scenario can name, with what each needs; names as in arctrue.table.causes."""

from __future__ import annotations

import cmath
import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from arctrue.studies.scenario.section import Section
from arctrue.table import two_heads
from arctrue.table.causes.autocollimator_scale import AutocollimatorScale
from arctrue.table.causes.ball_pass import BallPass
from arctrue.table.causes.base import PhysicalEffect
from arctrue.table.causes.belt_half_order import BeltPull
from arctrue.table.causes.bracket_expansion import BracketExpansion
from arctrue.table.causes.bracket_turn import BracketTurn
from arctrue.table.causes.bracket_vibration import BracketVibration
from arctrue.table.causes.centrifugal_lobes import CentrifugalLobes
from arctrue.table.causes.disc_eccentricity import DiscEccentricity
from arctrue.table.causes.gear_mesh import GearMesh
from arctrue.table.causes.graduation_bump import GraduationBump
from arctrue.table.causes.graduation_harmonics import GraduationHarmonics
from arctrue.table.causes.instrument_drift import InstrumentDrift
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
from arctrue.units import RAD_PER_ARCSEC

Build = Callable[[Section, int], PhysicalEffect]
"""From the values in the file and the lines of the disc."""

HEADS = two_heads()
MICROMETRE_M = 1e-6


@dataclass(frozen=True, slots=True)
class CauseName:
    """One name that may stand in ``[[effect]]``."""

    name: str
    effect: str
    """Of the catalogue of the workbench; empty where that has none."""
    build: Build
    reference_only: bool = False
    """It falsifies what a reference instrument shows, and nothing of the table."""


def _direction(section: Section) -> float:
    return math.radians(section.number("direction_deg", 0.0))


def _phase(section: Section, key: str = "phase_deg") -> float:
    return math.radians(section.number(key, 0.0))


def _arcsec(section: Section, key: str) -> float:
    return section.number(key) * RAD_PER_ARCSEC


def _head(section: Section, default: int | None = None) -> int:
    return section.whole("head", default, low=1, high=2) - 1


def _graduation(section: Section, _: int) -> PhysicalEffect:
    return GraduationHarmonics(
        (section.whole("order", low=1),), (_arcsec(section, "arcsec"),), (_phase(section),)
    )


def _eccentric(section: Section, _: int) -> PhysicalEffect:
    return DiscEccentricity(section.number("um") * MICROMETRE_M, _direction(section))


def _bracket_turn(section: Section, _: int) -> PhysicalEffect:
    head = _head(section, 2)
    return BracketTurn(head, HEADS[head], _arcsec(section, "arcsec"))


def _distortion(section: Section, lines: int) -> PhysicalEffect:
    return SignalDistortion(
        _head(section),
        lines,
        section.number("cosine_offset", 0.0, low=-0.5, high=0.5),
        section.number("sine_offset", 0.0, low=-0.5, high=0.5),
        section.number("gain_difference", 0.0, low=-0.5, high=0.5),
        math.radians(section.number("phase_error_deg", 0.0, low=-45, high=45)),
    )


def _ellipse(section: Section) -> tuple[complex, complex]:
    phase = _direction(section)
    forward = section.number("forward_um") * MICROMETRE_M
    backward = section.number("backward_um", 0.0) * MICROMETRE_M
    return cmath.rect(forward, phase), cmath.rect(backward, phase)


def _radial(section: Section, _: int) -> PhysicalEffect:
    return RadialMotion(section.whole("order", low=1), *_ellipse(section))


def _balls(section: Section, _: int) -> PhysicalEffect:
    return BallPass(section.number("order", above=0), *_ellipse(section))


def _belt(section: Section, _: int) -> PhysicalEffect:
    return BeltPull(
        section.number("order", above=0),
        section.number("um") * MICROMETRE_M,
        _direction(section),
        _phase(section),
    )


def _vibration(section: Section, _: int) -> PhysicalEffect:
    head = _head(section)
    return BracketVibration(
        head,
        HEADS[head],
        _arcsec(section, "arcsec"),
        section.number("hz", above=0),
        (_phase(section),),
    )


def _wind_up(section: Section, _: int) -> PhysicalEffect:
    return ShaftWindUp(_arcsec(section, "arcsec"))


def _skew(section: Section, _: int) -> PhysicalEffect:
    return SamplingSkew(section.number("us") * 1e-6)


def _latency(section: Section, _: int) -> PhysicalEffect:
    return ReadingLatency(section.number("us", low=0) * 1e-6)


def _expansion(section: Section, _: int) -> PhysicalEffect:
    head = _head(section, 2)
    return BracketExpansion(head, HEADS[head], _arcsec(section, "arcsec_per_k"))


def _thermal(section: Section, _: int) -> PhysicalEffect:
    rate = section.number("um_per_k") * MICROMETRE_M
    return ThermalCentre(cmath.rect(rate, _direction(section)))


def _bump(section: Section, _: int) -> PhysicalEffect:
    return GraduationBump(
        _arcsec(section, "arcsec"),
        math.radians(section.number("place_deg")),
        math.radians(section.number("width_deg", above=0)),
    )


def _gear(section: Section, _: int) -> PhysicalEffect:
    return GearMesh(
        section.whole("teeth", low=1), (_arcsec(section, "arcsec"),), (_phase(section),)
    )


def _warm(section: Section, _: int) -> PhysicalEffect:
    return WarmLobes(
        section.whole("order", low=1), _arcsec(section, "arcsec_per_k"), _phase(section)
    )


def _centrifugal(section: Section, _: int) -> PhysicalEffect:
    return CentrifugalLobes(
        section.whole("order", low=1), _arcsec(section, "arcsec_s2"), _phase(section)
    )


def _settling(section: Section, _: int) -> PhysicalEffect:
    head = _head(section, 2)
    angle, tau_s = _arcsec(section, "arcsec"), section.number("time_constant_s", above=0)
    # "Each run" is the time in which pauses count in full: see course.py.
    return SettlingBracket(head, HEADS[head], angle, tau_s, each_run=True)


def _faces(section: Section, _: int) -> PhysicalEffect:
    return PolygonFaces(tuple(np.multiply(section.numbers("arcsec"), RAD_PER_ARCSEC).tolist()))


def _polygon_mounting(section: Section, _: int) -> PhysicalEffect:
    return PolygonMounting(
        section.number("um") * MICROMETRE_M,
        section.number("flatness_um") * MICROMETRE_M,
        section.number("face_mm", above=0) * 1e-3,
        _arcsec(section, "tilt_arcsec"),
        float(np.deg2rad(section.number("roll_deg"))),
        _phase(section),
    )


def _gain(section: Section, _: int) -> PhysicalEffect:
    return AutocollimatorScale(section.number("percent") / 100)


def _drift(section: Section, _: int) -> PhysicalEffect:
    return InstrumentDrift(_arcsec(section, "arcsec_per_h") / 3600)


_ALL = (
    CauseName("disc_eccentricity", "graduation_harmonics", _eccentric),
    CauseName("graduation_harmonics", "high_order_graduation", _graduation),
    CauseName("bracket_turn", "head_angle_error", _bracket_turn),
    CauseName("signal_distortion", "subdivision_error", _distortion),
    CauseName("radial_motion", "radial_error_motion", _radial),
    CauseName("ball_pass", "bearing_ball_pass", _balls),
    CauseName("bracket_vibration", "vibration", _vibration),
    CauseName("shaft_wind_up", "hysteresis", _wind_up),
    CauseName("sampling_skew", "timing_skew", _skew),
    CauseName("reading_latency", "latency", _latency),
    CauseName("bracket_expansion", "thermal_head_drift", _expansion),
    CauseName("thermal_centre", "thermal_eccentricity", _thermal),
    CauseName("graduation_bump", "graduation_defect", _bump),
    CauseName("gear_mesh", "drive_gear_error", _gear),
    CauseName("polygon_faces", "polygon_face_error", _faces, True),
    CauseName("polygon_mounting", "polygon_eccentricity", _polygon_mounting, True),
    CauseName("autocollimator_scale", "autocollimator_gain", _gain, True),
    CauseName("instrument_drift", "reference_drift", _drift, True),
    CauseName("belt_half_order", "", _belt),
    CauseName("warm_lobes", "", _warm),
    CauseName("centrifugal_lobes", "", _centrifugal),
    CauseName("settling_bracket", "", _settling),
)

CAUSES = {cause.name: cause for cause in _ALL}
"""By name. ``count_slip`` has none: a counter loses counts by a fault of its pins."""
