"""Draws the error over one turn on the virtual instrument."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from arctrue.report.picture_file import save_picture
from arctrue.report.svg import AFTER, BEFORE, LIMIT, house_style
from arctrue.studies.revolution import (
    PAPER_AFTER_ARCSEC,
    PAPER_BEFORE_ARCSEC,
    RevolutionResult,
)


def plot_revolution(result: RevolutionResult, file: Path) -> None:
    """Draw the error before and after correction; below, draw the corrected error enlarged.

    The ending of the file name determines the format.
    """
    with house_style():
        figure = Figure(figsize=(9.6, 5.6), layout="constrained")
        upper, lower = figure.subplots(2, 1, sharex=True, height_ratios=[3, 2])
        degrees = np.rad2deg(result.after.angle_rad)
        upper.plot(degrees, result.before.error_arcsec, color=BEFORE, label="first turn")
        upper.plot(degrees, result.after.error_arcsec, color=AFTER, label="second turn, corrected")
        for end in PAPER_BEFORE_ARCSEC:
            upper.axhline(end, color=LIMIT, linestyle=(0, (4, 3)), linewidth=1)
        upper.set_title("Output of the compiled gateware against the true angle")
        upper.set_ylabel("error, arcsec")
        upper.legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=2)
        lower.plot(degrees, result.after.error_arcsec, color=AFTER)
        for sign in (-1, 1):
            lower.axhline(
                sign * result.limit_arcsec, color=LIMIT, linestyle=(0, (4, 3)), linewidth=1
            )
        lower.set_title(
            f"Corrected, means of half a degree; dashed: limit ±{result.limit_arcsec:.2g}″ "
            f"(the paper: {PAPER_AFTER_ARCSEC[0]} to {PAPER_AFTER_ARCSEC[1]}″)"
        )
        lower.set_ylabel("error, arcsec")
        lower.set_xlabel("true angle of the table, °")
        lower.set_xlim(0, 360)
        lower.set_xticks(range(0, 361, 45))
        save_picture(figure, file)
