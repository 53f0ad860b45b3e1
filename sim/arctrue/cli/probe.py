"""``arctrue probe PORT``: shows the table's position at each edge of the probe input."""

from __future__ import annotations

import sys
from pathlib import Path

import click

from arctrue.base.figures import figure
from arctrue.base.read_errors import sentence
from arctrue.base.whole_file import write_whole_text
from arctrue.cli._device import console_at
from arctrue.cli._numbers import Finite
from arctrue.cli._outputs import OutputFile
from arctrue.cli._tables import live_head, live_row
from arctrue.cli._terminal import note, say, tell_error
from arctrue.device.console import ConsoleError
from arctrue.device.probe import KINDS, Latch, Probe, as_csv

NO_DEVICE = 2
COLUMNS = (("edge", 6), ("time s", 14), ("position counts", 16), ("angle °", 12), ("kind", 17))


@click.command(short_help="Show the table's position at each edge of a probe.")
@click.argument("port")
@click.option("--count", type=click.IntRange(min=1), help="End after this number of edges.")
@click.option(
    "--csv", "out", type=OutputFile(".csv"), help="Write the edges to this file at the end."
)
@click.option(
    "--silence",
    type=Finite(min=0.1),
    default=60.0,
    show_default=True,
    help="Seconds without an edge after which a warning is printed.",
)
def probe(port: str, count: int | None, out: Path | None, silence: float) -> None:
    """Show the corrected position at each edge of probe_in, until Ctrl-C.

    A bitstream with EVENTS stores up to 64 edges in a queue, so that edges may come in bursts;
    after `compare events 1` on the console it also stores the pulses of compare_out. With any other
    bitstream the command reads the last edge ten times a second. In both cases it shows the numbers
    of missed edges. `probe falling 1` on the console selects falling edges.

    Exit code 2: the device does not answer, or the file cannot be written. The command writes the
    shown edges to the file even if the device stops answering.
    """
    latches: list[Latch] = []
    failed = False
    try:
        console = console_at(port)
        latch = Probe(console)
        say(live_head(COLUMNS))
        while count is None or len(latches) < count:
            found = latch.wait(silence)
            if found is None:
                note(f"no edge for {silence:g} s; is the probe connected to probe_in?")
                continue
            latches.append(found)
            if found.missed:
                say(f"{found.missed} edges missed before this one: {found.missed_edges}")
            say(_row(found))
    except KeyboardInterrupt:
        pass
    except (ConsoleError, OSError) as error:
        tell_error(sentence(error))
        failed = True
    if out is not None and (latches or not failed):
        try:
            write_whole_text(out, as_csv(latches))
        except OSError as error:
            tell_error(sentence(error))
            sys.exit(NO_DEVICE)
        say(f"{len(latches)} edges: {out}")
    if failed:
        sys.exit(NO_DEVICE)


def _row(latch: Latch) -> str:
    return live_row(
        [
            figure(latch.edge, 0),
            figure(latch.time_s, 6),
            figure(latch.position_counts, 0),
            figure(latch.angle_deg, 6),
            KINDS[latch.kind],
        ],
        COLUMNS,
    )
