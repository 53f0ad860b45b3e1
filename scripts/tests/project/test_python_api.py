"""Tests the Python interface, ``import arctrue as at``: which modules the import loads, which data
it accepts, and that the notebooks in docs/ run."""

from __future__ import annotations

import ast
import json
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
import pyarrow as pa  # type: ignore[import-untyped]
import pytest

import arctrue as at
from arctrue.measurement import MeasurementError, MeasurementSet, Reference, Table
from arctrue.workbench.model.model import HistoryStep
from scripts.reference_pages import api_page

DOCS = Path(__file__).resolve().parents[3] / "docs"
NOTEBOOKS = DOCS / "notebooks"


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
    """The page of the Python interface states the bounds of the file format in words: at most 2⁶²
    counts per turn, and an uncertainty of the index detection of at most one degree."""
    page = api_page()
    assert "Annotated" not in page
    assert "Meta(" not in page
    assert "| `counts_per_rev` | `int \\| None` | from 4 to 2^62 |" in page
    assert "| `index_detection_arcsec` | `float \\| None` | from 0 to 3600 |" in page


def test_a_recorded_set_is_compared_and_shown() -> None:
    table = at.read_set(DOCS / "data" / "worm_axis_telescope")
    found = at.compare(table)
    # Over this arc the model is a constant, which the fit weights by the correlated noise, so that
    # the RMS is slightly above the smallest possible one.
    error = table.reference.error_arcsec
    rms_arcsec = found.data["channels"]["reference"]["rms_arcsec"]
    assert error.std() <= rms_arcsec < 1.01 * error.std()
    assert "reference" in found._repr_html_()
    with pytest.raises(ValueError, match="no history"):
        at.Model().plot()


def _without_dates(model: at.Model) -> list[HistoryStep]:
    """Return the history of a model without dates, which differ between two fits of the same
    data."""
    return [msgspec.structs.replace(step, date="") for step in model.content.history]


@pytest.mark.large
def test_a_folder_is_as_good_as_its_set() -> None:
    folder = DOCS / "data" / "worm_axis_telescope"
    table = at.read_set(folder)
    for given in (folder, str(folder)):
        assert at.compare(given).data == at.compare(table).data
        assert at.Model().observations(given).reference is not None
        added = at.Model().add("reference_drift", given)
        other = at.Model().add("reference_drift", table)
        assert added.content.effects == other.content.effects
        assert _without_dates(added) == _without_dates(other)
    assert at.diagnose(str(folder)).verdict == at.diagnose(table).verdict
    with pytest.raises(MeasurementError, match="no such folder"):
        at.compare("nowhere")
    for work in (at.compare, at.diagnose, at.Model().observations):
        with pytest.raises(TypeError, match=r"expected a measurement set .* found list"):
            work([1, 2])


class _Series:
    """Column like a column of a pandas data frame: it is indexed by labels, and −1 is not a
    label."""

    def __init__(self, values: list[float]) -> None:
        self._values = np.array(values)

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> Any:
        return np.array(self._values, dtype=dtype)

    def __len__(self) -> int:
        return len(self._values)

    def __getitem__(self, label: Any) -> Any:
        if isinstance(label, int) and not 0 <= label < len(self._values):
            raise KeyError(label)
        return _Series(self._values[label].tolist())


@pytest.mark.parametrize("kind", [_Series, list, tuple, pa.chunked_array])
def test_columns_of_a_data_frame_are_taken(kind: Callable[[list[float]], Any]) -> None:
    angle = np.arange(0.0, 360.0, 5.0)
    values = {
        "target_deg": angle,
        "error_arcsec": 3.0 * np.sin(np.deg2rad(angle)),
        "time_s": np.arange(angle.size, dtype=np.int64),
        "direction": np.ones(angle.size),
    }

    def made(convert: Callable[[list[float]], Any]) -> MeasurementSet:
        if kind is pa.chunked_array and convert is kind:
            columns = {name: pa.chunked_array([pa.array(x)]) for name, x in values.items()}
        else:
            columns = {name: convert(x.tolist()) for name, x in values.items()}
        return MeasurementSet(Table(), reference=Reference(**columns))

    given = made(kind)
    assert given.reference is not None
    assert given.reference.direction is not None
    assert given.reference.direction.dtype == np.int64
    assert at.compare(given).data == at.compare(made(np.array)).data


@pytest.mark.parametrize(
    ("columns", "said"),
    [
        ({"direction": [1, 0.5, 1]}, r"direction\[1\]: expected whole numbers, found 0.5"),
        ({"error_arcsec": [1.0, 2.0]}, "equally long, found target_deg 3, error_arcsec 2"),
        ({"target_deg": ["a", "b", "c"]}, "target_deg: expected numbers"),
        ({"target_deg": [[1.0, 2.0, 3.0]]}, "target_deg: expected a row of numbers"),
        ({"mask": [0, 1, 2]}, r"mask\[2\]: expected 0 or 1, found 2"),
    ],
)
def test_columns_that_are_none_are_refused(columns: dict[str, Any], said: str) -> None:
    right: dict[str, Any] = {"target_deg": [0.0, 1.0, 2.0], "error_arcsec": [0.0, 1.0, 2.0]}
    with pytest.raises(ValueError, match=said):
        Reference(**{**right, **columns})


def shown_by(notebook: Path) -> list[Any]:
    """Run every code cell in order; return the last expression of each cell, which a notebook
    shows."""
    names: dict[str, object] = {}
    shown = []
    for cell in json.loads(notebook.read_text(encoding="utf-8"))["cells"]:
        if cell["cell_type"] == "code":
            tree = ast.parse("".join(cell["source"]))
            last = tree.body.pop()
            assert isinstance(last, ast.Expr)
            exec(compile(tree, notebook.name, "exec"), names)
            shown.append(eval(compile(ast.Expression(last.value), notebook.name, "eval"), names))
    return shown


@pytest.mark.large
def test_the_notebook_of_the_metrologist() -> None:
    """The results in the notebook agree with its simulation: amplitudes of 2″ and 0.3″, a reversal
    error of 0.4″, and noise of 0.1″ a row."""
    data, params, (value, stderr, (low, high)), tested, (correction, std) = shown_by(
        NOTEBOOKS / "metrologist.ipynb"
    )
    assert "240 rows" in repr(data)
    for order, size in ((1, 2.0), (3, 0.3)):
        found = params[f"graduation_harmonics.order_{order}_amplitude"]
        assert abs(found.value - size) < 3.0 * found.stderr
    # The uncertainty of the difference between both directions follows from 240 rows with 0.1″
    # noise.
    assert stderr == pytest.approx(2.0 * 0.1 / np.sqrt(240), rel=0.2)
    assert low < value < high
    assert low < 0.4 < high
    assert tested.ratio.p_value < 1e-9
    angle = np.deg2rad([0.0, 7.5, 15.0])
    expected = 2.0 * np.cos(angle) + 0.3 * np.sin(3.0 * angle) + 0.2
    assert np.all(np.abs(correction - expected) < 3.0 * std)


def test_the_notebook_of_the_beamline() -> None:
    """The results in the notebook agree with its simulation: an order 1 that changes by 0.25″/K,
    and noise of 0.2″ a row."""
    data, same, params, (value, (low, high)), correction = shown_by(NOTEBOOKS / "beamline.ipynb")
    assert "600 rows" in repr(data)
    assert same
    assert params["graduation_harmonics.order_1_amplitude"].value == pytest.approx(3.0, abs=0.05)
    assert low < value < high
    assert low < 0.25 < high
    angle = np.deg2rad(correction["angle"].values)
    # T₀ is the median temperature of the log, 22 °C.
    expected = 3.0 * np.cos(angle) + 0.25 * np.sin(angle)
    np.testing.assert_allclose(correction.values, expected, atol=0.1)


@pytest.mark.large
def test_the_notebook_of_the_machine_builder() -> None:
    polygon, data, verdict, model, left = shown_by(NOTEBOOKS / "machine_builder.ipynb")
    assert list(polygon.columns) == ["angle", "error_arcsec", "direction", "cycle"]
    assert "capture: 12000 rows, reference: 480 rows" in repr(data)
    assert (verdict.verdict, verdict.data["named"]) == ("named", "hysteresis")
    assert model.effects == ["graduation_harmonics", "hysteresis"]
    assert all(step.measurement_sha256 == data.sha256 for step in model.history)
    assert left["count"] == 480
    # The simulated autocollimator's noise is 0.15″.
    assert left["std"] < 0.2


@pytest.mark.large
def test_the_notebook_runs(tmp_path: Path) -> None:
    """All code cells of the notebook run in order, and the last expressions of the cells have the
    expected values."""
    shown = shown_by(DOCS / "notebook.ipynb")
    compared, pictures, diagnosed, model, ladder = shown
    assert "RMS" in compared._repr_html_()
    assert pictures._repr_html_().count("data:image/png;base64,") == len(pictures.images) >= 2
    assert diagnosed.data["verdict"] == diagnosed.verdict == "named"
    assert diagnosed.result.named.name == "hysteresis"
    assert model.effects == ["graduation_harmonics", "hysteresis"]
    (path,) = ladder.save(tmp_path)
    assert path.read_bytes().startswith(b"\x89PNG")
    # The notebook has written the model; the test reads it again.
    model.write(tmp_path / "m.toml")
    assert at.Model.read(tmp_path / "m.toml").effects == model.effects
