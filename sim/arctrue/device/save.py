"""Keep what a device works with in its flash."""

from __future__ import annotations

from arctrue.device.console import Console, ConsoleError
from arctrue.device.refusal import explained, reason_of

SAVE_S = 15.0
"""Erasing takes up to 3 s; the device gives up after 8 s."""


class SaveRefusedError(Exception):
    """The device cannot save; the message says why and what to do."""


def save_settings(console: Console) -> str:
    """What the device says when the record has been read back.

    Raises SaveRefusedError where the flash does not take it, ConsoleError where the device does
    not answer.
    """
    try:
        return console.confirmed("save", SAVE_S)
    except ConsoleError as error:
        reason = reason_of(error, "save")
        if reason is None:
            raise
        raise SaveRefusedError(explained(console, reason)) from error
