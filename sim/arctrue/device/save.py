"""Saves the device's present settings in the device's flash."""

from __future__ import annotations

from arctrue.device.console import Console, ConsoleError
from arctrue.device.refusal import explained, reason_of

SAVE_S = 15.0
"""Longest time in seconds for an answer: an erase takes up to 3 s, and the device ends its attempt
after 8 s."""


class SaveRefusedError(Exception):
    """Is raised if the device cannot save; the message states the reason and the remedy."""


def save_settings(console: Console) -> str:
    """Save the settings; return the device's answer, which it sends after it has read the record
    back.

    Raises SaveRefusedError if the device answers ``error: save REASON``, ConsoleError for another
    error or no answer.
    """
    try:
        return console.confirmed("save", SAVE_S)
    except ConsoleError as error:
        reason = reason_of(error, "save")
        if reason is None:
            raise
        raise SaveRefusedError(explained(console, reason)) from error
