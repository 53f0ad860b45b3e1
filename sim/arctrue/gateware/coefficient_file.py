"""The coefficient file: what ``arctrue calibrate`` writes and the gateware loads.

TOML. The integer words are what is loaded; the values beside them say the same in arcseconds and
degrees, and reading checks that they do. Lanes that are not listed have amplitude 0.
"""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from arctrue.gateware.coefficients import (
    AMPLITUDE_LSB_COUNTS,
    ORDER_MAX,
    Coefficients,
    check_counts_per_rev,
    phase_step,
)
from arctrue.gateware.thermal import SLOPE_LSB_COUNTS, ThermalLanes
from arctrue.generated.number_formats import LANES_MAX, PHASE_STEP_WIDTH, PHASE_WIDTH
from arctrue.toml_file import TomlContentError, read_toml
from arctrue.whole_file import write_whole_text

SCHEMA = 1
THERMAL_SCHEMA = 2
"""Of a file with lanes that follow the temperature; any other is of schema 1."""
ARCSEC_PER_TURN = 1_296_000

_FILE_KEYS = ("schema", "counts_per_rev", "lanes", "offset")
_OFFSET_KEYS = ("counts", "word")
_TEMPERATURE_KEYS = ("reference_c", "sensor_time_constant_s")
_SLOPE_KEYS = ("slope_arcsec_per_k", "slope_arcsec_per_k2", "slope")
_LANE_KEYS = (
    "order",
    "amplitude_arcsec",
    "phase_deg",
    "phase_step",
    "phase_offset",
    "amplitude",
)
# How far a value for people may be from its word, in units of the word: half for the rounding
# of a value that was typed in, and a little for the digits written.
_AGREEMENT = 0.51


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
        ]
        lines += [
            "",
            "[temperature]",
            f"reference_c = {thermal.reference_c!r}",
            f"sensor_time_constant_s = {thermal.time_constant_s!r}",
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
    except FileNotFoundError as error:
        raise CoefficientFileError(
            f"{path}: no such file; 'arctrue calibrate' writes one"
        ) from error
    except OSError as error:
        raise CoefficientFileError(f"{path}: cannot be read: {error.strerror}") from error
    except TomlContentError as error:
        raise CoefficientFileError(f"{path}: {error}") from error
    return _Reader(str(path)).coefficients(content)


class _Reader:
    def __init__(self, file: str) -> None:
        self.file = file

    def coefficients(self, content: Mapping[str, Any]) -> Coefficients:
        if "schema" in content and content["schema"] not in (SCHEMA, THERMAL_SCHEMA):
            raise self.error(
                "schema", f"expected {SCHEMA} or {THERMAL_SCHEMA}, found {content['schema']!r}"
            )
        thermal = content.get("schema") == THERMAL_SCHEMA
        required = (*_FILE_KEYS, "temperature") if thermal else _FILE_KEYS
        self.keys(content, "", required, optional=("title", "lane"))
        if not isinstance(content.get("title", ""), str):
            raise self.error("title", f"expected text, found {content['title']!r}")
        counts_per_rev = self.integer(content, "", "counts_per_rev")
        try:
            check_counts_per_rev(counts_per_rev)
        except ValueError as error:
            raise CoefficientFileError(f"{self.file}: {error}") from error
        lanes = self.integer(content, "", "lanes")
        if not 1 <= lanes <= LANES_MAX:
            raise self.error("lanes", f"expected 1 to {LANES_MAX}, found {lanes}")

        offset_table = content["offset"]
        if not isinstance(offset_table, dict):
            raise self.error("offset", "expected a table [offset] with counts and word")
        self.keys(offset_table, "offset.", _OFFSET_KEYS)
        offset = self.integer(offset_table, "offset.", "word")
        self.agree(offset_table, "offset.", "counts", "word", offset, AMPLITUDE_LSB_COUNTS)

        steps = np.zeros(lanes, dtype=object)
        offsets = np.zeros(lanes, dtype=object)
        amplitudes = np.zeros(lanes, dtype=object)
        entries = content.get("lane", [])
        if not isinstance(entries, list) or not all(isinstance(entry, dict) for entry in entries):
            raise self.error("lane", "expected tables [[lane]], one a lane")
        taken: set[int] = set()
        slopes: dict[int, list[int]] = {}
        for index, entry in enumerate(entries):
            where = f"lane[{index}]."
            follows = thermal and any(key in entry for key in _SLOPE_KEYS)
            self.keys(entry, where, ("lane", *_LANE_KEYS, *(_SLOPE_KEYS if follows else ())))
            lane = self.integer(entry, where, "lane")
            if not 0 <= lane < lanes:
                raise self.error(where + "lane", f"expected 0 to {lanes - 1}, found {lane}")
            if lane in taken:
                raise self.error(where + "lane", f"lane {lane} is listed twice")
            taken.add(lane)
            steps[lane], offsets[lane], amplitudes[lane] = self.words(entry, where, counts_per_rev)
            if follows:
                slopes[entry["order"]] = self.slope(entry, where, counts_per_rev)
        try:
            return Coefficients(
                np.array(steps.tolist(), dtype=np.int64),
                np.array(offsets.tolist(), dtype=np.int64),
                np.array(amplitudes.tolist(), dtype=np.int64),
                offset,
                counts_per_rev,
                self.thermal(content, slopes) if thermal else None,
            )
        except (ValueError, OverflowError) as error:
            raise CoefficientFileError(f"{self.file}: {error}") from error

    def words(
        self, entry: Mapping[str, Any], where: str, counts_per_rev: int
    ) -> tuple[int, int, int]:
        order = self.integer(entry, where, "order")
        if not 0 <= order <= ORDER_MAX:
            raise self.error(where + "order", f"expected 0 to {ORDER_MAX}, found {order}")
        step = self.integer(entry, where, "phase_step")
        if not 0 <= step < 2**PHASE_STEP_WIDTH:
            raise self.error(
                where + "phase_step", f"expected 0 to {2**PHASE_STEP_WIDTH - 1}, found {step}"
            )
        if step != phase_step(order, counts_per_rev):
            raise self.error(
                where + "phase_step",
                f"found {step}, but order {order} at {counts_per_rev} counts a turn needs "
                f"{phase_step(order, counts_per_rev)}; change both or neither",
            )
        amplitude = self.integer(entry, where, "amplitude")
        arcsec = ARCSEC_PER_TURN / counts_per_rev
        self.agree(
            entry, where, "amplitude_arcsec", "amplitude", amplitude, AMPLITUDE_LSB_COUNTS * arcsec
        )
        offset = self.integer(entry, where, "phase_offset")
        self.agree(
            entry, where, "phase_deg", "phase_offset", offset, 360.0 / 2**PHASE_WIDTH, turn=360.0
        )
        return step, offset, amplitude

    def slope(self, entry: Mapping[str, Any], where: str, counts_per_rev: int) -> list[int]:
        """The four words of a lane that follows the temperature."""
        arcsec = ARCSEC_PER_TURN / counts_per_rev
        words = self.numbers(entry, where, "slope", 4)
        said = [
            *self.numbers(entry, where, "slope_arcsec_per_k", 2),
            *self.numbers(entry, where, "slope_arcsec_per_k2", 2),
        ]
        if any(not isinstance(word, int) for word in words):
            raise self.error(where + "slope", f"expected whole numbers, found {words}")
        for value, word in zip(said, words, strict=True):
            unit = SLOPE_LSB_COUNTS * arcsec
            if abs(value - word * unit) > _AGREEMENT * unit + 1e-8 * abs(value):
                raise self.error(
                    where + "slope",
                    f"found {word}, which is {word * unit:.9g}, but {value} beside it; "
                    "change both or neither",
                )
        return [int(word) for word in words]

    def numbers(
        self, table: Mapping[str, Any], where: str, key: str, number: int
    ) -> list[int | float]:
        """A list of that many finite numbers."""
        found = table[key]
        if (
            not isinstance(found, list)
            or len(found) != number
            or any(isinstance(item, bool) or not isinstance(item, int | float) for item in found)
            or not all(math.isfinite(item) for item in found)
        ):
            raise self.error(where + key, f"expected {number} finite numbers, found {found!r}")
        return found

    def thermal(self, content: Mapping[str, Any], slopes: dict[int, list[int]]) -> ThermalLanes:
        """The table [temperature] and the slopes of the lanes."""
        table = content["temperature"]
        if not isinstance(table, dict):
            raise self.error("temperature", "expected a table [temperature] with reference_c")
        self.keys(table, "temperature.", _TEMPERATURE_KEYS)
        if not slopes:
            raise self.error("temperature", "no lane has a slope; leave [temperature] out")
        reference_c, time_constant_s = (
            self.numbers({key: [table[key]]}, "temperature.", key, 1)[0]
            for key in _TEMPERATURE_KEYS
        )
        return ThermalLanes(
            tuple(slopes), np.array(list(slopes.values())), float(reference_c), time_constant_s
        )

    def agree(
        self,
        table: Mapping[str, Any],
        where: str,
        value_key: str,
        word_key: str,
        word: int,
        unit: float,
        turn: float = math.inf,
    ) -> None:
        value = table[value_key]
        if (
            isinstance(value, bool)
            or not isinstance(value, int | float)
            or not math.isfinite(value)
        ):
            raise self.error(where + value_key, f"expected a finite number, found {value!r}")
        difference = value - word * unit
        if math.isfinite(turn):
            difference = math.remainder(difference, turn)
        if abs(difference) > _AGREEMENT * unit:
            raise self.error(
                where + value_key,
                f"found {value}, but {word_key} = {word} says {word * unit:.9g}; "
                "change both or neither",
            )

    def keys(
        self,
        table: Mapping[str, Any],
        where: str,
        required: tuple[str, ...],
        optional: tuple[str, ...] = (),
    ) -> None:
        for key in required:
            if key not in table:
                raise self.error(where + key, "is missing")
        for key in table:
            if key not in required and key not in optional:
                raise self.error(
                    where + key, f"is not known; expected {', '.join((*required, *optional))}"
                )

    def integer(self, table: Mapping[str, Any], where: str, key: str) -> int:
        value = table[key]
        if isinstance(value, bool) or not isinstance(value, int):
            raise self.error(where + key, f"expected a whole number, found {value!r}")
        return value

    def error(self, key: str, message: str) -> CoefficientFileError:
        return CoefficientFileError(f"{self.file}: {key}: {message}")
