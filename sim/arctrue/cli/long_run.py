"""arctrue long-run: compares strategies that keep a table corrected over many turns."""

from __future__ import annotations

from pathlib import Path

import click

from arctrue.base.figures import figure
from arctrue.base.json_text import plain
from arctrue.cli._instrument import on_the_instrument
from arctrue.cli._loaded_set import console, for_people, write_json, write_page
from arctrue.cli._options import json_option, page_option
from arctrue.cli._outputs import OutputFolder
from arctrue.cli._tables import number, table, words

LEAST_TURNS = 30
"""Smallest number of turns; fewer turns do not show how the orders depend on the temperature."""


@click.command("long-run", short_help="Simulate many turns with drift, heat and a fault.")
@click.argument("scenario_file", metavar="SCENARIO.toml", type=click.Path(path_type=Path))
@click.option(
    "--turns",
    type=click.IntRange(LEAST_TURNS),
    help="Compress the scenario into this number of turns, for a quick look.",
)
@json_option
@page_option
@click.option("--out", type=OutputFolder(), help="Folder for the picture.")
@for_people
def long_run(
    scenario_file: Path,
    turns: int | None,
    json_file: Path | None,
    page_file: Path | None,
    out: Path | None,
) -> None:
    """Run SCENARIO.toml with coefficients that are held, calibrated anew, averaged, or modelled.

    The scenario has one leg of turns, as sim/scenarios/long_run.toml, and runs on the virtual
    instrument: compiled gateware and the firmware's C code. The result is the error under each of
    the four strategies, the Allan deviation of the orders, and the trends that the telemetry watch
    reports.
    """
    from arctrue.studies.long_run.experiment import run_long, shortened
    from arctrue.studies.scenario import read_scenario

    scenario = read_scenario(scenario_file)
    if turns is not None:
        scenario = shortened(scenario, turns)
    with on_the_instrument(str(scenario_file)) as shown:
        found = plain(run_long(scenario, report_run=shown.progress, report_step=shown.say))
    rows = table(
        f"{found['turns']} turns, error after correction, ″",
        words(),
        *map(number, ("RMS", "largest", "applied", "refused")),
    )
    for name, one in found["strategies"].items():
        rows.add_row(
            name,
            figure(one["rms_arcsec"], 2),
            figure(one["largest_arcsec"], 2),
            str(one["applied"]),
            str(len(one["refused"])),
        )
    console.print(rows)
    for one in found["trends"]:
        console.print(
            f"turn {one['turn']}: order {one['order']} moved by {figure(one['change_arcsec'], 2)}″ "
            f"in {one['turns']} turns",
            soft_wrap=True,
        )
    write_json(json_file, found)
    if page_file is not None or out is not None:
        from arctrue.report.charts.long_run_picture import plot_long_run
        from arctrue.report.long_run_page import long_run_page

        write_page(found, page_file, long_run_page, out, plot_long_run)
