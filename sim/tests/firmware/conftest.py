"""Shares a running firmware and a mark among the tests of this folder. The firmware's C code calls
Python models; an assertion that fails in a model must fail the test. cffi cannot raise an exception
through C: it reports the exception and returns 0. Without the mark, such an assertion would have no
effect."""

from __future__ import annotations

from pathlib import Path

import pytest
from sim.tests.firmware.model_core import Firmware, ModelCore

HERE = Path(__file__).parent


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Add the mark to every test of this folder."""
    mark = pytest.mark.filterwarnings("error::pytest.PytestUnraisableExceptionWarning")
    for item in items:
        if HERE in item.path.parents:
            item.add_marker(mark)


@pytest.fixture
def running() -> Firmware:
    """Return the started firmware, which has seen the indices of heads 1 and 2."""
    made = Firmware(ModelCore())
    made.library.application_start(made.application)
    made.core.see_index()
    made.step()
    return made
