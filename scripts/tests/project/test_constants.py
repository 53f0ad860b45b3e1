"""Tests that a constant of the gateware is written once: VHDL, Python and C take its number from
the same line."""

from __future__ import annotations

import ast
import math
import re
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from arctrue.generated.registers import LOCAL_POINTS_WORDS
from scripts.number_formats import NUMBER_FORMATS, read_number_formats

ROOT = Path(__file__).resolve().parents[3]
VHDL = re.compile(r"^\s*constant\s+(\w+)\s*:\s*(?:positive|natural|integer)\s*:=\s*([^;]+);", re.M)
C = re.compile(r"(?:^#define\s+|[{,]\s*)([A-Z]\w*)(?:\s*=\s*|\s+)([^,}\n]+)", re.M)
COMMENT = re.compile(r"/\*.*?\*/", re.DOTALL)
ONLY_NUMBERS = (ast.Constant, ast.BinOp, ast.UnaryOp, ast.operator, ast.unaryop)
Constants = Iterator[tuple[str, int]]


def _number(expression: str) -> int | None:
    """Return the value of an expression of integers, None for an expression with a name, a text or
    a fraction."""
    try:
        tree = ast.parse(expression.strip(), mode="eval").body
    except SyntaxError:
        return None
    if not all(isinstance(node, ONLY_NUMBERS) for node in ast.walk(tree)):
        return None
    try:
        value = eval(compile(ast.Expression(tree), "", "eval"))
    except TypeError:
        return None
    return value if type(value) is int else None


def vhdl_constants(text: str) -> Constants:
    """Yield name and value of each constant of VHDL that is written as a number."""
    for name, expression in VHDL.findall(text):
        value = _number(expression)
        if value is not None:
            yield name.upper(), value


def python_constants(text: str) -> Constants:
    """Yield name and value of each constant of a module that is written as a number."""
    for node in ast.parse(text).body:
        targets = node.targets if isinstance(node, ast.Assign) else []
        if isinstance(node, ast.AnnAssign) and node.value is not None:
            targets = [node.target]
        for target in targets:
            assert isinstance(node, ast.Assign | ast.AnnAssign)
            names, values = [target], [node.value]
            if isinstance(target, ast.Tuple) and isinstance(node.value, ast.Tuple):
                names, values = target.elts, list(node.value.elts)
            for name, expression in zip(names, values, strict=True):
                value = _number(ast.unparse(expression)) if expression else None
                if isinstance(name, ast.Name) and name.id.isupper() and value is not None:
                    yield name.id.lstrip("_"), value


def c_constants(text: str) -> Constants:
    """Yield name and value of each macro and enumerator that is written as a number."""
    for name, expression in C.findall(COMMENT.sub("", text)):
        value = _number(re.sub(r"(?<=[0-9A-Fa-f])U?L*\b", "", expression))
        if value is not None:
            yield name, value


def written_twice(root: Path) -> list[str]:
    """Return a sentence for each constant that ``root`` contains twice as a number.

    A name of the package of number formats must not be defined as a number anywhere else, with any
    value. Moreover, a model in ``gateware`` and the firmware must not repeat name and number of a
    constant of another VHDL file.
    """
    package = read_number_formats(root / NUMBER_FORMATS)
    of_unit: dict[tuple[str, int], str] = {}
    found = []

    def compare(folder: str, endings: str, read: Callable[[str], Constants], models: bool) -> None:
        for path in sorted((root / folder).rglob(endings)):
            place = path.relative_to(root).as_posix()
            if path == root / NUMBER_FORMATS or "generated" in path.parts:
                continue
            for name, value in read(path.read_text(encoding="utf-8")):
                other = of_unit.get((name, value)) if models else None
                if name in package or other:
                    found.append(f"{place}: {name} = {value} is in {other or NUMBER_FORMATS} too")
                if path.suffix == ".vhd":
                    of_unit[name, value] = place

    compare("rtl", "*.vhd", vhdl_constants, models=False)
    compare("sim/arctrue/gateware", "*.py", python_constants, models=True)
    for folder in ("sim/arctrue", "tb", "scripts"):
        compare(folder, "*.py", python_constants, models=False)
    compare("firmware", "*.[ch]", c_constants, models=True)
    return sorted(set(found))


def test_no_constant_of_the_gateware_is_written_twice() -> None:
    assert written_twice(ROOT) == []


def test_arcseconds_of_a_turn_and_of_a_radian_are_written_once() -> None:
    # Half a turn, a turn, and a radian in arcseconds, and an arcsecond in radians.
    radian = 648_000.0 / math.pi
    package = ROOT / "sim" / "arctrue"
    # The benchmark's second generator shares no code with the package.
    apart = (package / "studies" / "benchmark" / "independent", package / "generated")
    found = {
        path.relative_to(package).as_posix()
        for path in package.rglob("*.py")
        if not any(path.is_relative_to(folder) for folder in apart)
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8")))
        if isinstance(node, ast.Constant) and isinstance(node.value, int | float)
        for size in (648_000.0, 1_296_000.0, radian, 1.0 / radian)
        if math.isclose(node.value, size, rel_tol=1e-3)
    }
    assert found == {"base/units.py"}


def test_number_of_points_is_that_of_the_register_map() -> None:
    # The register map states the number of words as a number of its own.
    assert (
        1 << read_number_formats(ROOT / NUMBER_FORMATS)["LOCAL_INDEX_WIDTH"] == LOCAL_POINTS_WORDS
    )


UNIT = "architecture rtl of unit is\n  constant LAG   : positive := 2 ** 3 - 1;\nbegin\n"


@pytest.mark.parametrize(
    ("file", "text", "found"),
    [
        ("rtl/other.vhd", "  constant SIDES : natural := 3;\n", "rtl/other.vhd: SIDES = 3"),
        ("sim/arctrue/gateware/unit.py", "SIDES: Final = 6\n", "SIDES = 6"),
        ("sim/arctrue/gateware/unit.py", "_LAG = 7\n", "LAG = 7 is in rtl/unit.vhd"),
        ("sim/arctrue/gateware/unit.py", "ROOM, LAG = 5, 7\n", "LAG = 7 is in rtl/unit.vhd"),
        ("tb/unit_bench.py", "SIDES = 2 * 3\n", "SIDES = 6"),
        ("scripts/tool.py", "SIDES = 6\n", "SIDES = 6"),
        ("firmware/unit.h", "enum { ROOM = 5, SIDES = 6 };\n", "SIDES = 6"),
        ("firmware/unit.c", "#define LAG 7U\n", "LAG = 7 is in rtl/unit.vhd"),
        ("sim/arctrue/gateware/unit.py", "LAG = 8\nROOM = 6\nWIDTH = SIDES + 1\n", None),
        ("firmware/unit.c", "#define LAG (1 << ARCTRUE_SIDES)\n/* enum { SIDES = 6 }; */\n", None),
    ],
)
def test_constant_that_is_written_twice_is_found(
    tmp_path: Path, file: str, text: str, found: str | None
) -> None:
    files = {
        NUMBER_FORMATS: "package p is\n  constant SIDES : positive := 6;\nend package p;\n",
        Path("rtl/unit.vhd"): UNIT,
        Path(file): text,
    }
    for path, content in files.items():
        (tmp_path / path).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / path).write_text(content, encoding="utf-8")
    twice = written_twice(tmp_path)
    assert len(twice) == (found is not None)
    assert not found or found in twice[0]
