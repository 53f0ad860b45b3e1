"""Tests that the C files of a folder do not include each other in a circle."""

from __future__ import annotations

import re
from graphlib import CycleError, TopologicalSorter

import pytest
from sim.tests.firmware.library import FIRMWARE

INCLUDE = re.compile(r'^#include "(\w+)\.h"', re.MULTILINE)


def included(folder: str) -> dict[str, set[str]]:
    """Return which modules each module of ``folder`` includes; a module is a .c file with its .h
    file."""
    found: dict[str, set[str]] = {}
    for path in sorted((FIRMWARE / folder).glob("*.[ch]")):
        found.setdefault(path.stem, set()).update(INCLUDE.findall(path.read_text("utf-8")))
    return {module: (names & set(found)) - {module} for module, names in found.items()}


@pytest.mark.parametrize("folder", ["application", "board", "calibration", "zynq"])
def test_no_circle_of_includes(folder: str) -> None:
    modules = included(folder)
    assert any(modules.values())
    try:
        TopologicalSorter(modules).prepare()
    except CycleError as error:
        pytest.fail(f"firmware/{folder} includes in a circle: {' <- '.join(error.args[1])}")
