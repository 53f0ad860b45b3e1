"""``import arctrue as at``: light and lazy."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

import arctrue as at

DOCS = Path(__file__).resolve().parents[3] / "docs"


def test_the_import_loads_nothing() -> None:
    program = (
        "import sys, arctrue; print([n for n in ('numpy', 'scipy', 'click') if n in sys.modules]);"
        "print('read_set' in dir(arctrue), hasattr(arctrue, 'nothing'))"
    )
    done = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, check=True
    )
    assert done.stdout.split("\n")[:2] == ["[]", "True False"]


def test_a_recorded_set_is_compared_and_shown() -> None:
    table = at.read_set(DOCS / "data" / "worm_axis_telescope")
    found = at.compare(table)
    # The RMS of a fit is at most that of what was fitted.
    error = table.reference.error_arcsec
    assert 0.0 < found.data["channels"]["reference"]["rms_arcsec"] <= error.std()
    assert "reference" in found._repr_html_()
    with pytest.raises(ValueError, match="no history"):
        at.Model().plot()
