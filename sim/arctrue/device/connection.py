"""Connects to a device's daemon, to receive its events or to use the console alone."""

from __future__ import annotations

import json
import os
import socket
import time
from collections.abc import Callable
from typing import Any

import msgspec

from arctrue.device.announcement import Announcement, announced, announced_at
from arctrue.device.console import Console, ConsoleError
from arctrue.device.lines import LineAssembler, TelemetryLine

TOKEN_VARIABLE = "ARCTRUE_DEVICE_TOKEN"
"""Environment variable with the token of a daemon on another machine."""
CONNECT_S = 5.0
_BLOCK = 65_536


class DaemonTransport:
    """Transfers bytes to and from the device through the device's daemon."""

    def __init__(self, connection: socket.socket, timeout_s: float, begun: bytes = b"") -> None:
        """Store an open connection; ``begun`` contains bytes that were already received."""
        connection.settimeout(timeout_s)
        self._connection, self._timeout_s, self._begun = connection, timeout_s, begun

    @property
    def unread(self) -> bytes:
        """Return the received bytes that were not read yet."""
        return self._begun

    def write(self, data: bytes, /) -> int | None:
        """Send all of ``data``. Raises OSError."""
        self._connection.sendall(data)
        return len(data)

    def read_until(self, expected: bytes = b"\n", /) -> bytes:
        """Return the bytes up to ``expected``; fewer bytes if they do not arrive in time.

        Raises OSError if the daemon ended the connection.
        """
        end = time.monotonic() + self._timeout_s
        while expected not in self._begun:
            try:
                self._connection.settimeout(max(end - time.monotonic(), 0.001))
                data = self._connection.recv(_BLOCK)
            except TimeoutError:
                part, self._begun = self._begun, b""
                return part
            if not data:
                raise ConnectionError("the program that owns the port ended the connection")
            self._begun += data
        line, _, self._begun = self._begun.partition(expected)
        return line + expected

    def close(self) -> None:
        """Close the connection."""
        self._connection.close()


class Watch:
    """Reads the events of a daemon one after the other; any number of programs may read them at
    once."""

    def __init__(self, daemon: Announcement, latest: int = 0) -> None:
        """Connect; the daemon first sends the ``latest`` recorded turns. Raises ConsoleError."""
        self.daemon = daemon
        request = {"ask": "watch", "latest": latest}
        connection, rest, answer = _connected(daemon, request, CONNECT_S)
        self.earlier = int(answer.get("earlier", 0))
        """Number of recorded turns that the daemon sends first."""
        self._transport = DaemonTransport(connection, 0.5, rest)
        self._lines = LineAssembler()

    def event(self, seconds: float) -> dict[str, Any] | None:
        """Return the next event; None if none arrives within ``seconds``. Raises ConsoleError."""
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            try:
                lines = self._lines.add(self._transport.read_until(b"\n"))
            except OSError as error:
                raise ConsoleError(f"{self.daemon.port}: {error}") from error
            for line in lines:
                found: dict[str, Any] = json.loads(line)
                return found
        return None

    def turn(self, seconds: float) -> TelemetryLine | None:
        """Return the next line of telemetry; None if none arrives within ``seconds``. Raises
        ConsoleError."""
        end = time.monotonic() + seconds
        while (left := end - time.monotonic()) > 0:
            event = self.event(left)
            if event is not None and event["event"] == "turn":
                return TelemetryLine(event["telemetry"])
        return None

    def close(self) -> None:
        """Close the connection."""
        self._transport.close()


def ask(
    daemon: Announcement, what: str, seconds: float = CONNECT_S, **content: Any
) -> dict[str, Any]:
    """Send the daemon a request, ``status``, ``capture``, ``life`` or ``zero``; return the answer.

    ``content``: further values for the request. Raises ConsoleError.
    """
    connection, _, answer = _connected(daemon, {"ask": what, **content}, seconds)
    connection.close()
    return answer


def daemon_of(port: str) -> Announcement | None:
    """Return the running daemon that owns ``port``, or else the daemon or None that ``daemon_at``
    returns."""
    return announced(port) or daemon_at(port)


def daemon_at(address: str) -> Announcement | None:
    """Return the daemon at HOST:PORT on any machine; None if ``address`` has another form.

    The token of a daemon on another machine is read from the environment; the function does not
    check whether this daemon runs.
    """
    host, colon, number = address.rpartition(":")
    if not colon or not host or "/" in address or not number.isdigit():
        return None
    token = os.environ.get(TOKEN_VARIABLE, "")
    return announced_at(address) or Announcement(address, host.strip("[]"), int(number), token, 0)


def open_console(port: str, report: Callable[[str], None]) -> Console:
    """Open the console of the device at ``port``, through the device's daemon if one is running.

    ``report`` gets one sentence if a daemon is used. Raises ConsoleError.
    """
    daemon = daemon_of(port)
    if daemon is None:
        return Console(port)
    report(through(port, daemon))
    return console_through(daemon)


def console_through(daemon: Announcement) -> Console:
    """Open the console of a device through its daemon. Raises ConsoleError, also if another
    operator uses the console."""
    connection, rest = _greeted(daemon, {"ask": "console"})
    return Console(daemon.port, transport=DaemonTransport(connection, 1.0, rest))


def through(port: str, daemon: Announcement) -> str:
    """Return the sentence for the user that a daemon connects to the device."""
    process = f"process {daemon.process}, " if daemon.process else ""
    return f"{port}: through its daemon ({process}{daemon.address})"


def _greeted(daemon: Announcement, request: dict[str, Any]) -> tuple[socket.socket, bytes]:
    return _connected(daemon, request, CONNECT_S)[:2]


def _connected(
    daemon: Announcement, request: dict[str, Any], seconds: float
) -> tuple[socket.socket, bytes, dict[str, Any]]:
    """Send the request; return the connection, the bytes that followed the answer, and the
    answer."""
    line = msgspec.json.encode({**request, "token": daemon.token}) + b"\n"
    connection = None
    try:
        connection = socket.create_connection((daemon.host, daemon.tcp_port), CONNECT_S)
        connection.sendall(line)
        transport = DaemonTransport(connection, seconds)
        answer: dict[str, Any] = json.loads(transport.read_until(b"\n"))
    except (OSError, ValueError) as error:
        if connection is not None:
            connection.close()
        raise ConsoleError(f"{daemon.port}: its daemon at {daemon.address}: {error}") from error
    if "error" in answer:
        connection.close()
        raise ConsoleError(f"{daemon.port}: {answer['error']}")
    return connection, transport.unread, answer
