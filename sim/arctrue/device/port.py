"""Opens a serial port for one program alone, and names the program that is already using the
port."""

from __future__ import annotations

import errno
import os
from contextlib import suppress
from typing import TYPE_CHECKING, Protocol

from arctrue.base.extras import LazyModule, MissingExtraError
from arctrue.device.exclusive_port import PORT_ERRORS, keep_others_out, let_others_in, other_users

if TYPE_CHECKING:
    import serial
else:
    serial = LazyModule("serial")

BAUD = 115_200


class ConsoleError(Exception):
    """Is raised if the device does not answer, or answers something unexpected; the user sees the
    message."""


class Transport(Protocol):
    """Methods that transfer bytes to and from a device, through a serial port or its daemon.

    The methods raise OSError if the connection is lost.
    """

    def write(self, data: bytes, /) -> int | None:
        """Send all of ``data``."""

    def read_until(self, expected: bytes = b"\n", /) -> bytes:
        """Return the bytes up to ``expected``; fewer bytes if they do not arrive in time."""

    def close(self) -> None:
        """Close the connection."""


class SerialTransport:
    """A serial port that no other program, except the administrator's, can open while it is open
    here."""

    def __init__(self, port: str, timeout_s: float, baud: int = BAUD) -> None:
        """Open ``port``, a device or a URL of pyserial.

        Raises ConsoleError, which names the program that uses the port if the system reveals it,
        and MissingExtraError without pyserial.
        """
        try:
            self._serial = serial.serial_for_url(port, baud, timeout=timeout_s, exclusive=True)
        except MissingExtraError:
            raise
        except PORT_ERRORS as error:
            raise _not_opened(port, error) from error
        if users := other_users(port):
            self._serial.close()
            raise _in_use(port, users)
        try:
            keep_others_out(self._serial)
        except PORT_ERRORS as error:
            self._serial.close()
            raise _not_opened(port, error) from error

    def fileno(self) -> int:
        """Return the file descriptor of the port. Raises OSError for a port without one."""
        number = getattr(self._serial, "fd", None)
        if not isinstance(number, int):
            raise OSError(errno.ENOTSUP, "this kind of port has no file descriptor")
        return number

    def write(self, data: bytes, /) -> int | None:
        """Send all of ``data``. Raises OSError."""
        return self._serial.write(data)

    def read_until(self, expected: bytes = b"\n", /) -> bytes:
        """Return the bytes up to ``expected``; fewer bytes if they do not arrive in time."""
        return bytes(self._serial.read_until(expected))

    def close(self) -> None:
        """Close the port; other programs may then open it."""
        if self._serial.is_open:
            with suppress(OSError):  # pyserial raises it if the device has been unplugged
                let_others_in(self._serial)
        self._serial.close()


def _not_opened(port: str, error: Exception) -> ConsoleError:
    # pyserial's message repeats the port's name and the system's error; a locked port gets a
    # message of its own.
    first = error.args[0] if error.args else None  # the error of termios has no errno
    number = getattr(error, "errno", first if isinstance(first, int) else None)
    if number in (errno.EBUSY, errno.EAGAIN) or "exclusively lock" in str(error):
        return _in_use(port, other_users(port))
    why = os.strerror(number) if number else str(error)
    return ConsoleError(
        f"{port}: cannot be opened: {why}; is the device plugged in, and may you use the port?"
    )


def _in_use(port: str, users: list[str]) -> ConsoleError:
    who = " and ".join(users) or "another program, whose name the system does not show"
    return ConsoleError(f"{port}: is in use by {who}; end that program first")
