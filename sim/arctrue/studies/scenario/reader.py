"""Scenario files: read strictly, refused in words for people."""

from __future__ import annotations

import dataclasses
import math
from difflib import get_close_matches
from pathlib import Path
from typing import Any

from arctrue.gateware.coefficient_file import CoefficientFileError, read_coefficient_file
from arctrue.instrument.instrument import (
    HEAD1_A,
    HEAD1_B,
    HEAD1_Z,
    HEAD2_A,
    HEAD2_B,
    HEAD2_Z,
)
from arctrue.studies.scenario.course import Course, Leg
from arctrue.studies.scenario.errors import ScenarioError
from arctrue.studies.scenario.scenario import (
    Fault,
    FirmwareSettings,
    Limits,
    NamedEffect,
    Scale,
    Scenario,
    TableErrors,
    TemperaturePoint,
)
from arctrue.studies.scenario.section import Section
from arctrue.table.causes.cause import SIGNALS, acts_on
from arctrue.table.causes.registry import CAUSES
from arctrue.toml_file import TomlContentError, read_toml

FORMAT = 1
PINS = {
    "head1.a": HEAD1_A,
    "head1.b": HEAD1_B,
    "head1.z": HEAD1_Z,
    "head2.a": HEAD2_A,
    "head2.b": HEAD2_B,
    "head2.z": HEAD2_Z,
}
REFERENCE = frozenset({"instrument_error_rad"})
"""What a reference instrument beside the virtual one honours."""
NAMES = tuple(
    name
    for name, cause in CAUSES.items()
    if cause.given is not None and acts_on(cause.kind) - REFERENCE <= SIGNALS
)
"""The causes that may stand in ``[[effect]]``. A counter that loses counts is a fault of pins."""
FLAGS = (
    *(f"head{head}.{name}" for head in (1, 2) for name in ("index_error", "illegal", "overspeed")),
    "status.cannot_keep_up",
)
REASONS = (
    "empty",
    "index_not_seen",
    "index_error",
    "illegal_transition",
    "edge_spacing",
    "bank_full",
    "stands_still",
    "short_of_a_turn",
    "more_than_a_turn",
    "reversal",
    "jump",
    "wrong_step",
    "over_speed",
    "inconsistent_heads",
    "heads_exchanged",
    "singular",
    "not_converged",
    "not_finite",
    "amplitude",
    "noise",
    "not_better",
)
"""Why the firmware refuses or keeps, as its telemetry says it."""
MOST_COUNTS_PER_REV = 1 << 24
MOST_LINES = 16384
MOST_BUS_STALL_CLOCKS = 1000
PAUSE_RUN_S = 0.5
"""What is run of a pause, unless the file says it."""
FIRMWARE_PARAMETERS = (
    "keep",
    "method",
    "gain_limit",
    "noise_limit",
    "separation_deg",
    "filter_length",
    "minimum_edge_spacing",
    "index_tolerance",
    "alarm_noise_arcsec",
    "alarm_error_arcsec",
    "alarm_separation_arcsec",
    "heal",
    "temperature_step_counts",
    "temperature_jump_k",
)
"""Those that a scenario may set; the others follow from its scale."""


def read_scenario(path: Path, *, lines: int | None = None) -> Scenario:
    """The scenario of a file; ``lines`` replaces the number of lines of the disc.

    With another number of lines the counts are not those that the limits in arcsec were made for:
    these are not asked for then.

    Raises ScenarioError: file, key, what was expected and what was found.
    """
    try:
        values = read_toml(path)
    except OSError as error:
        raise ScenarioError(f"{path}: cannot be read: {error.strerror}") from error
    except TomlContentError as error:
        raise ScenarioError(f"{path}: {error}") from error
    top = Section(str(path), "", values)
    found = top.whole("format")
    if found != FORMAT:
        top.refuse("format", str(FORMAT), found)
    scale = _scale(top.section("scale"), lines)
    legs, ripple_rad, ripple_order = _motion(top.section("motion"))
    scenario = Scenario(
        title=top.text("title"),
        about=top.text("about", ""),
        scale=scale,
        errors=_errors(top.section("table")),
        legs=legs,
        ripple_rad=ripple_rad,
        ripple_order=ripple_order,
        temperature=tuple(_temperature(s) for s in top.sections("temperature")),
        effects=tuple(_effect(s, scale.lines) for s in top.sections("effect")),
        faults=tuple(_fault(s) for s in top.sections("fault")),
        firmware=_firmware(top.section("firmware")),
        limits=_limits(top.section("limits")),
    )
    record = top.section("record")
    if record.has("orders"):
        orders = record.numbers("orders")
        if any(order != int(order) or not 1 <= order <= 64 for order in orders):
            record.refuse("orders", "whole numbers from 1 to 64", list(orders))
        scenario = dataclasses.replace(scenario, orders=tuple(int(order) for order in orders))
    scenario = dataclasses.replace(scenario, faces=record.whole("faces", 24, low=2, high=360))
    record.finish()
    top.finish()
    scenario = _checked(path, scenario)
    if scale.lines == _given_lines(values):
        return scenario
    return dataclasses.replace(scenario, limits=scenario.limits.without_arcsec())


def _given_lines(values: dict[str, Any]) -> int:
    """Lines of the disc that a checked file asks for."""
    return int(values.get("scale", {}).get("lines", Scale().lines))


def _scale(section: Section, lines: int | None) -> Scale:
    usual = Scale()
    given = section.whole("lines", usual.lines, low=16, high=MOST_LINES)
    scale = Scale(
        lines=given if lines is None else lines,
        interpolation=section.whole("interpolation", usual.interpolation, low=4, high=1024),
        lanes=section.whole("lanes", usual.lanes, low=1, high=64),
        samples=section.whole("samples", usual.samples, low=400, high=12000),
        clocks_per_count=section.number(
            "clocks_per_count", usual.clocks_per_count, low=1.05, high=100
        ),
        seed=section.whole("seed", usual.seed, low=0, high=2**31),
    )
    section.finish()
    if scale.counts_per_rev > MOST_COUNTS_PER_REV or scale.counts_per_rev % 4:
        section.refuse(
            "interpolation",
            f"lines × interpolation to be a multiple of 4 up to {MOST_COUNTS_PER_REV:,}",
            scale.interpolation,
        )
    return scale


def _errors(section: Section) -> TableErrors:
    usual = TableErrors()
    errors = TableErrors(
        paper=section.choice("errors", ("paper", "none"), "paper") == "paper",
        separation_error_arcsec=section.number(
            "separation_error_arcsec", 0.0, low=-3600, high=3600
        ),
        noise_arcsec=section.number("noise_arcsec", usual.noise_arcsec, low=0, high=100),
    )
    section.finish()
    return errors


def _motion(section: Section) -> tuple[tuple[Leg, ...], float, int]:
    speed_deg_s = section.number("speed_deg_s", 30.0, above=0, high=3600)
    ripple_rad = math.radians(section.number("ripple_deg", 0.0, low=0))
    ripple_order = section.whole("ripple_order", 7, low=1, high=1000)
    legs = tuple(_leg(item, speed_deg_s) for item in section.sections("legs"))
    section.finish()
    if not legs:
        section.refuse("legs", "a list of legs like {turns = 3} or {pause_s = 600}", [])
    if ripple_rad * ripple_order >= 1:
        section.refuse(
            "ripple_deg",
            f"less than {math.degrees(1 / ripple_order):g} at order {ripple_order}, or the table "
            f"would turn back",
            math.degrees(ripple_rad),
        )
    return legs, ripple_rad, ripple_order


def _leg(section: Section, speed_deg_s: float) -> Leg:
    if section.has("turns") == section.has("pause_s"):
        section.refuse("turns", "either turns or pause_s", ", ".join(section.keys()))
    if section.has("turns"):
        turns = section.number("turns")
        if abs(turns) < 0.05:
            section.refuse("turns", "0.05 turns or more, of either sign", turns)
        speed = section.number("speed_deg_s", speed_deg_s, above=0, high=3600)
        leg = Leg(turns=turns, speed_rad_s=math.radians(speed))
    else:
        pause_s = section.number("pause_s", above=0)
        run_s = section.number("run_s", min(pause_s, PAUSE_RUN_S), above=0, high=pause_s)
        leg = Leg(pause_s=pause_s, run_s=run_s)
    section.finish()
    return leg


def _temperature(section: Section) -> TemperaturePoint:
    point = TemperaturePoint(
        section.number("celsius", low=-50, high=150),
        section.number("at_turn", 0.0, low=0),
        section.number("after_s", 0.0),
    )
    section.finish()
    return point


def _effect(section: Section, lines: int) -> NamedEffect:
    name = section.text("cause")
    if name in CAUSES and name not in NAMES:
        left = ", ".join(sorted(acts_on(CAUSES[name].kind) - SIGNALS))
        section.refuse(
            "cause", f"what the virtual instrument can honour ({name} acts on {left})", name
        )
    if name not in NAMES:
        near = get_close_matches(name, NAMES, 1)
        meant = f'"{near[0]}", perhaps; there are ' if near else "one of "
        section.refuse("cause", meant + ", ".join(NAMES), name)
    cause = CAUSES[name]
    assert cause.given is not None
    try:
        physical = cause.given(section, lines)
    except ScenarioError:
        raise
    except ValueError as error:
        raise ScenarioError(f"{section.file}: {section.place}: {error}") from error
    section.finish()
    return NamedEffect(name, physical, acts_on(physical) == REFERENCE)


def _fault(section: Section) -> Fault:
    what = section.choice("what", ("pins", "bus_stall", "hung_processor"))
    at_turn = section.number("at_turn", low=0)
    fault = Fault(
        what,
        at_turn,
        section.number("for_turns", 0.0, low=0),
        section.number("for_s", 0.0, low=0),
    )
    if not fault.for_turns and not fault.for_s:
        section.refuse("for_turns", "for_turns or for_s above 0", 0)
    text = what.replace("_", " ")
    if what == "pins":
        names = section.words("pins", tuple(PINS))
        if not names:
            section.refuse("pins", "one pin or more", [])
        act = section.choice("act", ("invert", "low", "high"), "invert")
        fault = dataclasses.replace(
            fault,
            pins=sum(PINS[name] for name in set(names)),
            act=act,
            probability=section.number("probability", 1.0, above=0, high=1),
        )
        text = f"{', '.join(names)} {'inverted' if act == 'invert' else act}"
    if what == "bus_stall":
        most = section.whole("most_clocks", low=1, high=MOST_BUS_STALL_CLOCKS)
        fault = dataclasses.replace(fault, most_clocks=most)
    fault = dataclasses.replace(fault, text=section.text("text", text))
    section.finish()
    return fault


def _firmware(section: Section) -> FirmwareSettings:
    usual = FirmwareSettings()
    recalibrate = section.choice(
        "recalibrate", ("every_turn", "first_turn", "never"), usual.recalibrate
    )
    orders = section.whole("orders", usual.orders, low=1, high=64)
    calculation_s = section.number("calculation_s", usual.calculation_s, low=0, high=60)
    parameters = tuple(
        (name, section.number(name)) for name in FIRMWARE_PARAMETERS if section.has(name)
    )
    thermometer = section.choice("thermometer", ("none", "table"), "none") == "table"
    loaded = None
    if section.has("coefficients"):
        file = Path(section.file).parent / section.text("coefficients")
        try:
            loaded = read_coefficient_file(file)
        except CoefficientFileError as error:
            raise ScenarioError(f"{section.file}: firmware.coefficients: {error}") from error
    section.finish()
    return FirmwareSettings(
        recalibrate, orders, calculation_s, parameters, loaded, thermometer=thermometer
    )


def _limits(section: Section) -> Limits:
    def number(key: str) -> float | None:
        return section.number(key, low=0) if section.has(key) else None

    def whole(key: str, low: int = 0) -> int | None:
        return section.whole(key, low=low) if section.has(key) else None

    limits = Limits(
        from_turn=section.whole("from_turn", Limits().from_turn, low=1),
        to_turn=whole("to_turn", 1),
        corrected_rms_arcsec=number("corrected_rms_arcsec"),
        corrected_reach_arcsec=number("corrected_reach_arcsec"),
        worse_by_arcsec=number("worse_by_arcsec"),
        applied_turns_least=whole("applied_turns_least"),
        refused_turns_least=whole("refused_turns_least"),
        refused_turns_most=whole("refused_turns_most"),
        reasons_wanted=section.words("reasons_wanted", REASONS, ()),
        flags_wanted=section.words("flags_wanted", FLAGS, ()),
        flags_allowed=section.words("flags_allowed", FLAGS)
        if section.has("flags_allowed")
        else None,
    )
    section.finish()
    if limits.to_turn is not None and limits.to_turn < limits.from_turn:
        section.refuse("to_turn", f"{limits.from_turn} (from_turn) or more", limits.to_turn)
    return limits


def _checked(path: Path, scenario: Scenario) -> Scenario:
    """What only the parts together can tell."""
    try:
        course: Course = scenario.course()
    except ValueError as error:
        raise ScenarioError(f"{path}: motion.legs: {error}") from error
    limits = scenario.limits
    judged = (limits.corrected_rms_arcsec, limits.corrected_reach_arcsec) != (None, None)
    if judged and limits.from_turn > math.ceil(course.turns - 1e-6):
        raise ScenarioError(
            f"{path}: limits.from_turn: expected a turn of the motion, which has "
            f"{course.turns:g}, found {limits.from_turn}"
        )
    for number, fault in enumerate(scenario.faults, start=1):
        if fault.at_turn >= course.turns:
            raise ScenarioError(
                f"{path}: fault[{number}].at_turn: expected less than the {course.turns:g} turns "
                f"of the motion, found {fault.at_turn:g}"
            )
    for number, point in enumerate(scenario.temperature, start=1):
        if (point.turn or 0.0) > course.turns:
            raise ScenarioError(
                f"{path}: temperature[{number}].at_turn: expected at most the {course.turns:g} "
                f"turns of the motion, found {point.turn:g}"
            )
    fast, slow = max(scenario.speeds_rad_s), min(scenario.speeds_rad_s)
    least_samples = 2 * scenario.firmware.orders + 2
    if scenario.scale.samples * slow / fast < least_samples:
        raise ScenarioError(
            f"{path}: motion.legs: a turn at the fastest speed would have "
            f"{scenario.scale.samples * slow / fast:.0f} samples, "
            f"{scenario.firmware.orders} orders need {least_samples}: let the speeds differ less, "
            f"or raise scale.samples"
        )
    return scenario
