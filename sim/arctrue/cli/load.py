"""``arctrue load PORT FILE``: loads a coefficient file into a running device."""

from __future__ import annotations

import sys
from pathlib import Path

import click

from arctrue.cli._device import console_at
from arctrue.cli._numbers import Finite
from arctrue.cli._progress import Progress
from arctrue.cli._terminal import say, tell_error, tell_warning
from arctrue.device.console import ConsoleError
from arctrue.device.load import (
    DEVICE_LOADS,
    LoadRefusedError,
    heads_without_sets,
    phase_commands,
    send_coefficients,
    wait_until_judged,
)
from arctrue.gateware.coefficient_file import CoefficientFileError, read_coefficient_file

REFUSED = 1
NO_DEVICE = 2


@click.command(short_help="Load a coefficient file into a device.")
@click.argument("port")
@click.argument("file", type=click.Path(path_type=Path))
@click.option(
    "--timeout",
    type=Finite(min=1.0),
    default=120.0,
    show_default=True,
    help="Longest time to wait for the turns that test the coefficients, seconds.",
)
@click.option(
    "--force",
    is_flag=True,
    help="Also load orders that no turn has tested, whether two heads can see them or not.",
)
@click.option(
    "--unseen",
    is_flag=True,
    help="Also load orders that two heads cannot see, such as order 0; turns test the others.",
)
@click.option(
    "--turn",
    type=click.IntRange(-(1 << 23), (1 << 23) - 1),
    help="Number that the device gives to turn 0 of FILE (`load status` shows the present "
    "number). The number sets the phases of orders that are not integers, unless the device finds "
    "them itself; without --turn these orders are off until `load phase` at the console.",
)
def load(
    port: str, file: Path, timeout: float, *, force: bool, unseen: bool, turn: int | None
) -> None:
    """Load FILE, which calibrate or export wrote, into the device at PORT.

    The device continues to calibrate: FILE corrects the orders that it contains, and the device's
    own calibration corrects all others. A file without orders removes the loaded orders. The device
    tests each order with captured turns; if one order is wrong, it refuses the whole file, even
    with --force.

    Exit code 1: the device refuses the coefficients, states the reason and keeps its active
    coefficients; or other coefficients are active at the end. 2: FILE cannot be used, the device
    does not answer, or no turn tests the coefficients within --timeout.
    """
    try:
        coefficients = read_coefficient_file(file, DEVICE_LOADS)
        missing = heads_without_sets(coefficients)
        if missing:
            tell_warning(
                f"{file}: the coefficients for the loss of head {', '.join(map(str, missing))} are "
                "not sent, because lanes of the file follow the temperature or a condition. If the "
                "head fails, the device does not leave it out of the mean"
            )
        console = console_at(port)
        with Progress(f"{file.name}: sending") as progress:
            sent = send_coefficients(
                console,
                coefficients,
                lambda done, all_: progress.now(f"{file.name}: {done} of {all_} frames sent"),
                force=force,
                unseen=unseen,
            )
            progress.now("waiting for turns that test the coefficients")
            unjudged = wait_until_judged(console, sent, timeout)
            for line in phase_commands(coefficients, turn) if turn is not None else []:
                console.command(line)
    except LoadRefusedError as error:
        tell_error(f"{file}: the device refuses: {error}")
        sys.exit(REFUSED)
    except (CoefficientFileError, ConsoleError) as error:
        tell_error(str(error))
        sys.exit(NO_DEVICE)
    except ValueError as error:
        tell_error(f"{file}: {error}")
        sys.exit(NO_DEVICE)
    if sent.is_empty:
        say(f"{file}: contains no orders; the device has removed the earlier loaded orders")
        return
    said = f"{file}: {len(sent.orders)} orders are loaded and active"
    if sent.has_sets:
        said += ", with the coefficients for the loss of a head"
    if sent.lacks_failover:
        tell_warning(
            f"{file}: its coefficients for the loss of a head were not sent: the gateware is built "
            "without FAILOVER. If a head fails, the device does not leave it out of the mean"
        )
    if sent.has_table:
        said += ", with a local table"
    if sent.followed:
        said += f", and {sent.followed} lanes that follow a condition"
    if sent.unseen_followed:
        said += f"; no turn of two heads shows {sent.unseen_followed} of these lanes"
    if sent.real:
        said += f", and {sent.real} orders that are not integers"
        if sent.sought:
            said += f", of which {sent.sought} are off until the device has found their phase"
        if turn is None and sent.real > sent.sought:
            said += (
                f", of which {sent.real - sent.sought} are off, because their phase is unknown: "
                "state it with --turn, or with `load phase` at the console"
            )
    if unjudged:
        said += f"; not tested by any turn: {', '.join(map(str, unjudged))}"
    say(said)
