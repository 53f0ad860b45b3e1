"""``arctrue save PORT``: saves the settings and coefficients of a device for the next power-on."""

from __future__ import annotations

import sys

import click

from arctrue.cli._device import console_at
from arctrue.cli._terminal import say, tell_error
from arctrue.device.console import ConsoleError
from arctrue.device.save import SaveRefusedError, save_settings

REFUSED = 1
NO_DEVICE = 2


@click.command(short_help="Save a device's settings and coefficients for power-on.")
@click.argument("port")
def save(port: str) -> None:
    """Save the parameters, switches and active coefficients of the device at PORT.

    The device writes them into the flash of the board. At power-on it uses the parameters at once,
    and the coefficients after a captured turn has confirmed them. The earlier record stays valid
    until the device has read the new record back.

    Exit code 1: the device refuses to save. 2: the device does not answer.
    """
    try:
        console = console_at(port)
        say(f"{port}: {save_settings(console)}")
    except SaveRefusedError as error:
        tell_error(f"{port}: {error}")
        sys.exit(REFUSED)
    except ConsoleError as error:
        tell_error(str(error))
        sys.exit(NO_DEVICE)
