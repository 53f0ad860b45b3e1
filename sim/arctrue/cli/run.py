"""arctrue run: a scenario on the virtual instrument, turn by turn."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING

import click

from arctrue.cli._instrument import on_the_instrument
from arctrue.cli._outputs import OutputFile, OutputFolder
from arctrue.cli._terminal import say, tell_error
from arctrue.cli._workbench import console, for_people, write_json

if TYPE_CHECKING:
    from arctrue.studies.scenario import ScenarioResult, Turn

FULL_LINES = 16384


@click.command(short_help="Run a scenario on the virtual instrument, turn by turn.")
@click.argument("scenario_file", metavar="SCENARIO.toml", type=click.Path(path_type=Path))
@click.option(
    "--lines",
    type=click.IntRange(16, FULL_LINES),
    help="Lines of the disc in place of the scenario's. 64 is a quick look with counts of 20″; "
    "the limits in arcsec are not asked for then.",
)
@click.option("--json", "json_file", type=OutputFile(), help="Write JSON.")
@click.option("--out", type=OutputFolder(), help="Folder for the picture.")
@for_people
def run(scenario_file: Path, lines: int | None, json_file: Path | None, out: Path | None) -> None:
    """Run SCENARIO.toml: a table with effects and faults before gateware and firmware.

    Scenarios for each effect are in sim/scenarios; docs/scenarios.md tells what a file may say.
    Ends with exit code 1 where a limit of the scenario is broken, and 2 when it cannot be run.
    """
    from arctrue.studies.scenario import read_scenario, run_scenario

    scenario = read_scenario(scenario_file, lines=lines)
    with on_the_instrument(str(scenario_file)) as shown:
        result = run_scenario(scenario, say=shown.say, progress=shown.progress)
    _print(result)
    write_json(json_file, result.as_json())
    if out is not None:
        from arctrue.report.scenario_figure import plot_scenario

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
    orders = "".join(f"{f'order {order}':>10}" for order in scenario.orders)
    say(f"{scenario.title}\nErrors against the true angle in ″; each turn's mean is removed.\n")
    say(
        f"{'':4}{'':8}{'not corr.':>11} │ {'corrected: means of half a degree':36}{'edges':>9}"
        f"{'mean':>9}"
    )
    say(
        f"{'turn':>4}{'°C':>8}{'RMS':>11} │ {'min':>10}{'max':>10}{'RMS':>10}{'':6}{'RMS':>9}"
        f"{'':9}{orders}{'reference' if by_reference else '':>12}"
    )
    for turn in result.turns:
        say(_line(turn, scenario.orders))
        for said in _said(turn):
            say(f"{'':12}{said}")
    say(
        f"\n{scenario.scale.counts_per_rev:,} counts a turn ({scenario.arcsec_per_count:.4f}″), "
        f"{scenario.scale.lanes} lanes; {result.applied} captures applied, {result.refused} "
        f"refused; {result.clocks / 1e6:,.1f} million clocks in {result.wall_s:,.0f} s"
    )


def _line(turn: Turn, orders: tuple[int, ...]) -> str:
    before, after = turn.uncorrected, turn.corrected
    amplitudes = [math.nan] * len(orders)
    values = [math.nan] * 5
    if after is not None:
        amplitudes = [float(after.amplitude_arcsec[order - 1]) for order in orders]
        values = [
            after.lowest_arcsec,
            after.highest_arcsec,
            after.rms_arcsec,
            after.edges_rms_arcsec,
            after.mean_arcsec,
        ]
    low, high, rms, edges, mean = (_number(value) for value in values)
    text = (
        f"{turn.number:4}{turn.temperature_c:8.2f}"
        f"{_number(math.nan if before is None else before.rms_arcsec):>11} │ "
        f"{low:>10}{high:>10}{rms:>10}{'':6}{edges:>9}{mean:>9}"
    )
    text += "".join(f"{_number(value):>10}" for value in amplitudes)
    return text if turn.reference is None else f"{text}{turn.reference.rms_arcsec:12.3f}"


def _number(value: float) -> str:
    return f"{value:.3f}" if math.isfinite(value) else "–"


def _said(turn: Turn) -> list[str]:
    """What happened, one thing a line."""
    lines = list(turn.events)
    for told in turn.told:
        reason = "" if told["result"] == "applied" else f": {told['reason'].replace('_', ' ')}"
        alarms = f"; alarm: {', '.join(told['alarms'])}" if told["alarms"] else ""
        lines.append(f"firmware {told['result']}{reason}{alarms}")
    if turn.flags:
        lines.append(f"flags: {', '.join(turn.flags)}")
    return lines
