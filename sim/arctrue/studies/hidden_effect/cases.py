"""Defines the hidden effects, and the runs that a user would make to find them."""

from __future__ import annotations

import cmath
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass

from arctrue.base.units import RAD_PER_ARCSEC
from arctrue.studies.hidden_effect.settings import HiddenSettings
from arctrue.table.cause import Cause
from arctrue.table.causes.centrifugal_lobes import CentrifugalLobes
from arctrue.table.causes.gear_mesh import GearMesh
from arctrue.table.causes.graduation_bump import GraduationBump
from arctrue.table.causes.loose_centre import LooseCentre
from arctrue.table.causes.reading_latency import ReadingLatency
from arctrue.table.causes.shaft_wind_up import ShaftWindUp
from arctrue.table.causes.signal_distortion import SignalDistortion
from arctrue.table.causes.thermal_centre import ThermalCentre
from arctrue.table.causes.warm_lobes import WarmLobes
from arctrue.table.conditions import USUAL_TEMPERATURE_C

Build = Callable[[HiddenSettings], list[Cause]]

COLD_C = USUAL_TEMPERATURE_C
WARM_C = USUAL_TEMPERATURE_C + 4.0
STROKE_RAD = math.radians(1.0)
"""Travel after a reversal over which the friction changes sign; far shorter than the distance
between two stations."""
FRESH_C = USUAL_TEMPERATURE_C + 2.5
"""In the cases with a thermal effect: temperature of the judged turns, in which the corrected
output is compared with the true angle. No measured run of these cases has this temperature."""


@dataclass(frozen=True, slots=True)
class RunPlan:
    """Plan of a run: after a power-up, some turns at one speed are captured; a reference may read
    the same turns."""

    side: int = 1
    turns: int = 2
    temperature_c: tuple[float, float] = (COLD_C, COLD_C)
    start_s: float = 0.0
    reference: bool = False
    speed: float = 1.0
    """Speed in units of the usual speed."""
    second_speed: float | None = None
    """Second speed in units of the usual speed; in each turn, the table changes to this speed and
    back."""


@dataclass(frozen=True, slots=True)
class DriveIndex:
    """Index of the drive: ``per_turn`` pulses come per turn of the table, one of them at the angle
    ``first_turns`` (turns).
    """

    per_turn: float
    first_turns: float = 0.3


@dataclass(frozen=True, slots=True)
class Case:
    """Hidden effect, the runs that find it, and the run that judges the correction."""

    name: str
    title: str
    """Title for the page and the terminal."""
    build: Build
    further: tuple[RunPlan, ...] = ()
    """Runs after the first run. The first run is the same in all cases: two turns upwards at the
    usual temperature."""
    polygon: bool = False
    """Whether the reference is a polygon, read at stations, up and down; if False, it is read while
    the table moves past marks."""
    fresh: RunPlan = RunPlan(start_s=3600.0)
    """Run in which the result is judged, after a new power-up; without further runs, the first run
    continues instead."""
    judged_order: int | None = None
    """Order at which the effect appears in the output's error; None: the largest error is
    judged."""
    added: tuple[str, Mapping[str, object]] | None = None
    """Effect and settings that the user, who knows the drive, adds; None: the effect of the
    diagnosis is added."""
    effects: int = 1
    """Number of effects that are added, one after the other."""
    least_lanes: int = 1
    modulators: bool = False
    """Whether the gateware has lanes that follow direction and speed."""
    local_table: bool = False
    """Whether the gateware has the local table, whose points over the turn are interpolated."""
    real_orders: bool = False
    """Whether the gateware has lanes of real orders, which need not be integers."""
    drive_gear_teeth: float | None = None
    """Tooth count of the drive's gear, which the measurement set states."""
    probe: DriveIndex | None = None
    """Index of the drive at the pin ``probe_in``, from which the firmware computes the phase of
    real orders; None: the operator states the phase."""
    lines: tuple[float, ...] = ()
    """Orders whose amplitudes in the output are judged in both directions."""
    reference_turns: int = 1
    """Number of turns over which the reference is read while the table moves."""
    order1_warms: bool = False
    """Whether order 1 changes with the temperature, so that a correction can follow it while the
    table warms."""

    @property
    def slowest(self) -> float:
        """Return the smallest speed, in units of the usual speed; at this speed a turn must still
        fit into a bank."""
        plans = (*self.further, self.fresh)
        return min(1.0, *(plan.second_speed or plan.speed for plan in plans))


def _subdivision(settings: HiddenSettings) -> list[Cause]:
    # An offset of the share p of the signals' amplitude causes an error of p radians of the signal
    # period: p = 0.050 of head 1 causes 0.63″ at 16,384 lines.
    lines = settings.revolution.lines
    return [
        SignalDistortion(0, lines, 0.036, 0.035, 0.016, 0.012),
        SignalDistortion(1, lines, -0.030, 0.024, -0.014, 0.012),
    ]


def _coarser(settings: HiddenSettings) -> float:
    """Return the size of a count divided by its size at the paper's scale; the hidden effects are
    enlarged by this factor."""
    return (1 << 24) / settings.revolution.counts_per_rev


def _thermal_centre(settings: HiddenSettings) -> list[Cause]:
    # 0.4 µm/K at a radius of 54 mm are 1.5″/K.
    return [ThermalCentre(cmath.rect(0.4e-6 * _coarser(settings), 1.1))]


def _wind_up(settings: HiddenSettings) -> list[Cause]:
    return [ShaftWindUp(1.0 * RAD_PER_ARCSEC * _coarser(settings), STROKE_RAD)]


def _warm_lobes(settings: HiddenSettings) -> list[Cause]:
    return [WarmLobes(2, 0.4 * RAD_PER_ARCSEC * _coarser(settings), 0.7)]


def _latency(settings: HiddenSettings) -> list[Cause]:
    # The effect is 28 counts at 30°/s at every scale.
    return [ReadingLatency(20e-6 * _coarser(settings))]


def _centrifugal(settings: HiddenSettings) -> list[Cause]:
    # The effect is 0.55″ at 30°/s.
    return [CentrifugalLobes(3, 2.0 * RAD_PER_ARCSEC * _coarser(settings), 0.9)]


def _loose_centre(settings: HiddenSettings) -> list[Cause]:
    # 0.2 µm at a radius of 54 mm are 0.76″.
    return [LooseCentre(cmath.rect(0.2e-6 * _coarser(settings), 0.4))]


def _scratch(settings: HiddenSettings) -> list[Cause]:
    # The bump is 20″ high, 0.2° wide at half maximum, at 84° of the disc. With coarser counts,
    # height and width grow with the square root of the count's size, so that the slope stays the
    # same, and no head moves by two counts in a clock.
    larger = math.sqrt(_coarser(settings))
    width_rad = math.radians(0.2) * larger / SIGMAS_OF_HALF
    return [GraduationBump(20.0 * RAD_PER_ARCSEC * larger, math.radians(84.0), width_rad)]


SIGMAS_OF_HALF = 2.0 * math.sqrt(2.0 * math.log(2.0))
"""Full width of a bell at half of its maximum, in standard deviations."""


GEAR_TEETH = 71.4
"""Number of gear teeth that pass per turn of the table: 357 teeth in five turns."""


def _gear(settings: HiddenSettings) -> list[Cause]:
    # The amplitude is 1″. The gear twists the shaft between disc and table top: both heads read the
    # same turn of the disc, so that only a reference on the table top shows the error.
    return [GearMesh(GEAR_TEETH, (1.0 * RAD_PER_ARCSEC * _coarser(settings),), (0.8,))]


MESH_WOBBLE_RAD = 0.3
"""Modulation of the mesh by an eccentric gear, radians: the orders one below and one above the
gear's order have 15 % of its amplitude."""
PINION_TEETH = 21
BELT_ORDER = 0.5


def _eccentric_gear(settings: HiddenSettings) -> list[Cause]:
    size = 1.0 * RAD_PER_ARCSEC * _coarser(settings)
    return [GearMesh(GEAR_TEETH, (size,), (0.8,), MESH_WOBBLE_RAD, 1.9)]


def _belt(settings: HiddenSettings) -> list[Cause]:
    # The belt is twice as long as the circumference of the pulley: therefore it twists the shaft
    # once in two turns.
    return [GearMesh(BELT_ORDER, (1.0 * RAD_PER_ARCSEC * _coarser(settings),), (-1.1,))]


def _at_once(settings: HiddenSettings) -> list[Cause]:
    builds = (_latency, _centrifugal, _loose_centre, _thermal_centre)
    return [cause for build in builds for cause in build(settings)]


SLOW = 0.5
"""Second measured speed, in units of the usual speed."""
BETWEEN = 0.7
"""Third speed, in units of the usual speed. The case ``centrifugal_lobes`` is judged at this speed,
but has no measured run at it; the case ``latency`` has such a run.
"""

_WARMING = (
    RunPlan(start_s=900.0, temperature_c=(COLD_C + 1.5, COLD_C + 2.0)),
    RunPlan(start_s=1800.0, temperature_c=(WARM_C - 0.5, WARM_C), reference=True),
    RunPlan(start_s=2700.0, side=-1, temperature_c=(WARM_C, WARM_C)),
)

_ALL = (
    Case("subdivision_error", "error of the interpolation", _subdivision),
    Case(
        "thermal_eccentricity",
        "a disc whose centre wanders with heat",
        _thermal_centre,
        _WARMING,
        fresh=RunPlan(start_s=3600.0, temperature_c=(FRESH_C, FRESH_C)),
        order1_warms=True,
    ),
    Case(
        "hysteresis",
        "a shaft that winds up",
        _wind_up,
        (RunPlan(side=-1),),
        polygon=True,
        modulators=True,
    ),
    Case(
        "latency",
        "readings that are 20 µs old",
        _latency,
        (
            RunPlan(start_s=900.0, speed=SLOW, reference=True),
            RunPlan(start_s=1800.0, speed=BETWEEN, reference=True),
        ),
        modulators=True,
        fresh=RunPlan(start_s=3600.0, second_speed=SLOW),
    ),
    Case(
        "centrifugal_lobes",
        "a disc that the centrifugal force stretches three times a turn",
        _centrifugal,
        # The speeds of the runs do not rise or fall steadily in time, so that effects of speed and
        # of time can be separated.
        (
            RunPlan(start_s=900.0, speed=SLOW, reference=True),
            RunPlan(start_s=1800.0, speed=0.85, reference=True),
        ),
        modulators=True,
        fresh=RunPlan(start_s=3600.0, speed=BETWEEN),
        judged_order=3,
    ),
    Case(
        "loose_centre",
        "a disc that shifts within its clearance with the direction",
        _loose_centre,
        (RunPlan(start_s=900.0, side=-1, reference=True),),
        modulators=True,
        fresh=RunPlan(start_s=3600.0, side=-1),
        judged_order=1,
    ),
    Case(
        "all_at_once",
        "latency, centrifugal lobes, a loose centre, and a centre that wanders with heat",
        _at_once,
        (
            RunPlan(start_s=900.0, speed=SLOW, reference=True),
            RunPlan(start_s=1800.0, side=-1, reference=True),
            RunPlan(start_s=2700.0, temperature_c=(WARM_C, WARM_C), reference=True),
            RunPlan(
                start_s=3000.0, side=-1, speed=SLOW, temperature_c=(WARM_C, WARM_C), reference=True
            ),
        ),
        modulators=True,
        fresh=RunPlan(start_s=3600.0, side=-1, temperature_c=(FRESH_C, FRESH_C), second_speed=SLOW),
        effects=4,
        least_lanes=8,
    ),
    Case(
        "graduation_defect",
        "a scratch of the disc",
        _scratch,
        (RunPlan(side=-1),),
        local_table=True,
    ),
    Case("periodic_error", "a gear of 71.4 teeth before the table", _gear, real_orders=True),
    Case(
        "drive_gear_error",
        "an eccentric gear of 71.4 teeth with its side lines, and an index of its pinion",
        _eccentric_gear,
        real_orders=True,
        drive_gear_teeth=GEAR_TEETH,
        added=("drive_gear_error", {"below": [1], "above": [1]}),
        probe=DriveIndex(GEAR_TEETH / PINION_TEETH),
        lines=(GEAR_TEETH - 1.0, GEAR_TEETH, GEAR_TEETH + 1.0),
        least_lanes=8,
    ),
    Case(
        "belt",
        "a belt that twists the shaft every second turn, and an index on the belt",
        _belt,
        real_orders=True,
        probe=DriveIndex(BELT_ORDER),
        lines=(BELT_ORDER,),
        added=("periodic_error", {}),
        reference_turns=8,
    ),
    Case(
        "warm_ovality",
        "a disc that becomes oval with heat, which is not in the catalogue",
        _warm_lobes,
        _WARMING,
        fresh=RunPlan(start_s=3600.0, temperature_c=(FRESH_C, FRESH_C)),
        judged_order=2,
    ),
)

CASES = {case.name: case for case in _ALL}
"""Cases by the name of the effect."""
