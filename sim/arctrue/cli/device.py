"""``arctrue device``: runs the daemon that owns a device's serial port, and serves many programs
that watch the device."""

from __future__ import annotations

import asyncio
import contextlib
import os
import secrets
import sqlite3
import sys
from collections.abc import Iterator
from pathlib import Path

import click

from arctrue.base.extras import optional
from arctrue.base.read_errors import sentence
from arctrue.base.whole_file import write_whole_text
from arctrue.cli._group import Commands
from arctrue.cli._numbers import Finite
from arctrue.cli._outputs import OutputFolder
from arctrue.cli._terminal import note, say, tell_error, tell_warning
from arctrue.device.announcement import announced_at
from arctrue.device.connection import ask, daemon_of
from arctrue.device.console import ConsoleError
from arctrue.device.port import BAUD
from arctrue.device.recorder import Retention

NO_DEVICE = 2
LOOPBACK = ("127.0.0.1", "localhost", "::1")
SHIPPED = Path(__file__).resolve().parents[1] / "device" / "shipped"
_TOKEN_BYTES = 24


@click.group("device", cls=Commands, short_help="Own a device's port; let many programs watch.")
def device() -> None:
    """Own the serial port of a device, record its telemetry and serve it to other programs."""


@device.command("run", short_help="Own a port, record and serve its telemetry.")
@click.argument("port")
@click.option(
    "--store",
    type=OutputFolder(),
    default=Path("arctrue-device"),
    show_default=True,
    help="Folder for the record (telemetry.sqlite), captures and the token.",
)
@click.option(
    "--host",
    default="127.0.0.1",
    show_default=True,
    help="Network address at which the program serves.",
)
@click.option(
    "--tcp-port",
    type=click.IntRange(0, 65535),
    default=8051,
    show_default=True,
    help="TCP port at which the program serves; 0: any free port.",
)
@click.option(
    "--baud",
    type=click.IntRange(min=1200),
    default=BAUD,
    show_default=True,
    help="Baud rate of the serial port.",
)
@click.option(
    "--allow-control",
    is_flag=True,
    help="Pass on lines that change the device (such as load, save, flash), which are otherwise "
    "refused.",
)
@click.option(
    "--keep-days",
    type=Finite(min=0.01),
    help="Delete turns that are older than this number of days.",
)
@click.option(
    "--keep-megabytes",
    type=Finite(min=1.0),
    default=10_000.0,
    show_default=True,
    help="Largest size of the record, megabytes; the oldest turns are deleted.",
)
@click.option("--capture-every", type=Finite(min=0.001), help="Hours between two captures.")
@click.option("--no-alarm-capture", is_flag=True, help="Take no capture when an alarm begins.")
@click.option(
    "--most-captures",
    type=click.IntRange(min=1),
    default=500,
    show_default=True,
    help="Largest number of captures; the oldest ones are deleted.",
)
@click.option(
    "--probe-every",
    type=Finite(min=0.01),
    help="Seconds between two requests for events of probe and compare.  [default: no requests]",
)
@click.option(
    "--files", type=OutputFolder(), help="Folder for HDF5 files in NeXus form, one a day (UTC)."
)
@click.option(
    "--files-every",
    type=Finite(min=0.01),
    default=0.1,
    show_default=True,
    help="Minutes between two additions to the present day's file.",
)
def run(
    port: str,
    store: Path,
    host: str,
    tcp_port: int,
    baud: int,
    allow_control: bool,
    keep_days: float | None,
    keep_megabytes: float,
    capture_every: float | None,
    no_alarm_capture: bool,
    most_captures: int,
    probe_every: float | None,
    files: Path | None,
    files_every: float,
) -> None:
    """Own the serial PORT until Ctrl-C: record the telemetry, take captures, serve both to other
    programs.

    While this program runs, the other commands for a device use PORT through it. It reopens a lost
    port as soon as the port is present again. Exit code 2: the port or the store is in use, or the
    record cannot be opened.
    """
    if sys.platform == "win32":
        tell_error("arctrue device run needs the serial ports of Linux or macOS")
        sys.exit(NO_DEVICE)
    from arctrue.device.daemon.daemon import Daemon
    from arctrue.device.daemon.settings import DaemonSettings

    optional("serial")
    if files is not None:
        optional("h5py")
    if host not in LOOPBACK:
        tell_warning(
            f"{host} can be reached by other machines, and the connection is not encrypted; only "
            "clients with the token are accepted"
        )
    try:
        settings = DaemonSettings(
            port=port,
            store=store,
            token=_token(store / "token"),
            host=host,
            tcp_port=tcp_port,
            baud=baud,
            allow_control=allow_control,
            retention=Retention(keep_days, keep_megabytes),
            capture_every_s=0.0 if capture_every is None else 3600.0 * capture_every,
            capture_on_alarm=not no_alarm_capture,
            most_captures=most_captures,
            probe_every_s=probe_every or 0.0,
            files=files,
            files_every_s=60.0 * files_every,
        )
        asyncio.run(_run(Daemon, settings))
    except sqlite3.Error as error:
        tell_error(f"{store / 'telemetry.sqlite'}: cannot be opened: {error}")
        sys.exit(NO_DEVICE)
    except (ConsoleError, OSError) as error:
        tell_error(sentence(error))
        sys.exit(NO_DEVICE)


async def _run(daemon: type, settings: object) -> None:
    await daemon(settings, note).run()


def _token(file: Path) -> str:
    """Return the token in the store; at the first start, make a token that only its owner can
    read."""
    file.parent.mkdir(parents=True, exist_ok=True)
    try:
        handle = os.open(file, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600)
    except FileExistsError:
        return file.read_text(encoding="ascii").strip()
    token = secrets.token_urlsafe(_TOKEN_BYTES)
    with os.fdopen(handle, "w", encoding="ascii") as opened:
        opened.write(token + "\n")
    return token


@device.command("status", short_help="Show the state of a running daemon.")
@click.argument("port", default="")
def status(port: str) -> None:
    """Show the counters and the latest turn of a daemon.

    PORT is the serial port of the daemon (default: any daemon on this machine), or HOST:PORT with
    the token in ARCTRUE_DEVICE_TOKEN. Exit code 2: no daemon answers.
    """
    daemon = daemon_of(port) if port else announced_at("")
    if daemon is None:
        tell_error(f"no daemon runs{f' on {port}' if port else ''}; start: arctrue device run PORT")
        sys.exit(NO_DEVICE)
    try:
        found = ask(daemon, "status")
    except ConsoleError as error:
        tell_error(str(error))
        sys.exit(NO_DEVICE)
    latest = found.pop("latest") or {}
    for name, value in found.items():
        shown = ", ".join(value) or "none" if isinstance(value, list | dict) else value
        say(f"{name.replace('_', ' ')}: {shown}")
    if latest:
        say(f"latest turn: {latest['turn']}, {latest['result']}")


@device.command("files", short_help="Write a record as NeXus files, one a day.")
@click.argument("record", type=click.Path(path_type=Path, dir_okay=False, exists=True))
@click.argument("folder", type=OutputFolder())
def files(record: Path, folder: Path) -> None:
    """Write each day of RECORD (telemetry.sqlite) to FOLDER as an HDF5 file in NeXus form.

    Files that already have all turns of their day are not written again. Exit code 2: RECORD cannot
    be read, FOLDER cannot be written, or a daemon writes its files to FOLDER.
    """
    from arctrue.device.nexus_days import UnfinishedFileError, recorded_days, write_missing_days

    try:
        recorded_days(record)  # FOLDER is made only for a record
        with _only_writer(folder):
            for path in write_missing_days(record, folder):
                say(str(path))
    except sqlite3.Error as error:
        if error.sqlite_errorcode in (sqlite3.SQLITE_NOTADB, sqlite3.SQLITE_ERROR):
            tell_error(
                f"{record}: is no record of arctrue device run ({error}); name the file "
                "telemetry.sqlite in the folder of its --store"
            )
        else:
            tell_error(f"{record}: cannot be read: {error}")
        sys.exit(NO_DEVICE)
    except UnfinishedFileError as error:
        tell_error(sentence(error))
        sys.stdout.flush()
        sys.stderr.flush()
        os._exit(NO_DEVICE)  # HDF5 cannot close the file
    except (ConsoleError, OSError) as error:
        tell_error(sentence(error))
        sys.exit(NO_DEVICE)


@contextlib.contextmanager
def _only_writer(folder: Path) -> Iterator[None]:
    """Keep daemons from writing to a folder of daily files. Raises ConsoleError if one does."""
    if sys.platform == "win32":  # no daemon runs there
        yield
        return
    from arctrue.device.daemon.store_lock import StoreLock

    folder.mkdir(parents=True, exist_ok=True)
    lock = StoreLock.of_files(folder, "arctrue device files", "it writes missing files itself")
    try:
        yield
    finally:
        lock.release()


@device.command("unit", short_help="Write the systemd unit and the udev rule.")
@click.argument("folder", type=OutputFolder())
def unit(folder: Path) -> None:
    """Write arctrue-device@.service and 70-arctrue.rules to FOLDER.

    The first line of each file states the folder in which to install it.
    """
    try:
        for file in sorted(SHIPPED.iterdir()):
            text = file.read_text(encoding="utf-8").replace("@ARCTRUE@", _program())
            write_whole_text(folder / file.name, text)
            say(str(folder / file.name))
        if Path(_program()).is_relative_to("/home") or Path(_program()).is_relative_to("/root"):
            tell_warning(
                f"{_program()}: a service cannot read home folders; install arctrue elsewhere, for "
                "example in /opt/arctrue, and run this command of that installation"
            )
    except OSError as error:
        tell_error(sentence(error))
        sys.exit(NO_DEVICE)


def _program() -> str:
    """Return the path of the command ``arctrue`` of this installation."""
    return str(Path(sys.executable).with_name("arctrue"))


@device.command("epics", short_help="Serve a device as EPICS PVs.")
@click.argument("port")
@click.option(
    "--prefix", default="ARCTRUE:", show_default=True, help="Prefix of the name of every PV."
)
@click.option(
    "--interface",
    default="127.0.0.1",
    show_default=True,
    help="Address of the network interface. At any address except the default, other machines can "
    "connect.",
)
@click.option(
    "--allow-control", is_flag=True, help="Let every client write to the PVs Capture and Zero."
)
def epics(port: str, prefix: str, interface: str, allow_control: bool) -> None:
    """Serve the device at PORT, which arctrue device run owns, over Channel Access and PVAccess.

    PVs have no tokens: every machine that reaches the interface can read them. While the daemon
    does not run, the PVs are INVALID. Exit code 2: softioc is missing.
    """
    optional("softioc")
    from arctrue.device.epics_server import serve_pvs

    if interface not in LOOPBACK:
        tell_warning(f"{interface} can be reached by other machines, and PVs have no tokens")
    try:
        serve_pvs(lambda: daemon_of(port), prefix, interface, note, allow_control=allow_control)
    except OSError as error:
        tell_error(sentence(error))
        sys.exit(NO_DEVICE)
    except KeyboardInterrupt:
        return
