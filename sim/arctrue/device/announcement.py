"""Publishes the address of a daemon that owns a serial port, in a file that only some users can
read."""

from __future__ import annotations

import os
import socket
import stat
from collections.abc import Iterator
from pathlib import Path

import msgspec

from arctrue.base.whole_file import write_whole_text

FOLDER_VARIABLE = "ARCTRUE_RUN"
SYSTEM_FOLDER = Path("/run/arctrue")
"""Folder in which systemd makes a folder for each service (RuntimeDirectory)."""
_REACH_S = 2.0


class Announcement(msgspec.Struct, frozen=True):
    """Serial port, address and token of a daemon."""

    port: str
    host: str
    tcp_port: int
    token: str
    process: int

    @property
    def address(self) -> str:
        """Return HOST:PORT."""
        return address_of(self.host, self.tcp_port)


def address_of(host: str, port: int) -> str:
    """Return HOST:PORT, with an IPv6 host in brackets."""
    return f"[{host}]:{port}" if ":" in host else f"{host}:{port}"


def own_folder() -> Path:
    """Return the folder of this user's announcement files."""
    named = os.environ.get(FOLDER_VARIABLE) or os.environ.get("RUNTIME_DIRECTORY")
    if named:
        return Path(named)
    base = os.environ.get("XDG_RUNTIME_DIR")
    if base:
        return Path(base) / "arctrue"
    # The folder above it also contains the files that users drop into the page.
    return Path.home() / ".local" / "state" / "arctrue" / "run"


def announce(announcement: Announcement) -> Path:
    """Write the announcement file; only the user and the folder's group can read it. Raises
    OSError."""
    folder = own_folder()
    folder.mkdir(mode=0o750, parents=True, exist_ok=True)
    if folder.stat().st_mode & stat.S_IWOTH:
        raise PermissionError(0, f"{folder}: everybody can write to it; choose another folder")
    file = folder / (_name(announcement.port) + ".json")
    before = os.umask(0o027)
    try:
        write_whole_text(file, msgspec.json.encode(announcement).decode())
    finally:
        os.umask(before)
    return file


def announced(port: str) -> Announcement | None:
    """Return the announcement of the running daemon of a serial port, or None."""
    for found in _all():
        if _name(found.port) == _name(port) and _answers(found):
            return found
    return None


def announced_at(address: str) -> Announcement | None:
    """Return the announcement of this machine's daemon at HOST:PORT, or None; an empty ``address``
    means any daemon."""
    for found in _all():
        if address in ("", found.address) and _answers(found):
            return found
    return None


def _all() -> Iterator[Announcement]:
    for file in (*sorted(own_folder().glob("*.json")), *sorted(SYSTEM_FOLDER.glob("*/*.json"))):
        try:
            yield msgspec.json.decode(file.read_bytes(), type=Announcement)
        except (OSError, msgspec.MsgspecError):
            continue  # the file belongs to another user, or is not an announcement


def _answers(found: Announcement) -> bool:
    """Tell whether the daemon answers; a killed daemon leaves only its announcement."""
    try:
        socket.create_connection((found.host, found.tcp_port), _REACH_S).close()
    except OSError:
        return False
    return True


def _name(port: str) -> str:
    """Return the same name for a device whether ``port`` is the device's file or a link to it."""
    path = Path(port)
    named = str(path.resolve()) if path.exists() else port
    return named.strip("/").replace("/", "-").replace(":", "-")
