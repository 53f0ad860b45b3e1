"""Reads and writes the coefficient file, which ``arctrue calibrate`` and ``arctrue export`` make.

The format is TOML. The gateware loads the integer words; further keys state the values of these
words in arcseconds and degrees, and the reader checks that keys and words agree. Lanes that are not
listed have amplitude 0. docs/map-extensions.md describes the additions of schema 3.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from arctrue.base.read_errors import unreadable
from arctrue.base.toml_file import read_toml
from arctrue.base.typed_content import ContentError, typed
from arctrue.base.whole_file import write_whole_text
from arctrue.gateware.capability import Capability
from arctrue.gateware.coefficient_file_checks import agree, check_slope, check_words
from arctrue.gateware.coefficient_file_keys import (
    DECLARED,
    ExtendedFileKeys,
    ExtendedLaneKeys,
    FileKeys,
    LaneKeys,
    LocalTableKeys,
    MeanKeys,
    OnlySchema,
    TemperatureKeys,
    ThermalFileKeys,
    ThermalLaneKeys,
)
from arctrue.gateware.coefficient_file_text import coefficient_file_text
from arctrue.gateware.coefficients import Coefficients, Extension
from arctrue.gateware.extension import (
    POINTS,
    WIDTH_ONE,
    WINDOW_EXPONENT_MOST,
    Conditions,
    LocalTable,
)
from arctrue.gateware.lane_words import AMPLITUDE_LSB_COUNTS, check_counts_per_rev
from arctrue.gateware.mean_set import OFFSET_ONE, WEIGHT_ONE, MeanSet
from arctrue.gateware.thermal import ThermalLanes


class CoefficientFileError(ValueError):
    """Is raised for a coefficient file that cannot be used; the message names the file and, if one
    key is wrong, this key."""


def write_coefficient_file(path: Path | str, coefficients: Coefficients, title: str = "") -> None:
    """Write ``coefficients`` completely or not at all: an existing file remains until the new file
    is complete.

    Raises OSError if the folder cannot be written.
    """
    write_whole_text(Path(path), coefficient_file_text(coefficients, title))


def read_coefficient_file(path: Path | str, bitstream: Capability | None = None) -> Coefficients:
    """Read a coefficient file and check it for ``bitstream``; None: the default build.

    Raises CoefficientFileError for a file that cannot be read, wrong TOML, a key that is missing,
    unknown or of the wrong type, and a word outside its format. The same error is raised if words
    contradict their values in arcseconds, degrees or counts, or if the bitstream cannot hold a
    part; the message then names the generic that the part needs.
    """
    path = Path(path)
    try:
        content = read_toml(path)
        declared = DECLARED[typed(content, OnlySchema).schema]
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


def _coefficients(file: FileKeys) -> Coefficients:
    check_counts_per_rev(file.counts_per_rev)
    agree("offset.counts", file.offset.counts, "word", file.offset.word, AMPLITUDE_LSB_COUNTS)
    lanes, slopes = _lanes(file.lane, "lane", file)

    thermal = None
    if isinstance(file, ThermalFileKeys | ExtendedFileKeys) and file.temperature is not None:
        thermal = _thermal(file.temperature, slopes)
    elif slopes:
        raise ContentError("temperature: is missing, but a lane has a slope")
    return Coefficients(
        *_words(lanes, file.lanes),
        file.offset.word,
        file.counts_per_rev,
        thermal,
        _extension(file, lanes) if isinstance(file, ExtendedFileKeys) else None,
    )


def _lanes(
    listed: Sequence[LaneKeys], key: str, file: FileKeys
) -> tuple[dict[int, LaneKeys], dict[int, tuple[int, ...]]]:
    """Return the lanes by their numbers, and the slopes by order. Raises ContentError for
    contradictions."""
    lanes: dict[int, LaneKeys] = {}
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
        check_words(place, lane, file.counts_per_rev)
        if isinstance(lane, ThermalLaneKeys) and lane.slope is not None:
            check_slope(place, lane, file.counts_per_rev)
            # In a file of schema 3 the order of a lane is a floating-point number.
            slopes[int(lane.order)] = lane.slope
    return lanes, slopes


def _words(
    lanes: Mapping[int, LaneKeys], count: int
) -> tuple[NDArray[Any], NDArray[Any], NDArray[Any]]:
    """Return phase steps, phase offsets and amplitudes of ``count`` lanes."""

    def of_key(key: str) -> NDArray[Any]:
        found = [getattr(lanes[at], key) if at in lanes else 0 for at in range(count)]
        return np.array(found, dtype=np.int64)

    return of_key("phase_step"), of_key("phase_offset"), of_key("amplitude")


def _of_lanes(lanes: Mapping[int, LaneKeys]) -> dict[str, Any]:
    """Return modulators, turn steps and phase sources as the extension stores them."""
    extended = {at: lane for at, lane in lanes.items() if isinstance(lane, ExtendedLaneKeys)}
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


def _extension(file: ExtendedFileKeys, lanes: Mapping[int, LaneKeys]) -> Extension:
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
            raise ContentError(f"{place}.weight_words: expected {mean.heads}, one per head")
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


def _mean(table: MeanKeys) -> MeanSet:
    for number, head in enumerate(table.head, start=1):
        place = f"mean.head[{number}]"
        agree(f"{place}.weight", head.weight, "weight_word", head.weight_word, 1 / WEIGHT_ONE)
        agree(
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


def _local_table(table: LocalTableKeys) -> LocalTable:
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


def _thermal(table: TemperatureKeys, slopes: Mapping[int, tuple[int, ...]]) -> ThermalLanes:
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
