"""``arctrue commission PORT``: checks how the heads are connected, and measures their places, radii
and skew."""

from __future__ import annotations

import sys
from collections.abc import Sequence

import click

from arctrue.base.read_errors import sentence
from arctrue.calibration import CaptureRefusedError
from arctrue.calibration.commissioning import Connection
from arctrue.cli._device import console_at
from arctrue.cli._numbers import Finite
from arctrue.cli._places import Places
from arctrue.cli._tables import live_head, live_row
from arctrue.cli._terminal import note, say, tell_error
from arctrue.device.commissioning import (
    CONNECTION_COLUMNS,
    STEPS,
    TURNED_COLUMNS,
    Turned,
    both_directions,
    connection_rows,
    measure_turn,
    planned_places,
    read_connection,
    read_parameters,
    turned_rows,
    write_delays,
    write_places,
)
from arctrue.device.console import ConsoleError

WRONG = 1
NO_DEVICE = 2
CONNECTION_WIDTHS = (6, 12, 7, 10, 11)
TURNED_WIDTHS = (5, 11, 6, 15, 8, 9, 7, 6)


@click.command(short_help="Check the connection of the heads; measure places and skew.")
@click.argument("port")
@click.option(
    "--places",
    "places_deg",
    type=Places(),
    help="Planned places of all heads, degrees after head 1, such as 0,64.3,177,257.9.  [default: "
    "the parameters of the device]",
)
@click.option(
    "--connection",
    "only",
    is_flag=True,
    help="End after step 1, which checks order, direction and indices of the heads.",
)
@click.option("--write", is_flag=True, help="Write places and head_delays to the device.")
@click.option(
    "--timeout",
    type=Finite(min=1.0),
    default=120.0,
    show_default=True,
    help="Longest time to wait for the turns of a step, seconds.",
)
def commission(
    port: str, places_deg: tuple[float, ...] | None, only: bool, write: bool, timeout: float
) -> None:
    """Guide the user through the first operation of the heads at PORT, and report faults.

    Step 1: the table turns twice in its positive direction, by hand or by its drive. The command
    names each head that counts in the wrong direction, does not count, has no index, or is
    exchanged with another head. Steps 2 and 3: the table turns once forward and once backward at
    constant speed. The command prints the heads' places with their uncertainties, their radii, the
    noise of one reading, and the skew (delay) of the heads' electronics with the settings that
    remove it. A bearing that moves differently backward looks like skew; a second pair of turns at
    another speed separates the two.

    Exit code 1: a head is connected wrongly, or a turn is refused. 2: the device does not answer.
    """
    try:
        console = console_at(port)
        device = read_parameters(console)
        plan = places_deg or planned_places(device)
        _ask(f"1. {STEPS[0]}")
        found = read_connection(console, device, plan, timeout)
        _show_connection(found)
        if found.faults or only:
            if write and not found.faults:
                write_places(console, plan)
                _written()
            sys.exit(WRONG if found.faults else 0)
        _ask(f"2. {STEPS[1]}")
        forward = measure_turn(console, device, plan, timeout)
        _ask(f"3. {STEPS[2]}")
        turned = both_directions(device, forward, measure_turn(console, device, plan, timeout))
        _show_turns(turned)
        if write:
            write_places(console, tuple(turned.places_deg.tolist()))
            if turned.skew.head_delays != int(device.get("head_delays", 0.0)):
                _ask("Stop the table, because the delays are changed now.")
                write_delays(console, turned.skew)
            _written()
    except (CaptureRefusedError, ValueError) as error:
        tell_error(str(error))
        sys.exit(WRONG)
    except (ConsoleError, OSError) as error:
        tell_error(sentence(error))
        sys.exit(NO_DEVICE)


def _ask(instruction: str) -> None:
    note(instruction)
    if sys.stdin.isatty():
        click.prompt(
            "Press Enter when the table does this", default="", show_default=False, err=True
        )


def _written() -> None:
    say(
        "Written to the device; `arctrue save` stores it in the flash, so that it is kept at "
        "power-off."
    )


def _show_table(
    names: Sequence[str], widths: Sequence[int], rows: Sequence[tuple[str, ...]]
) -> None:
    columns = tuple(zip(names, widths, strict=True))
    say(live_head(columns))
    for row in rows:
        say(live_row(row, columns))


def _show_connection(found: Connection) -> None:
    _show_table(CONNECTION_COLUMNS, CONNECTION_WIDTHS, connection_rows(found))
    for fault in found.faults:
        say(fault)
    if not found.faults:
        say(
            "All heads are connected as planned; no place differs from the plan by more than "
            f"{found.off_deg:.3f}°."
        )


def _show_turns(turned: Turned) -> None:
    _show_table(TURNED_COLUMNS, TURNED_WIDTHS, turned_rows(turned))
    say(f"Noise of the {turned.noise_name}: {turned.noise_arcsec:.3f}″.")
    delays = turned.skew.head_delays
    say(
        f"To remove the skew, enter `set head_delays {delays}` while the table stands; the device "
        "then searches the index marks again."
    )
