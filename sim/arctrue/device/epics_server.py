"""Serves the EPICS process variables (PVs) of a device over Channel Access and PVAccess; the server
gets the values from the device's daemon."""

from __future__ import annotations

import asyncio
import contextlib
import ctypes
import os
import socket
import stat
import sys
import threading
import time
from collections.abc import Callable
from pathlib import Path
from tempfile import TemporaryDirectory

from arctrue.base.whole_file import write_whole_text
from arctrue.device.announcement import Announcement
from arctrue.device.connection import Watch, ask
from arctrue.device.console import ConsoleError
from arctrue.device.epics_records import Records, access_text

_CAPTURE_S = 400.0
_AGAIN_S = 1.0
_EVENT_S = 5.0
LOOPBACK = ("127.0.0.1", "localhost")
_INTERNET = (socket.AF_INET, socket.AF_INET6)


def bind_to(interface: str) -> None:
    """Set the environment variables that restrict EPICS to one interface; call this before softioc
    starts. PVXS ignores them for one socket, see :func:`confine_to_loopback`."""
    for name in ("EPICS_CAS_INTF_ADDR_LIST", "EPICS_PVAS_INTF_ADDR_LIST"):
        os.environ[name] = interface
    for name in ("EPICS_CAS_BEACON_ADDR_LIST", "EPICS_PVAS_BEACON_ADDR_LIST"):
        os.environ[name] = interface
    for name in ("EPICS_CA_ADDR_LIST", "EPICS_PVA_ADDR_LIST", "EPICS_PVA_INTF_ADDR_LIST"):
        os.environ[name] = interface
    for name in ("EPICS_CAS_AUTO_BEACON_ADDR_LIST", "EPICS_PVAS_AUTO_BEACON_ADDR_LIST"):
        os.environ[name] = "NO"
    for name in ("EPICS_CA_AUTO_ADDR_LIST", "EPICS_PVA_AUTO_ADDR_LIST"):
        os.environ[name] = "NO"


def confine_to_loopback() -> None:
    """Bind each UDP socket of this program to the loopback interface (Linux only).

    PVXS listens for searches at port 5076 of all interfaces, whatever the values of its variables.
    On other systems the sockets stay as they are. Raises OSError if the system refuses to bind one.
    """
    if not sys.platform.startswith("linux"):
        return
    for name in os.listdir("/proc/self/fd"):  # noqa: PTH208, a folder of numbers
        try:
            if not stat.S_ISSOCK(os.fstat(int(name)).st_mode):
                continue
            copy = os.dup(int(name))
        except OSError:
            continue  # the socket has been closed
        with socket.socket(fileno=copy) as found:
            if found.type == socket.SOCK_DGRAM and found.family in _INTERNET:
                found.setsockopt(socket.SOL_SOCKET, socket.SO_BINDTODEVICE, b"lo\0")


def serve_pvs(
    find: Callable[[], Announcement | None],
    prefix: str,
    interface: str,
    report: Callable[[str], None],
    *,
    allow_control: bool,
) -> None:
    """Serve the PVs until the program is interrupted; while the daemon does not run, wait for it.

    ``find`` returns the daemon. Without ``allow_control`` EPICS refuses every write.
    """
    bind_to(interface)
    from softioc import asyncio_dispatcher, softioc

    async def capture() -> str:
        return await _in_thread(lambda: _capture(find, report))

    # A zero that was written while no daemon answered; the next connection sends it.
    unsent: list[float] = []

    async def keep_zero(zero_deg: float) -> None:
        unsent[:] = [zero_deg]
        await _in_thread(lambda: _send_zero(find(), unsent, report))

    records = Records(prefix, capture, keep_zero)
    with TemporaryDirectory() as folder:
        file = Path(folder) / "access.acf"
        write_whole_text(file, access_text(allow_control=allow_control))
        _use_access_file(file)
        softioc.iocInit(asyncio_dispatcher.AsyncioDispatcher())
    if interface in LOOPBACK:
        confine_to_loopback()
    report(f"serving {prefix}Turn and others at {interface}")
    records.connected(False, time.time())
    while True:
        daemon = find()
        try:
            if daemon is not None:
                _follow(daemon, records, unsent, report)
        except ConsoleError as error:
            report(str(error))
        records.connected(False, time.time())
        time.sleep(_AGAIN_S)


def _send_zero(
    daemon: Announcement | None, unsent: list[float], report: Callable[[str], None]
) -> str:
    """Send the zero in ``unsent`` to the daemon; the zero stays in ``unsent`` if no daemon answers.
    Return an empty text."""
    if daemon is not None and unsent:
        zero_deg = unsent[0]
        try:
            ask(daemon, "zero", degrees=zero_deg)
            with contextlib.suppress(ValueError):  # another thread has replaced the value
                unsent.remove(zero_deg)
        except ConsoleError as error:
            report(str(error))
    return ""


def _follow(
    daemon: Announcement,
    records: Records,
    unsent: list[float],
    report: Callable[[str], None],
) -> None:
    """Set the PVs to the daemon's events until the daemon ends. Raises ConsoleError."""
    watch = Watch(daemon, latest=1)
    try:
        # Connected is set after these values, because it states that they are valid.
        for _ in range(watch.earlier):
            event = watch.event(_EVENT_S)
            if event is not None:
                records.show(event["telemetry"], event["recorded_s"])
        _send_zero(daemon, unsent, report)
        state = ask(daemon, "status")
        if not unsent:
            records.zero(float(state["zero_deg"]))
        records.machine_alarms(list(state["machine_alarms"]), time.time())
        records.connected(bool(state["connected"]), time.time())
        while True:
            event = watch.event(_EVENT_S)
            if event is None:
                continue
            if event["event"] == "turn":
                records.show(event["telemetry"], event["recorded_s"])
            elif event["event"] == "port":
                records.connected(bool(event["state"]["connected"]), event["recorded_s"])
            elif event["event"] == "probe":
                records.edge(event, event["recorded_s"])
            elif event["event"] == "zero":
                records.zero(float(event["state"]["zero_deg"]))
            elif event["event"] == "life":
                names = list(event["state"]["machine_alarms"])
                records.machine_alarms(names, event["recorded_s"])
    finally:
        watch.close()


def _capture(find: Callable[[], Announcement | None], report: Callable[[str], None]) -> str:
    """Capture a turn and return the folder of the set. Raises ConsoleError."""
    try:
        daemon = find()
        if daemon is None:
            raise ConsoleError("no daemon runs; start it with arctrue device run")
        folder = str(ask(daemon, "capture", _CAPTURE_S)["capture"])
    except ConsoleError as error:
        report(str(error))
        raise
    report(f"captured: {folder}")
    return folder


async def _in_thread(work: Callable[[], str]) -> str:
    """Await ``work`` in a thread that does not keep the program alive. Raises the exceptions of
    ``work``."""
    loop = asyncio.get_running_loop()
    ended: asyncio.Future[str] = loop.create_future()

    def run() -> None:
        try:
            found = work()
        except Exception as error:
            loop.call_soon_threadsafe(ended.set_exception, error)
        else:
            loop.call_soon_threadsafe(ended.set_result, found)

    threading.Thread(target=run, daemon=True).start()
    return await ended


def _use_access_file(file: Path) -> None:
    """Make EPICS read the file of access security, as asSetFilename in the EPICS shell does.

    Raises RuntimeError if EPICS does not accept the file, because every client could then write to
    the PVs.
    """
    from epicscorelibs import path

    library = ctypes.CDLL(path.get_lib("dbCore"))
    library.asSetFilename.argtypes = [ctypes.c_char_p]
    if library.asSetFilename(str(file).encode()):
        raise RuntimeError("EPICS refused the file of access security")
