"""Makes the pictures of docs/tutorial.md and two pictures of docs/real-data.md.

The tutorial's pictures are made with the commands of that page, the other two with functions of
this script. Run ``python -m scripts.make_workbench_pictures``. The pictures are committed; a test
runs the pages and thereby checks the figures in the pictures.
"""

from __future__ import annotations

import argparse
import os
import shutil
import tempfile
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from numpy.typing import NDArray

from arctrue.cli import main as arctrue
from arctrue.measurement import read_measurement_set
from arctrue.report.log_scale import set_log_y
from arctrue.workbench.effects.registry import built_in
from arctrue.workbench.inference.added import best_form
from arctrue.workbench.inference.design_matrix import Term
from arctrue.workbench.inference.fit import fit
from arctrue.workbench.inference.residuals import Residuals
from arctrue.workbench.observations import Observations
from arctrue.workbench.observations.build import observations_of

ROOT = Path(__file__).resolve().parents[1]
IMAGES = ROOT / "docs" / "images"
DATA = ROOT / "docs" / "data"
BEFORE, AFTER = "#1f5f99", "#c2571a"
EFFECTS = built_in()


def _run(words: str) -> None:
    arctrue(words.split(), standalone_mode=False)


def tutorial() -> None:
    """Run, in a separate folder, the commands of the tutorial that write pictures."""
    start = Path.cwd()
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        try:
            _run("simulate monday --hidden --seed 12 --experiment short")
            _run("compare monday --out pictures")
            _run("diagnose monday --out pictures")
            _run("add thermal_eccentricity monday --model table.toml")
            _run("history --model table.toml --out pictures")
            _run(
                "simulate stranger --effect centrifugal_lobes --size 0.3 --seed 3 "
                "--experiment short"
            )
            _run("compare stranger --out first_look")
            for made, kept in (
                ("pictures/residual_branches.png", "tutorial_branches.png"),
                ("pictures/candidates.png", "tutorial_candidates.png"),
                ("pictures/history.png", "tutorial_history.png"),
                ("first_look/residual_branches.png", "tutorial_stranger.png"),
            ):
                shutil.copyfile(made, IMAGES / kept)
        finally:
            os.chdir(start)


def _observations(name: str) -> Observations:
    return observations_of(read_measurement_set(DATA / name))


def _left(terms: list[Term], observations: Observations) -> NDArray[np.float64]:
    residual = Residuals(fit(terms, observations)).reference_arcsec
    assert residual is not None
    return residual


def motor() -> None:
    """Draw the order spectrum of the motor encoder after the base model and the reversal error."""
    observations = _observations("moteus_motor_encoder")
    rows = observations.reference
    assert rows is not None
    terms = [Term(EFFECTS["graduation_harmonics"](), {}), Term(EFFECTS["hysteresis"](), {})]
    residual = _left(terms, observations)
    orders = np.arange(21, 200)
    sums = residual @ np.exp(-1j * np.outer(rows.target_rad, orders))
    amplitude = 2.0 * np.abs(sums) / residual.size
    figure = Figure(figsize=(8.0, 3.2), layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.subplots()
    axes.vlines(orders, 1.0, amplitude, color=BEFORE, linewidth=1.4)
    for order in (21, 36, 42, 72, 108, 126, 144):
        height = float(amplitude[order - 21])
        axes.annotate(
            str(order), (order, height), xytext=(0, 3), textcoords="offset points", ha="center"
        )
    set_log_y(axes)
    axes.set(ylim=(5.0, 2000.0), xlabel="order, periods a turn", ylabel="amplitude / ″")
    axes.set_title("Motor encoder: residual without orders 1 to 20 and reversal error", loc="left")
    axes.spines[["top", "right"]].set_visible(False)
    figure.savefig(IMAGES / "real_motor.png", dpi=110)


def worm() -> None:
    """Draw the residual of the telescope axis over time, before and after the effect of the worm is
    added to the model."""
    observations = _observations("worm_axis_telescope")
    rows = observations.reference
    assert rows is not None
    assert rows.time_s is not None
    drift = Term(EFFECTS["reference_drift"](degree=2), {})
    residuals = Residuals(fit([drift], observations))
    gear = Term(best_form(EFFECTS["drive_gear_error"](), residuals), {})
    figure = Figure(figsize=(8.0, 3.2), layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.subplots()
    for terms, colour, label in (
        ([drift], BEFORE, "drift of degree 2"),
        ([drift, gear], AFTER, "and the worm of 225 teeth"),
    ):
        axes.plot(
            rows.time_s / 60.0, _left(terms, observations), ".", markersize=3, color=colour,
            label=label,
        )  # fmt: skip
    axes.set(xlabel="time / min", ylabel="error less model / ″")
    axes.set_title("Telescope axis against a guide star", loc="left")
    axes.spines[["top", "right"]].set_visible(False)
    axes.legend(frameon=False, ncols=2)
    figure.savefig(IMAGES / "real_worm.png", dpi=110)


def main(arguments: Sequence[str] | None = None) -> None:
    """Make all pictures."""
    argparse.ArgumentParser(description=__doc__).parse_args(arguments)
    IMAGES.mkdir(parents=True, exist_ok=True)
    tutorial()
    motor()
    worm()


if __name__ == "__main__":
    main()
