"""Wraps a user's effect: checks the result of each call, and reports the place of an error in the
user's file."""

from __future__ import annotations

import dis
import functools
import re
from collections.abc import Callable, Mapping
from pathlib import Path
from types import TracebackType
from typing import Any, get_args

import numpy as np

from arctrue.base.printable import is_printable
from arctrue.workbench.effects.base import (
    SEARCHED,
    Compensation,
    Effect,
    Lane,
    Parameter,
    SearchKind,
    SearchParameter,
)
from arctrue.workbench.effects.time_limit import TookTooLongError, call_within

LOAD_S = 60.0
"""Longest time in seconds for loading a file of effects."""
NAME = re.compile(r"[a-z][a-z0-9_]*\Z")
TEXTS = (
    "physics", "equation", "source", "capture_sees", "reference_sees", "separated_by",
    "next_measurement", "plausible", "compensation_note",
)  # fmt: skip
"""Names of the declarations of an effect that are texts for people."""
SWITCHES = (
    "at_reading", "depends_on_model", "fixed_to_polygon", "local_on_disc", "narrowed_when_added",
    "needs_settings", "of_the_signal", "unspecific",
)  # fmt: skip
"""Names of the declarations of an effect that are True or False."""


class EffectFileError(ValueError):
    """A file of effects cannot be used; the message names the file, and method and line if they are
    known."""


def guarded(kind: type[Effect], path: Path) -> type[Effect]:
    """Make a subclass of the effect in a user's file; it checks every call of the methods in
    CHECKS.

    Columns must be a finite numeric array of shape (rows, coefficients), or None. An exception from
    the file, including SystemExit, becomes an EffectFileError with file, method and line. A call
    that takes longer than the effect's ``longest_call_s`` has the same result.

    Raises EffectFileError for a declaration that is missing or of a wrong type.
    """
    _check_declarations(kind, path)
    checked = {
        name: _checked(getattr(kind, name), name, path, check) for name, check in CHECKS.items()
    }
    return type(kind.__name__, (kind,), {**checked, "__module__": kind.__module__})


def file_error(path: Path, error: BaseException, place: str = "") -> EffectFileError | None:
    """Make the EffectFileError for ``error`` if the user's file caused it; return None otherwise.

    A KeyboardInterrupt counts as caused by the file only if a ``raise`` statement of the file
    raised it; otherwise the user pressed Ctrl-C.
    """
    last = _last_of(path, error)
    if isinstance(error, SyntaxError) and error.filename == str(path):
        return EffectFileError(f"{path}: line {error.lineno}: {type(error).__name__}: {error.msg}")
    if last is None or (isinstance(error, KeyboardInterrupt) and not _raised_at(last)):
        return None
    where = f"{place}, line {last.tb_lineno}" if place else f"line {last.tb_lineno}"
    what = f"{type(error).__name__}: {error}" if str(error) else type(error).__name__
    return EffectFileError(f"{path}: {where}: {what}")


def too_long(path: Path, error: TookTooLongError, place: str, seconds: float) -> EffectFileError:
    """Make the EffectFileError for a call into the file, or its loading, that was ended after
    ``seconds``."""
    line = next((line for name, line in error.frames if name == str(path)), None)
    where = ", ".join([*([place] if place else []), *([f"line {line}"] if line else [])])
    limit = "longest_call_s of the effect sets the limit" if place else "the limit of loading"
    return EffectFileError(
        f"{path}: {where or 'loading'}: took longer than {seconds:g} s and was ended; "
        f"a loop without an end? ({limit})"
    )


def _last_of(path: Path, error: BaseException) -> TracebackType | None:
    """Return the innermost traceback entry that belongs to the user's file; None if there is
    none."""
    last = None
    trace = error.__traceback__
    while trace is not None:
        if trace.tb_frame.f_code.co_filename == str(path):
            last = trace
        trace = trace.tb_next
    return last


def _raised_at(trace: TracebackType) -> bool:
    """Tell whether the instruction at which the frame stopped is a ``raise``."""
    code = trace.tb_frame.f_code.co_code
    return dis.opname[code[trace.tb_lasti]] == "RAISE_VARARGS"


Check = Callable[[Effect, tuple[Any, ...], Any], str | None]
"""Function that describes the fault of a call's result in words; None if the result is correct."""


def _checked(method: Callable[..., Any], name: str, path: Path, check: Check) -> Callable[..., Any]:
    # Methods of this package need no limit of their own, since their calls into the file have
    # limits.
    limited = not method.__module__.startswith("arctrue.")

    @functools.wraps(method)
    def call(self: Effect, *arguments: Any, **named: Any) -> Any:
        try:
            if limited:
                found = call_within(self.longest_call_s, method, self, *arguments, **named)
            else:
                found = method(self, *arguments, **named)
        except EffectFileError:
            raise
        except TookTooLongError as error:
            raise too_long(path, error, name, self.longest_call_s) from error
        except BaseException as error:
            mine = file_error(path, error, name)
            if mine is None:
                raise
            raise mine from error
        fault = check(self, arguments, found)
        if fault is not None:
            raise EffectFileError(f"{path}: {name}{_first_line(method, path)}: {fault}")
        return found

    return call


def _first_line(method: Callable[..., Any], path: Path) -> str:
    code = getattr(method, "__code__", None)
    if code is None or code.co_filename != str(path):
        return ""
    return f", line {code.co_firstlineno}"


def _columns(effect: Effect, arguments: tuple[Any, ...], found: Any) -> str | None:
    if found is None:
        return None
    rows = arguments[0].run.size
    if not isinstance(found, np.ndarray) or found.ndim != 2 or found.shape[0] != rows:
        return f"expected an array of shape ({rows}, coefficients), found {_shape(found)}"
    widths = vars(effect).get("_widths", set())
    if widths and found.shape[1] not in widths:
        return (
            f"expected as many columns as column_names has names "
            f"({', '.join(map(str, sorted(widths)))}), found {found.shape[1]}"
        )
    if found.dtype.kind not in "fiub":
        return f"expected numbers, found an array of {found.dtype}"
    bad = np.flatnonzero(~np.isfinite(found).all(axis=1))
    if bad.size:
        return f"expected finite numbers, found {found[bad[0]]} in row {bad[0]}"
    return None


def _shape(found: Any) -> str:
    return f"shape {found.shape}" if isinstance(found, np.ndarray) else type(found).__name__


def _values(effect: Effect, arguments: tuple[Any, ...], found: Any) -> str | None:
    if found is None:
        return None
    rows = arguments[0].run.size
    if not isinstance(found, np.ndarray) or found.shape != (rows,):
        return f"expected an array of shape ({rows},), found {_shape(found)}"
    if found.dtype.kind not in "fiub" or not np.isfinite(found).all():
        return "expected finite numbers"
    return None


def _column_names(effect: Effect, arguments: tuple[Any, ...], found: Any) -> str | None:
    fault = _texts(effect, arguments, found)
    if fault is None:
        vars(effect).setdefault("_widths", set()).add(len(found))
    return fault


def _column_runs(effect: Effect, arguments: tuple[Any, ...], found: Any) -> str | None:
    widths = vars(effect).get("_widths", set())
    right = isinstance(found, tuple) and all(
        run is None or (isinstance(run, int) and run >= 0) for run in found
    )
    if right and (not widths or len(found) in widths):
        return None
    return f"expected a tuple with a run or None for each name of column_names, found {found!r}"


def _texts(effect: Effect, arguments: tuple[Any, ...], found: Any) -> str | None:
    if isinstance(found, list) and all(
        isinstance(item, str) and is_printable(item) for item in found
    ):
        return None
    return f"expected a list of printable texts, found {found!r}"


def _text_or_none(effect: Effect, arguments: tuple[Any, ...], found: Any) -> str | None:
    if found is None or (isinstance(found, str) and is_printable(found)):
        return None
    return f"expected a printable text or None, found {found!r}"


def _text(effect: Effect, arguments: tuple[Any, ...], found: Any) -> str | None:
    right = isinstance(found, str) and (not found or is_printable(found))
    return None if right else f"expected one line of printable text, found {found!r}"


def _truth(effect: Effect, arguments: tuple[Any, ...], found: Any) -> str | None:
    return (
        None if isinstance(found, bool | np.bool_) else f"expected True or False, found {found!r}"
    )


def _nothing(effect: Effect, arguments: tuple[Any, ...], found: Any) -> str | None:
    return None


def _parameters(effect: Effect, arguments: tuple[Any, ...], found: Any) -> str | None:
    named = isinstance(found, Mapping) and all(
        isinstance(name, str)
        and is_printable(name)
        and isinstance(item, Parameter)
        and np.isfinite(item.value)
        for name, item in found.items()
    )
    return None if named else f"expected Parameters with finite values by name, found {found!r}"


def _limit(effect: Effect, arguments: tuple[Any, ...], found: Any) -> str | None:
    number = isinstance(found, int | float | np.integer | np.floating)
    if number and not isinstance(found, bool) and 0.0 <= found < np.inf:
        return None
    return f"expected a finite number of 0 or more, found {found!r}"


def _lanes(effect: Effect, arguments: tuple[Any, ...], found: Any) -> str | None:
    right = isinstance(found, list) and all(
        isinstance(item, Lane) and np.isfinite([item.cosine_arcsec, item.sine_arcsec]).all()
        for item in found
    )
    return None if right else f"expected a list of Lane with finite sizes, found {found!r}"


CHECKS: Mapping[str, Check] = {
    "__init__": _nothing,
    "disc_orders": _nothing,
    "search_range": _nothing,
    "lanes": _lanes,
    "concerns": _truth,
    "missing": _texts,
    "variety": _texts,
    "contradiction": _text_or_none,
    "search_contradiction": _text_or_none,
    "constant_between_heads_arcsec": _limit,
    "column_names": _column_names,
    "column_runs": _column_runs,
    "capture_columns": _columns,
    "reference_columns": _columns,
    "capture_formula": _values,
    "reference_formula": _values,
    "describe": _text,
    "describe_data": _text,
    "describe_values": _text,
    "derived": _parameters,
    "narrowed": _nothing,
    "forms": _nothing,
    "parameters": _parameters,
}


def _check_declarations(kind: type[Effect], path: Path) -> None:
    def fail(name: str, expected: str) -> None:
        found = getattr(kind, name, None)
        raise EffectFileError(
            f"{path}: {kind.__name__}.{name}: expected {expected}, found {found!r}"
        )

    if not isinstance(kind.name, str) or not NAME.match(kind.name):
        fail("name", "small letters, digits, underscores")
    for text in TEXTS:
        if not isinstance(getattr(kind, text, None), str):
            fail(text, "a text")
    if kind.compensation not in get_args(Compensation):
        fail("compensation", " or ".join(map(repr, get_args(Compensation))))
    if not isinstance(kind.search, tuple) or not all(
        isinstance(item, SearchParameter) and item.low < item.high for item in kind.search
    ):
        fail("search", "a tuple of SearchParameter, each with low below high")
    if kind.search_kind not in get_args(SearchKind):
        fail("search_kind", " or ".join(map(repr, get_args(SearchKind))))
    names = {item.name for item in kind.search}
    expected = SEARCHED.get(kind.search_kind, names)
    if names != expected:
        fail("search", f"{', '.join(sorted(expected))} for search_kind {kind.search_kind!r}")
    if "scan" in vars(kind):
        fail("scan", "none: search_kind states the kind of search")
    for switch in SWITCHES:
        if not isinstance(getattr(kind, switch), bool):
            fail(switch, "True or False")
    if kind.step_at is not None and not (
        isinstance(kind.step_at, tuple)
        and len(kind.step_at) == 2
        and all(isinstance(name, str) and name in names for name in kind.step_at)
    ):
        fail("step_at", "two names of search or None")
    if not isinstance(kind.in_parts, tuple) or not all(
        isinstance(part, str) for part in kind.in_parts
    ):
        fail("in_parts", "a tuple of texts")
    limit = kind.longest_call_s
    if isinstance(limit, bool) or not isinstance(limit, int | float) or not limit > 0.0:
        fail("longest_call_s", "seconds above 0")
    if not isinstance(kind.defaults, Mapping):
        fail("defaults", "settings by name")
    if not isinstance(kind.parameter_units, Mapping):
        fail("parameter_units", "units by parameter")
