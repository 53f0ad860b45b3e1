"""The coefficient file: what ``arctrue calibrate`` writes and the gateware loads.

TOML. The integer words are what is loaded; the values beside them say the same in arcseconds and
degrees, and reading checks that they do. Lanes that are not listed have amplitude 0.
"""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
from msgspec import Meta, Struct
from numpy.typing import NDArray

from arctrue.base.toml_file import read_toml
from arctrue.base.typed_content import ContentError, Number, typed
from arctrue.base.units import ARCSEC_PER_TURN
from arctrue.base.whole_file import write_whole_text
from arctrue.gateware.coefficients import (
    AMPLITUDE_LSB_COUNTS,
    ORDER_MAX,
    Coefficients,
    check_counts_per_rev,
    phase_step,
)
from arctrue.gateware.thermal import SLOPE_LSB_COUNTS, ThermalLanes
from arctrue.generated.number_formats import LANES_MAX, PHASE_STEP_WIDTH, PHASE_WIDTH

SCHEMA = 1
THERMAL_SCHEMA = 2
"""Of a file with lanes that follow the temperature; any other is of schema 1."""

# How far a value for people may be from its word, in units of the word: half for the rounding
# of a value that was typed in, and a little for the digits written.
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


class _OnlySchema(Struct):
    schema: Literal[1, 2]


class CoefficientFileError(ValueError):
    """A coefficient file that cannot be used; the message names the file and the key."""


def write_coefficient_file(path: Path | str, coefficients: Coefficients, title: str = "") -> None:
    """Write ``coefficients``, whole or not at all: a file that is there stays until the new one is.

    Raises OSError where the folder cannot be written.
    """
    write_whole_text(Path(path), coefficient_file_text(coefficients, title))


def coefficient_file_text(coefficients: Coefficients, title: str = "") -> str:
    """The text of a coefficient file."""
    arcsec = ARCSEC_PER_TURN / coefficients.counts_per_rev
    lines = [
        "# Coefficients of the gateware: offset + sum of amplitude * cos(order * angle + phase).",
        "# Loaded: phase_step (turn a count / 2^48), phase_offset (turn / 2^24), amplitude and",
        "# offset.word (count / 2^11). The other values say the same for people.",
        f"schema = {SCHEMA if coefficients.thermal is None else THERMAL_SCHEMA}",
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
            "# Below least_c and above most_c they stay as they are there.",
        ]
        lines += [
            "",
            "[temperature]",
            f"reference_c = {thermal.reference_c!r}",
            f"sensor_time_constant_s = {thermal.time_constant_s!r}",
            f"least_c = {thermal.least_c!r}",
            f"most_c = {thermal.most_c!r}",
        ]
    for lane in range(coefficients.lanes):
        amplitude = int(coefficients.amplitudes[lane])
        step = int(coefficients.phase_steps[lane])
        offset = int(coefficients.phase_offsets[lane])
        if amplitude == step == offset == 0:
            continue
        lines += [
            "",
            "[[lane]]",
            f"lane = {lane}",
            f"order = {coefficients.orders[lane]}",
            f"amplitude_arcsec = {float(f'{amplitude * AMPLITUDE_LSB_COUNTS * arcsec:.9g}')!r}",
            f"phase_deg = {math.degrees(coefficients.phases_rad[lane]):.6f}",
            f"phase_step = {step}",
            f"phase_offset = {offset}",
            f"amplitude = {amplitude}",
        ]
        order = int(coefficients.orders[lane])
        if thermal is not None and order in thermal.orders:
            words = thermal.slopes[thermal.orders.index(order)].tolist()
            said = [float(f"{word * SLOPE_LSB_COUNTS * arcsec:.9g}") for word in words]
            lines += [
                f"slope_arcsec_per_k = {said[:2]}",
                f"slope_arcsec_per_k2 = {said[2:]}",
                f"slope = {words}",
            ]
    return "\n".join(lines) + "\n"


def read_coefficient_file(path: Path | str) -> Coefficients:
    """Read and check a coefficient file.

    Raises CoefficientFileError for a file that is not there or not TOML, a key that is missing,
    unknown or of the wrong type, a word outside its format, or words that contradict the values
    beside them.
    """
    path = Path(path)
    try:
        content = read_toml(path)
        thermal = typed(content, _OnlySchema).schema == THERMAL_SCHEMA
        return _coefficients(typed(content, _ThermalFile if thermal else _File))
    except FileNotFoundError as error:
        raise CoefficientFileError(
            f"{path}: no such file; 'arctrue calibrate' writes one"
        ) from error
    except OSError as error:
        raise CoefficientFileError(f"{path}: cannot be read: {error.strerror}") from error
    except (ValueError, OverflowError) as error:
        raise CoefficientFileError(f"{path}: {error}") from error


def _coefficients(file: _File) -> Coefficients:
    check_counts_per_rev(file.counts_per_rev)
    _agree("offset.counts", file.offset.counts, "word", file.offset.word, AMPLITUDE_LSB_COUNTS)
    lanes: dict[int, _Lane] = {}
    slopes: dict[int, tuple[int, ...]] = {}
    for number, lane in enumerate(file.lane, start=1):
        place = f"lane[{number}]"
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
            slopes[lane.order] = lane.slope

    def words(key: str) -> NDArray[Any]:
        found = [getattr(lanes[at], key) if at in lanes else 0 for at in range(file.lanes)]
        return np.array(found, dtype=np.int64)

    return Coefficients(
        words("phase_step"),
        words("phase_offset"),
        words("amplitude"),
        file.offset.word,
        file.counts_per_rev,
        _thermal(file.temperature, slopes) if isinstance(file, _ThermalFile) else None,
    )


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
    """Raise ContentError where the words of a lane are not what its values say."""
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


def _check_slope(place: str, lane: _ThermalLane, counts_per_rev: int) -> None:
    assert lane.slope is not None
    said = (*(lane.slope_arcsec_per_k or ()), *(lane.slope_arcsec_per_k2 or ()))
    unit = SLOPE_LSB_COUNTS * ARCSEC_PER_TURN / counts_per_rev
    for value, word in zip(said, lane.slope, strict=True):
        if abs(value - word * unit) > _AGREEMENT * unit + 1e-8 * abs(value):
            raise ContentError(
                f"{place}.slope: found {word}, which is {word * unit:.9g}, but {value} beside "
                "it; change both or neither"
            )


def _agree(
    place: str, value: float, word_key: str, word: int, unit: float, turn: float = math.inf
) -> None:
    """Raise ContentError where ``value`` is not ``word`` units, less whole ``turn``s."""
    difference = value - word * unit
    if math.isfinite(turn):
        difference = math.remainder(difference, turn)
    if abs(difference) > _AGREEMENT * unit:
        raise ContentError(
            f"{place}: found {value}, but {word_key} = {word} says {word * unit:.9g}; "
            "change both or neither"
        )
