"""Reads logs of EPICS process variables as ``camonitor`` prints them: NAME DATE TIME VALUE."""

from __future__ import annotations

import re
from datetime import UTC, datetime
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from arctrue.importing.choices import Ambiguous, Choices
from arctrue.importing.file_content import FileContent, Known
from arctrue.importing.reader import ReadSettings
from arctrue.importing.readers.unpacked_size import refuse_many_fields
from arctrue.measurement import MeasurementError

_LINE = re.compile(r"(\S+)\s+(\d{4}-\d\d-\d\d)[ T](\d\d:\d\d:\d\d(?:\.\d+)?)\s+(\S+)(.*)\Z")
_NOT_THERE = re.compile(r"\S+\s+\*\*\* ")
TURN_STEP_SHARE = 0.5
"""Share of a variable's range above which a step is the restart at the end of a turn."""
USUAL_STEP_SHARE = 0.25
"""Largest median step, as a share of the range, of a variable whose restarts are recognisable."""


def recognises(path: Path, head: bytes) -> bool:
    """Tell whether one of the first three lines has the form NAME DATE TIME VALUE."""
    text = head.decode("utf-8", "replace")
    return any(_LINE.match(line) for line in text.splitlines()[:3])


def read(path: Path, settings: ReadSettings, choices: Choices) -> FileContent:
    """Return ``time_s`` and one column per variable, all at the times of one of the variables.

    EPICS records a variable when its value changes, so each variable has its own times; the values
    of the other variables are interpolated linearly. ``settings.group`` names the variable whose
    times are used; the user is asked for it if the times differ. Rows outside the times of another
    variable, and rows in a step of another variable at the end of a turn, are left out. Raises
    MeasurementError, which names the row of a wrong line, and AmbiguousError.
    """
    times: dict[str, list[float]] = {}
    values: dict[str, list[float]] = {}
    lines: dict[str, list[int]] = {}
    gone = posts = 0
    with path.open(encoding="utf-8", errors="replace") as file:
        for number, text in enumerate(file, start=1):
            text = text.strip()
            if not text or text.startswith("#"):
                continue
            if _NOT_THERE.match(text):
                gone += 1
                continue
            name, moment, value = _fields(path, number, text)
            if name in times and moment < times[name][-1]:
                raise MeasurementError("time", path, "time runs backwards", row=number, column=name)
            times.setdefault(name, []).append(moment)
            values.setdefault(name, []).append(value)
            lines.setdefault(name, []).append(number)
            posts += 3
            refuse_many_fields(path, posts)
    names = list(times)
    base = _base(path, settings.group, times, choices)
    at = np.array(times[base])
    inside = np.ones(at.size, dtype=bool)
    for name in names:
        inside &= (at >= times[name][0]) & (at <= times[name][-1])
    if not inside.any():
        raise MeasurementError("empty", path, "its variables were never recorded together")
    outside = int((~inside).sum())
    stepping: dict[str, str] = {}
    for name in names:
        steps, within = _steps_of_a_turn(at, np.array(times[name]), np.array(values[name]))
        if (inside & within).any():
            often = "once" if steps == 1 else f"{steps} times"
            stepping[name] = (
                f"{path.name}: {name} steps {often} by more than half of its range, like an angle "
                f"at the end of a turn; {int((inside & within).sum())} rows in such a step are "
                "left out"
            )
            inside &= ~within
    if not inside.any():
        raise MeasurementError("empty", path, "all of its rows lie in steps at the end of a turn")
    start = float(at[inside][0])
    columns: dict[str, NDArray[np.float64]] = {"time_s": at[inside] - start}
    notes = [f"{path.name}: {len(names)} EPICS variables, {int(inside.sum())} rows"]
    for name in names:
        columns[name] = np.interp(at[inside], times[name], values[name])
        if times[name] != times[base]:
            longest = float(np.diff(times[name]).max(initial=0.0))
            notes.append(
                f"{path.name}: {name} is interpolated linearly to the times of {base}; "
                f"its values are {longest:.3g} s apart at most"
            )
        if name in stepping:
            notes.append(stepping[name])
    if gone or outside:
        notes.append(
            f"{path.name}: {outside} rows outside the others' times and {gone} lines "
            "without a value are left out"
        )
    return FileContent(
        path,
        "epics",
        columns,
        np.array(lines[base])[inside],
        known={"time": Known("time_s", "s")},
        notes=tuple(notes),
    )


def _steps_of_a_turn(
    at: NDArray[np.float64], times: NDArray[np.float64], values: NDArray[np.float64]
) -> tuple[int, NDArray[np.bool_]]:
    """Return the number of steps of a variable at the end of a turn, and for each time ``at`` (n,)
    whether it lies within such a step.

    The unit of the variable is not known here; a step is the end of a turn if it is longer than
    half of the range and the median step is shorter than a quarter of the range.
    """
    step, span = np.abs(np.diff(values)), float(np.ptp(values))
    if not step.size or float(np.median(step)) > USUAL_STEP_SHARE * span:
        return 0, np.zeros(at.size, dtype=bool)
    long = step > TURN_STEP_SHARE * span
    place = np.clip(np.searchsorted(times, at, "right") - 1, 0, step.size - 1)
    within = long[place] & (at > times[place]) & (at < times[place + 1])
    return int(np.count_nonzero(long)), within


def _fields(path: Path, row: int, text: str) -> tuple[str, float, float]:
    found = _LINE.match(text)
    if found is None:
        raise MeasurementError(
            "format", path, "expected NAME DATE TIME VALUE of camonitor", row=row
        )
    name, day, hour, value, _ = found.groups()
    try:
        moment = datetime.fromisoformat(f"{day}T{hour}").replace(tzinfo=UTC).timestamp()
    except ValueError as error:
        raise MeasurementError("time", path, f"{day} {hour}: {error}", row=row) from error
    try:
        number = float(value)
    except ValueError:
        raise MeasurementError(
            "value", path, f"expected a number, found {value!r}", row=row, column=name
        ) from None
    if not np.isfinite(number):
        raise MeasurementError(
            "not_a_number", path, f"expected a number, found {value!r}", row=row, column=name
        )
    return name, moment, number


def _base(path: Path, wanted: str, times: dict[str, list[float]], choices: Choices) -> str:
    names = list(times)
    if not wanted:
        if all(times[name] == times[names[0]] for name in names):
            return names[0]
        wanted = choices.ask(
            Ambiguous(
                "--group",
                f"{path}: the variables have different times; which variable's times are used?",
                names,
            )
        )
    if wanted not in times:
        raise MeasurementError(
            "missing", path, f"no variable {wanted}; there are {', '.join(names)}"
        )
    return wanted
