"""Opens the console of a device for a command, through the device's daemon if one is running."""

from __future__ import annotations

import click

from arctrue.cli._terminal import note
from arctrue.device.connection import Watch, daemon_of, open_console, through
from arctrue.device.console import Console


def console_at(port: str) -> Console:
    """Open the console and close it when the command ends. Raises ConsoleError."""
    console = open_console(port, note)
    click.get_current_context().call_on_close(console.close)
    return console


def watch_at(port: str) -> Watch | None:
    """Watch the daemon of the port until the command ends; return None if no daemon is running.

    Raises ConsoleError.
    """
    daemon = daemon_of(port)
    if daemon is None:
        return None
    note(through(port, daemon))
    watch = Watch(daemon)
    click.get_current_context().call_on_close(watch.close)
    return watch
