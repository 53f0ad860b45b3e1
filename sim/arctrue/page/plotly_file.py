"""Finds the file plotly.js in the package plotly, so that the page needs no network."""

from __future__ import annotations

from importlib.util import find_spec
from pathlib import Path


def plotly_file() -> Path:
    """Return the path of plotly.js without importing the package. Raises FileNotFoundError."""
    spec = find_spec("plotly")
    for place in (spec.submodule_search_locations or []) if spec is not None else []:
        path = Path(place) / "package_data" / "plotly.min.js"
        if path.is_file():
            return path
    raise FileNotFoundError("plotly.min.js is not in the package plotly: install arctrue again")
