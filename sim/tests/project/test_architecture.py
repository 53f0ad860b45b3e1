"""Tests that docs/architecture.md and the rules in pyproject.toml name the existing folders and
modules."""

from __future__ import annotations

import re
import tomllib
from itertools import chain, pairwise
from pathlib import Path

from arctrue.base.source_tree import ROOT

PACKAGE = ROOT / "sim" / "arctrue"
# Each part of these packages has its own row in the table of docs/architecture.md.
DIVIDED = ("workbench", "studies")
CONFIGURATION = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
# Layers from the command line (top) to the units (bottom). A module imports only from lower layers.
LAYERS, LAYERS_OF_WORKBENCH = (
    [[name.strip().removeprefix("arctrue.") for name in layer.split("|")] for layer in found]
    for found in (
        contract["layers"] for contract in CONFIGURATION["tool"]["importlinter"]["contracts"][:2]
    )
)


def rows() -> list[list[str]]:
    """Return the names in the first column of the Python package's table."""
    text = (ROOT / "docs" / "architecture.md").read_text(encoding="utf-8")
    table = text.split("The Python package `sim/arctrue`")[1].split("\n## ")[0]
    cells = re.findall(r"^\| (`[^|]*) \|", table, re.MULTILINE)
    return [re.findall(r"`([\w/]+)`", cell) for cell in cells]


def parts(folder: Path) -> set[str]:
    """Return the names of the modules and packages directly in ``folder``."""
    found = {path.stem for path in folder.glob("*.py")} - {"__init__"}
    return found | {path.parent.name for path in folder.glob("*/__init__.py")}


def test_the_table_names_every_part_of_the_package() -> None:
    named = list(chain.from_iterable(rows()))
    assert len(named) == len(set(named))
    wanted = parts(PACKAGE) - set(DIVIDED)
    wanted |= {f"{package}/{part}" for package in DIVIDED for part in parts(PACKAGE / package)}
    assert wanted - set(named) == set(), "not in docs/architecture.md"


def test_the_table_names_nothing_else() -> None:
    for name in chain.from_iterable(rows()):
        places = (PACKAGE / name, PACKAGE / f"{name}.py", ROOT / name)
        assert any(place.exists() for place in places), name


def depth(name: str) -> int:
    """Return the number of the layer that contains the module or package ``name``, counted from the
    top."""
    (found,) = [place for place, layer in enumerate(LAYERS) if name.split("/")[0] in layer]
    return found


def test_the_rows_are_in_the_order_of_the_imports() -> None:
    in_package = [[depth(name) for name in row if not name.startswith("sim/")] for row in rows()]
    for above, below in pairwise(in_package):
        assert min(above) >= max(below), (above, below)
    within = [
        place
        for row in rows()
        for name in row
        for place, layer in enumerate(LAYERS_OF_WORKBENCH)
        if name.split("/")[0] == "workbench" and name.split("/")[1] in layer
    ]
    assert within == sorted(within, reverse=True)


def test_import_linter_knows_every_part() -> None:
    assert set(chain.from_iterable(LAYERS)) == parts(PACKAGE)
    assert set(chain.from_iterable(LAYERS_OF_WORKBENCH)) == parts(PACKAGE / "workbench")


def test_an_exemption_from_the_lint_has_a_file() -> None:
    exempt = CONFIGURATION["tool"]["ruff"]["lint"]["per-file-ignores"]
    for pattern in exempt:
        listed = re.search(r"\{([^}]*)\}", pattern)
        words = listed[1].split(",") if listed else [""]
        for word in words:
            one = pattern.replace(listed[0], word) if listed else pattern
            assert any(ROOT.glob(one)), f"pyproject.toml: no file matches {one}"
