"""Tests that each constant that influences a result of the workbench states its origin.

A constant of a module needs a docstring of its own with a derivation, a source, the command that
calibrates it, or the statement that it only limits cost or output.
"""

from __future__ import annotations

import ast
from pathlib import Path

import pytest

import arctrue.workbench

ROOT = Path(arctrue.workbench.__file__).parent
PACKAGES = ("diagnose", "inference", "noise", "observations")
LEAST_WORDS = 3
"""Least number of words in the docstring of a constant; fewer would only repeat the name of the
constant."""
MODULES = sorted(file for name in PACKAGES for file in (ROOT / name).rglob("*.py"))


def _is_number(node: ast.expr) -> bool:
    """Tell whether an expression is a number, a sequence of numbers, or arithmetic with numbers."""
    if isinstance(node, ast.Constant):
        return isinstance(node.value, (int, float)) and not isinstance(node.value, bool)
    if isinstance(node, ast.UnaryOp):
        return _is_number(node.operand)
    if isinstance(node, ast.BinOp):
        return _is_number(node.left) and _is_number(node.right)
    if isinstance(node, (ast.Tuple, ast.List)):
        return bool(node.elts) and all(_is_number(item) for item in node.elts)
    return False


def unstated(source: str) -> list[str]:
    """Return the names of a module's numeric constants that have no docstring of LEAST_WORDS."""
    body = ast.parse(source).body
    found = []
    for statement, after in zip(body, [*body[1:], None], strict=True):
        if isinstance(statement, ast.Assign):
            targets, value = statement.targets, statement.value
        elif isinstance(statement, ast.AnnAssign) and statement.value is not None:
            targets, value = [statement.target], statement.value
        else:
            continue
        if not _is_number(value):
            continue
        words = ""
        if isinstance(after, ast.Expr) and isinstance(after.value, ast.Constant):
            words = str(after.value.value)
        if len(words.split()) < LEAST_WORDS:
            found += [ast.unparse(target) for target in targets]
    return found


@pytest.mark.parametrize("module", MODULES, ids=lambda file: str(file.relative_to(ROOT)))
def test_every_numeric_constant_states_where_it_comes_from(module: Path) -> None:
    assert unstated(module.read_text(encoding="utf-8")) == []


@pytest.mark.parametrize(
    ("source", "names"),
    [
        ("A = 3\n", ["A"]),
        ("A = 3\n'''Of the repeats.'''\nB: float = -1.5\n", ["B"]),
        ("A = (1.0, 2.0)\n'''A.'''\n", ["A"]),
        ("A = 1 << 15\n'''Rows of one product.'''\n", []),
        ("A = 'text'\nB = True\nC = [name for name in ()]\n", []),
    ],
)
def test_what_counts_as_stated(source: str, names: list[str]) -> None:
    assert unstated(source) == names
