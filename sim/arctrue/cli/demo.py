"""``arctrue demo``: simulates the whole calibration loop with the real VHDL and the firmware's C
code."""

from __future__ import annotations

import sys
from pathlib import Path

import click

from arctrue.base.figures import figure
from arctrue.base.progress import ReportStep
from arctrue.base.source_tree import ROOT, lack_of_source_tree
from arctrue.cli._loaded_set import console, for_people
from arctrue.cli._options import lanes_option
from arctrue.cli._outputs import OutputFolder
from arctrue.cli._tables import number, table, words
from arctrue.cli._terminal import say, tell_error
from arctrue.cli.hidden import print_result as print_hidden
from arctrue.instrument import InstrumentError
from arctrue.report.demo_page import write_demo_page
from arctrue.report.second_act_page import write_second_act_page
from arctrue.studies.demo.acts import Background
from arctrue.studies.demo.judgement import RecordingError
from arctrue.studies.demo.result import DemoResult
from arctrue.studies.demo.run import run_demo
from arctrue.studies.demo.second_act import SecondAct, run_second_act
from arctrue.studies.demo.settings import DemoSettings
from arctrue.studies.demo.source_tree import DemoError
from arctrue.studies.hidden_effect.settings import HiddenSettings

FIRST_PAGE = "index.html"
SECOND_PAGE = "second_act.html"
SECOND_FOLDER = "second_act"


@click.command(short_help="See the error fall, through the real VHDL and C.")
@click.option(
    "--out",
    type=OutputFolder(),
    default=ROOT / "build" / "demo",
    show_default="build/demo",
    help="Folder for the pages and intermediate files.",
)
@lanes_option(
    DemoSettings().lanes, "Number of harmonic lanes in the first act; more lanes take longer."
)
@click.option(
    "--act",
    type=click.Choice(["1", "2", "both"]),
    default="both",
    show_default=True,
    help="Run only this act.",
)
@for_people
def demo(out: Path, lanes: int, act: str) -> None:
    """Simulate a table, correct its edges with the VHDL and the firmware's C, and write the pages.

    The first act calibrates a table that is coarse enough for a simulation in GHDL. The second act
    runs at the same time: the compiled gateware measures a table of the paper's size with a hidden
    effect, and the workbench names and corrects the effect. Exit code 1: the corrected output is
    outside the limits. 2: an act cannot run.
    """
    if lack := lack_of_source_tree():
        raise ValueError(lack)
    out = out.resolve()
    second_act = None
    if act != "1":
        second_act = Background(
            lambda: run_second_act(HiddenSettings(), out / SECOND_FOLDER, _say("2 | "))
        )
    faults: list[str] = []
    cannot: list[str] = []
    first_written = False
    if act != "2":
        try:
            tell = _say("1 | " if second_act else "")
            first = run_demo(DemoSettings(lanes=lanes), out, tell)
        except (DemoError, RecordingError) as error:
            cannot.append(str(error))
        else:
            page = out / FIRST_PAGE
            first_written = True
            write_demo_page(first, page, SECOND_PAGE if second_act else "")
            _print_result(first)
            say(f"\nPage: {page}\n")
            faults += first.faults
    if second_act is not None:
        try:
            second = second_act.wait()
        except InstrumentError as error:
            cannot.append(f"second act: {error}")
        else:
            page = out / SECOND_PAGE
            write_second_act_page(second, page, FIRST_PAGE if first_written else "")
            _print_second(second)
            say(f"\nPage: {page}")
            faults += [f"second act: {fault}" for fault in second.faults]
    for text in (*cannot, *faults):
        tell_error(str(text))
    if cannot or faults:
        sys.exit(2 if cannot else 1)


def _say(prefix: str) -> ReportStep:
    def tell(text: str) -> None:
        for line in text.splitlines():
            say(prefix + line)

    return tell


def _print_second(act: SecondAct) -> None:
    say("Second act: a hidden effect")
    print_hidden(act.result)
    say(
        f"{'Within' if act.passed else 'Outside'} the limits; {act.total_s:.0f} s in all, "
        "including the build of the instrument"
    )


def _print_result(result: DemoResult) -> None:
    settings = result.settings
    arcsec = settings.arcsec_per_count
    console.print(f"\nOutput against the true angle, one turn; one count is {arcsec:.2f}″ here")
    errors = table(
        "Error, counts",
        words(),
        *map(number, ("min", "max", "RMS", "largest\norder", "which")),
    )
    for name, turn in (("before", result.before), ("after", result.after)):
        errors.add_row(
            name,
            *(figure(value / arcsec, 2) for value in turn.every_edge_arcsec),
            figure(turn.edges_rms_arcsec / arcsec, 2),
            figure(float(turn.amplitude_arcsec.max()) / arcsec, 3),
            str(turn.largest_order),
        )
    console.print(errors)
    console.print(
        f"limits: peak {settings.peak_limit_counts:g} counts, "
        f"each order {settings.order_limit_counts:g} count"
    )
    latency = table("Latency, clocks", words(), number("measured"), number("Table 1"))
    for unit in result.latencies:
        latency.add_row(unit.unit, str(unit.measured_clocks), str(unit.paper_clocks))
    measured = sum(unit.measured_clocks for unit in result.latencies)
    paper = sum(unit.paper_clocks for unit in result.latencies)
    latency.add_row("together", str(measured), str(paper))
    latency.add_row("pin to pin", str(result.pin_to_pin_clocks), "–")
    console.print(latency)
    firmware = table(
        "Firmware",
        number("turn"),
        words("result"),
        number("expected\nerror ″"),
        number("with new\nones ″"),
    )
    for line in result.turns:
        reason = "" if line.reason == "none" else f", {line.reason.replace('_', ' ')}"
        firmware.add_row(
            str(line.number),
            line.result + reason,
            figure(line.active_arcsec, 2),
            figure(line.candidate_arcsec, 2),
        )
    console.print(firmware)
    say(
        f"\n{'Within' if result.passed else 'Outside'} the limits; "
        f"{result.clocks_simulated:,} clocks simulated in {result.simulation_s:.0f} s, "
        f"{result.total_s:.0f} s in all"
    )
