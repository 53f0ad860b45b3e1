"""``arctrue demo``: see the error fall, through the real VHDL."""

from __future__ import annotations

import sys
from pathlib import Path

import click

from arctrue.demo.judgement import RecordingError
from arctrue.demo.result import DemoResult
from arctrue.demo.run import run_demo
from arctrue.demo.settings import DemoSettings
from arctrue.demo.source_tree import ROOT, DemoError
from arctrue.report.demo_page import write_demo_page


@click.command()
@click.option(
    "--out",
    type=click.Path(file_okay=False, path_type=Path),
    default=ROOT / "build" / "demo",
    show_default="build/demo",
    help="Folder of the page and of the files in between.",
)
@click.option(
    "--lanes",
    type=click.IntRange(1, 64),
    default=DemoSettings().lanes,
    show_default=True,
    help="Harmonic lanes of the gateware; more take longer.",
)
def demo(out: Path, lanes: int) -> None:
    """Run the whole loop: table, edges, VHDL in GHDL, calibration, corrected edges, page.

    Ends with exit code 1 when the corrected output is outside the limits, and 2 when the demo
    cannot run.
    """
    try:
        result = run_demo(DemoSettings(lanes=lanes), out.resolve(), click.echo)
    except (DemoError, RecordingError) as error:
        click.echo(f"demo: {error}", err=True)
        sys.exit(2)
    page = out / "index.html"
    write_demo_page(result, page)
    _print_result(result)
    click.echo(f"\nPage: {page}")
    if not result.passed:
        for fault in result.faults:
            click.echo(f"demo: {fault}", err=True)
        sys.exit(1)


def _print_result(result: DemoResult) -> None:
    settings = result.settings
    arcsec = settings.arcsec_per_count
    click.echo(f"\nOutput against the true angle, one turn; a count is {arcsec:.2f}″ at this scale")
    click.echo(f"  {'':8}{'min':>9}{'max':>9}{'RMS':>9}  {'largest order':>14}")
    for name, turn in (("before", result.before), ("after", result.after)):
        click.echo(
            f"  {name:8}{turn.lowest_counts:9.2f}{turn.highest_counts:9.2f}{turn.rms_counts:9.2f}"
            f"  {turn.amplitude_counts.max():8.3f} (n={turn.worst_order})"
        )
    click.echo(
        f"  limits: peak {settings.peak_limit_counts:g} counts, "
        f"each order {settings.order_limit_counts:g} count"
    )
    click.echo("\nLatency, clocks                 measured   Table 1")
    for unit in result.latencies:
        click.echo(f"  {unit.unit:30}{unit.measured_clocks:8}{unit.paper_clocks:10}")
    measured = sum(unit.measured_clocks for unit in result.latencies)
    paper = sum(unit.paper_clocks for unit in result.latencies)
    click.echo(f"  {'together':30}{measured:8}{paper:10}")
    click.echo(f"  {'pin to pin':30}{result.pin_to_pin_clocks:8}")
    click.echo(
        f"\n{'Within' if result.passed else 'Outside'} the limits; "
        f"{result.clocks_simulated:,} clocks simulated in {result.simulation_s:.0f} s, "
        f"{result.total_s:.0f} s in all"
    )
