"""Converts content of TOML and JSON files to typed structures, with messages for people.

A reader declares its file as msgspec structures or dataclasses: names, types, ranges and defaults
of the keys. :func:`typed` converts the content, or raises an error that names the wrong key, the
expected value and the found value.
"""

from __future__ import annotations

import json
import math
import re
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Annotated, Any, TypeVar

import msgspec
from msgspec import Meta, inspect

from arctrue.base.printable import is_printable, one_line
from arctrue.base.similar import similar

T = TypeVar("T")

LARGEST = sys.float_info.max
"""Largest finite number; a range that ends at this number excludes NaN and infinity."""
LARGE_POWER = 40
"""Smallest exponent n for which a limit 2ⁿ is printed as a power of two."""
LONGEST_FOUND = 60
"""Largest number of characters of a value that a message repeats."""


def at_least(low: float) -> Meta:
    """Declare a finite number of ``low`` or more."""
    return Meta(ge=low, le=LARGEST)


def above(low: float) -> Meta:
    """Declare a finite number greater than ``low``."""
    return Meta(gt=low, le=LARGEST)


Number = Annotated[float, Meta(ge=-LARGEST, le=LARGEST)]
"""Any finite number."""
NotNegative = Annotated[float, at_least(0.0)]
Positive = Annotated[float, above(0.0)]


class ContentError(ValueError):
    """Content does not fit its declaration; the text begins with the key."""

    def __init__(self, text: str, *, missing: bool = False) -> None:
        """Store the text; ``missing``: whether the fault is that a required key is absent."""
        super().__init__(text)
        self.missing = missing


def typed(content: object, kind: type[T], place: str = "") -> T:
    """Convert ``content`` to ``kind``, a structure or dataclass; ``place`` is its key in the file.

    Raises ContentError with the key, the expected and the found value. A ValueError that a
    structure's ``__post_init__`` raises becomes a ContentError; its text must begin with a key of
    the structure.
    """
    try:
        return msgspec.convert(content, kind)
    except msgspec.ValidationError as error:
        raise _readable_error(content, kind, place, error) from error


def read_json(path: Path, kind: type[T]) -> T:
    """Read a JSON file that a program wrote; all of its keys must be declared.

    Raises OSError if the file cannot be read, ContentError with its name for wrong content.
    """
    return typed_json(path.read_bytes(), kind, str(path))


def typed_json(text: str | bytes, kind: type[T], file: str) -> T:
    """Convert JSON text to ``kind``. Raises ContentError, which names ``file``."""
    try:
        content = json.loads(text)
    except (ValueError, RecursionError) as error:
        raise ContentError(f"{file}: is not JSON: {one_line(str(error))}") from error
    try:
        found = typed(content, kind)
    except ContentError as error:
        message = re.sub(r"expected a table( \[[^]]*\])?", "expected an object", str(error))
        raise ContentError(f"{file}: {message}", missing=error.missing) from error
    for key, near in unknown_keys(content, kind).items():
        meant = f"; did you mean {' or '.join(near)}?" if near else ""
        raise ContentError(f"{file}: {one_line(key)}: is not known{meant}")
    return found


def unknown_keys(content: object, kind: type) -> dict[str, list[str]]:
    """Return the dotted keys that ``kind`` does not declare, with similar declared keys."""
    return dict(_unknown(_Spot("", _declared(kind), content)))


def _unknown(spot: _Spot) -> Iterator[tuple[str, list[str]]]:
    value, declared = spot.value, _bare(_branch(spot.declared, spot.value))
    if isinstance(value, dict):
        fields = _fields(declared)
        if isinstance(declared, inspect.DictType):
            fields = dict.fromkeys(value, declared.value_type)
        for name in value if fields else ():
            if name in fields:
                yield from _unknown(_Spot(spot.inside(name), fields[name], value[name]))
            else:
                yield spot.inside(name), similar(name, fields)
    elif isinstance(value, list) and isinstance(declared, _LISTS):
        for index, item in enumerate(value):
            place = f"{spot.key}[{index + 1}]{_called(item)}"
            yield from _unknown(_Spot(place, _item(declared, index), item))


def bound_words(kind: Any) -> str:
    """Describe the range of an annotated type; return an empty text if it has no range."""
    declared = _branch(_declared(kind), None)
    return _range(declared).strip() if isinstance(declared, _NUMBERS) else ""


def shown(value: object) -> str:
    """Write a value as the file has it, on one line; long values are cut."""
    if isinstance(value, str):
        text = f'"{value}"'
    elif value is None or isinstance(value, bool):
        text = "null" if value is None else str(value).lower()
    else:
        text = repr(value)
    text = one_line(text)
    return text if len(text) <= LONGEST_FOUND else text[: LONGEST_FOUND - 1] + "…"


@cache
def _declared(kind: Any) -> inspect.Type:
    return inspect.type_info(kind)


@dataclass(frozen=True)
class _Spot:
    """A place in the content, with its key for messages, its declaration and its value."""

    key: str
    declared: inspect.Type
    value: Any

    def inside(self, name: str) -> str:
        return f"{self.key}.{name}" if self.key else name


_WHERE = re.compile(r"^(?P<what>.*?)(?: - at `\$(?P<path>[^`]*)`)?$", re.DOTALL)
_STEP = re.compile(r"\.([^.\[]+)|\[(\d+)\]|(\[\.\.\.\])")
_NAMED = re.compile(r"^Object (missing required|contains unknown) field `(.*)`$", re.DOTALL)


def _readable_error(
    content: object, kind: type, place: str, error: msgspec.ValidationError
) -> ContentError:
    """Turn the library's error into a sentence for the author of the file."""
    where = _WHERE.match(str(error))
    assert where is not None
    spot = _spot(content, kind, place, where["path"] or "", str(error))
    if isinstance(error.__cause__, ValueError):
        return ContentError(spot.inside(str(error.__cause__)))
    named = _NAMED.match(where["what"])
    if named is None:
        expected = _words(spot.declared, spot.value)
        if expected == "a table" and spot.key and "[" not in spot.key:
            expected = f"a table [{spot.key}]"
        before = f"{spot.key}: " if spot.key else ""
        return ContentError(f"{before}expected {expected}, found {shown(spot.value)}")
    name, fields = named[2], _fields(spot.declared)
    if named[1] == "missing required":
        expected = _words(fields[name]) if name in fields else "a text"
        return ContentError(f"{spot.inside(name)}: is missing: expected {expected}", missing=True)
    near = similar(name, fields)
    meant = f" (did you mean {' or '.join(near)}?)" if near else ""
    return ContentError(
        f"{one_line(spot.inside(name))}: is not known{meant}; there are: {', '.join(fields)}"
    )


def _spot(content: object, kind: type, place: str, path: str, text: str) -> _Spot:
    spot = _Spot(place, _declared(kind), content)
    taken: list[str | int] = []
    for name, index, _ in _STEP.findall(path):
        spot = _Spot(spot.key, _branch(spot.declared, spot.value), spot.value)
        if name:
            step: str | int = name
            declared = _fields(spot.declared).get(name, inspect.AnyType())
            spot = _Spot(spot.inside(name), declared, spot.value.get(name))
        elif index:
            step = int(index)
            value = spot.value[step]
            declared = _item(_bare(spot.declared), step)
            spot = _Spot(f"{spot.key}[{step + 1}]{_called(value)}", declared, value)
        else:
            step = _guilty_key(content, kind, taken, spot.value, text)
            assert isinstance(spot.declared, inspect.DictType)
            spot = _Spot(spot.inside(one_line(step)), spot.declared.value_type, spot.value[step])
        taken.append(step)
    return _Spot(spot.key, _branch(spot.declared, spot.value), spot.value)


def _called(value: object) -> str:
    """Return `` (name)`` for an entry of a list that has a name; otherwise an empty text."""
    name = value.get("name") if isinstance(value, dict) else None
    return f" ({shown(name)[1:-1]})" if isinstance(name, str) and name else ""


def _guilty_key(
    content: object, kind: type, taken: list[str | int], items: dict[str, Any], text: str
) -> str:
    """Find the key of ``items`` that causes the error ``text``; the library does not name it."""
    for key, value in items.items():
        try:
            msgspec.convert(_replaced(content, taken, {key: value}), kind)
        except msgspec.ValidationError as error:
            if str(error) == text:
                return key
    return next(iter(items))


def _replaced(content: Any, path: list[str | int], new: object) -> Any:
    if not path:
        return new
    inner = _replaced(content[path[0]], path[1:], new)
    if isinstance(content, dict):
        return {**content, path[0]: inner}
    return [inner if index == path[0] else item for index, item in enumerate(content)]


def _branch(declared: inspect.Type, value: object) -> inspect.Type:
    """Return the member of a union that the value matches; return other declarations unchanged."""
    if isinstance(declared, inspect.Metadata):
        # Metadata with a description is kept, because the message states this description.
        return declared if "description" in (declared.extra_json_schema or {}) else declared.type
    if not isinstance(declared, inspect.UnionType):
        return declared
    kinds = [kind for kind in declared.types if not isinstance(kind, inspect.NoneType)]
    for kind in kinds:
        if not isinstance(kind, inspect.StructType) or not isinstance(value, dict):
            continue
        if kind.tag is not None and value.get(str(kind.tag_field)) == kind.tag:
            return kind
    return kinds[0] if len(kinds) == 1 else inspect.UnionType(tuple(kinds))


def _bare(declared: inspect.Type) -> inspect.Type:
    return declared.type if isinstance(declared, inspect.Metadata) else declared


def _fields(declared: inspect.Type) -> dict[str, inspect.Type]:
    """Return the declaration of each key of a structure; the key of its tag comes first."""
    declared = _bare(declared)
    if isinstance(declared, inspect.UnionType):
        kinds = [kind for kind in declared.types if isinstance(kind, inspect.StructType)]
        tags = tuple(kind.tag for kind in kinds)
        return {str(kinds[0].tag_field): inspect.LiteralType(tags)} if kinds else {}
    if not isinstance(declared, inspect.StructType | inspect.DataclassType):
        return {}
    fields = {field.encode_name: field.type for field in declared.fields}
    tag = getattr(declared, "tag_field", None)
    return {tag: inspect.StrType(), **fields} if tag else fields


_LISTS = (inspect.ListType, inspect.VarTupleType, inspect.TupleType, inspect.StructType)
"""Declarations that a list in the file may have; a structure may also be written as a list of its
values."""


def _item(declared: inspect.Type, index: int) -> inspect.Type:
    if isinstance(declared, inspect.TupleType):
        return declared.item_types[index]
    if isinstance(declared, inspect.StructType):
        return declared.fields[index].type
    assert isinstance(declared, inspect.ListType | inspect.VarTupleType)
    return declared.item_type


def _words(declared: inspect.Type, found: object = None) -> str:
    """Describe the expected value in words."""
    if isinstance(declared, inspect.Metadata):
        said = (declared.extra_json_schema or {}).get("description")
        return str(said) if said else _words(declared.type, found)
    if isinstance(declared, inspect.UnionType):
        kinds = [kind for kind in declared.types if not isinstance(kind, inspect.NoneType)]
        return " or ".join(dict.fromkeys(_words(kind, found) for kind in kinds))
    if isinstance(declared, inspect.IntType):
        return "a whole number" + _range(declared)
    if isinstance(declared, inspect.FloatType):
        unbounded = not _range(declared)
        odd = isinstance(found, float) and not math.isfinite(found)
        return ("a finite number" if unbounded or odd else "a number") + _range(declared)
    if isinstance(declared, inspect.LiteralType):
        words = ", ".join(shown(value) for value in declared.values)
        return words if len(declared.values) == 1 else f"one of {words}"
    if isinstance(declared, inspect.ListType | inspect.VarTupleType):
        some = "a list of one or more " if declared.min_length else "a list of "
        return some + _plural(declared.item_type)
    if isinstance(declared, inspect.TupleType):
        return f"{len(declared.item_types)} {_plural(declared.item_types[0])}"
    return {
        inspect.StrType: "a text",
        inspect.BoolType: "true or false",
        inspect.StructType: "a table",
        inspect.DataclassType: "a table",
        inspect.DictType: "a table",
    }.get(type(declared), "another value")


def _plural(declared: inspect.Type) -> str:
    bare = _bare(declared)
    if isinstance(bare, inspect.LiteralType):
        return _words(bare).removeprefix("one of ")
    return {
        inspect.IntType: "whole numbers",
        inspect.FloatType: "finite numbers",
        inspect.StrType: "texts",
    }.get(type(bare), "tables")


_NUMBERS = (inspect.IntType, inspect.FloatType)


def _range(declared: inspect.IntType | inspect.FloatType) -> str:
    low, high = declared.ge, declared.le
    if declared.gt is None and _is_stated(low) and _is_stated(high):
        return f" from {_figure(low)} to {_figure(high)}"
    words = " and".join(_limits(declared))
    return f" of{words}" if words.startswith(" at most") else words


def _limits(declared: inspect.IntType | inspect.FloatType) -> Iterator[str]:
    if declared.gt is not None:
        yield f" above {_figure(declared.gt)}"
    if _is_stated(declared.ge):
        yield f" of {_figure(declared.ge)} or more"
    if declared.lt is not None:
        yield f" below {_figure(declared.lt)}"
    if _is_stated(declared.le):
        yield f" at most {_figure(declared.le)}"


def _figure(limit: float | None) -> str:
    assert limit is not None
    for less, words in ((0, ""), (1, " - 1")):
        power = math.frexp(abs(limit + less))[1] - 1
        if power >= LARGE_POWER and abs(limit + less) == 2**power:
            return f"{'-' if limit < 0 else ''}2^{power}{words}"
    return str(int(limit)) if limit == round(limit) and abs(limit) < 1e15 else f"{limit:g}"


def _is_stated(limit: float | None) -> bool:
    return limit is not None and abs(limit) < LARGEST


def line_of_text(text: str, key: str) -> None:
    """Raise ValueError, for a ``__post_init__``, if ``text`` is not one printable line."""
    if not is_printable(text):
        raise ValueError(f"{key}: expected one line of printable text, found {text!r}")
