"""``arctrue capture PORT OUT``: one turn of a device as a measurement set, or as a run more."""

from __future__ import annotations

import sys
from pathlib import Path

import click

from arctrue.cli._numbers import Finite
from arctrue.cli._outputs import OutputFolder
from arctrue.cli._runs import print_runs
from arctrue.cli._terminal import say
from arctrue.device.console import Console, ConsoleError
from arctrue.measurement import (
    JoinError,
    MeasurementError,
    joined,
    read_measurement_set,
    write_measurement_set,
)
from arctrue.measurement.description import FILE_NAME

NO_DEVICE = 2


@click.command(short_help="Write one capture of a device as a set.")
@click.argument("port")
@click.argument("out", type=OutputFolder())
@click.option("--append", is_flag=True, help="Add a run to the set OUT, of the same table.")
@click.option(
    "--timeout",
    type=Finite(min=1.0),
    default=120.0,
    show_default=True,
    help="Seconds to wait for the turn, and for each line of it.",
)
def capture(port: str, out: Path, append: bool, timeout: float) -> None:
    """Write the next turn that the device at PORT captures to the folder OUT.

    12,000 samples take 40 s at 115,200 baud. Exit code 2: no answer, characters
    were lost, or OUT holds a measurement set already. With --append the turn becomes a
    run more of that set: down after up, faster, warmer, as arctrue diagnose asks for it.
    The device's clock begins anew with each capture; the pause between two runs is not known.
    """
    there = (out / FILE_NAME).exists()
    if there and not append:
        say(
            f"capture: {out}: holds a measurement set already; name a new folder, or --append",
            err=True,
        )
        sys.exit(NO_DEVICE)
    notes: list[str] = []
    try:
        before = read_measurement_set(out) if there else None
        console = Console(port)
        taken = measurement = console.dump(timeout)
        if before is not None:
            measurement, notes = joined([before, measurement], times="after")
        write_measurement_set(out, measurement)
    except (ConsoleError, OSError, MeasurementError, JoinError) as error:
        say(f"capture: {error}", err=True)
        sys.exit(NO_DEVICE)
    samples = 0 if taken.capture is None else taken.capture.run.size
    say(f"{samples} samples: {out}")
    if there:
        for note in notes:
            say(note)
        print_runs(measurement)
