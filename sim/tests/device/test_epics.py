"""The PVs of a device, read by caproto: Channel Access in pure Python."""

from __future__ import annotations

import ctypes
import os
import socket
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest
from sim.tests.device.daemon_process import (
    PATIENCE_S,
    PROGRAM,
    Replay,
    Running,
    daemon,
    until,
)

client = pytest.importorskip("caproto.sync.client", reason="softioc has x86-64 wheels only")
from caproto import CaprotoTimeoutError  # noqa: E402

PREFIX = "TEST:"


@pytest.fixture
def ports(monkeypatch: pytest.MonkeyPatch) -> dict[str, str]:
    """Ports of EPICS that nothing else on this machine uses."""
    names = ("CA_SERVER_PORT", "CAS_SERVER_PORT", "CA_REPEATER_PORT")
    names += ("PVAS_SERVER_PORT", "PVA_BROADCAST_PORT", "PVAS_BROADCAST_PORT")
    with socket.socket() as one, socket.socket() as two, socket.socket() as three:
        for free in (one, two, three):
            free.bind(("127.0.0.1", 0))
        server, repeater, pva = (str(free.getsockname()[1]) for free in (one, two, three))
    values = (server, server, repeater, pva, pva, pva)
    found = {f"EPICS_{name}": value for name, value in zip(names, values, strict=True)}
    found |= {"EPICS_CA_ADDR_LIST": "127.0.0.1", "EPICS_CA_AUTO_ADDR_LIST": "NO"}
    for name, value in found.items():
        monkeypatch.setenv(name, value)
    return found


@contextmanager
def pvs(port: str, *options: str) -> Iterator[Running]:
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


def read(name: str, kind: str = "time") -> Any:
    """A PV with timestamp and severity (time), or with unit and limits (control)."""
    return client.read(f"{PREFIX}{name}", data_type=kind, timeout=20.0, repeater=False)


def shows(name: str, is_right: Callable[[Any], bool]) -> None:
    until(lambda: is_right(read(name)), lambda: f"{name}: {read(name)}")


def test_a_turn_becomes_pvs_with_unit_limits_severity_and_time(
    replay: Replay, tmp_path: Path, ports: dict[str, str]
) -> None:
    harmonics = [[1, 150.0, 0.4, 0.01, 1], [2, 6.25, -2.0, 0.02, 0]]
    with daemon(replay.port, tmp_path, "--no-alarm-capture") as running, pvs(replay.port):
        begin = time.time()
        replay.turn(7, harmonics=harmonics, separation_deg=33.25)
        shows("Turn", lambda found: found.data[0] == 7)
        shows("HeadSeparation", lambda found: found.data[0] == 33.25)
        found = read("HeadSeparation")
        assert found.metadata.severity == 0
        assert begin - 1.0 < found.metadata.timestamp < time.time() + 1.0
        shows("Amplitudes", lambda found: found.data.tolist() == [150.0, 6.25])
        shows("Uncertainties", lambda found: found.data.tolist() == [0.01, 0.02])
        # The device did not send it.
        shows("TableTemperature", lambda found: found.metadata.severity == 3)
        limits = read("DieTemperature", "control").metadata
        assert limits.units == b"degC"
        assert (limits.upper_warning_limit, limits.upper_alarm_limit) == (85.0, 100.0)
        replay.turn(8, temperature_c=90.0, alarms=["temperature"], separation_deg=33.25)
        shows("Turn", lambda found: found.data[0] == 8)
        shows("DieTemperature", lambda found: found.metadata.severity == 1)
        shows("Alarms", lambda found: found.metadata.severity == 2)
        assert bytes(read("Alarms").data).rstrip(b"\0") == b"temperature"
        # Without the daemon no value is valid.
        assert read("HeadSeparation").metadata.severity == 0
        running.process.kill()
        shows("HeadSeparation", lambda found: found.metadata.severity == 3)
        shows("Connected", lambda found: found.data[0] == 0)


def test_nobody_writes_unless_it_is_allowed(
    replay: Replay, tmp_path: Path, ports: dict[str, str]
) -> None:
    def write(name: str, value: float) -> str:
        """The status that EPICS answers with."""
        asked = {"notify": True, "timeout": 20.0, "repeater": False}
        return str(client.write(f"{PREFIX}{name}", value, **asked).status.name)

    with daemon(replay.port, tmp_path):
        with pvs(replay.port):
            for name in ("Capture", "HeadSeparation", "DieTemperature.HIGH"):
                assert write(name, 1.0) == "ECA_NOWTACCESS"
        with pvs(replay.port, "--allow-control"):
            assert write("HeadSeparation", 1.0) == "ECA_NOWTACCESS"
            assert write("Capture", 1.0) == "ECA_NORMAL"
            asked = b""
            # The daemon's console asks first whether it is in step.
            while b"marker" not in asked:
                asked += replay.received.get(timeout=PATIENCE_S)


def socket_of(process: int, number: int) -> socket.socket:
    """A duplicate of a socket of another process."""
    pidfd_getfd = 438
    found = ctypes.CDLL(None, use_errno=True).syscall(
        pidfd_getfd, os.pidfd_open(process), number, 0
    )
    assert found >= 0, os.strerror(ctypes.get_errno())
    return socket.socket(fileno=found)


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="by calls of Linux")
def test_every_socket_is_of_this_machine_alone(
    replay: Replay, tmp_path: Path, ports: dict[str, str]
) -> None:
    """Each TCP socket that listens and each UDP socket has the loopback address or device."""
    with daemon(replay.port, tmp_path), pvs(replay.port) as running:
        served = []
        for link in Path(f"/proc/{running.process.pid}/fd").iterdir():
            if not str(link.readlink()).startswith("socket:"):
                continue
            with socket_of(running.process.pid, int(link.name)) as found:
                if found.family not in (socket.AF_INET, socket.AF_INET6):
                    continue
                device = found.getsockopt(socket.SOL_SOCKET, socket.SO_BINDTODEVICE, 16)
                address, port = found.getsockname()[:2]
                assert address == "127.0.0.1" or device.rstrip(b"\0") == b"lo", (address, port)
                served.append(str(port))
    # Searches of Channel Access and of PVAccess, and a server of each.
    assert {ports["EPICS_CA_SERVER_PORT"], ports["EPICS_PVA_BROADCAST_PORT"]} <= set(served)


def test_a_missing_pv_is_no_pv(ports: dict[str, str]) -> None:
    with pytest.raises(CaprotoTimeoutError):
        client.read(f"{PREFIX}Nothing", timeout=0.2, repeater=False)
