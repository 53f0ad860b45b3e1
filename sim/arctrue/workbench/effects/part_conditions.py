"""Defines the conditions that a product of parts may have."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from arctrue.workbench.effects.first_order_lag import behind
from arctrue.workbench.effects.gateware_lanes import Condition as GatewareCondition
from arctrue.workbench.observations import CaptureRows, Observations, ReferenceRows
from arctrue.workbench.observations.column_unit import column_unit

Float = NDArray[np.float64]
Rows = CaptureRows | ReferenceRows
LEAST_RUNS_OF_A_STATE = 2
"""Fewest runs before and after a change between two runs: a single run that differs from the others
does not show that the new state lasts."""
MOST_RUNS = 40
"""Largest number of runs of a reference between which changes are searched, to limit cost: each
boundary is one more factor of every order. With more runs, the report states that changes were not
searched."""


@dataclass(frozen=True)
class Condition:
    """A factor that depends on the conditions of a row."""

    part: str
    """Name in the JSON: temperature, speed, speed^2, direction, time, settling, run, travel, or a
    column of the set; empty for the factor 1."""
    words: str
    unit: str
    values: Callable[[Rows], Float | None]
    time_constant_s: float | None = None
    each_run: bool = False
    column: str | None = None
    """Name of the column, if the condition is an additional column of the user."""
    column_zero: float = 0.0
    """Value of the column at which the condition is 0."""
    by_direction: bool = False
    """Whether the condition is multiplied by the direction of approach."""
    form: str = ""
    """Name of the form of the column: of FORMS, of SEARCHED_FORMS, or LAG; empty for the column
    itself."""
    from_run: int | None = None
    """First run of the reference in which the factor is 1, if it is 0 before and 1 from then
    on."""

    @property
    def without_power(self) -> str:
        """Return ``part`` without its power or form: speed for speed^2."""
        return self.column_words or self.part.partition("^")[0]

    @property
    def column_words(self) -> str | None:
        """Return the name of the condition's column for people; None without a column."""
        return None if self.column is None else _name_and_unit(self.column)[0]

    @property
    def settings(self) -> dict[str, object]:
        """Return the settings with which a :class:`ProductOfParts` has this condition."""
        if self.column is not None:
            found: dict[str, object] = {"column": self.column, "column_zero": self.column_zero}
            if self.time_constant_s is not None:
                found |= {"time_constant_s": self.time_constant_s}
            if self.form:
                return found | {"condition": self.form}
            return found | ({"condition": "direction"} if self.by_direction else {})
        if self.from_run is not None:
            return {"from_run": self.from_run}
        if self.time_constant_s is not None:
            return {"time_constant_s": self.time_constant_s, "each_run": self.each_run}
        names = {condition.words: name for name, condition in CONDITIONS.items()}
        return {"condition": names[self.words]}


def _temperature(rows: Rows) -> Float | None:
    warmth = rows.temperature_c
    return None if warmth is None else warmth - rows.reference_temperature_c


def _speed(rows: Rows) -> Float | None:
    return rows.speed_rad_s


def _speed_size(rows: Rows) -> Float | None:
    return None if rows.speed_rad_s is None else np.abs(rows.speed_rad_s)


def _speed_square(rows: Rows) -> Float | None:
    return None if rows.speed_rad_s is None else rows.speed_rad_s**2


def _direction(rows: Rows) -> Float | None:
    return rows.direction


def _time(rows: Rows) -> Float | None:
    # The time counts from the start of the session: seconds since midnight or since 1970 would be
    # nearly constant.
    return None if rows.time_s is None else (rows.time_s - rows.session_start_s) / 3600.0


def _direction_time(rows: Rows) -> Float | None:
    time = _time(rows)
    if time is None or rows.direction is None or isinstance(rows, CaptureRows):
        return None
    return rows.direction * time


def _travel(rows: Rows) -> Float | None:
    return np.degrees(rows.target_rad) if isinstance(rows, ReferenceRows) else None


def _settling(time_constant_s: float, each_run: bool) -> Callable[[Rows], Float | None]:
    def values(rows: Rows) -> Float | None:
        if rows.time_s is None or rows.run_start_s is None:
            return None
        since = rows.time_s - (rows.run_start_s if each_run else rows.session_start_s)
        return np.asarray(np.exp(-np.maximum(since, 0.0) / time_constant_s))

    return values


ALWAYS = Condition("", "", "", lambda rows: np.ones(rows.run.size))
TEMPERATURE = Condition("temperature", "(T − T₀)", "K", _temperature)
SIMPLE_CONDITIONS = (
    TEMPERATURE,
    Condition("direction", "direction", "", _direction),
    Condition("speed", "speed", "rad/s", _speed),
    Condition("speed^2", "speed²", "(rad/s)²", _speed_square),
    Condition("speed", "|speed|", "rad/s", _speed_size),
    Condition("time", "time", "h", _time),
)
TRAVEL = Condition("travel", "angle of travel", "°", _travel)
SHORT_ARC_RAD = np.pi
"""On a shorter arc the default model has no order of the disc, so that no eccentricity in the model
can explain an error that grows with the angle."""
LONG_TRAVEL_RAD = 4.0 * np.pi
"""Two turns. Over more turns, the orders of the disc repeat and cannot follow an error that grows
with the angle."""
DIRECTION_TIME = Condition("time", "direction × time", "h", _direction_time, by_direction=True)
CONDITIONS: Mapping[str, Condition] = {
    "|speed|" if condition.values is _speed_size else condition.part: condition
    for condition in (ALWAYS, *SIMPLE_CONDITIONS, TRAVEL)
} | {"direction*time": DIRECTION_TIME}
"""Conditions by their names in the setting ``condition``."""
BY_GATEWARE: Mapping[str, GatewareCondition] = {
    "direction": "direction",
    "speed": "speed",
    "speed²": "speed_squared",
}
"""Conditions of the gateware, by the names of the same conditions in the workbench."""


def settling_condition(time_constant_s: float, each_run: bool) -> Condition:
    """Make the condition exp(−t/τ), where t counts from the start of each run or of the whole
    set."""
    since = "each start" if each_run else "the start"
    return Condition(
        "settling",
        f"exp(−t/{time_constant_s:.3g} s) from {since}",
        "",
        _settling(time_constant_s, each_run),
        time_constant_s,
        each_run,
    )


def column_condition(column: str, zero: float) -> Condition:
    """Make the condition of a user's additional column, from which ``zero`` is subtracted."""

    def values(rows: Rows) -> Float | None:
        found = rows.conditions.get(column)
        return None if found is None else found - zero

    unit = column_unit(column)
    away = f"({column} − {zero:g})" if zero > 0.0 else f"({column} + {-zero:g})"
    words = column if zero == 0.0 else away
    return Condition(column, words, unit, values, column=column, column_zero=zero)


@dataclass(frozen=True)
class _Form:
    """A function of a column minus its zero."""

    part: str
    """Public name; {0} is the name of the column."""
    words: str
    """Name for people; {0} is the column minus its zero."""
    unit: str
    """Unit; {0} is the unit of the column."""
    of: Callable[[Float], Float]


FORMS: Mapping[str, _Form] = {
    "square": _Form("{0}^2", "{0}²", "{0}²", np.square),
    "size": _Form("|{0}|", "|{0}|", "{0}", np.abs),
    "signed_square": _Form(
        "{0}*|{0}|", "{0} × |{0}|", "{0}²", lambda values: values * np.abs(values)
    ),
}
"""Forms of a column by their names in the setting ``condition``. Examples: a deflection by the
square of a torque or a current; friction that grows with the size of a load; the pressure of wind,
which grows with the square of its speed and has the sign of the speed."""
SEARCHED_FORMS: Mapping[str, _Form] = {
    "square": FORMS["square"],
    "size": FORMS["size"],
    "above": _Form("above:{0}", "max(0, {0})", "{0}", lambda values: np.maximum(values, 0.0)),
    "below": _Form("below:{0}", "max(0, −{0})", "{0}", lambda values: np.maximum(-values, 0.0)),
}
"""Forms of a column or of the temperature whose zero is found by a search. Examples: a distance
that is shortest at one temperature; a joint that slips above a torque."""
LAG = "lag"
"""Value of the setting ``condition`` for a column after a first-order lag."""
TEMPERATURE_COLUMN = "temperature_c"
"""Column of the temperature, which may have a form like a user's additional column."""


def column_of(rows: Rows, column: str) -> Float | None:
    """Return an additional column of the user, or the temperature in degrees Celsius."""
    return rows.temperature_c if column == TEMPERATURE_COLUMN else rows.conditions.get(column)


def form_condition(
    column: str, form: str, zero: float = 0.0, time_constant_s: float | None = None
) -> Condition:
    """Make a condition: the form (a name of FORMS or SEARCHED_FORMS) of a column minus ``zero``.

    ``zero`` is 0 if there is no error at the column's own zero, for example without torque, current
    or wind. The form LAG is the column after a first-order lag of ``time_constant_s``, minus
    ``zero``.

    Raises ValueError for an unknown form.
    """
    if form == LAG:
        return _lag_condition(column, zero, time_constant_s or 0.0)
    forms = {**FORMS, **SEARCHED_FORMS}
    if form not in forms:
        known = ", ".join([*forms, LAG])
        raise ValueError(f"no form {form!r} of a column; there are: {known}")
    used = forms[form]

    def values(rows: Rows) -> Float | None:
        found = column_of(rows, column)
        return None if found is None else np.asarray(used.of(found - zero))

    name, unit = _name_and_unit(column)
    compound = f"({unit})" if "·" in unit and used.unit != "{0}" else unit
    bare = form in ("above", "below", "size")
    if form == "below":
        words = f"max(0, {zero:g} − {name})"
    else:
        words = used.words.format(_away(name, zero, bare=bare))
    return Condition(
        used.part.format(name),
        words,
        used.unit.format(compound),
        values,
        column=column,
        column_zero=zero,
        form=form,
    )


def _lag_condition(column: str, zero: float, time_constant_s: float) -> Condition:
    """Make the condition that is a column of the reference after a first-order lag."""

    def values(rows: Rows) -> Float | None:
        found = column_of(rows, column)
        if found is None or rows.time_s is None or isinstance(rows, CaptureRows):
            return None
        if not np.all(np.diff(rows.time_s) > 0.0):
            return None
        return behind(found, rows.time_s, time_constant_s) - zero

    name, unit = _name_and_unit(column)
    return Condition(
        f"lag:{name}",
        f"{name} behind a lag of {float(f'{time_constant_s:.3g}'):g} s",
        unit,
        values,
        time_constant_s,
        column=column,
        column_zero=zero,
        form=LAG,
    )


def _name_and_unit(column: str) -> tuple[str, str]:
    return ("temperature", "K") if column == TEMPERATURE_COLUMN else (column, column_unit(column))


def _away(name: str, zero: float, *, bare: bool) -> str:
    """Return a column minus its zero in words, in brackets unless ``bare``."""
    if zero == 0.0:
        return name
    text = f"{name} − {zero:g}" if zero > 0.0 else f"{name} + {-zero:g}"
    return text if bare else f"({text})"


def condition_named(
    words: str, time_constant_s: float | None = None, each_run: bool = False
) -> Condition:
    """Return the condition with this name or these words; if ``time_constant_s`` is given, return
    the condition exp(−t/τ). The name "" is the factor 1.

    Raises ValueError for unknown words.
    """
    if time_constant_s is not None:
        return settling_condition(time_constant_s, each_run)
    for name, condition in CONDITIONS.items():
        if words in (name, condition.words):
            return condition
    known = ", ".join(repr(name) for name in CONDITIONS if name)
    raise ValueError(f"no condition {words!r}; there are: {known}")


def recorded_conditions(observations: Observations) -> list[Condition]:
    """Return the simple conditions and the user's additional columns, even if some are equal or
    missing in the set; exp(−t/τ) is not included."""
    return [*SIMPLE_CONDITIONS, *_columns(observations)]


def run_condition(first: int) -> Condition:
    """Make the condition that is 0 in the runs of the reference before run ``first``, and 1 from
    this run on."""

    def values(rows: Rows) -> Float | None:
        return None if isinstance(rows, CaptureRows) else (rows.run >= first).astype(np.float64)

    return Condition("run", f"from run {first} on", "", values, from_run=first)


def _run_conditions(observations: Observations) -> list[Condition]:
    """Return the changes between two runs of the reference, with LEAST_RUNS_OF_A_STATE or more runs
    before and after each; none if the numbers of the runs do not increase through the rows."""
    rows = observations.reference
    if rows is None or np.any(np.diff(rows.run) < 0) or too_many_runs(observations) is not None:
        return []
    runs = np.unique(rows.run)
    return [
        run_condition(int(first))
        for first in runs[LEAST_RUNS_OF_A_STATE : runs.size - LEAST_RUNS_OF_A_STATE + 1]
        if first != 0  # The setting 0 means no change.
    ]


def too_many_runs(observations: Observations) -> int | None:
    """Return the number of runs of a reference if there are too many to search for changes between
    them; otherwise None."""
    rows = observations.reference
    runs = 0 if rows is None else np.unique(rows.run).size
    return runs if runs > MOST_RUNS else None


def times_direction(condition: Condition) -> Condition:
    """Return a column's condition times the direction of approach, which only a reference has."""

    def values(rows: Rows) -> Float | None:
        found = condition.values(rows)
        if found is None or rows.direction is None or isinstance(rows, CaptureRows):
            return None
        return rows.direction * found

    words = f"direction × {condition.words}"
    return replace(condition, words=words, values=values, by_direction=True)


def conditions_by_direction(observations: Observations) -> list[Condition]:
    """Return every additional column times the direction, if the reference was read in both
    directions: friction, and with it the reversal error, may grow with a load."""
    if not _both_ways(observations):
        return []
    return [times_direction(item) for item in _columns(observations)]


def _both_ways(observations: Observations) -> bool:
    rows = observations.reference
    return rows is not None and rows.direction is not None and float(np.ptp(rows.direction)) > 0.0


def _forms(observations: Observations) -> list[Condition]:
    """Return the forms of the user's additional columns."""
    return [
        form_condition(item.column, form)
        for item in _columns(observations)
        for form in FORMS
        if item.column is not None
    ]


def _columns(observations: Observations) -> list[Condition]:
    """Return the user's additional columns of both files, each minus its median over the set."""
    channels = [rows for rows in (observations.capture, observations.reference) if rows is not None]
    names = dict.fromkeys(name for rows in channels for name in rows.conditions)
    found = []
    for name in names:
        there = [rows.conditions[name] for rows in channels if name in rows.conditions]
        # The value is rounded, so that descriptions and an adopted file state the value in use.
        found.append(column_condition(name, float(f"{np.median(np.concatenate(there)):.4g}")))
    return found


def conditions(observations: Observations) -> list[Condition]:
    """Return the factor 1 and the conditions that vary in this set, the simpler first; of
    equivalent conditions, return the first only."""
    found = [
        ALWAYS,
        *recorded_conditions(observations),
        *conditions_by_direction(observations),
        *([DIRECTION_TIME] if _both_ways(observations) else []),
        *_forms(observations),
        *_run_conditions(observations),
    ]
    if _is_travelled(observations):
        found.append(TRAVEL)
    longest = max(observations.longest_run_s, _reference_span(observations))
    shortest = 20.0 * max(observations.sample_period_s, 1e-9)
    if longest > 4.0 * shortest:
        for constant in np.geomspace(max(longest / 300.0, shortest), 3.0 * longest, 9):
            found += [settling_condition(float(constant), each) for each in (False, True)]
    return _distinct(found, observations)


def _is_travelled(observations: Observations) -> bool:
    """Tell whether a set has only a reference, over a short arc or over more than two turns."""
    rows = observations.reference
    if rows is None or observations.capture is not None:
        return False
    return not SHORT_ARC_RAD <= float(np.ptp(rows.target_rad)) <= LONG_TRAVEL_RAD


def _reference_span(observations: Observations) -> float:
    rows = observations.reference
    if rows is None or rows.time_s is None or rows.time_s.size == 0:
        return 0.0
    return float(np.ptp(rows.time_s))


def _distinct(found: list[Condition], observations: Observations) -> list[Condition]:
    kept: list[Condition] = []
    shapes: list[Float] = []
    for condition in found:
        pieces = []
        for rows in (observations.capture, observations.reference):
            if rows is None:
                continue
            values = condition.values(rows)
            thin = max(rows.run.size // 20_000, 1)
            pieces.append(np.zeros(rows.run.size) if values is None else values)
            pieces[-1] = pieces[-1][::thin]
        shape = np.concatenate(pieces) if pieces else np.zeros(0)
        centred = shape - shape.mean() if shape.size else shape
        if condition is not ALWAYS:
            scale = float(np.sqrt(np.mean(centred**2))) if centred.size else 0.0
            if scale <= 1e-9 * max(float(np.abs(shape).max(initial=0.0)), 1e-30):
                continue
            correlations = [
                abs(float(centred @ other)) / (np.linalg.norm(centred) * np.linalg.norm(other))
                for other in shapes
            ]
            if max(correlations, default=0.0) > 0.9999:
                continue
            shapes.append(centred)
        kept.append(condition)
    return kept
