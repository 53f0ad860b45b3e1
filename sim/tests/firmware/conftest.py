"""An assertion of a model that the firmware's C calls fails the test.

cffi cannot raise through C: it reports the exception and returns 0. Without this the assertions in
the models would be read by nobody.
"""

from __future__ import annotations

from pathlib import Path

import pytest

HERE = Path(__file__).parent


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Every test of this folder."""
    mark = pytest.mark.filterwarnings("error::pytest.PytestUnraisableExceptionWarning")
    for item in items:
        if HERE in item.path.parents:
            item.add_marker(mark)
