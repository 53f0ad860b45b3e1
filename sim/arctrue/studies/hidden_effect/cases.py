"""What is hidden, and the runs that a person would make to find it."""

from __future__ import annotations

import cmath
import math
from collections.abc import Callable
from dataclasses import dataclass

from arctrue.base.units import RAD_PER_ARCSEC
from arctrue.studies.hidden_effect.settings import HiddenSettings
from arctrue.table.cause import Cause
from arctrue.table.causes.shaft_wind_up import ShaftWindUp
from arctrue.table.causes.signal_distortion import SignalDistortion
from arctrue.table.causes.thermal_centre import ThermalCentre
from arctrue.table.causes.warm_lobes import WarmLobes
from arctrue.table.conditions import USUAL_TEMPERATURE_C

Build = Callable[[HiddenSettings], list[Cause]]

COLD_C = USUAL_TEMPERATURE_C
WARM_C = USUAL_TEMPERATURE_C + 4.0
STROKE_RAD = math.radians(1.0)
"""Travel in which friction goes over after a reversal: between two stations it is long over."""
FRESH_C = USUAL_TEMPERATURE_C + 2.5
"""At none of the measured temperatures."""


@dataclass(frozen=True, slots=True)
class RunPlan:
    """A power-up of its own and some turns at one speed, captured and read by the reference."""

    side: int = 1
    turns: int = 2
    temperature_c: tuple[float, float] = (COLD_C, COLD_C)
    start_s: float = 0.0
    reference: bool = False


@dataclass(frozen=True, slots=True)
class Case:
    """One hidden effect."""

    name: str
    title: str
    """For people."""
    build: Build
    further: tuple[RunPlan, ...] = ()
    """Runs after the first, which is the same for all: two turns up, cold."""
    polygon: bool = False
    """A reference run at stations, up and down, in place of marks on the move."""
    fresh_c: float | None = None
    """Temperature of the fresh turns after a new power-up; None: the first run goes on."""
    modulators: bool = False
    """The gateware is built with lanes that follow direction and speed."""
    order1_warms: bool = False
    """Order 1 changes with the temperature: it can be followed while the table warms."""


def _subdivision(settings: HiddenSettings) -> list[Cause]:
    # A share p of the amplitude errs by p of a radian of the signal period: 0.63″ at 16,384 lines.
    lines = settings.revolution.lines
    return [
        SignalDistortion(0, lines, 0.036, 0.035, 0.016, 0.012),
        SignalDistortion(1, lines, -0.030, 0.024, -0.014, 0.012),
    ]


def _coarser(settings: HiddenSettings) -> float:
    """How much coarser a count is than at the paper's scale; what is hidden grows with it."""
    return (1 << 24) / settings.revolution.counts_per_rev


def _thermal_centre(settings: HiddenSettings) -> list[Cause]:
    # 0.4 µm/K at a radius of 54 mm are 1.5″/K.
    return [ThermalCentre(cmath.rect(0.4e-6 * _coarser(settings), 1.1))]


def _wind_up(settings: HiddenSettings) -> list[Cause]:
    return [ShaftWindUp(1.0 * RAD_PER_ARCSEC * _coarser(settings), STROKE_RAD)]


def _warm_lobes(settings: HiddenSettings) -> list[Cause]:
    return [WarmLobes(2, 0.4 * RAD_PER_ARCSEC * _coarser(settings), 0.7)]


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
        fresh_c=FRESH_C,
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
        "warm_ovality",
        "a disc that ovalises with heat, which is in no catalogue",
        _warm_lobes,
        _WARMING,
        fresh_c=FRESH_C,
    ),
)

CASES = {case.name: case for case in _ALL}
"""By the name of the effect."""
