"""arctrue paper: repeats the paper's experiment on the virtual instrument."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any

import click

from arctrue.base.figures import figure
from arctrue.base.json_text import plain
from arctrue.base.typed_content import ContentError, read_json, typed
from arctrue.base.whole_file import write_whole_text
from arctrue.cli._instrument import on_the_instrument
from arctrue.cli._loaded_set import console, for_people, write_json
from arctrue.cli._numbers import SEED
from arctrue.cli._options import json_option, lanes_option
from arctrue.cli._outputs import OutputFile, OutputFolder
from arctrue.cli._tables import number, table, words

FULL_INTERPOLATION = 1024
COARSE_INTERPOLATION = 64
LEAST_INTERPOLATION = 16
"""Smallest interpolation factor; with a smaller factor, the ramp to new coefficients has not ended
when the polygon's cycles begin."""


@click.command(short_help="Repeat the paper's experiment on the virtual instrument.")
@click.option(
    "--cycles",
    type=click.IntRange(2),
    default=10,
    show_default=True,
    help="Number of cycles over the faces.",
)
@click.option(
    "--interpolation",
    type=click.IntRange(LEAST_INTERPOLATION, FULL_INTERPOLATION),
    default=FULL_INTERPOLATION,
    show_default=True,
    help="Counts per line. 64 takes a sixteenth of the time, with counts of 1.2″.",
)
@lanes_option(
    words=(
        "Number of lanes of the gateware. 8 are enough for this table, and run more than twice "
        "as fast."
    )
)
@click.option(
    "--seed", type=SEED, default=1, show_default=True, help="Seed of instruments and noise."
)
@json_option
@click.option(
    "--page",
    "page_file",
    type=OutputFile(".md"),
    help="Write the page as Markdown. Runs the experiment with --interpolation 64 too.",
)
@click.option("--out", type=OutputFolder(), help="Folder for the figures.")
@click.option(
    "--from",
    "source",
    type=click.Path(exists=True, dir_okay=False, path_type=Path),
    multiple=True,
    help="Use the JSON of an earlier run instead of a new run; repeatable.",
)
@for_people
def paper(
    cycles: int,
    interpolation: int,
    lanes: int,
    seed: int,
    json_file: Path | None,
    page_file: Path | None,
    out: Path | None,
    source: tuple[Path, ...],
) -> None:
    """Measure with a 24-face polygon and autocollimator before and after the correction.

    On a simulated table, gateware and firmware capture, calibrate and correct; every edge passes
    the decoders. At the paper's size a cycle takes about a minute and a half. --page writes a page
    that compares every equation, table and figure of the paper with this experiment.
    """
    experiments = [one for path in source for one in _stored(path)]
    if not source:
        experiments.append(_run(cycles, interpolation, lanes, seed))
        if page_file is not None and interpolation != COARSE_INTERPOLATION:
            experiments.append(_run(cycles, COARSE_INTERPOLATION, lanes, seed))
    for one in experiments:
        _print(one)
    if page_file is None and len(experiments) == 1:
        write_json(json_file, experiments[0])
    else:
        from arctrue.studies.paper.page_items import paper_items

        found = plain(paper_items(experiments))
        experiments = found["experiments"]
        write_json(json_file, found)
        if page_file is not None:
            from arctrue.report.paper_page import paper_page

            write_whole_text(page_file, paper_page(found))
            console.print(f"wrote {page_file}", soft_wrap=True)
    if out is not None:
        from arctrue.report.charts.paper_drawings import draw_figures
        from arctrue.report.paper_figures import plot_experiment

        for path in (plot_experiment(experiments[0], out), *draw_figures(out)):
            console.print(f"wrote {path}", soft_wrap=True)


def _run(cycles: int, interpolation: int, lanes: int, seed: int) -> dict[str, Any]:
    from arctrue.studies.paper.experiment import ExperimentSettings, run_experiment
    from arctrue.studies.revolution import RevolutionSettings

    settings = ExperimentSettings(
        revolution=RevolutionSettings(
            interpolation=interpolation, lanes=lanes, noise_arcsec=0.1, seed=seed
        ),
        cycles=cycles,
        seed=seed,
    )
    with on_the_instrument() as shown:
        return run_experiment(settings, report_step=shown.say, report_run=shown.progress).as_json()


def _stored(source: Path) -> list[dict[str, Any]]:
    """Return the experiments in a file. Raises ValueError for a file with other content."""
    with suppress(ContentError):
        found = read_json(source, dict[str, Any])
        experiments = typed(found.get("experiments", [found]), list[dict[str, Any]])
        if all({"published", "after"} <= one.keys() for one in experiments):
            return experiments
    raise ValueError(
        f"{source}: expected a file that `arctrue paper --json` wrote, with one experiment or "
        "(with --page) a list of experiments"
    )


def _print(result: Mapping[str, Any]) -> None:
    printed, budget = result["published"], result["budget"]
    comparison = table(
        f"{printed['faces']} faces, {result['settings']['cycles']} cycles, ″",
        words(),
        number("paper"),
        number("here"),
    )

    def span(values: list[float]) -> str:
        return f"[{figure(values[0], 2)}, {figure(values[1], 2)}]"

    comparison.add_row(
        "error, uncorrected", span(printed["before_arcsec"]), span(result["before"]["span_arcsec"])
    )
    comparison.add_row(
        "error, corrected", span(printed["after_arcsec"]), span(result["after"]["span_arcsec"])
    )
    comparison.add_row(
        "largest σ of a face, (13)",
        f"{printed['largest_deviation_arcsec']:.2f}",
        f"{max(result['after']['deviation_arcsec']):.2f}",
    )
    names = {
        "polygon_arcsec": "u₁ polygon",
        "autocollimator_arcsec": "u₂ autocollimator",
        "repeatability_arcsec": "u₃ repeatability",
        "mounting_eccentricity_arcsec": "u₄ mounting, (14)",
        "tower_difference_arcsec": "u₅ tower difference, (15)",
    }
    for name, label in names.items():
        comparison.add_row(label, f"{printed['budget'][name]:g}", f"{budget[name]:.2g}")
    comparison.add_row(
        "u combined, (16)", f"{printed['combined_arcsec']:.2f}", f"{budget['combined_arcsec']:.2f}"
    )
    comparison.add_row(
        "U expanded, k = 2, (17)",
        f"{printed['expanded_arcsec']:.2f}",
        f"{budget['expanded_arcsec']:.2f}",
    )
    amplitude = result["residual_orders_arcsec"]
    largest = max(range(len(amplitude)), key=amplitude.__getitem__)
    comparison.add_row("largest remaining order", "1", f"{largest + 1} ({amplitude[largest]:.2f}″)")
    console.print(comparison)
    given = result["settings"]["revolution"]
    console.print(
        f"u₁ and u₂ are the paper's; {given['lines'] * given['interpolation']:,} counts a turn, "
        f"{result['applied_orders']} orders applied, {result['refused_turns']} turns refused, "
        f"{result['clocks'] / 1e6:,.0f} million clocks in {result['wall_s']:,.0f} s."
    )
