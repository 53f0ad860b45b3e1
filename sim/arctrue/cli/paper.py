"""arctrue paper: the paper's experiment on the virtual instrument."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from arctrue.cli._figures import figure
from arctrue.cli._instrument import on_the_instrument
from arctrue.cli._numbers import SEED
from arctrue.cli._outputs import OutputFile, OutputFolder
from arctrue.cli._tables import number, table, words
from arctrue.cli._workbench import console, for_people, write_json

if TYPE_CHECKING:
    from arctrue.studies.paper.experiment import ExperimentResult

FULL_INTERPOLATION = 1024
LEAST_INTERPOLATION = 16
"""With less, the ramp takes longer than the turns between calibration and cycles."""


@click.command(short_help="The paper's experiment on the virtual instrument.")
@click.option("--cycles", type=click.IntRange(2), default=10, show_default=True)
@click.option(
    "--interpolation",
    type=click.IntRange(LEAST_INTERPOLATION, FULL_INTERPOLATION),
    default=FULL_INTERPOLATION,
    show_default=True,
    help="Counts a line. 64 takes a sixteenth of the time and steps of 1.2″.",
)
@click.option("--seed", type=SEED, default=1, show_default=True, help="Of instruments and noise.")
@click.option("--json", "json_file", type=OutputFile(), help="Write JSON.")
@click.option("--out", type=OutputFolder(), help="Folder for Fig. 11.")
@for_people
def paper(
    cycles: int, interpolation: int, seed: int, json_file: Path | None, out: Path | None
) -> None:
    """Polygon of 24 faces and autocollimator, before and after, beside the paper's figures.

    The table is captured, calibrated and corrected by gateware and firmware, every edge through the
    decoders. At the paper's size a cycle takes about a minute and a half.
    """
    from arctrue.instrument.revolution import RevolutionSettings
    from arctrue.studies.paper.experiment import ExperimentSettings, run_experiment

    settings = ExperimentSettings(
        revolution=RevolutionSettings(interpolation=interpolation, noise_arcsec=0.1, seed=seed),
        cycles=cycles,
        seed=seed,
    )
    with on_the_instrument() as shown:
        result = run_experiment(settings, say=shown.say, progress=shown.progress)
    _print(result)
    write_json(json_file, result.as_json())
    if out is not None:
        from arctrue.report.paper_figures import plot_experiment

        console.print(f"wrote {plot_experiment(result, out)}")


def _print(result: ExperimentResult) -> None:
    printed, budget = result.published, result.budget
    beside = table(
        f"{printed.faces} faces, {result.settings.cycles} cycles, ″",
        words(),
        number("paper"),
        number("here"),
    )

    def span(values: tuple[float, float]) -> str:
        return f"[{figure(values[0], 2)}, {figure(values[1], 2)}]"

    beside.add_row(
        "error, uncorrected", span(printed.before_arcsec), span(result.before.span_arcsec)
    )
    beside.add_row("error, corrected", span(printed.after_arcsec), span(result.after.span_arcsec))
    beside.add_row(
        "largest σ of a face, (13)",
        f"{printed.largest_deviation_arcsec:.2f}",
        f"{result.after.deviation_arcsec.max():.2f}",
    )
    names = {
        "polygon_arcsec": "u₁ polygon",
        "autocollimator_arcsec": "u₂ autocollimator",
        "repeatability_arcsec": "u₃ repeatability",
        "mounting_eccentricity_arcsec": "u₄ mounting, (14)",
        "tower_difference_arcsec": "u₅ tower difference, (15)",
    }
    for name, label in names.items():
        beside.add_row(label, f"{getattr(printed.budget, name):g}", f"{getattr(budget, name):.2g}")
    beside.add_row(
        "u combined, (16)", f"{printed.combined_arcsec:.2f}", f"{budget.combined_arcsec:.2f}"
    )
    beside.add_row(
        "U expanded, k = 2, (17)", f"{printed.expanded_arcsec:.2f}", f"{budget.expanded_arcsec:.2f}"
    )
    largest = int(result.residual_orders_arcsec.argmax())
    beside.add_row(
        "largest order that is left",
        "1",
        f"{largest + 1} ({result.residual_orders_arcsec[largest]:.2f}″)",
    )
    console.print(beside)
    console.print(
        f"u₁ and u₂ are the paper's; {result.settings.revolution.counts_per_rev:,} counts a turn, "
        f"{result.applied_orders} orders applied, {result.refused_turns} turns refused, "
        f"{result.clocks / 1e6:,.0f} million clocks in {result.wall_s:,.0f} s."
    )
