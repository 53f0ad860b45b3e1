"""``arctrue capture PORT OUT``: one turn of a device as a measurement set."""

from __future__ import annotations

import sys
from pathlib import Path

import click

from arctrue.cli._numbers import Finite
from arctrue.cli._outputs import OutputFolder
from arctrue.cli._terminal import say
from arctrue.device.console import Console, ConsoleError
from arctrue.measurement import write_measurement_set
from arctrue.measurement.description import FILE_NAME

NO_DEVICE = 2


@click.command(short_help="Write one capture of a device as a set.")
@click.argument("port")
@click.argument("out", type=OutputFolder())
@click.option(
    "--timeout",
    type=Finite(min=1.0),
    default=120.0,
    show_default=True,
    help="Seconds to wait for the turn, and for each line of it.",
)
def capture(port: str, out: Path, timeout: float) -> None:
    """Write the next turn that the device at PORT captures to the folder OUT.

    12,000 samples take 40 s at 115,200 baud. Exit code 2: no answer, characters
    were lost, or OUT holds a measurement set already.
    """
    if (out / FILE_NAME).exists():
        say(f"capture: {out}: holds a measurement set already; name a new folder", err=True)
        sys.exit(NO_DEVICE)
    try:
        console = Console(port)
        measurement = console.dump(timeout)
        write_measurement_set(out, measurement)
    except (ConsoleError, OSError) as error:
        say(f"capture: {error}", err=True)
        sys.exit(NO_DEVICE)
    samples = 0 if measurement.capture is None else measurement.capture.run.size
    say(f"{samples} samples: {out}")
