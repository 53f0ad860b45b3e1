"""Runs ``arctrue device epics`` as a separate process, at ports that no other program uses."""

from __future__ import annotations

import os
import socket
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from sim.tests.device.daemon_process import PATIENCE_S, PROGRAM, Running

PREFIX = "TEST:"


def free_ports() -> dict[str, str]:
    """Return EPICS variables that set free ports and let clients search only on this machine."""
    names = ("CA_SERVER_PORT", "CAS_SERVER_PORT", "CA_REPEATER_PORT")
    names += ("PVAS_SERVER_PORT", "PVA_BROADCAST_PORT", "PVAS_BROADCAST_PORT")
    with socket.socket() as one, socket.socket() as two, socket.socket() as three:
        for free in (one, two, three):
            free.bind(("127.0.0.1", 0))
        server, repeater, pva = (str(free.getsockname()[1]) for free in (one, two, three))
    values = (server, server, repeater, pva, pva, pva)
    found = {f"EPICS_{name}": value for name, value in zip(names, values, strict=True)}
    for kind in ("CA", "PVA"):
        found |= {f"EPICS_{kind}_ADDR_LIST": "127.0.0.1", f"EPICS_{kind}_AUTO_ADDR_LIST": "NO"}
    return found


@contextmanager
def pvs(port: str, *options: str) -> Iterator[Running]:
    """Serve the PVs of the device at ``port``, with the EPICS variables of the environment."""
    command = [sys.executable, "-c", PROGRAM, "device", "epics", port, "--prefix", PREFIX]
    process = subprocess.Popen(
        [*command, *options],
        stdin=subprocess.DEVNULL,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        text=True,
        env={**os.environ, "PYTHONUNBUFFERED": "1"},
    )
    running = Running(process, Path())
    try:
        running.heard(f"serving {PREFIX}Turn")
        yield running
    finally:
        process.kill()
        process.wait(PATIENCE_S)
