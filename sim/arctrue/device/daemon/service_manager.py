"""Sends systemd by sd_notify the readiness and status of the service, and its watchdog message."""

from __future__ import annotations

import asyncio
import os
import socket


def notify(state: str) -> None:
    """Send ``state``, for example ``READY=1``, to systemd; without systemd the function does
    nothing."""
    address = os.environ.get("NOTIFY_SOCKET", "")
    if not address:
        return
    if address.startswith("@"):
        address = "\0" + address[1:]  # abstract socket of Linux: it has a name but no file
    try:
        with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as manager:
            manager.setblocking(False)
            manager.sendto(state.encode(), address)
    except OSError:
        return  # a service manager that does not receive the message must not stop the daemon


async def keep_alive() -> None:
    """Send the watchdog's message at half of the interval that systemd requires."""
    microseconds = int(os.environ.get("WATCHDOG_USEC", "0"))
    while microseconds:
        notify("WATCHDOG=1")
        await asyncio.sleep(microseconds / 2e6)
