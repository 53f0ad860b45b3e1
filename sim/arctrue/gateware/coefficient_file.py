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
from arctrue.generated.number_formats import LANES_MAX, PHASE_STEP_WIDTH, PHASE_WIDTH
from arctrue.toml_file import TomlContentError, read_toml
from arctrue.whole_file import write_whole_text

SCHEMA = 1
ARCSEC_PER_TURN = 1_296_000

_FILE_KEYS = ("schema", "counts_per_rev", "lanes", "offset")
_OFFSET_KEYS = ("counts", "word")
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
        f"schema = {SCHEMA}",
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
        if "schema" in content and content["schema"] != SCHEMA:
            raise self.error("schema", f"expected {SCHEMA}, found {content['schema']!r}")
        self.keys(content, "", _FILE_KEYS, optional=("title", "lane"))
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
        for index, entry in enumerate(entries):
            where = f"lane[{index}]."
            self.keys(entry, where, ("lane", *_LANE_KEYS))
            lane = self.integer(entry, where, "lane")
            if not 0 <= lane < lanes:
                raise self.error(where + "lane", f"expected 0 to {lanes - 1}, found {lane}")
            if lane in taken:
                raise self.error(where + "lane", f"lane {lane} is listed twice")
            taken.add(lane)
            steps[lane], offsets[lane], amplitudes[lane] = self.words(entry, where, counts_per_rev)
        try:
            return Coefficients(
                np.array(steps.tolist(), dtype=np.int64),
                np.array(offsets.tolist(), dtype=np.int64),
                np.array(amplitudes.tolist(), dtype=np.int64),
                offset,
                counts_per_rev,
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
