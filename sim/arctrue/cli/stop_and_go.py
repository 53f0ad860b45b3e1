"""arctrue stop-and-go: runs the paper's ten cycles with a simulated servo that stops at each
face."""

from __future__ import annotations

from pathlib import Path

import click

from arctrue.base.figures import figure
from arctrue.base.json_text import plain
from arctrue.cli._loaded_set import console, for_people, write_json, write_page
from arctrue.cli._numbers import SEED
from arctrue.cli._options import json_option, page_option
from arctrue.cli._outputs import OutputFolder
from arctrue.cli._progress import Progress
from arctrue.cli._tables import number, table, words


@click.command("stop-and-go", short_help="Repeat the paper's ten cycles with a simulated servo.")
@click.option(
    "--cycles",
    type=click.IntRange(2, 100),
    default=10,
    show_default=True,
    help="Number of cycles over the faces.",
)
@click.option(
    "--seed", type=SEED, default=1, show_default=True, help="Seed of instruments and noise."
)
@json_option
@page_option
@click.option("--out", type=OutputFolder(), help="Folder for the picture.")
@for_people
def stop_and_go(
    cycles: int, seed: int, json_file: Path | None, page_file: Path | None, out: Path | None
) -> None:
    """Let a servo stop the table at each face, with raw and then with corrected feedback.

    The servo has a motor, friction and a position loop; the encoder signal is its only feedback.
    """
    from arctrue.studies.stop_and_go.experiment import StopAndGoSettings, run_stop_and_go

    with Progress("driving to the faces"):
        found = plain(run_stop_and_go(StopAndGoSettings(cycles=cycles, seed=seed)))
    both = (found["raw"], found["corrected"])
    comparison = table(
        f"24 faces, {cycles} cycles, ″", words(), number("head 1's signal"), number("corrected")
    )
    comparison.add_row(
        "error by polygon",
        *(
            f"[{figure(one['span_arcsec'][0], 2)}, {figure(one['span_arcsec'][1], 2)}]"
            for one in both
        ),
    )
    comparison.add_row(
        "largest σ of a face", *(figure(max(one["deviation_arcsec"]), 2) for one in both)
    )
    comparison.add_row("U, k = 2", *(figure(one["expanded_arcsec"], 2) for one in both))
    console.print(comparison)
    write_json(json_file, found)
    if page_file is not None or out is not None:
        from arctrue.report.charts.stop_and_go_picture import plot_stop_and_go
        from arctrue.report.stop_and_go_page import stop_and_go_page

        write_page(found, page_file, stop_and_go_page, out, plot_stop_and_go)
