"""arctrue error-sources: simulates each error source of the calibration separately."""

from __future__ import annotations

from contextlib import suppress
from pathlib import Path
from typing import Any

import click

from arctrue.base.figures import figure
from arctrue.base.json_text import plain
from arctrue.base.typed_content import ContentError, read_json
from arctrue.cli._loaded_set import console, for_people, write_json, write_page
from arctrue.cli._numbers import SEED
from arctrue.cli._options import json_option, page_option
from arctrue.cli._outputs import OutputFolder
from arctrue.cli._progress import Progress
from arctrue.cli._tables import number, table, words
from arctrue.studies.error_budget import DRAWS


@click.command("error-sources", short_help="Simulate each error source of the calibration.")
@click.option(
    "--draws",
    type=click.IntRange(2, 1000),
    default=DRAWS,
    show_default=True,
    help="Number of draws of each source.",
)
@click.option("--seed", type=SEED, default=1, show_default=True, help="Seed of the draws.")
@click.option(
    "--monte-carlo",
    "folder",
    type=click.Path(exists=True, file_okay=False, path_type=Path),
    help="Folder of an arctrue monte-carlo run, whose stated uncertainty is compared.",
)
@click.option(
    "--from",
    "source",
    type=click.Path(exists=True, dir_okay=False, path_type=Path),
    help="Use the JSON of an earlier run instead of a simulation.",
)
@json_option
@page_option
@click.option("--out", type=OutputFolder(), help="Folder for the picture.")
@for_people
def error_sources(
    draws: int,
    seed: int,
    folder: Path | None,
    source: Path | None,
    json_file: Path | None,
    page_file: Path | None,
    out: Path | None,
) -> None:
    """Simulate each error source of the calibration alone, then all together.

    The command also prints the budget of the paper's experiment with a polygon that is mounted anew
    in every cycle, and the E_n score of that experiment against the calibration by two heads.
    """
    from arctrue.report.charts.error_budget_picture import plot_error_budget
    from arctrue.report.error_budget_page import error_budget_page, summary
    from arctrue.studies.error_budget.drawn import drawn_calibrations
    from arctrue.studies.error_budget.experiment import experiment_budget
    from arctrue.studies.error_budget.sources import error_budget

    if source is not None:
        found = _stored(source)
    else:
        with Progress("simulating") as step:
            found = error_budget(draws, seed, step.now)
            step.now("polygon and two heads")
            found["experiment"] = experiment_budget()
    if folder is not None:
        found["monte_carlo"] = drawn_calibrations(folder)
    found = plain(found)
    left = table(
        "Error of head 1 after calibration, RMS over the turn, ″",
        words("source"),
        number("least\nsquares"),
        number("the paper's\nmethod"),
    )
    for title, own, paper in summary(found):
        left.add_row(title, figure(own, 4), figure(paper, 4))
    left.add_section()
    both = [found["methods"][name] for name in ("least_squares", "paper")]
    left.add_row("root of the sum of squares", *(figure(one["sum_arcsec"], 4) for one in both))
    left.add_row("all together", *(figure(one["whole"]["rms_arcsec"], 4) for one in both))
    console.print(left)
    for name, one in found["experiment"]["compared"].items():
        console.print(
            f"{name}: two heads and polygon, largest |E_n| {max(map(abs, one['e_n'])):.2f}",
            soft_wrap=True,
        )
    write_json(json_file, found)
    write_page(found, page_file, error_budget_page, out, plot_error_budget)


def _stored(source: Path) -> dict[str, Any]:
    """Return the results in a file. Raises ValueError for a file with other content."""
    with suppress(ContentError):
        found = read_json(source, dict[str, Any])
        if {"methods", "experiment", "angle_deg"} <= found.keys():
            return found
    raise ValueError(f"{source}: expected a file that `arctrue error-sources --json` wrote")
