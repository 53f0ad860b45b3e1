"""What the tests of this folder share: a firmware that runs, and a mark.

An assertion of a model that the firmware's C calls fails the test. cffi cannot raise through C: it
reports the exception and returns 0. Without the mark the assertions in the models would be read by
nobody.
"""

from __future__ import annotations

from pathlib import Path

import pytest
from sim.tests.firmware.model_core import Firmware, ModelCore

HERE = Path(__file__).parent


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Every test of this folder."""
    mark = pytest.mark.filterwarnings("error::pytest.PytestUnraisableExceptionWarning")
    for item in items:
        if HERE in item.path.parents:
            item.add_marker(mark)


@pytest.fixture
def running() -> Firmware:
    """The firmware after its start, head 1's index seen."""
    made = Firmware(ModelCore())
    made.library.application_start(made.application)
    made.core.see_index()
    made.step()
    return made
