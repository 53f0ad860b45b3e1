"""Tests that each public name's docstring describes arguments, units and exceptions in numpydoc
sections."""

from __future__ import annotations

import ast
import dataclasses
import doctest
import importlib
import inspect
import re
import textwrap
from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path
from typing import Any

import pytest

import arctrue

PACKAGES = (
    "arctrue",
    "arctrue.measurement",
    "arctrue.importing",
    "arctrue.calibration",
    "arctrue.instrument",
    "arctrue.table",
    "arctrue.workbench.model",
    "arctrue.workbench.observations",
    "arctrue.studies.campaign",
    "arctrue.studies.paper",
    "arctrue.studies.revolution",
    "arctrue.studies.scenario",
    "arctrue.table.instruments",
    "arctrue.metrology.controllers",
)
"""Packages whose ``__all__`` the test reads."""
SECTION = re.compile(r"^(\w[\w ]*)\n(-{3,})$", re.MULTILINE)
ARRAYS = ("NDArray", "ArrayLike", "Float]", "Integer")
NUMBERS = re.compile(r"\bfloat\b|ArrayLike|float64|\bFloat\b")
"""Types of numbers that may have a unit."""
UNIT_IN_NAME = re.compile(r"_(arcsec|deg|rad|s|c|m|hz|s2|counts|clocks)$|_per_rev$")
UNIT_IN_TEXT = re.compile(
    r"arcsec|°|″|degree|radian|second|\bs\b|count|turn|metre|\bm\b|hertz|\bHz\b|\bunits?\b"
    r"|ratio|probability|factor|weight|±1|\+1|steps|clocks|correlation|number of",
    re.IGNORECASE,
)
"""Words that state a unit, or that a number has none."""


def sections(text: str) -> dict[str, str]:
    """Return the text below each underlined heading."""
    found = list(SECTION.finditer(text))
    if not found:
        return {}
    ends = [item.start() for item in found[1:]] + [len(text)]
    return {item[1]: text[item.end() : end] for item, end in zip(found, ends, strict=True)}


def entries(words: str) -> dict[str, str]:
    """Return each name in a section with its text; a line ``a, b : int`` contains two names."""
    found: dict[str, str] = {}
    for part in re.split(r"\n(?=\S)", words.strip("\n")):
        head, _, _ = part.partition("\n")
        for name in head.partition(" : ")[0].split(","):
            found[name.strip().lstrip("*")] = part
    return found


def public() -> Iterator[tuple[str, Any]]:
    """Yield functions and classes of the packages, and the public methods of the classes, also
    the inherited methods."""
    for package in PACKAGES:
        module = importlib.import_module(package)
        for name in module.__all__:
            what = getattr(module, name)
            place = f"{package}.{name}"
            if inspect.isclass(what):
                yield place, what
                bases = [one for one in what.__mro__ if one.__module__.startswith("arctrue.")]
                for own, method in (item for base in bases for item in vars(base).items()):
                    function = getattr(method, "__func__", method)
                    if not own.startswith("_") and inspect.isfunction(function):
                        yield f"{place}.{own}", function
            elif inspect.isfunction(what):
                yield place, what


def raised(function: Any) -> bool:
    """Tell whether the body of the function itself raises an exception."""
    tree = ast.parse(textwrap.dedent(inspect.getsource(function)))
    body = tree.body[0]
    assert isinstance(body, ast.FunctionDef)
    inner = [
        node for node in ast.walk(body) if isinstance(node, ast.FunctionDef) and node is not body
    ]
    within = {id(node) for one in inner for node in ast.walk(one)}
    return any(isinstance(node, ast.Raise) and id(node) not in within for node in ast.walk(body))


def inline(kind: type) -> dict[str, str]:
    """Return the text below each field of a class; Sphinx reads this text too."""
    tree = ast.parse(textwrap.dedent(inspect.getsource(kind))).body[0]
    assert isinstance(tree, ast.ClassDef)
    return {
        item.target.id: str(text.value.value)
        for item, text in pairwise(tree.body)
        if isinstance(item, ast.AnnAssign)
        and isinstance(item.target, ast.Name)
        and isinstance(text, ast.Expr)
        and isinstance(text.value, ast.Constant)
    }


def faults(what: Any) -> list[str]:
    """Return the arguments, exceptions and sections that the docstring lacks."""
    text = inspect.getdoc(what) or ""
    found = (
        [] if re.match(r"[A-Z`].*[.:]$", text.partition("\n")[0]) else ["no summary in one line"]
    )
    described = sections(text)
    parameters = entries(described.get("Parameters", ""))
    if inspect.isclass(what):
        if issubclass(what, Exception) or getattr(what, "_is_protocol", False):
            return found
        if not dataclasses.is_dataclass(what):
            made = inspect.signature(what.__init__).parameters if "__init__" in vars(what) else {}
            wanted = {name: str(one.annotation) for name, one in made.items() if name != "self"}
            return found + _of_parameters(wanted, parameters)
        wanted = {
            item.name: str(item.type)
            for item in dataclasses.fields(what)
            if not item.name.startswith("_")
        }
        for name, words in inline(what).items():
            parameters.setdefault(name, words)
        wanted |= dict.fromkeys(inline(what), "")
    else:
        signature = inspect.signature(what)
        wanted = {
            name: str(item.annotation)
            for name, item in signature.parameters.items()
            if name not in ("self", "cls")
        }
        given = str(signature.return_annotation)
        if given != "None" and "Returns" not in described and "Yields" not in described:
            found.append("no section Returns")
        if raised(what) and "Raises" not in described:
            found.append("raises, and no section Raises")
    return found + _of_parameters(wanted, parameters)


def _of_parameters(wanted: dict[str, str], parameters: dict[str, str]) -> list[str]:
    """Return the faults of the described ``parameters``; ``wanted``: types by name."""
    found = [f"no parameter {name}" for name in wanted if name not in parameters]
    found += [
        f"no unit of {name}"
        for name, kind in wanted.items()
        if name in parameters
        and NUMBERS.search(kind)
        and not UNIT_IN_NAME.search(name)
        and not UNIT_IN_TEXT.search(parameters[name])
    ]
    found += [f"there is no parameter {name}" for name in parameters if name not in {*wanted, ""}]
    found += [
        f"no shape of {name}"
        for name, kind in wanted.items()
        if any(word in kind for word in ARRAYS)
        and not re.search(r"shape|\(\w*,", parameters.get(name, "shape"))
    ]
    return found


@pytest.mark.parametrize(("name", "what"), [pytest.param(*item, id=item[0]) for item in public()])
def test_a_public_name_says_what_its_arguments_are(name: str, what: Any) -> None:
    assert faults(what) == [], name


EXAMPLES = [
    pytest.param(what, id=name)
    for name, what in public()
    if ">>>" in (what.__doc__ or "") and not inspect.isclass(what)
]


@pytest.mark.parametrize("what", EXAMPLES)
def test_an_example_gives_what_it_says(what: Any) -> None:
    module = importlib.import_module(what.__module__)
    (test,) = doctest.DocTestFinder(recurse=False).find(what, globs=dict(vars(module)))
    assert doctest.DocTestRunner().run(test).failed == 0


def test_every_package_with_public_names_is_read() -> None:
    """Every package with public names is read; arctrue.api has the same public names as arctrue."""
    root = Path(arctrue.__file__).parent
    named = {
        ".".join(("arctrue", *path.parent.relative_to(root).parts))
        for path in root.rglob("__init__.py")
        if re.search(r"^__all__ = ", path.read_text(encoding="utf-8"), re.MULTILINE)
    }
    assert named - {"arctrue.api"} == set(PACKAGES)


def test_the_check_sees_what_is_missing() -> None:
    def bad(
        angle_deg: NDArray,  # type: ignore[name-defined]  # noqa: F821
        level: float,
        count: int,
    ) -> int:
        """Do something.

        Parameters
        ----------
        angle_deg : ndarray
            Angles.
        level : float
            The level.
        other : int
            Not there.
        """
        raise ValueError

    assert faults(bad) == [
        "no section Returns",
        "raises, and no section Raises",
        "no parameter count",
        "no unit of level",
        "there is no parameter other",
        "no shape of angle_deg",
    ]
