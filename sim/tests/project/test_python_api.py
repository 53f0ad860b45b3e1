"""``import arctrue as at``: light, lazy, and the notebook of the documents runs."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import pytest
from scripts.reference_pages import api_page

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


def test_the_page_shows_plain_types_with_their_bounds_in_words() -> None:
    """The bounds are those of the format: counts below 2⁶², one detection within a degree."""
    page = api_page()
    assert "Annotated" not in page
    assert "Meta(" not in page
    assert "| `counts_per_rev` | `int \\| None` | from 4 to 2^62 |" in page
    assert "| `index_detection_arcsec` | `float \\| None` | from 0 to 3600 |" in page


def test_a_recorded_set_is_compared_and_shown() -> None:
    table = at.read_set(DOCS / "data" / "worm_axis_telescope")
    found = at.compare(table)
    # The RMS of a fit is at most that of what was fitted.
    error = table.reference.error_arcsec
    assert 0.0 < found.data["channels"]["reference"]["rms_arcsec"] <= error.std()
    assert "reference" in found._repr_html_()
    with pytest.raises(ValueError, match="no history"):
        at.Model().plot()


@pytest.mark.slow
def test_the_notebook_runs(tmp_path: Path) -> None:
    """Every code cell in order; the last line of a cell is what a notebook would show."""
    cells = json.loads((DOCS / "notebook.ipynb").read_text(encoding="utf-8"))["cells"]
    names: dict[str, object] = {}
    shown = []
    for cell in cells:
        if cell["cell_type"] == "code":
            *lines, last = "".join(cell["source"]).splitlines()
            exec("\n".join(lines), names)
            shown.append(eval(last, names))
    compared, pictures, diagnosed, model, ladder = shown
    assert "RMS" in compared._repr_html_()
    assert pictures._repr_html_().count("data:image/png;base64,") == len(pictures.images) >= 2
    assert diagnosed.data["verdict"] == diagnosed.verdict == "named"
    assert diagnosed.result.named.name == "hysteresis"
    assert model.effects == ["graduation_harmonics", "hysteresis"]
    (path,) = ladder.save(tmp_path)
    assert path.read_bytes().startswith(b"\x89PNG")
    # The model is written and read again.
    model.write(tmp_path / "m.toml")
    assert at.Model.read(tmp_path / "m.toml").effects == model.effects
