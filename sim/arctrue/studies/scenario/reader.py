"""Reads scenario files, and rejects every unknown key with an error message in sentences."""

from __future__ import annotations

import dataclasses
import math
from pathlib import Path
from typing import Annotated, Literal

from msgspec import Meta, Struct, field, structs

from arctrue.base.read_errors import unreadable
from arctrue.base.similar import similar
from arctrue.base.toml_file import TomlContentError, read_toml
from arctrue.base.typed_content import ContentError, NotNegative, Number, Positive, shown, typed
from arctrue.gateware.coefficient_file import CoefficientFileError, read_coefficient_file
from arctrue.instrument.pins import (
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
    MOST_COUNTS_PER_REV,
    Fault,
    FirmwareSettings,
    Limits,
    Scale,
    Scenario,
    ScenarioCause,
    TableErrors,
    TemperaturePoint,
)
from arctrue.table.cause import SIGNALS, acts_on
from arctrue.table.instruments.polygon import FACES
from arctrue.table.registry import CAUSES

PINS = {
    "head1.a": HEAD1_A,
    "head1.b": HEAD1_B,
    "head1.z": HEAD1_Z,
    "head2.a": HEAD2_A,
    "head2.b": HEAD2_B,
    "head2.z": HEAD2_Z,
}
REFERENCE = frozenset({"instrument_error_rad"})
"""Methods of a cause that act on a reference instrument, which the scenario simulates too."""
NAMES = tuple(
    name
    for name, cause in CAUSES.items()
    if cause.values is not None and acts_on(cause.kind) - REFERENCE <= SIGNALS
)
"""Names of the causes that ``[[cause]]`` permits. The loss of counts is not permitted as a cause; a
fault of pins simulates it."""
PAUSE_RUN_S = 0.5
"""Default duration of the part of a pause that is simulated clock by clock."""
Speed = Annotated[float, Meta(gt=0, le=3600)]
Pin = Literal["head1.a", "head1.b", "head1.z", "head2.a", "head2.b", "head2.z"]


class _Leg(Struct, forbid_unknown_fields=True):
    turns: Number | None = None
    pause_s: Positive | None = None
    speed_deg_s: Speed | None = None
    run_s: Positive | None = None

    def __post_init__(self) -> None:
        if (self.turns is None) == (self.pause_s is None):
            found = "neither" if self.turns is None else "both"
            raise ValueError(f"turns: expected either turns or pause_s, found {found}")
        if self.turns is not None and abs(self.turns) < 0.05:
            raise ValueError(
                f"turns: expected 0.05 turns or more, of either sign, found {self.turns:g}"
            )
        key, needed = ("speed_deg_s", "turns") if self.turns is None else ("run_s", "pause_s")
        if getattr(self, key) is not None:
            raise ValueError(
                f"{key}: expected only together with {needed}, found {getattr(self, key):g}"
            )
        if self.pause_s is not None and self.run_s is not None and self.run_s > self.pause_s:
            raise ValueError(
                f"run_s: expected at most pause_s, {self.pause_s:g}, found {self.run_s:g}"
            )

    def leg(self, speed_deg_s: float) -> Leg:
        if self.turns is not None:
            return Leg(self.turns, math.radians(self.speed_deg_s or speed_deg_s))
        assert self.pause_s is not None
        return Leg(pause_s=self.pause_s, run_s=self.run_s or min(self.pause_s, PAUSE_RUN_S))


class _Motion(Struct, forbid_unknown_fields=True):
    legs: Annotated[
        list[_Leg],
        Meta(min_length=1, description="a list of legs like {turns = 3} or {pause_s = 600}"),
    ]
    speed_deg_s: Speed = 30.0
    ripple_deg: NotNegative = 0.0
    ripple_order: Annotated[int, Meta(ge=1, le=1000)] = 7

    def __post_init__(self) -> None:
        most_deg = math.degrees(1 / self.ripple_order)
        if self.ripple_deg >= most_deg:
            raise ValueError(
                f"ripple_deg: expected less than {most_deg:g} at order {self.ripple_order} "
                f"(otherwise the table turns back), found {self.ripple_deg:g}"
            )


class _Fault(Struct, forbid_unknown_fields=True, tag_field="what"):
    at_turn: NotNegative
    for_turns: NotNegative = 0.0
    for_s: NotNegative = 0.0
    text: str | None = None

    def __post_init__(self) -> None:
        if not self.for_turns and not self.for_s:
            raise ValueError("for_turns: expected for_turns or for_s above 0, found 0")

    def fault(self) -> Fault:
        what = str(self.__struct_config__.tag)
        text = what.replace("_", " ") if self.text is None else self.text
        return Fault(what, self.at_turn, self.for_turns, self.for_s, text=text)


class _HungProcessor(_Fault, tag="hung_processor"):
    pass


class _BusStall(_Fault, tag="bus_stall", kw_only=True):
    most_clocks: Annotated[int, Meta(ge=1, le=1000)]

    def fault(self) -> Fault:
        return dataclasses.replace(super().fault(), most_clocks=self.most_clocks)


class _Pins(_Fault, tag="pins", kw_only=True):
    pins: Annotated[list[Pin], Meta(min_length=1)]
    act: Literal["invert", "low", "high"] = "invert"
    probability: Annotated[float, Meta(gt=0, le=1)] = 1.0

    def fault(self) -> Fault:
        act = "inverted" if self.act == "invert" else self.act
        return dataclasses.replace(
            super().fault(),
            pins=sum(PINS[name] for name in set(self.pins)),
            act=self.act,
            probability=self.probability,
            text=f"{', '.join(self.pins)} {act}" if self.text is None else self.text,
        )


class _Parameters(Struct):
    """Parameters of the firmware that a scenario may set; the scenario's scale determines the other
    parameters."""

    keep: Number | None = None
    method: Number | None = None
    gain_limit: Number | None = None
    noise_limit: Number | None = None
    separation_deg: Number | None = None
    filter_length: Number | None = None
    minimum_edge_spacing: Number | None = None
    index_tolerance: Number | None = None
    alarm_noise_arcsec: Number | None = None
    alarm_error_arcsec: Number | None = None
    alarm_separation_arcsec: Number | None = None
    heal: Number | None = None
    temperature_step_counts: Number | None = None
    temperature_jump_k: Number | None = None


class _Firmware(_Parameters, forbid_unknown_fields=True):
    recalibrate: Literal["every_turn", "first_turn", "never"] = "every_turn"
    orders: Annotated[int, Meta(ge=1, le=64)] = 32
    calculation_s: Annotated[float, Meta(ge=0, le=60)] = 0.25
    thermometer: Literal["none", "table"] = "none"
    coefficients: str | None = None

    def settings(self, folder: Path) -> FirmwareSettings:
        """Convert the parameters to the settings of the firmware.

        Raises ContentError if a coefficient file, named relative to ``folder``, is invalid.
        """
        given = {name: getattr(self, name) for name in _Parameters.__struct_fields__}
        try:
            loaded = self.coefficients and read_coefficient_file(folder / self.coefficients)
        except CoefficientFileError as error:
            raise ContentError(f"firmware.coefficients: {error}") from error
        return FirmwareSettings(
            self.recalibrate,
            self.orders,
            self.calculation_s,
            tuple((name, value) for name, value in given.items() if value is not None),
            loaded or None,
            thermometer=self.thermometer == "table",
        )


class _Record(Struct, forbid_unknown_fields=True):
    orders: Annotated[tuple[Number, ...], Meta(min_length=1)] = (1.0, 2.0, 3.0)
    faces: Annotated[int, Meta(ge=2, le=360)] = FACES

    def __post_init__(self) -> None:
        if any(order != int(order) or not 1 <= order <= 64 for order in self.orders):
            raise ValueError(
                f"orders: expected whole numbers from 1 to 64, found {shown(list(self.orders))}"
            )


class _OnlyFormat(Struct):
    format: Literal[1]


class _File(Struct, forbid_unknown_fields=True, kw_only=True):
    format: Literal[1]
    title: str
    about: str = ""
    scale: Scale = field(default_factory=Scale)
    table: TableErrors = field(default_factory=TableErrors)
    motion: _Motion
    temperature: tuple[TemperaturePoint, ...] = ()
    cause: list[dict[str, object]] = []
    effect: list[dict[str, object]] = []
    """Former form of ``[[cause]]`` with the key ``cause`` in place of ``name``; it is still read
    for one release."""
    fault: list[_HungProcessor | _BusStall | _Pins] = []
    firmware: _Firmware = field(default_factory=_Firmware)
    limits: Limits = field(default_factory=Limits)
    record: _Record = field(default_factory=_Record)


def read_scenario(path: Path, *, lines: int | None = None) -> Scenario:
    """Read the scenario of a file.

    The limits in arcseconds apply to the file's own number of lines: they are dropped if ``lines``
    differs.

    Parameters
    ----------
    path : Path
        The TOML file.
    lines : int, optional
        Number of lines of the disc in place of the file's number.

    Returns
    -------
    Scenario
        The whole content of the file.

    Raises
    ------
    ScenarioError
        If the file cannot be read or a key is wrong; it names file, key, expected and found value.
    """
    try:
        content = read_toml(path)
        # A file of another format may have keys of other types, whose error messages would mislead.
        typed(content, _OnlyFormat)
        return _scenario(typed(content, _File), path.parent, lines)
    except OSError as error:
        raise ScenarioError(f"{path}: {unreadable(error)}") from error
    except (TomlContentError, ContentError) as error:
        raise ScenarioError(f"{path}: {error}") from error


def _scenario(file: _File, folder: Path, lines: int | None) -> Scenario:
    scale = file.scale if lines is None else structs.replace(file.scale, lines=lines)
    if scale.counts_per_rev > MOST_COUNTS_PER_REV or scale.counts_per_rev % 4:
        raise ContentError(
            "scale.interpolation: expected lines × interpolation to be a multiple of 4 up to "
            f"{MOST_COUNTS_PER_REV:,}, found {scale.interpolation}"
        )
    scenario = Scenario(
        title=file.title,
        about=file.about,
        scale=scale,
        errors=file.table,
        legs=tuple(leg.leg(file.motion.speed_deg_s) for leg in file.motion.legs),
        ripple_rad=math.radians(file.motion.ripple_deg),
        ripple_order=file.motion.ripple_order,
        temperature=file.temperature,
        causes=tuple(
            _cause(values, f"cause[{number}]", scale.lines)
            for number, values in enumerate([*file.cause, *map(_renamed, file.effect)], start=1)
        ),
        faults=tuple(fault.fault() for fault in file.fault),
        firmware=file.firmware.settings(folder),
        limits=file.limits,
        orders=tuple(int(order) for order in file.record.orders),
        faces=file.record.faces,
    )
    _check(scenario)
    if scale.lines == file.scale.lines:
        return scenario
    return dataclasses.replace(scenario, limits=scenario.limits.without_arcsec())


class _OnlyName(Struct):
    name: str


def _renamed(values: dict[str, object]) -> dict[str, object]:
    """Convert the former ``[[effect]]`` to the present form, ``[[cause]]``."""
    return {("name" if key == "cause" else key): value for key, value in values.items()}


def _cause(values: dict[str, object], place: str, lines: int) -> ScenarioCause:
    name = typed(values, _OnlyName, place).name
    if name in CAUSES and name not in NAMES:
        left = ", ".join(sorted(acts_on(CAUSES[name].kind) - SIGNALS))
        raise ContentError(
            f"{place}.name: expected a cause that the instrument can simulate ({name} acts on "
            f"{left}), found {shown(name)}"
        )
    if name not in NAMES:
        near = similar(name, NAMES)
        meant = f'; did you mean "{near[0]}"?' if near else ""
        raise ContentError(
            f"{place}.name: expected one of {', '.join(NAMES)}, found {shown(name)}{meant}"
        )
    given = CAUSES[name].values
    assert given is not None
    try:
        physical = typed(values, given, place).physical(lines)
    except ContentError:
        raise
    except ValueError as error:
        raise ContentError(f"{place}: {error}") from error
    return ScenarioCause(name, physical, acts_on(physical) == REFERENCE)


def _check(scenario: Scenario) -> None:
    """Raise ContentError if parts of the scenario contradict each other."""
    try:
        course: Course = scenario.course()
    except ValueError as error:
        raise ContentError(f"motion.legs: {error}") from error
    limits = scenario.limits
    judged = (limits.corrected_rms_arcsec, limits.corrected_reach_arcsec) != (None, None)
    if judged and limits.from_turn > math.ceil(course.turns - 1e-6):
        raise ContentError(
            f"limits.from_turn: expected a turn of the motion, which has "
            f"{course.turns:g}, found {limits.from_turn}"
        )
    for number, fault in enumerate(scenario.faults, start=1):
        if fault.at_turn >= course.turns:
            raise ContentError(
                f"fault[{number}].at_turn: expected less than the {course.turns:g} turns "
                f"of the motion, found {fault.at_turn:g}"
            )
    for number, point in enumerate(scenario.temperature, start=1):
        if point.at_turn > course.turns:
            raise ContentError(
                f"temperature[{number}].at_turn: expected at most the {course.turns:g} "
                f"turns of the motion, found {point.at_turn:g}"
            )
    fast, slow = max(scenario.speeds_rad_s), min(scenario.speeds_rad_s)
    least_samples = 2 * scenario.firmware.orders + 2
    if scenario.scale.samples * slow / fast < least_samples:
        raise ContentError(
            f"motion.legs: a turn at the fastest speed would have "
            f"{scenario.scale.samples * slow / fast:.0f} samples, "
            f"but {scenario.firmware.orders} orders need {least_samples}: let the speeds differ "
            f"less, or raise scale.samples"
        )
