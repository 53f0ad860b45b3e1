"""Tests that no module imports itself through others, and which folders may import which."""

from __future__ import annotations

import ast
import re
from graphlib import TopologicalSorter
from pathlib import Path

import arctrue

PACKAGE = Path(arctrue.__path__[0])
SIM = Path(__file__).parents[2]


def _modules() -> dict[str, Path]:
    found = {}
    for file in PACKAGE.rglob("*.py"):
        parts = file.relative_to(PACKAGE.parent).with_suffix("").parts
        found[".".join(part for part in parts if part != "__init__")] = file
    return found


def _imported(file: Path, modules: dict[str, Path]) -> set[str]:
    """Return the modules that a file imports at its top level, except those imported only for
    types."""
    found = set()
    for node in ast.parse(file.read_text(encoding="utf-8")).body:
        if isinstance(node, ast.Import):
            found |= {item.name for item in node.names}
        elif isinstance(node, ast.ImportFrom):
            inner = {f"{node.module}.{item.name}" for item in node.names}
            found |= inner if inner <= set(modules) else {str(node.module)}
    return found & set(modules)


def test_no_module_imports_itself_through_others() -> None:
    modules = _modules()
    assert len(modules) > 300
    graph = {name: _imported(file, modules) - {name} for name, file in modules.items()}
    # prepare() raises CycleError, which names the circle.
    TopologicalSorter(graph).prepare()


def test_nothing_in_sim_imports_the_scripts_or_the_test_benches() -> None:
    """No module in sim imports from scripts or tb: shared code is in sim."""
    found = [
        f"{file.relative_to(SIM)}:{node.lineno}"
        for file in SIM.rglob("*.py")
        if re.search(r"\b(scripts|tb)\b", text := file.read_text(encoding="utf-8"))
        for node in ast.walk(ast.parse(text))
        for name in _names(node)
        if name.partition(".")[0] in ("scripts", "tb")
    ]
    assert found == []


def _names(node: ast.AST) -> list[str]:
    if isinstance(node, ast.Import):
        return [item.name for item in node.names]
    return [node.module or ""] if isinstance(node, ast.ImportFrom) and not node.level else []


def test_no_circle_of_the_workbench_hides_in_a_function() -> None:
    """Every module of the workbench imports parts of the package only at the top of its file."""
    hidden = [
        f"{file.relative_to(PACKAGE)}: {inner.module}"
        for file in (PACKAGE / "workbench").rglob("*.py")
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8")))
        if isinstance(node, ast.FunctionDef)
        for inner in ast.walk(node)
        if isinstance(inner, ast.ImportFrom) and str(inner.module).startswith("arctrue.")
    ]
    assert hidden == []
