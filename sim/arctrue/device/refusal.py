"""Explains why a device refuses a command: finds the reason, and its text in the device's help."""

from __future__ import annotations

from arctrue.device.console import Console, ConsoleError


def reason_of(error: ConsoleError, command: str) -> str | None:
    """Return the word that follows ``error: COMMAND``; None for another error or no answer."""
    _, found, reason = str(error).rpartition(f"error: {command} ")
    return reason.split()[0] if found and reason else None


def explained(console: Console, reason: str) -> str:
    """Return ``reason``, followed by its explanation in the device's help if there is one."""
    try:
        return f"{reason}: {console.command(f'help {reason}')[0]}"
    except (ConsoleError, IndexError):
        return reason
