"""Why a device refuses a command: the word that it says, and what its help says of it."""

from __future__ import annotations

from arctrue.device.console import Console, ConsoleError


def reason_of(error: ConsoleError, command: str) -> str | None:
    """The device's word after ``error: COMMAND``; None where it is another error, or no answer."""
    _, found, reason = str(error).rpartition(f"error: {command} ")
    return reason.split()[0] if found and reason else None


def explained(console: Console, reason: str) -> str:
    """The word, and the sentence of the device's help where it has one."""
    try:
        return f"{reason}: {console.command(f'help {reason}')[0]}"
    except (ConsoleError, IndexError):
        return reason
