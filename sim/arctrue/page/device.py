"""Loads the coefficients of a step into a running device, as the command ``arctrue load`` does."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from arctrue.base.whole_file import write_whole_text
from arctrue.device.connection import open_console
from arctrue.device.console import ConsoleError
from arctrue.device.load import LoadRefusedError, send_coefficients, wait_until_judged
from arctrue.gateware.coefficient_file import read_coefficient_file

_WAIT_S = 120.0


def load_into_device(port: str, device: Mapping[str, Any], *, force: bool) -> str:
    """Send the coefficients, wait for the turn that checks them, and return a sentence about the
    result.

    Raises ValueError if the device or the coefficients are missing, if there are objections and
    ``force`` is false, and if the device refuses the coefficients or does not answer.
    """
    if not port:
        raise ValueError("no device: start the page with --port PORT")
    if "file" not in device:
        raise ValueError("there are no coefficients for a device here")
    if device["objections"] and not force:
        raise ValueError(f"not loaded: {'; '.join(device['objections'])}")
    with TemporaryDirectory() as folder:
        path = Path(folder) / "coefficients.toml"
        write_whole_text(path, device["file"])
        coefficients = read_coefficient_file(path)
    try:
        console = open_console(port, lambda _: None)
        try:
            sent = send_coefficients(console, coefficients, lambda done, all_: None)
            wait_until_judged(console, sent, _WAIT_S)
        finally:
            console.close()
    except LoadRefusedError as error:
        raise ValueError(f"the device refuses: {error}") from error
    except ConsoleError as error:
        raise ValueError(str(error)) from error
    return f"{len(device['orders'])} orders are loaded and active."
