"""arctrue run: runs a scenario on the virtual instrument, turn by turn."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from arctrue.base.figures import figure
from arctrue.cli._instrument import on_the_instrument
from arctrue.cli._loaded_set import console, for_people, write_json
from arctrue.cli._options import json_option
from arctrue.cli._outputs import OutputFolder
from arctrue.cli._tables import number, table
from arctrue.cli._terminal import tell_error

if TYPE_CHECKING:
    from arctrue.studies.scenario import ScenarioResult, ScenarioTurn

FULL_LINES = 16384


@click.command(short_help="Run a scenario on the virtual instrument, turn by turn.")
@click.argument("scenario_file", metavar="SCENARIO.toml", type=click.Path(path_type=Path))
@click.option(
    "--lines",
    type=click.IntRange(16, FULL_LINES),
    help="Number of lines of the disc, instead of the scenario's. 64 is a quick look with counts "
    "of 20″; the limits in arcsec are then not checked.",
)
@json_option
@click.option("--out", type=OutputFolder(), help="Folder for the picture.")
@for_people
def run(scenario_file: Path, lines: int | None, json_file: Path | None, out: Path | None) -> None:
    """Run SCENARIO.toml: gateware and firmware measure a table with effects and faults.

    sim/scenarios has a scenario for each effect; docs/scenarios.md describes the format. Exit code
    1: a limit of the scenario is exceeded. 2: the scenario cannot run.
    """
    from arctrue.studies.scenario import read_scenario, run_scenario

    scenario = read_scenario(scenario_file, lines=lines)
    with on_the_instrument(str(scenario_file)) as shown:
        result = run_scenario(scenario, report_step=shown.say, report_run=shown.progress)
    _print(result)
    write_json(json_file, result.as_json())
    if out is not None:
        from arctrue.report.charts.scenario_figure import plot_scenario

        out.mkdir(parents=True, exist_ok=True)
        picture = out / f"{scenario_file.stem}.svg"
        plot_scenario(result, picture)
        console.print(f"wrote {picture}", soft_wrap=True)
    for broken in result.broken:
        tell_error(str(broken))
    if result.broken:
        raise SystemExit(1)


def _print(result: ScenarioResult) -> None:
    scenario = result.scenario
    by_reference = any(turn.reference is not None for turn in result.turns)
    console.print(scenario.title)
    errors = table(
        "Error against the true angle, ″, each turn's mean removed; corrected: means of half a "
        "degree",
        *map(number, ("turn", "°C", "not corr.\nRMS", "min", "max", "RMS", "edges\nRMS")),
    )
    orders = table(
        "Mean and orders of the corrected output, ″",
        *map(number, ("turn", "mean", *(f"order {order}" for order in scenario.orders))),
        *((number("RMS by the\nreference"),) if by_reference else ()),
    )
    for turn in result.turns:
        errors.add_row(*_error_cells(turn))
        orders.add_row(*_order_cells(turn, scenario.orders, by_reference=by_reference))
    console.print(errors)
    console.print(orders)
    for turn in result.turns:
        for said in _said(turn):
            console.print(f"turn {turn.number}: {said}", soft_wrap=True)
    console.print(
        f"{scenario.scale.counts_per_rev:,} counts a turn ({scenario.arcsec_per_count:.4f}″), "
        f"{scenario.scale.lanes} lanes; {result.applied} captures applied, {result.refused} "
        f"refused; {result.clocks / 1e6:,.1f} million clocks in {result.wall_s:,.0f} s"
    )


def _error_cells(turn: ScenarioTurn) -> list[str]:
    before, after = turn.uncorrected, turn.corrected
    values: list[float | None] = [None] * 4
    if after is not None:
        values = [
            after.lowest_arcsec,
            after.highest_arcsec,
            after.rms_arcsec,
            after.edges_rms_arcsec,
        ]
    return [
        str(turn.number),
        figure(turn.temperature_c, 2),
        figure(None if before is None else before.rms_arcsec, 3),
        *(figure(value, 3) for value in values),
    ]


def _order_cells(turn: ScenarioTurn, orders: tuple[int, ...], *, by_reference: bool) -> list[str]:
    after = turn.corrected
    values: list[float | None] = [None] * (1 + len(orders))
    if after is not None:
        values = [
            after.mean_arcsec,
            *(float(after.amplitude_arcsec[order - 1]) for order in orders),
        ]
    if by_reference:
        values.append(None if turn.reference is None else turn.reference.rms_arcsec)
    return [str(turn.number), *(figure(value, 3) for value in values)]


def _said(turn: ScenarioTurn) -> list[str]:
    """Return the lines about a turn: its events, the results that the firmware reports, and the
    flags."""
    lines = list(turn.events)
    for reply in turn.telemetry:
        reason = "" if reply["result"] == "applied" else f": {reply['reason'].replace('_', ' ')}"
        alarms = f"; alarm: {', '.join(reply['alarms'])}" if reply["alarms"] else ""
        lines.append(f"firmware {reply['result']}{reason}{alarms}")
    if turn.flags:
        lines.append(f"flags: {', '.join(turn.flags)}")
    return lines
