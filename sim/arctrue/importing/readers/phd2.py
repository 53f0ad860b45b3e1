"""Reads guide logs of PHD2, which contain the error of a telescope axis relative to a guide star.

Distances in the log are camera pixels from the lock position and include the effect of the guiding
corrections. Without guiding, the error of the axis would be the distance plus all earlier
corrections, times the pixel scale, divided by the cosine of the star's declination. The page "PHD2
Guide Log Format" of the project's wiki describes the format.
"""

from __future__ import annotations

import csv
import math
import re
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from datetime import datetime
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from arctrue.importing.choices import Choices
from arctrue.importing.file_content import FileContent, Known
from arctrue.importing.reader import ReadSettings
from arctrue.importing.readers.unpacked_size import refuse_many_fields
from arctrue.measurement import MeasurementError

SIDEREAL_DAY_S = 86164.0905
_NEEDED = ("Time", "mount", "RARawDistance", "RAGuideDistance", "RADuration")
_SCALE = re.compile(r"Pixel scale = ([\d.]+) arc-sec/px")
_DECLINATION = re.compile(r"\bDec = (-?[\d.]+) deg")
_RATE = re.compile(r"\bxRate = ([\d.]+)")
_BEGIN = re.compile(r"Guiding Begins at (\d{4}-\d\d-\d\d \d\d:\d\d:\d\d)")
_RIGHT_ASCENSION = re.compile(r"\bRA = ([\d.]+) hr")
_PIER_SIDE = re.compile(r"\bPier side = (East|West)\b")
_DEG_PER_HOUR = 15.0
_HALF_TURN_DEG = 180.0


@dataclass
class _Section:
    """One stretch of guiding during which the lock position does not change."""

    scale: float | None
    declination_deg: float | None
    rate_px_s: float | None
    begin: datetime | None = None
    right_ascension_deg: float | None = None
    pier_side: str = ""
    header: list[str] = field(default_factory=list)
    lines: list[int] = field(default_factory=list)
    rows: list[dict[str, str]] = field(default_factory=list)


def recognises(path: Path, head: bytes) -> bool:
    """Tell whether the first line is the first line of a PHD2 guide log."""
    return head.lstrip(b"\xef\xbb\xbf").startswith(b"PHD2 version")


def read(path: Path, settings: ReadSettings, choices: Choices) -> FileContent:
    """Return ``error_arcsec`` over ``target_deg``, the sidereal rotation since guiding began.

    Each stretch of guiding is a run; a dither or a new lock position begins a new run. The zero of
    a run is unknown, so its mean is subtracted. The sign of the error depends on the camera, so the
    import asks the user for it later. A last row that the writing program could not complete is
    left out. Raises MeasurementError, which names the row of a wrong line.
    """
    sections, dropped, cut_line = _sections(path)
    sections = [section for section in sections if len(section.rows) > 1]
    if not sections:
        raise MeasurementError("empty", path, "contains no rows of guiding")
    columns: dict[str, list[NDArray[Any]]] = {
        name: [] for name in ("run", "time_s", "target_deg", "error_arcsec", "direction")
    }
    notes = [f"{path.name}: PHD2 guide log with {len(sections)} stretches of guiding"]
    since_s = _since_first(sections)
    for run, section in enumerate(sections):
        time_s, error = _error(path, section, choices, notes)
        time_s = time_s + since_s[run]
        turned_deg = time_s * (360.0 / SIDEREAL_DAY_S)
        columns["run"].append(np.full(time_s.size, run))
        columns["time_s"].append(time_s)
        away_deg = _star_apart_deg(sections[0], section) + _flipped_deg(sections[0], section)
        columns["target_deg"].append(turned_deg - away_deg)
        columns["error_arcsec"].append(error - error.mean())
        columns["direction"].append(np.ones(time_s.size, dtype=np.int64))
    notes.append(
        f"{path.name}: target = sidereal rotation since guiding first began, minus the difference "
        "of the stars' right ascensions (which the log rounds); the mean of each run is "
        "subtracted, since the lock position is arbitrary"
    )
    if len({section.pier_side for section in sections} - {""}) > 1:
        notes.append(
            f"{path.name}: the telescope changed the side of the pier, which required half a turn "
            "of the axis"
        )
    if dropped:
        notes.append(f"{path.name}: {dropped} dropped frames are left out")
    if cut_line is not None:
        notes.append(f"{path.name}, line {cut_line}: the last row is cut and is left out")
    return FileContent(
        path,
        "phd2",
        {name: np.concatenate(parts) for name, parts in columns.items()},
        np.concatenate([np.array(section.lines) for section in sections]),
        known={
            "run": Known("run"),
            "time": Known("time_s", "s"),
            "target": Known("target_deg", "deg"),
            "error": Known("error_arcsec", "arcsec"),
            "direction": Known("direction"),
        },
        notes=tuple(notes),
        instrument="guide star",
    )


def _begin(text: str) -> datetime | None:
    match = _BEGIN.search(text)
    try:
        return None if match is None else datetime.fromisoformat(match[1])
    except ValueError:
        return None  # no date of the calendar


def _since_first(sections: Sequence[_Section]) -> list[float]:
    """Return the seconds from the first "Guiding Begins" to that of each stretch; all are 0 if the
    log lacks one of the times, or if its clock was set back."""
    begins = [section.begin for section in sections]
    known = [begin for begin in begins if begin is not None]
    if len(known) < len(begins) or known != sorted(known):
        return [0.0] * len(sections)
    return [(begin - known[0]).total_seconds() for begin in known]


def _star_apart_deg(first: _Section, section: _Section) -> float:
    """Return the right ascension of the star minus that of the first stretch's star. The axis
    points farther back by this angle. The result is 0 if the log lacks one of them."""
    here, there = section.right_ascension_deg, first.right_ascension_deg
    if here is None or there is None:
        return 0.0
    return float(np.remainder(here - there + 180.0, 360.0) - 180.0)


def _flipped_deg(first: _Section, section: _Section) -> float:
    """Return the angle by which the axis stands farther back after the telescope changed the side
    of the pier.

    A German mount that has followed a star to the meridian turns its axis back by half a turn. The
    telescope then goes from the west side of the pier to the east side (the sides of ASCOM's
    ``SideOfPier``). The result is 0 if the log does not state both sides.
    """
    here, there = section.pier_side, first.pier_side
    if not (here and there) or here == there:
        return 0.0
    return _HALF_TURN_DEG if here == "East" else -_HALF_TURN_DEG


def _sections(path: Path) -> tuple[list[_Section], int, int | None]:
    """Return the stretches of guiding, the number of dropped frames, and the number of a last line
    that is cut."""
    found: list[_Section] = []
    scale: float | None = None
    declination: float | None = None
    rate: float | None = None
    ascension: float | None = None
    side = ""
    begin: datetime | None = None
    dropped = held = 0
    guiding = False
    cut_line: int | None = None
    with path.open(encoding="utf-8-sig", errors="replace") as file:
        for number, line in enumerate(file, start=1):
            text = line.strip()
            if text.startswith("Guiding Begins"):
                scale = declination = rate = ascension = None
                side = ""
                begin = _begin(text)
                guiding = True
            elif text.startswith(("Guiding Ends", "Calibration Begins")):
                guiding = False
            elif match := _SCALE.search(text):
                scale = float(match[1])
            elif guiding and text.startswith("Frame,"):
                header = text.split(",")
                for name in _NEEDED:
                    if name not in header:
                        raise MeasurementError(
                            "missing", path, "is missing in the header", row=number, column=name
                        )
                found.append(_Section(scale, declination, rate, begin, ascension, side, header))
            elif text.startswith("INFO:") and ("DITHER" in text or "SET LOCK POS" in text):
                if found and guiding and found[-1].rows:
                    found.append(replace(found[-1], lines=[], rows=[]))
            elif guiding and found and text[:1].isdigit() and found[-1].header:
                fields = next(csv.reader([text]))
                row = dict(zip(found[-1].header, fields, strict=False))
                if row.get("mount") == "DROP":
                    dropped += 1
                    continue
                if not line.endswith("\n") and len(fields) < len(found[-1].header):
                    cut_line = number
                    continue
                found[-1].rows.append(row)
                held += 1 + len(row)
                refuse_many_fields(path, held)
                found[-1].lines.append(number)
            else:
                if match := _DECLINATION.search(text):
                    declination = float(match[1])
                if guiding and (match := _RIGHT_ASCENSION.search(text)):
                    ascension = float(match[1]) * _DEG_PER_HOUR
                if guiding and (match := _PIER_SIDE.search(text)):
                    side = match[1]
                if match := _RATE.search(text):
                    rate = rate if rate is not None else float(match[1])
    return found, dropped, cut_line


def _error(
    path: Path, section: _Section, choices: Choices, notes: list[str]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the time in seconds and the error in arcseconds that the axis would have without
    guiding."""
    time_s = _numbers(path, section, "Time")
    raw = _numbers(path, section, "RARawDistance")
    guide = _numbers(path, section, "RAGuideDistance")
    duration_s = _numbers(path, section, "RADuration") / 1000.0
    rate = section.rate_px_s
    sent = np.copysign(duration_s * (rate or 0.0), guide)
    moved = (duration_s > 0.0) & (guide != 0.0)
    # PHD2 limits the duration of a pulse, so the correction of the axis is this duration times the
    # guide rate, not the requested RAGuideDistance. Old logs state the rate in pixels per
    # millisecond; the products then disagree with RAGuideDistance, which is used instead.
    agrees = moved.any() and 0.5 < float(np.median(np.abs(sent[moved] / guide[moved]))) < 2.0
    if not (rate and agrees):
        sent = guide
        if moved.any():
            choices.note(
                f"{path.name}: the log states no guide rate that fits the pulses; "
                "RAGuideDistance is taken as the correction"
            )
    scale = section.scale
    if scale is None:
        raise MeasurementError(
            "missing",
            path,
            "the log does not state the pixel scale (Pixel scale = … arc-sec/px)",
            row=section.lines[0],
        )
    if section.declination_deg is None:
        raise MeasurementError(
            "missing",
            path,
            "the log does not state the star's declination (Dec = … deg), which the angle "
            "of the axis needs",
            row=section.lines[0],
        )
    notes.append(
        f"{path.name}: {scale:g}″ a pixel at declination {section.declination_deg:g}°, "
        f"{time_s.size} frames in {time_s[-1] - time_s[0]:.0f} s"
    )
    before = np.concatenate(([0.0], np.cumsum(sent)[:-1]))
    return time_s, (raw + before) * scale / math.cos(math.radians(section.declination_deg))


def _numbers(path: Path, section: _Section, name: str) -> NDArray[np.float64]:
    found = np.empty(len(section.rows))
    for place, row in enumerate(section.rows):
        text = row.get(name, "")
        try:
            found[place] = float(text) if text else 0.0 if name == "RADuration" else math.nan
        except ValueError:
            found[place] = math.nan
        if not math.isfinite(found[place]):
            raise MeasurementError(
                "value",
                path,
                f"expected a number, found {text!r}",
                row=section.lines[place],
                column=name,
            )
    return found
