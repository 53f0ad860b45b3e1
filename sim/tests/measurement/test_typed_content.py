"""Tests the messages for values that do not fit their declaration: key, expected and found value,
similar name."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, Literal

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from msgspec import Meta, Struct, field

from arctrue.base.typed_content import (
    ContentError,
    Number,
    Positive,
    read_json,
    typed,
    unknown_keys,
)


class Ball(Struct, tag_field="kind", tag="ball", forbid_unknown_fields=True):
    um: Number


class Belt(Struct, tag_field="kind", tag="belt", forbid_unknown_fields=True):
    order: Annotated[int, Meta(ge=1, le=64)] = 1


@dataclass(frozen=True)
class Disc:
    lines: Annotated[int, Meta(ge=4)] | None = None
    width: Annotated[float, Meta(gt=-360, lt=360)] = 0.0


@dataclass(frozen=True)
class Stored(Disc):
    sorts: dict[str, list[Disc]] | None = None
    pair: tuple[Disc, int] | None = None


class File(Struct, forbid_unknown_fields=True):
    schema: Annotated[Literal[1], Meta(description="1, the only schema")]
    title: str = "none"
    shown: bool = True
    disc: Disc = field(default_factory=Disc)
    pair: tuple[int, int] | None = None
    speeds: Annotated[list[Positive], Meta(min_length=1)] = field(default_factory=lambda: [1.0])
    places: list[Literal["disc", "head"]] = []
    sizes: dict[str, Number] = {}
    discs: dict[str, list[Disc]] = {}
    parts: list[Ball | Belt] = []
    named: list[dict[str, int]] = []
    share: Annotated[float, Meta(gt=0, le=2**63)] = 1.0
    most: Annotated[int, Meta(le=9)] = 1
    low: Number = 0.0
    high: Number = 1.0

    def __post_init__(self) -> None:
        if self.low > self.high:
            raise ValueError(f"low: expected at most high, {self.high:g}, found {self.low:g}")


SENTENCES: list[tuple[dict[str, Any], str]] = [
    ({"schema": 2}, "schema: expected 1, the only schema, found 2"),
    ({"title": 3}, "title: expected a text, found 3"),
    ({"shown": 1}, "shown: expected true or false, found 1"),
    ({"titel": "x"}, "titel: is not known (did you mean title?); there are: schema, title, shown"),
    ({"disc": 3}, "disc: expected a table [disc], found 3"),
    ({"disc": {"lines": 3}}, "disc.lines: expected a whole number of 4 or more, found 3"),
    ({"disc": {"lines": 4.0}}, "disc.lines: expected a whole number of 4 or more, found 4.0"),
    ({"disc": {"lines": True}}, "disc.lines: expected a whole number of 4 or more, found true"),
    ({"disc": {"width": 360}}, "disc.width: expected a number above -360 and below 360, found 360"),
    ({"pair": [1]}, "pair: expected 2 whole numbers, found [1]"),
    ({"pair": [1, "a"]}, 'pair[2]: expected a whole number, found "a"'),
    ({"speeds": []}, "speeds: expected a list of one or more finite numbers, found []"),
    ({"speeds": [1, 0]}, "speeds[2]: expected a number above 0, found 0"),
    ({"speeds": [math.inf]}, "speeds[1]: expected a finite number above 0, found inf"),
    ({"places": "disc"}, 'places: expected a list of "disc", "head", found "disc"'),
    ({"places": ["disk"]}, 'places[1]: expected one of "disc", "head", found "disk"'),
    ({"sizes": {"a": 1, "b.c[0]": "x"}}, 'sizes.b.c[0]: expected a finite number, found "x"'),
    ({"sizes": {"a": 10**400}}, "sizes.a: expected a finite number, found 1000"),
    ({"discs": {"a": [], "b": [{}, {"lines": 0}]}}, "discs.b[2].lines: expected a whole number"),
    ({"parts": [{"kind": "bal"}]}, 'parts[1].kind: expected one of "ball", "belt", found "bal"'),
    ({"parts": [{}]}, 'parts[1].kind: is missing: expected one of "ball", "belt"'),
    ({"parts": [{"kind": "ball"}]}, "parts[1].um: is missing: expected a finite number"),
    (
        {"parts": [{"kind": "belt"}, {"kind": "belt", "oder": 1}]},
        "parts[2].oder: is not known (did you mean order?); there are: kind, order",
    ),
    ({"parts": [{"kind": "belt", "order": 65}]}, "order: expected a whole number from 1 to 64"),
    ({"named": [{"name": 1.5}]}, "named[1].name: expected a whole number, found 1.5"),
    ({"named": [{"name": "warm"}]}, 'named[1] (warm).name: expected a whole number, found "warm"'),
    ({"share": 0}, "share: expected a number above 0 and at most 2^63, found 0"),
    ({"most": 10}, "most: expected a whole number of at most 9, found 10"),
    ({"low": 2}, "low: expected at most high, 1, found 2"),
    ({"low": math.nan}, "low: expected a finite number, found nan"),
]


@pytest.mark.parametrize(("content", "said"), SENTENCES)
def test_key_expected_found(content: dict[str, Any], said: str) -> None:
    with pytest.raises(ContentError) as caught:
        typed({"schema": 1} | content, File)
    assert said in str(caught.value)
    assert str(caught.value).startswith(said.split(":")[0]) or "order" in said
    assert not caught.value.missing or "is missing" in said


def test_a_place_of_its_own_stands_before_the_key() -> None:
    with pytest.raises(ContentError, match=r"^effect\[3\].um: is missing") as caught:
        typed({"kind": "ball"}, Ball, "effect[3]")
    assert caught.value.missing


def test_what_fits_is_converted() -> None:
    found = typed({"schema": 1, "disc": {"lines": 5}, "parts": [{"kind": "ball", "um": 1}]}, File)
    assert (found.disc, found.parts) == (Disc(5), [Ball(1.0)])


def test_unknown_keys_of_a_file_that_may_have_them() -> None:
    class Open(Struct):
        title: str
        disc: Disc

    content = {"title": "x", "tittle": 1, "disc": {"line": 1, "lines": 5}, "further": {"disc": 1}}
    assert unknown_keys(content, Open) == {
        "tittle": ["title"],
        "disc.line": ["lines"],
        "further": [],
    }


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("{", "is not JSON: "),
        ("[" * 100_000, "is not JSON: "),
        ("\xff", "is not JSON: "),
        ("3", "expected an object, found 3"),
        ('{"lines": "4"}', 'lines: expected a whole number of 4 or more, found "4"'),
        ('{"line": 4}', "line: is not known; did you mean lines?"),
        ('{"sorts": {"a": [{}, {"line": 4}]}}', "sorts.a[2].line: is not known; did you mean line"),
        ('{"pair": [{"line": 4}, 3]}', "pair[1].line: is not known; did you mean lines?"),
    ],
)
def test_a_json_file_is_named(tmp_path: Path, text: str, said: str) -> None:
    file = tmp_path / "disc.json"
    file.write_text(text, encoding="latin-1")
    with pytest.raises(ContentError) as caught:
        read_json(file, Stored)
    assert str(caught.value).startswith(f"{file}: {said}")
    file.write_text('{"lines": 4, "width": 2}')
    assert read_json(file, Stored) == Stored(4, 2.0)


VALUES = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=5),
    lambda inner: (
        st.lists(inner, max_size=3)
        | st.dictionaries(
            st.sampled_from(["lines", "kind", "um", "order", "a", "b.c", "[1]"]), inner, max_size=3
        )
    ),
    max_leaves=6,
)


@settings(max_examples=150, deadline=None)
@given(content=st.dictionaries(st.sampled_from(File.__struct_fields__), VALUES, min_size=1))
def test_any_content_is_converted_or_gives_one_sentence(content: dict[str, Any]) -> None:
    try:
        typed({"schema": 1} | content, File)
    except ContentError as error:
        said = str(error)
    else:
        return
    key = re.match(r"\w+", said)
    assert key
    assert "\n" not in said
    assert "expected" in said or "there are" in said
    # The key that the message names is also wrong if it is the only key.
    with pytest.raises(ContentError):
        typed({"schema": 1, key[0]: content[key[0]]}, File)
