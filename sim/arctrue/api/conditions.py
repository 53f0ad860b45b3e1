"""Checks the arguments ``fix``, ``bounds`` and ``tie`` of :func:`arctrue.fit`, and turns them into
conditions of the fit."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from arctrue.api.model import Model
from arctrue.base.similar import did_you_mean
from arctrue.workbench.effects.parameter import Parameter, kind_of
from arctrue.workbench.inference.constrained import Condition, ConditionError
from arctrue.workbench.inference.design_matrix import Term
from arctrue.workbench.inference.fit import fit as fit_terms
from arctrue.workbench.inference.named import labels
from arctrue.workbench.inference.solution import Solution
from arctrue.workbench.model.predicted import plain

Tied = str | tuple[str, float] | Callable[[Mapping[str, float]], float]
"""Value of a tied parameter: a parameter's name, (name, factor), or a function of all values."""
Fixes = Mapping[str, float] | Iterable[str] | None

TURN_DEG = 360.0


@dataclass(frozen=True)
class Constant:
    """The value of a fixed parameter."""

    value: float

    def __call__(self, parameters: Mapping[str, float]) -> float:
        """Return the value."""
        return self.value


@dataclass(frozen=True)
class Multiple:
    """A multiple of another parameter."""

    other: str
    factor: float

    def __call__(self, parameters: Mapping[str, float]) -> float:
        """Return the factor times the other parameter."""
        return self.factor * parameters[self.other]


@dataclass(frozen=True)
class UsersFunction:
    """A user's function of all parameters, whose values are checked."""

    name: str
    function: Callable[[Mapping[str, float]], float]

    def __call__(self, parameters: Mapping[str, float]) -> float:
        """Return the value of the function. Raises ConditionError unless it is a finite number."""
        value = self.function(parameters)
        try:
            number = float(value)
        except (TypeError, ValueError):
            number = math.nan
        if not math.isfinite(number):
            raise ConditionError(
                f"tie of {self.name}: expected a function that returns a finite number, found "
                f"{value!r}"
            )
        return number


@dataclass(frozen=True)
class Difference:
    """Difference of a parameter from a wanted value; a phase may differ by whole turns."""

    name: str
    wanted: Callable[[Mapping[str, float]], float]
    is_phase: bool

    def __call__(self, parameters: Mapping[str, float]) -> float:
        """Return the difference."""
        off = parameters[self.name] - self.wanted(parameters)
        return _within_half_a_turn(off) if self.is_phase else float(off)


@dataclass(frozen=True)
class Side:
    """Distance of a parameter from a bound, negative if the parameter violates the bound; a phase
    is first shifted by whole turns to within 180° of ``centre``."""

    name: str
    bound: float
    sign: float
    centre: float | None

    def __call__(self, parameters: Mapping[str, float]) -> float:
        """Return the distance."""
        value = parameters[self.name]
        if self.centre is not None:
            value = self.centre + _within_half_a_turn(value - self.centre)
        return self.sign * (value - self.bound)


@dataclass
class Wanted:
    """Requirements of the arguments on a fit."""

    conditions: list[Condition] = field(default_factory=list)
    places: dict[str, float] = field(default_factory=dict)
    """Values of fixed search parameters that are integers."""
    fixed: set[str] = field(default_factory=set)
    """Names of the fixed parameters."""
    limits: dict[str, tuple[float, float]] = field(default_factory=dict)
    """Bounds by name; infinite on an open side."""


def wanted_of(
    model: Model,
    solution: Solution,
    fix: Fixes,
    bounds: Mapping[str, tuple[float | None, float | None]] | None,
    tie: Mapping[str, Tied] | None,
) -> Wanted:
    """Return the conditions that the fit must meet.

    Raises ValueError for an unknown name or a value that no parameter can have.
    """
    known = solution.named_parameters()
    found = Wanted()
    for name, given in _fixed_values(model, fix).items():
        value = _number(f"fix {name}", given, _known(known, name).unit)
        _require_possible(f"fix {name}", name, known[name], value)
        found.fixed.add(name)
        if _is_whole(solution, name):
            found.places[name] = value
        else:
            found.conditions.append(_equal(name, Constant(value), (name,), known))
    for name, sides in _mapping("bounds", "{name: (low, high)}", bounds).items():
        low, high = _limits(name, sides, _known(known, name))
        if _is_phase(name, known) and high - low >= TURN_DEG and math.isfinite(high - low):
            continue
        found.limits[name] = (low, high)
        both = math.isfinite(low) and math.isfinite(high)
        centre = 0.5 * (low + high) if both and _is_phase(name, known) else None
        found.conditions += [
            Condition((name,), Side(name, bound, sign, centre), equation=False)
            for bound, sign in ((low, 1.0), (high, -1.0))
            if math.isfinite(bound)
        ]
    for name, tied in _mapping("tie", "{name: other name}", tie).items():
        _known(known, name)
        if callable(tied):
            found.conditions.append(_equal(name, UsersFunction(name, tied), tuple(known), known))
            continue
        other, factor = _other(name, tied)
        _known(known, other)
        if other == name:
            raise ValueError(f"tie of {name}: expected another parameter, found the same")
        found.conditions.append(_equal(name, Multiple(other, factor), (name, other), known))
    return found


def with_places(solution: Solution, places: Mapping[str, float]) -> Solution:
    """Return the fit with the integer search parameters fixed at these values.

    Raises ValueError for a value out of range.
    """
    named = labels(solution.terms)
    terms: list[Term] = list(solution.terms)
    for name, value in places.items():
        label, _, own = name.rpartition(".")
        number = named.index(label)
        low, high = terms[number].effect.search_range(own)
        if not low <= value <= high or value != round(value):
            raise ValueError(
                f"fix {name}: expected a whole number from {low:g} to {high:g}, found {value:g}"
            )
        terms[number] = replace(terms[number], nonlinear={**terms[number].nonlinear, own: value})
    return fit_terms(terms, solution.observations)


def _within_half_a_turn(angle_deg: float) -> float:
    return float(np.remainder(angle_deg + 0.5 * TURN_DEG, TURN_DEG) - 0.5 * TURN_DEG)


def _is_phase(name: str, known: Mapping[str, Parameter]) -> bool:
    return kind_of(name, known[name]) == "phase"


def _known(known: Mapping[str, Parameter], name: Any) -> Parameter:
    """Return a parameter. Raises ValueError for an unknown name."""
    if name not in known:
        raise ValueError(
            f"no parameter {name!r}.{did_you_mean(str(name), known)} There are: {', '.join(known)}"
        )
    return known[name]


def _number(place: str, given: Any, unit: str) -> float:
    """Return a finite number in the unit of the parameter; a quantity of astropy is converted.

    Raises ValueError for anything else.
    """
    converted = plain(given, unit, place)
    try:
        value = math.nan if isinstance(converted, str) else float(converted)
    except (TypeError, ValueError):
        value = math.nan
    if not math.isfinite(value):
        raise ValueError(f"{place}: expected a finite number, found {given!r}")
    return value


def _require_possible(place: str, name: str, parameter: Parameter, value: float) -> None:
    if kind_of(name, parameter) == "amplitude" and value < 0.0:
        raise ValueError(
            f"{place}: expected 0 or more, found {value:g}; an amplitude has no sign; "
            "shift the phase by 180° instead"
        )


def _limits(name: str, sides: Any, parameter: Parameter) -> tuple[float, float]:
    """Return the bounds of a parameter, infinite where they are None. Raises ValueError."""
    place = f"bounds of {name}"
    if isinstance(sides, str) or not isinstance(sides, Iterable) or len(both := list(sides)) != 2:
        raise ValueError(f"{place}: expected (low, high), None on an open side, found {sides!r}")
    low, high = (
        end if side is None or _is_end(side, end) else _number(place, side, parameter.unit)
        for side, end in zip(both, (-math.inf, math.inf), strict=True)
    )
    if low > high:
        raise ValueError(f"{place}: expected low <= high, found {low:g} and {high:g}")
    _require_possible(place, name, parameter, high)
    return low, high


def _is_end(side: Any, end: float) -> bool:
    """Tell whether a bound is infinite in the direction of its open side."""
    return isinstance(side, float | int) and side == end


def _other(name: str, tied: Any) -> tuple[str, float]:
    """Return the other parameter and the factor of a tie. Raises ValueError."""
    if isinstance(tied, str):
        return tied, 1.0
    if isinstance(tied, tuple | list) and len(tied) == 2 and isinstance(tied[0], str):
        return tied[0], _number(f"tie of {name}", tied[1], "")
    raise ValueError(
        f"tie of {name}: expected a parameter's name, (name, factor) or a function, found {tied!r}"
    )


def _mapping(argument: str, form: str, given: Any) -> Mapping[str, Any]:
    if given is None:
        return {}
    if not isinstance(given, Mapping):
        raise ValueError(f"{argument}: expected {form}, found {given!r}")
    return given


def _equal(
    name: str,
    wanted: Callable[[Mapping[str, float]], float],
    names: tuple[str, ...],
    known: Mapping[str, Parameter],
) -> Condition:
    """Require that ``name`` equals the value of ``wanted``."""
    every = names if names[:1] == (name,) else (name, *names)
    return Condition(every, Difference(name, wanted, _is_phase(name, known)))


def _fixed_values(model: Model, fix: Fixes) -> Mapping[str, Any]:
    """Return the fixed values by name.

    Raises ValueError for a name for which neither ``fix`` nor the model has a value.
    """
    if fix is None or isinstance(fix, Mapping):
        return fix or {}
    if not isinstance(fix, Iterable):
        raise ValueError(f"fix: expected {{name: value}} or names, found {fix!r}")
    stored = {
        f"{entry.name}.{name}": item.value
        for entry in model.content.effects
        for name, item in entry.parameters.items()
    }
    names = [fix] if isinstance(fix, str) else list(fix)
    for name in names:
        if name not in stored:
            raise ValueError(
                f"fix {name}: the model has no fitted value for this name."
                f"{did_you_mean(name, stored)} Give one: fix={{'{name}': VALUE}}"
            )
    return {name: stored[name] for name in names}


def _is_whole(solution: Solution, name: str) -> bool:
    """Tell whether the parameter is a search parameter with integer values, such as an order or a
    run."""
    label, _, own = name.rpartition(".")
    term = solution.terms[labels(solution.terms).index(label)]
    return any(item.name == own and item.integer for item in term.effect.search)
