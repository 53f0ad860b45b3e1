"""``arctrue capture PORT OUT``: captures one turn of a device as a measurement set, or appends it
to a set."""

from __future__ import annotations

import sys
from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path

import click

from arctrue.base.read_errors import sentence
from arctrue.cli._device import console_at
from arctrue.cli._guide import next_option, refuse_what_was_not_asked, steps
from arctrue.cli._numbers import Finite
from arctrue.cli._outputs import OutputFolder
from arctrue.cli._runs import print_runs
from arctrue.cli._terminal import note, say, tell_error, tell_warning
from arctrue.device.console import ConsoleError
from arctrue.measurement import (
    JoinError,
    MeasurementError,
    MeasurementSet,
    joined,
    read_measurement_set,
    write_measurement_set,
)
from arctrue.measurement.asked import by_device
from arctrue.measurement.description import FILE_NAME
from arctrue.measurement.reader import unread_columns
from arctrue.measurement.writer import refuse_occupied

NO_DEVICE = 2


@click.command(short_help="Write one capture of a device as a set.")
@click.argument("port")
@click.argument("out", type=OutputFolder())
@click.option(
    "--append", is_flag=True, help="Add the turn as a run to the set OUT of the same table."
)
@next_option
@click.option(
    "--timeout",
    type=Finite(min=1.0),
    default=120.0,
    show_default=True,
    help="Longest time to wait for the turn, and for each of its lines, seconds.",
)
def capture(
    port: str, out: Path, append: bool, kind: str | None, force: bool, timeout: float
) -> None:
    """Write the next turn that the device at PORT captures to the folder OUT.

    The transfer of 12,000 samples takes 40 s at 115,200 baud. With --append the turn becomes a
    further run of the set OUT. With --next the command prints what to do at the table, waits for
    Enter (at a terminal), and refuses a turn that is not the requested measurement (exit code 1).
    Exit code 2: the device does not answer, characters were lost, --append would lose a column of
    OUT, or (without --append) OUT already holds a set or one of its files. The device's clock
    restarts with each capture, so the pause between two runs is unknown.
    """
    there = (out / FILE_NAME).exists()
    if there and not append:
        tell_error(f"{out}: holds a measurement set already; name a new folder, or give --append")
        sys.exit(NO_DEVICE)
    if kind is not None and not there:
        tell_error(f"--next {kind} compares with the first run, and {out} holds no set yet")
        sys.exit(NO_DEVICE)
    notes: list[str] = []
    try:
        if not there:
            refuse_occupied(out)
        before = _before(out) if there else None
        if before is not None and kind is not None:
            _guide(kind, before)
        console = console_at(port)
        now = datetime.now(UTC).replace(microsecond=0)
        taken = measurement = replace(console.dump(timeout), date=now)
        if before is not None and kind is not None:
            refuse_what_was_not_asked(kind, before, taken, force=force)
        if before is not None:
            measurement, notes = joined([before, measurement], times="after")
        write_measurement_set(out, measurement)
    except (ConsoleError, OSError, MeasurementError, JoinError, ValueError) as error:
        tell_error(sentence(error))
        sys.exit(NO_DEVICE)
    samples = 0 if taken.capture is None else taken.capture.run.size
    say(f"{samples} samples: {out}")
    if there:
        for decided in notes:
            say(decided)
        print_runs(measurement)


def _before(out: Path) -> MeasurementSet:
    """Read the set to which the turn is appended, and print its warnings.

    Raises MeasurementError, and ValueError if the set has columns that cannot be written again.
    """
    before = read_measurement_set(out)
    for warning in before.warnings:
        tell_warning(warning)
    for path, column in unread_columns(before, out):
        raise ValueError(
            f"{path}: --append would lose the column {column or '(without a name)'}, which is not "
            "read as numbers; write the turn to a new folder, or take the column out of the file"
        )
    return before


def _guide(kind: str, before: MeasurementSet) -> None:
    """Print the instructions for the operator of the table before the turn is captured. Raises
    ValueError."""
    lines = steps(kind, before)
    if not by_device(kind):
        raise ValueError(
            f"--next {kind}: the device captures one turn of both heads, which is another "
            "measurement. "
            f"{' '.join(lines)} Then: arctrue import, arctrue join --next {kind}"
        )
    for line in lines:
        note(line)
    if sys.stdin.isatty():
        click.prompt(
            "Press Enter when the table does this", default="", show_default=False, err=True
        )
