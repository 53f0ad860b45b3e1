"""Every cause of the simulated table: by its name, and how it is drawn.

The one registry: captures, edges, polygon runs, scenarios, hidden effects, ``simulate`` and the
benchmark take their causes from here. What a consumer cannot honour it refuses, see
:func:`arctrue.table.causes.cause.refuse_unhonoured`.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from arctrue.table.causes import drawn, given
from arctrue.table.causes.autocollimator_scale import AutocollimatorScale
from arctrue.table.causes.autoregressive_noise import AutoregressiveNoise
from arctrue.table.causes.ball_pass import BallPass
from arctrue.table.causes.base import PhysicalEffect
from arctrue.table.causes.belt_half_order import BeltPull
from arctrue.table.causes.bracket_expansion import BracketExpansion
from arctrue.table.causes.bracket_turn import BracketTurn
from arctrue.table.causes.bracket_vibration import BracketVibration
from arctrue.table.causes.centrifugal_lobes import CentrifugalLobes
from arctrue.table.causes.creeping_centre import CreepingCentre
from arctrue.table.causes.disc_eccentricity import DiscEccentricity
from arctrue.table.causes.drawn import Build, Occasion, Random
from arctrue.table.causes.flat_track import FlatTrack
from arctrue.table.causes.gear_mesh import GearMesh
from arctrue.table.causes.given import Given
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

__all__ = [
    "CAUSES",
    "NOISES",
    "RECIPES",
    "REGISTRY",
    "STRANGERS",
    "NamedCause",
    "Occasion",
    "Recipe",
]

Kind = Literal["catalogue", "parts", "stranger", "noise"]
"""An effect of the catalogue; a product of parts; neither of both; noise, which is no effect."""


@dataclass(frozen=True, slots=True)
class NamedCause:
    """A cause by the name of its file."""

    name: str
    kind: type[PhysicalEffect]
    given: type[Given] | None = None
    """Values that somebody may give; None: it is only drawn."""


@dataclass(frozen=True, slots=True)
class Recipe:
    """One cause with its range of sizes."""

    name: str
    """Of the effect, as the catalogue has it."""
    cause: str
    """Of the cause, a key of CAUSES."""
    unit: str
    """Of the size."""
    low: float
    high: float
    build: Build
    kind: Kind = "catalogue"
    parts: tuple[str, ...] = ()
    """Of a product of parts: what it is made of."""

    @property
    def in_catalogue(self) -> bool:
        """The workbench knows an effect of this name."""
        return self.kind == "catalogue"

    def draw_size(self, random: Random) -> float:
        """A size between low and high, as likely in each octave."""
        return float(np.exp(random.uniform(np.log(self.low), np.log(self.high))))


_CAUSES = (
    NamedCause("autocollimator_scale", AutocollimatorScale, given.Gain),
    NamedCause("autoregressive_noise", AutoregressiveNoise),
    NamedCause("ball_pass", BallPass, given.Balls),
    NamedCause("belt_half_order", BeltPull, given.Belt),
    NamedCause("bracket_expansion", BracketExpansion, given.Expansion),
    NamedCause("bracket_turn", BracketTurn, given.Turn),
    NamedCause("bracket_vibration", BracketVibration, given.Vibration),
    NamedCause("centrifugal_lobes", CentrifugalLobes, given.Centrifugal),
    NamedCause("creeping_centre", CreepingCentre, given.Creeping),
    NamedCause("disc_eccentricity", DiscEccentricity, given.Eccentric),
    NamedCause("flat_track", FlatTrack, given.Flat),
    NamedCause("gear_mesh", GearMesh, given.Gear),
    NamedCause("graduation_bump", GraduationBump, given.Bump),
    NamedCause("graduation_harmonics", GraduationHarmonics, given.Graduation),
    NamedCause("index_scatter", IndexScatter),
    NamedCause("instrument_drift", InstrumentDrift, given.Drift),
    NamedCause("leaning_bracket", LeaningBracket, given.Leaning),
    NamedCause("loosening_head", LooseningHead, given.Loosening),
    NamedCause("lost_counts", LostCounts),
    NamedCause("noise_by_angle", NoiseByAngle),
    NamedCause("outliers", Outliers),
    NamedCause("polygon_faces", PolygonFaces, given.Faces),
    NamedCause("polygon_mounting", PolygonMounting, given.Mounting),
    NamedCause("power_law_noise", PowerLawNoise),
    NamedCause("radial_motion", RadialMotion, given.Radial),
    NamedCause("reading_latency", ReadingLatency, given.Latency),
    NamedCause("relaxing_noise", RelaxingNoise),
    NamedCause("sampling_skew", SamplingSkew, given.Skew),
    NamedCause("saw_tooth_motion", SawToothMotion, given.SawTooth),
    NamedCause("sensor_lag", SensorLag),
    NamedCause("settling_bracket", SettlingBracket, given.Settling),
    NamedCause("shaft_wind_up", ShaftWindUp, given.WindUp),
    NamedCause("signal_distortion", SignalDistortion, given.Distortion),
    NamedCause("sticking_bracket", StickingBracket, given.Sticking),
    NamedCause("swinging_speed", SwingingSpeed),
    NamedCause("thermal_centre", ThermalCentre, given.Thermal),
    NamedCause("time_gaps", TimeGaps),
    NamedCause("wandering_reference", WanderingReference),
    NamedCause("warm_fast_lobes", WarmFastLobes, given.WarmFast),
    NamedCause("warm_lobes", WarmLobes, given.Warm),
    NamedCause("wearing_track", WearingTrack, given.Wearing),
    NamedCause("white_noise", WhiteNoise),
)

CAUSES = {cause.name: cause for cause in _CAUSES}
"""Every cause by the name of its file."""

_ALL = (
    Recipe("high_order_graduation", "graduation_harmonics", "arcsec", 0.1, 1.0, drawn.high_order),
    Recipe("head_angle_error", "bracket_turn", "arcsec", 2.0, 60.0, drawn.head_angle),
    Recipe("subdivision_error", "signal_distortion", "arcsec", 0.06, 2.4, drawn.subdivision),
    Recipe("radial_error_motion", "radial_motion", "um", 0.1, 2.0, drawn.radial),
    Recipe("bearing_ball_pass", "ball_pass", "um", 0.1, 1.0, drawn.ball_pass),
    Recipe("vibration", "bracket_vibration", "arcsec", 0.1, 1.0, drawn.vibration),
    Recipe("hysteresis", "shaft_wind_up", "arcsec", 0.2, 5.0, drawn.hysteresis),
    Recipe("timing_skew", "sampling_skew", "us", 1.0, 20.0, drawn.skew),
    Recipe("latency", "reading_latency", "us", 2.0, 50.0, drawn.latency),
    Recipe("thermal_head_drift", "bracket_expansion", "arcsec/K", 0.1, 1.0, drawn.head_drift),
    Recipe("thermal_eccentricity", "thermal_centre", "um/K", 0.1, 0.9, drawn.thermal_centre),
    Recipe("count_slip", "lost_counts", "counts", 4.0, 64.0, drawn.slip),
    Recipe("graduation_defect", "graduation_bump", "arcsec", 0.5, 5.0, drawn.defect),
    Recipe("drive_gear_error", "gear_mesh", "arcsec", 0.3, 3.0, drawn.gear),
    Recipe("polygon_face_error", "polygon_faces", "arcsec", 0.1, 0.5, drawn.faces),
    Recipe("polygon_eccentricity", "polygon_mounting", "arcsec", 0.1, 1.0, drawn.polygon_mounting),
    Recipe("autocollimator_gain", "autocollimator_scale", "percent", 0.1, 1.0, drawn.gain),
    Recipe("reference_drift", "instrument_drift", "arcsec/h", 0.3, 3.0, drawn.drift),
    Recipe(
        "warm_ovality",
        "warm_lobes",
        "arcsec/K",
        0.1,
        0.5,
        drawn.warm,
        "parts",
        ("temperature", "order:2", "disc"),
    ),
    Recipe(
        "centrifugal_lobes",
        "centrifugal_lobes",
        "arcsec/(rad/s)^2",
        0.1,
        0.5,
        drawn.centrifugal,
        "parts",
        ("speed^2", "order:3", "disc"),
    ),
    Recipe(
        "half_order",
        "belt_half_order",
        "um",
        0.1,
        1.0,
        drawn.half_order,
        "parts",
        ("order:*", "stator"),
    ),
    Recipe(
        "settling_bracket",
        "settling_bracket",
        "arcsec",
        0.5,
        3.0,
        drawn.settling,
        "parts",
        ("settling", "head2"),
    ),
    Recipe("flat_track", "flat_track", "um", 0.2, 2.0, drawn.flat, "stranger"),
    Recipe("saw_tooth_motion", "saw_tooth_motion", "um", 0.1, 1.0, drawn.saw, "stranger"),
    Recipe(
        "warm_fast_lobes",
        "warm_fast_lobes",
        "arcsec/K/(rad/s)^2",
        0.1,
        1.0,
        drawn.warm_fast,
        "stranger",
    ),
    Recipe("sticking_bracket", "sticking_bracket", "arcsec", 0.1, 1.0, drawn.sticking, "stranger"),
    Recipe("loosening_head", "loosening_head", "arcsec", 0.3, 3.0, drawn.loosening, "stranger"),
    Recipe("wearing_track", "wearing_track", "um", 0.2, 2.0, drawn.wearing, "stranger"),
    Recipe("leaning_bracket", "leaning_bracket", "arcsec", 0.2, 3.0, drawn.leaning, "stranger"),
    Recipe("white", "white_noise", "arcsec", 0.02, 0.5, drawn.white, "noise"),
    Recipe("by_angle", "noise_by_angle", "arcsec", 0.05, 0.3, drawn.by_angle, "noise"),
    Recipe("pink", "power_law_noise", "arcsec", 0.03, 0.3, drawn.pink, "noise"),
    Recipe("power_law", "power_law_noise", "arcsec", 0.03, 0.3, drawn.power_law, "noise"),
    Recipe("ornstein_uhlenbeck", "relaxing_noise", "arcsec", 0.03, 0.3, drawn.relaxing, "noise"),
    Recipe(
        "autoregressive", "autoregressive_noise", "arcsec", 0.03, 0.3, drawn.autoregressive, "noise"
    ),
    Recipe("outliers", "outliers", "percent", 0.01, 1.0, drawn.outliers, "noise"),
    Recipe("index_scatter", "index_scatter", "counts", 1.0, 3.0, drawn.index, "noise"),
    Recipe("sensor_lag", "sensor_lag", "minutes", 0.5, 10.0, drawn.lag, "noise"),
    Recipe(
        "wandering_reference", "wandering_reference", "arcsec", 0.05, 0.5, drawn.wander, "noise"
    ),
    Recipe("gaps", "time_gaps", "percent", 0.5, 20.0, drawn.gaps, "noise"),
    Recipe("swinging_speed", "swinging_speed", "percent", 0.5, 8.0, drawn.swing, "noise"),
)

REGISTRY = {recipe.name: recipe for recipe in _ALL}
"""Every cause by its name."""
RECIPES = {recipe.name: recipe for recipe in _ALL if recipe.kind in ("catalogue", "parts")}
STRANGERS = {recipe.name: recipe for recipe in _ALL if recipe.kind == "stranger"}
NOISES = {recipe.name: recipe for recipe in _ALL if recipe.kind == "noise"}
