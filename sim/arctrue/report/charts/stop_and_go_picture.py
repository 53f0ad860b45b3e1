"""Draws the errors at the faces of the stop-and-go study."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from arctrue.report.picture_file import save_picture
from arctrue.report.svg import AFTER, BEFORE, LIMIT, house_style

PICTURE = "stop_and_go.svg"


def plot_stop_and_go(found: Mapping[str, Any], folder: Path) -> Path:
    """Draw the errors at the faces as the reference instruments measure them, and the true
    errors."""
    path = folder / PICTURE
    faces = np.arange(len(found["raw"]["mean_arcsec"])) * 15.0
    with house_style():
        figure = Figure(figsize=(9.0, 5.6), layout="constrained")
        whole, enlarged = figure.subplots(2, 1, sharex=True)
        for name, colour, label in (
            ("raw", BEFORE, "feedback: head 1's signal"),
            ("corrected", AFTER, "feedback: corrected signal"),
        ):
            whole.plot(faces, found[name]["mean_arcsec"], "o-", color=colour, label=label)
        enlarged.errorbar(
            faces,
            found["corrected"]["mean_arcsec"],
            yerr=found["corrected"]["deviation_arcsec"],
            fmt="o-",
            color=AFTER,
            capsize=2,
            label="measured with polygon and autocollimator; bars: σ",
        )
        true = np.asarray(found["corrected"]["true_mean_arcsec"])
        enlarged.plot(faces, true, "s--", color=LIMIT, markersize=3, label="true")
        whole.set_title("Error at 24 faces, stop and go")
        for axes in (whole, enlarged):
            axes.set_ylabel("error, ″")
            axes.legend(fontsize=8)
        enlarged.set_xlabel("target, °")
        enlarged.set_xticks(range(0, 361, 45))
        return save_picture(figure, path)
