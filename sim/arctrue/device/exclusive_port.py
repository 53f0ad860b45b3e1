"""Reserves a serial port for one program; with two readers, each would receive parts of lines."""

from __future__ import annotations

import os
import sys
from pathlib import Path
from typing import Any

if sys.platform == "win32":
    PORT_ERRORS: tuple[type[Exception], ...] = (OSError, ValueError)
else:
    import fcntl
    import termios

    PORT_ERRORS: tuple[type[Exception], ...] = (OSError, ValueError, termios.error)
    """Exceptions of pyserial when a port cannot be opened; its own SerialException is an OSError,
    termios.error is not."""

COMMAND_SHOWN = 200
"""Largest number of characters of another program's command line that a message shows."""


def keep_others_out(port: Any) -> None:
    """Prevent all other programs, except the administrator's, from opening ``port``.

    The lock that pyserial sets with ``exclusive`` works only against programs that also set it. A
    port that is not a terminal (a URL of pyserial, a port of Windows) is not locked.
    """
    descriptor = _descriptor(port)
    if descriptor is not None:
        fcntl.ioctl(descriptor, termios.TIOCEXCL)


def let_others_in(port: Any) -> None:
    """Undo :func:`keep_others_out`; otherwise a pseudo-terminal would keep the lock after it is
    closed."""
    descriptor = _descriptor(port)
    if descriptor is not None:
        fcntl.ioctl(descriptor, termios.TIOCNXCL)


def _descriptor(port: Any) -> int | None:
    if sys.platform == "win32":
        return None
    number = getattr(port, "fd", None)
    return number if isinstance(number, int) and os.isatty(number) else None


def other_users(port: str) -> list[str]:
    """Return the other programs that have ``port`` open, each as ``COMMAND LINE (process NUMBER)``.

    Linux shows a user only the user's own programs, and shows an administrator all programs; on
    other systems the list is empty.
    """
    try:
        wanted = Path(port).resolve(strict=True)
        processes = [entry for entry in Path("/proc").iterdir() if entry.name.isdigit()]
    except OSError:
        return []
    others = [entry for entry in processes if int(entry.name) != os.getpid()]
    return [_named(entry) for entry in others if _has_open(entry, wanted)]


def _has_open(process: Path, file: Path) -> bool:
    try:
        return any(_target(link) == str(file) for link in (process / "fd").iterdir())
    except OSError:
        return False


def _target(link: Path) -> str:
    try:
        return str(link.readlink())
    except OSError:
        return ""


def _named(process: Path) -> str:
    try:
        words = (process / "cmdline").read_bytes().rstrip(b"\0").split(b"\0")
    except OSError:
        words = []
    line = b" ".join(words).decode("utf-8", "replace") or "a program"
    return f"{line[:COMMAND_SHOWN]} (process {process.name})"
