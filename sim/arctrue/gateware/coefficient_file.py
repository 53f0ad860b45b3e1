"""Reads and writes the coefficient file, which ``arctrue calibrate`` and ``arctrue export`` make.

The format is TOML. The gateware loads the integer words; further keys state the values of these
words in arcseconds and degrees, and the reader checks that keys and words agree. Lanes that are not
listed have amplitude 0. docs/map-extensions.md describes the additions of schema 3.
"""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from fractions import Fraction
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
from msgspec import Meta, Struct
from numpy.typing import NDArray

from arctrue.base.read_errors import unreadable
from arctrue.base.toml_file import read_toml
from arctrue.base.typed_content import ContentError, Number, typed
from arctrue.base.units import ARCSEC_PER_TURN
from arctrue.base.whole_file import write_whole_text
from arctrue.gateware.capability import Capability
from arctrue.gateware.coefficients import (
    AMPLITUDE_LSB_COUNTS,
    ORDER_MAX,
    Coefficients,
    check_counts_per_rev,
    phase_step,
)
from arctrue.gateware.extension import (
    POINT_LIMIT,
    POINTS,
    WIDTH_ONE,
    WINDOW_EXPONENT_MOST,
    Conditions,
    Extension,
    LocalTable,
    PhaseSource,
)
from arctrue.gateware.mean_set import OFFSET_ONE, WEIGHT_ONE, MeanSet
from arctrue.gateware.thermal import SLOPE_LSB_COUNTS, ThermalLanes
from arctrue.generated.number_formats import LANES_MAX, PHASE_STEP_WIDTH, PHASE_WIDTH

SCHEMA = 1
THERMAL_SCHEMA = 2
"""Schema number of a file with lanes that follow the temperature and without an extension."""
EXTENDED_SCHEMA = 3
"""Schema number of a file with an :class:`Extension` (mean, conditions, modulators, real orders,
local table or prepared sets); without an extension, the file has schema 1 or 2."""

# Permitted difference between a value in arcseconds, degrees or counts and its word, in units of
# the word: half a unit for the rounding of a typed value, and a small margin for the number of
# written digits.
_AGREEMENT = 0.51


class _Offset(Struct, forbid_unknown_fields=True):
    counts: Number
    word: int


class _Lane(Struct, forbid_unknown_fields=True):
    lane: Annotated[int, Meta(ge=0, lt=LANES_MAX)]
    order: Annotated[int, Meta(ge=0, le=ORDER_MAX)]
    amplitude_arcsec: Number
    phase_deg: Number
    phase_step: Annotated[int, Meta(ge=0, lt=2**PHASE_STEP_WIDTH)]
    phase_offset: int
    amplitude: int


class _ThermalLane(_Lane, forbid_unknown_fields=True):
    slope_arcsec_per_k: tuple[Number, Number] | None = None
    slope_arcsec_per_k2: tuple[Number, Number] | None = None
    slope: tuple[int, int, int, int] | None = None

    def __post_init__(self) -> None:
        found = {name: getattr(self, name) for name in _SLOPE_KEYS}
        lacking = [name for name, value in found.items() if value is None]
        if 0 < len(lacking) < len(found):
            raise ValueError(f"{lacking[0]}: is missing: a slope has {', '.join(_SLOPE_KEYS)}")


_SLOPE_KEYS = ("slope_arcsec_per_k", "slope_arcsec_per_k2", "slope")


class _Temperature(Struct, forbid_unknown_fields=True):
    reference_c: Number
    sensor_time_constant_s: Number
    least_c: Number = math.nan
    most_c: Number = math.nan


class _File(Struct, forbid_unknown_fields=True, kw_only=True):
    schema: Literal[1]
    counts_per_rev: int
    lanes: Annotated[int, Meta(ge=1, le=LANES_MAX)]
    offset: _Offset
    title: str = ""
    lane: list[_Lane] = []


class _ThermalFile(_File, forbid_unknown_fields=True, kw_only=True):
    schema: Literal[2]  # type: ignore[assignment]
    temperature: _Temperature
    lane: list[_ThermalLane] = []  # type: ignore[assignment]


class _ExtendedLane(_ThermalLane, forbid_unknown_fields=True, kw_only=True):
    order: Annotated[float, Meta(ge=0, le=ORDER_MAX)]  # type: ignore[assignment]
    turn_step: Annotated[int, Meta(ge=0, lt=2**PHASE_STEP_WIDTH)] = 0
    modulator: str = "one"
    phase_from: str = "operator"
    probe_side: int = 0
    probe_phase: int = 0

    @property
    def phase_source(self) -> PhaseSource | None:
        """Return the origin of the lane's phase; None: the operator states the phase."""
        if self.phase_from == "operator" and not (self.probe_side or self.probe_phase):
            return None
        return PhaseSource(self.phase_from, self.probe_side, self.probe_phase)


class _MeanHead(Struct, forbid_unknown_fields=True):
    weight: Number
    weight_word: int
    offset_counts: Number
    offset_word: int
    delay_clocks: int = 0


class _Mean(Struct, forbid_unknown_fields=True):
    carrier: int
    head: list[_MeanHead]


class _Conditions(Struct, forbid_unknown_fields=True):
    width_counts: Number
    dead_zone_counts: int
    nominal_deg_per_s: Number


class _LocalTable(Struct, forbid_unknown_fields=True):
    width_turn: Number
    fraction_bits: int
    starts_counts: list[int]
    points: list[Annotated[int, Meta(ge=-POINT_LIMIT, lt=POINT_LIMIT)]]


class _Without(Struct, forbid_unknown_fields=True):
    head: int
    carrier: int
    weight_words: list[int]
    offset_words: list[int]
    offset_word: int
    lane: list[_ExtendedLane] = []


class _ExtendedFile(_File, forbid_unknown_fields=True, kw_only=True):
    schema: Literal[3]  # type: ignore[assignment]
    temperature: _Temperature | None = None
    lane: list[_ExtendedLane] = []  # type: ignore[assignment]
    mean: _Mean | None = None
    conditions: _Conditions | None = None
    local_table: _LocalTable | None = None
    without: list[_Without] = []


class _OnlySchema(Struct):
    schema: Literal[1, 2, 3]


_DECLARED: Mapping[int, type[_File]] = {
    1: _File,
    THERMAL_SCHEMA: _ThermalFile,
    EXTENDED_SCHEMA: _ExtendedFile,
}


class CoefficientFileError(ValueError):
    """Is raised for a coefficient file that cannot be used; the message names the file and, if one
    key is wrong, this key."""


def write_coefficient_file(path: Path | str, coefficients: Coefficients, title: str = "") -> None:
    """Write ``coefficients`` completely or not at all: an existing file remains until the new file
    is complete.

    Raises OSError if the folder cannot be written.
    """
    write_whole_text(Path(path), coefficient_file_text(coefficients, title))


def coefficient_file_text(coefficients: Coefficients, title: str = "") -> str:
    """Return the text of a coefficient file."""
    schema = SCHEMA if coefficients.thermal is None else THERMAL_SCHEMA
    lines = [
        "# Coefficients of the gateware: offset + sum of amplitude * cos(order * angle + phase).",
        "# Loaded: phase_step (turn a count / 2^48), phase_offset (turn / 2^24), amplitude and",
        "# offset.word (count / 2^11). The other values state the same for people.",
        f"schema = {schema if coefficients.extension is None else EXTENDED_SCHEMA}",
    ]
    if title:
        lines.append(f"title = {json.dumps(title, ensure_ascii=False)}")
    lines += [
        f"counts_per_rev = {coefficients.counts_per_rev}",
        f"lanes = {coefficients.lanes}",
        "",
        "[offset]",
        f"counts = {coefficients.offset_counts!r}",
        f"word = {coefficients.offset}",
    ]
    thermal = coefficients.thermal
    if thermal is not None:
        lines[1:3] += [
            "# Lanes with a slope follow the temperature T: their cosine and sine gain",
            "# slope[0:2] (T - T0) + slope[2:4] (T - T0)^2, in count / 2^20; T0 is reference_c.",
            "# Below least_c and above most_c they keep the values that they have at this limit.",
        ]
        lines += [
            "",
            "[temperature]",
            f"reference_c = {thermal.reference_c!r}",
            f"sensor_time_constant_s = {thermal.time_constant_s!r}",
            f"least_c = {thermal.least_c!r}",
            f"most_c = {thermal.most_c!r}",
        ]
    lines += _extension_lines(coefficients.extension)
    lines += _lane_lines(coefficients, "lane")
    for entry in coefficients.extension.without if coefficients.extension else ():
        lines += _without_lines(entry)
    return "\n".join(lines) + "\n"


def _lane_lines(coefficients: Coefficients, table: str) -> list[str]:
    """Return the lines of the TOML array of tables ``table``, one table for each lane whose words
    are not all 0."""
    arcsec = ARCSEC_PER_TURN / coefficients.counts_per_rev
    thermal = coefficients.thermal
    extension = coefficients.extension or Extension()
    modulators, turn_steps = dict(extension.modulators), dict(extension.turn_steps)
    sources = dict(extension.phase_sources)
    lines: list[str] = []
    for lane in range(coefficients.lanes):
        amplitude = int(coefficients.amplitudes[lane])
        step = int(coefficients.phase_steps[lane])
        offset = int(coefficients.phase_offsets[lane])
        turn_step = turn_steps.get(lane, 0)
        if amplitude == step == offset == turn_step == 0:
            continue
        order = int(coefficients.orders[lane])
        lines += [
            "",
            f"[[{table}]]",
            f"lane = {lane}",
            f"order = {_real_order(step, turn_step, coefficients.counts_per_rev)!r}"
            if turn_step
            else f"order = {order}",
            f"amplitude_arcsec = {float(f'{amplitude * AMPLITUDE_LSB_COUNTS * arcsec:.9g}')!r}",
            f"phase_deg = {math.degrees(coefficients.phases_rad[lane]):.6f}",
            f"phase_step = {step}",
            f"phase_offset = {offset}",
            f"amplitude = {amplitude}",
        ]
        if turn_step:
            lines.append(f"turn_step = {turn_step}")
        if lane in sources:
            source = sources[lane]
            lines.append(f"phase_from = {json.dumps(source.source)}")
            if source.source == "probe":
                lines.append(f"probe_side = {source.side}")
                lines.append(f"probe_phase = {source.probe_phase}")
        if lane in modulators:
            lines.append(f"modulator = {json.dumps(modulators[lane])}")
        if thermal is not None and order in thermal.orders:
            words = thermal.slopes[thermal.orders.index(order)].tolist()
            said = [float(f"{word * SLOPE_LSB_COUNTS * arcsec:.9g}") for word in words]
            lines += [
                f"slope_arcsec_per_k = {said[:2]}",
                f"slope_arcsec_per_k2 = {said[2:]}",
                f"slope = {words}",
            ]
    return lines


def _extension_lines(extension: Extension | None) -> list[str]:
    """Return the lines of those tables of schema 3 that precede the lanes."""
    lines: list[str] = []
    if extension is None:
        return lines
    if extension.mean:
        mean = extension.mean
        lines += ["", "[mean]", f"carrier = {mean.carrier}"]
        for weight, offset, delay in zip(
            mean.weights, mean.offsets, mean.delays_clocks, strict=True
        ):
            lines += [
                "",
                "[[mean.head]]",
                f"weight = {weight / WEIGHT_ONE!r}",
                f"weight_word = {weight}",
                f"offset_counts = {offset / OFFSET_ONE!r}",
                f"offset_word = {offset}",
                f"delay_clocks = {delay}",
            ]
    if extension.conditions:
        conditions = extension.conditions
        lines += [
            "",
            "[conditions]",
            f"width_counts = {conditions.width / WIDTH_ONE!r}",
            f"dead_zone_counts = {conditions.dead_zone_counts}",
            f"nominal_deg_per_s = {conditions.nominal_deg_per_s!r}",
        ]
    if extension.local_table:
        table = extension.local_table
        lines += [
            "",
            "[local_table]",
            f"width_turn = {2.0**-table.width_exponent!r}",
            f"fraction_bits = {table.fraction_bits}",
            f"starts_counts = {list(table.starts_counts)}",
            f"points = {list(table.points)}",
        ]
    return lines


def _without_lines(entry: Coefficients) -> list[str]:
    """Return the lines of the prepared set for a missing head."""
    mean = entry.extension.mean if entry.extension else None
    assert mean is not None, "checked by Coefficients"
    return [
        "",
        "[[without]]",
        f"head = {mean.missing}",
        f"carrier = {mean.carrier}",
        f"weight_words = {list(mean.weights)}",
        f"offset_words = {list(mean.offsets)}",
        f"offset_word = {entry.offset}",
        *_lane_lines(entry, "without.lane"),
    ]


def read_coefficient_file(path: Path | str, bitstream: Capability | None = None) -> Coefficients:
    """Read a coefficient file and check it for ``bitstream``; None: the default build.

    Raises CoefficientFileError for a file that is missing or cannot be read, wrong TOML, a key that
    is missing, unknown or of the wrong type, a word outside its format, words that contradict their
    values in arcseconds, degrees or counts, or a part that the bitstream cannot hold (the message
    then names the generic that the part needs).
    """
    path = Path(path)
    try:
        content = read_toml(path)
        declared = _DECLARED[typed(content, _OnlySchema).schema]
        coefficients = _coefficients(typed(content, declared))
        if coefficients.extension is not None:
            _check_loadable(coefficients.extension, bitstream or Capability())
        return coefficients
    except OSError as error:
        why = unreadable(error, "'arctrue calibrate' writes one")
        raise CoefficientFileError(f"{path}: {why}") from error
    except (ValueError, OverflowError) as error:
        raise CoefficientFileError(f"{path}: {error}") from error


def _check_loadable(extension: Extension, bitstream: Capability) -> None:
    """Raise ContentError if the bitstream lacks a part that the file requires."""
    lacking = bitstream.lacking(extension.needs)
    if lacking:
        raise ContentError(
            f"it needs a bitstream that is built with {', '.join(lacking)}; this one is not. Load "
            "such a bitstream, or export without the parts that need it"
        )


def _coefficients(file: _File) -> Coefficients:
    check_counts_per_rev(file.counts_per_rev)
    _agree("offset.counts", file.offset.counts, "word", file.offset.word, AMPLITUDE_LSB_COUNTS)
    lanes, slopes = _lanes(file.lane, "lane", file)

    thermal = None
    if isinstance(file, _ThermalFile | _ExtendedFile) and file.temperature is not None:
        thermal = _thermal(file.temperature, slopes)
    elif slopes:
        raise ContentError("temperature: is missing, but a lane has a slope")
    return Coefficients(
        *_words(lanes, file.lanes),
        file.offset.word,
        file.counts_per_rev,
        thermal,
        _extension(file, lanes) if isinstance(file, _ExtendedFile) else None,
    )


def _lanes(
    listed: Sequence[_Lane], key: str, file: _File
) -> tuple[dict[int, _Lane], dict[int, tuple[int, ...]]]:
    """Return the lanes by their numbers, and the slopes by order. Raises ContentError for
    contradictions."""
    lanes: dict[int, _Lane] = {}
    slopes: dict[int, tuple[int, ...]] = {}
    for number, lane in enumerate(listed, start=1):
        place = f"{key}[{number}]"
        if lane.lane >= file.lanes:
            raise ContentError(
                f"{place}.lane: expected a whole number from 0 to {file.lanes - 1}, "
                f"found {lane.lane}"
            )
        if lane.lane in lanes:
            raise ContentError(f"{place}.lane: lane {lane.lane} is listed twice")
        lanes[lane.lane] = lane
        _check_words(place, lane, file.counts_per_rev)
        if isinstance(lane, _ThermalLane) and lane.slope is not None:
            _check_slope(place, lane, file.counts_per_rev)
            # In a file of schema 3 the order of a lane is a floating-point number.
            slopes[int(lane.order)] = lane.slope
    return lanes, slopes


def _words(
    lanes: Mapping[int, _Lane], count: int
) -> tuple[NDArray[Any], NDArray[Any], NDArray[Any]]:
    """Return phase steps, phase offsets and amplitudes of ``count`` lanes."""

    def of_key(key: str) -> NDArray[Any]:
        found = [getattr(lanes[at], key) if at in lanes else 0 for at in range(count)]
        return np.array(found, dtype=np.int64)

    return of_key("phase_step"), of_key("phase_offset"), of_key("amplitude")


def _of_lanes(lanes: Mapping[int, _Lane]) -> dict[str, Any]:
    """Return modulators, turn steps and phase sources as the extension stores them."""
    extended = {at: lane for at, lane in lanes.items() if isinstance(lane, _ExtendedLane)}
    return {
        "modulators": tuple(
            (at, lane.modulator) for at, lane in sorted(extended.items()) if lane.modulator != "one"
        ),
        "turn_steps": tuple(
            (at, lane.turn_step) for at, lane in sorted(extended.items()) if lane.turn_step
        ),
        "phase_sources": tuple(
            (at, source)
            for at, source in ((at, lane.phase_source) for at, lane in sorted(extended.items()))
            if source is not None
        ),
    }


def _extension(file: _ExtendedFile, lanes: Mapping[int, _Lane]) -> Extension:
    mean = _mean(file.mean) if file.mean else None
    conditions = table = None
    if file.conditions:
        width = file.conditions.width_counts * WIDTH_ONE
        if width != round(width):
            raise ContentError("conditions.width_counts: expected sixteenths of a count")
        conditions = Conditions(
            round(width), file.conditions.dead_zone_counts, file.conditions.nominal_deg_per_s
        )
    if file.local_table:
        table = _local_table(file.local_table)
    without = []
    for number, entry in enumerate(file.without, start=1):
        place = f"without[{number}]"
        if mean is None or not 1 <= entry.head <= mean.heads:
            raise ContentError(f"{place}.head: head {entry.head} is not in [mean]")
        if entry.head in {before.head for before in file.without[: number - 1]}:
            raise ContentError(f"{place}.head: head {entry.head} is listed twice")
        if len(entry.weight_words) != mean.heads:
            raise ContentError(f"{place}.weight_words: expected {mean.heads}, one a head of [mean]")
        of_set, slopes = _lanes(entry.lane, f"{place}.lane", file)
        if slopes:
            raise ContentError(f"{place}.lane: a prepared set cannot follow the temperature")
        try:
            set_mean = MeanSet(
                tuple(entry.weight_words),
                tuple(entry.offset_words),
                entry.carrier,
                entry.head,
                mean.delays_clocks,
            )
        except ValueError as error:
            raise ContentError(f"{place}: {error}") from error
        without.append(
            Coefficients(
                *_words(of_set, file.lanes),
                entry.offset_word,
                file.counts_per_rev,
                None,
                Extension(mean=set_mean, conditions=conditions, **_of_lanes(of_set)),
            )
        )
    return Extension(
        mean, conditions, **_of_lanes(lanes), local_table=table, without=tuple(without)
    )


def _mean(table: _Mean) -> MeanSet:
    for number, head in enumerate(table.head, start=1):
        place = f"mean.head[{number}]"
        _agree(f"{place}.weight", head.weight, "weight_word", head.weight_word, 1 / WEIGHT_ONE)
        _agree(
            f"{place}.offset_counts",
            head.offset_counts,
            "offset_word",
            head.offset_word,
            1 / OFFSET_ONE,
        )
    try:
        return MeanSet(
            tuple(head.weight_word for head in table.head),
            tuple(head.offset_word for head in table.head),
            table.carrier,
            0,
            tuple(head.delay_clocks for head in table.head),
        )
    except ValueError as error:
        raise ContentError(f"mean: {error}") from error


def _local_table(table: _LocalTable) -> LocalTable:
    exponents = [e for e in range(WINDOW_EXPONENT_MOST + 1) if table.width_turn == 2.0**-e]
    if not exponents:
        raise ContentError(
            f"local_table.width_turn: expected 1, 1/2, to 1/{1 << WINDOW_EXPONENT_MOST}, "
            f"found {table.width_turn}"
        )
    points = list(table.points)
    while points and points[-1] == 0:
        points.pop()
    if len(points) > POINTS:
        raise ContentError(f"local_table.points: expected {POINTS} at most, found {len(points)}")
    return LocalTable(tuple(points), tuple(table.starts_counts), exponents[0], table.fraction_bits)


def _thermal(table: _Temperature, slopes: Mapping[int, tuple[int, ...]]) -> ThermalLanes:
    if not slopes:
        raise ContentError("temperature: no lane has a slope; leave [temperature] out")
    return ThermalLanes(
        tuple(slopes),
        np.array(list(slopes.values())),
        table.reference_c,
        table.sensor_time_constant_s,
        table.least_c,
        table.most_c,
    )


def _check_words(place: str, lane: _Lane, counts_per_rev: int) -> None:
    """Raise ContentError if the words of a lane contradict its values in arcseconds and degrees."""
    if isinstance(lane, _ExtendedLane):
        _check_real_order(place, lane, counts_per_rev)
    else:
        needed = phase_step(lane.order, counts_per_rev)
        if lane.phase_step != needed:
            raise ContentError(
                f"{place}.phase_step: found {lane.phase_step}, but order {lane.order} at "
                f"{counts_per_rev} counts a turn needs {needed}; change both or neither"
            )
    unit = AMPLITUDE_LSB_COUNTS * ARCSEC_PER_TURN / counts_per_rev
    _agree(f"{place}.amplitude_arcsec", lane.amplitude_arcsec, "amplitude", lane.amplitude, unit)
    step_deg = 360.0 / 2**PHASE_WIDTH
    _agree(f"{place}.phase_deg", lane.phase_deg, "phase_offset", lane.phase_offset, step_deg, 360.0)


def _check_real_order(place: str, lane: _ExtendedLane, counts_per_rev: int) -> None:
    """Raise ContentError if the phase step or the turn step contradicts the order.

    A step may differ by _AGREEMENT units and by the effect of rounding the order to 53 bits.
    """
    turn = 1 << PHASE_STEP_WIDTH
    order = Fraction(lane.order)
    slack = Fraction(_AGREEMENT) + order * Fraction(turn, 2**52)
    for key, step, needed in (
        ("phase_step", lane.phase_step, order * turn / counts_per_rev),
        ("turn_step", lane.turn_step, order % 1 * turn),
    ):
        away = (step - needed) % turn
        if min(away, turn - away) > slack:
            raise ContentError(
                f"{place}.{key}: found {step}, but order {lane.order} at {counts_per_rev} counts "
                f"a turn needs {round(needed) % turn}; change both or neither"
            )


def _real_order(step: int, turn_step: int, counts_per_rev: int) -> float:
    """Return the order whose fraction is that of the turn step and which is nearest to the order of
    the phase step."""
    turn = 1 << PHASE_STEP_WIDTH
    fraction = Fraction(turn_step, turn)
    return float(round(Fraction(step * counts_per_rev, turn) - fraction) + fraction)


def _check_slope(place: str, lane: _ThermalLane, counts_per_rev: int) -> None:
    assert lane.slope is not None
    said = (*(lane.slope_arcsec_per_k or ()), *(lane.slope_arcsec_per_k2 or ()))
    unit = SLOPE_LSB_COUNTS * ARCSEC_PER_TURN / counts_per_rev
    for value, word in zip(said, lane.slope, strict=True):
        if abs(value - word * unit) > _AGREEMENT * unit + 1e-8 * abs(value):
            raise ContentError(
                f"{place}.slope: found {word}, which is {word * unit:.9g}, but the value is "
                f"{value}; change both or neither"
            )


def _agree(
    place: str, value: float, word_key: str, word: int, unit: float, turn: float = math.inf
) -> None:
    """Raise ContentError if ``value`` differs from ``word`` · ``unit`` by more than _AGREEMENT ·
    ``unit``, apart from a multiple of ``turn``."""
    difference = value - word * unit
    if math.isfinite(turn):
        difference = math.remainder(difference, turn)
    if abs(difference) > _AGREEMENT * unit:
        raise ContentError(
            f"{place}: found {value}, but {word_key} = {word} says {word * unit:.9g}; "
            "change both or neither"
        )
