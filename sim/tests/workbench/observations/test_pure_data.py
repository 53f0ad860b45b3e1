"""Tests that the observations are data only: they have no callbacks and store no results."""

import ast
from pathlib import Path

import arctrue.workbench.observations

FOLDER = Path(arctrue.workbench.observations.__file__).parent
REFUSED = {"Callable", "cached_property", "cache", "lru_cache", "WeakKeyDictionary"}


def test_observations_have_no_callback_and_no_cache() -> None:
    found = [
        f"{path.name}: {node.id}"
        for path in sorted(FOLDER.rglob("*.py"))
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8")))
        if isinstance(node, ast.Name) and node.id in REFUSED
    ]
    assert found == []
