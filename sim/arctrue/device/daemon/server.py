"""Serves events to any number of watchers, and the console to one operator at a time, over TCP.

The first line of a client is JSON: ``ask`` (``watch``, ``console``, ``status``, ``capture``,
``life``, ``zero``) and ``token``. The first line of the answer is JSON too: ``{"error": …}`` or the
requested data. The same port answers the HTTP request ``GET /metrics``.
"""

from __future__ import annotations

import asyncio
import contextlib
import hmac
import json
from collections.abc import Awaitable, Callable
from typing import Any

from arctrue.device.daemon.console_rights import refusal_of
from arctrue.device.daemon.metrics import CONTENT_TYPE, metrics_text
from arctrue.device.daemon.settings import DaemonSettings
from arctrue.device.daemon.state import DaemonState
from arctrue.device.recorder import RecordedTurn

FIRST_LINE_S = 5.0
MOST_REQUEST_BYTES = 65_536
"""Largest length of a request in bytes; the longest request contains the alarms of a machine's
history."""
MOST_UNREAD_BYTES = 1_000_000
"""Largest number of unread bytes; a client with more is disconnected, so that the daemon never
waits for it."""
MOST_CLIENTS = 64
MOST_HEADERS = 100
MOST_LATEST = 5_000
_LATEST_S = 10.0
"""Longest time in seconds that a watcher may take to read the earlier turns."""
Answer = Callable[[], Awaitable[dict[str, Any]]]
Writer = asyncio.StreamWriter


class Server:
    """Serves the clients of one device."""

    def __init__(
        self,
        settings: DaemonSettings,
        state: DaemonState,
        write: Callable[[bytes], None],
        turns: Callable[[int, int], list[RecordedTurn]],
        capture: Answer,
        life: Callable[[Any], dict[str, Any]],
        zero: Callable[[Any], dict[str, Any]],
    ) -> None:
        """Store the callbacks: ``write`` sends bytes to the device; ``capture`` captures a turn.

        ``life`` takes the alarms of a machine's history and returns the answer; ``zero`` takes the
        angle of another axis at the index, degrees.

        ``turns`` reads the latest turns of the record; its arguments are the largest number of
        turns and the id after which they begin.
        """
        self._settings, self._state = settings, state
        self._write, self._turns, self._capture = write, turns, capture
        self._life, self._zero = life, zero
        self._watchers: set[Writer] = set()
        self._operator: Writer | None = None
        self._line_begun, self._refusals = False, b""
        self._clients = 0
        self._server: asyncio.Server | None = None
        self.console_free = asyncio.Condition()

    async def start(self) -> tuple[str, int]:
        """Open the listening socket; return host and port. Raises OSError."""
        self._server = await asyncio.start_server(
            self._serve, self._settings.host, self._settings.tcp_port, limit=MOST_REQUEST_BYTES
        )
        address = self._server.sockets[0].getsockname()
        return str(address[0]), int(address[1])

    def broadcast(self, event: dict[str, Any]) -> None:
        """Send an event to all watchers."""
        line = _line(event)
        for watcher in list(self._watchers):
            self._send(watcher, line)

    def to_operator(self, data: bytes) -> None:
        """Send the device's bytes to the operator's console.

        A refusal waits for the end of the device's line; in the middle of the line it would damage
        the line.
        """
        line, end, others = data.partition(b"\n")
        if self._refusals and end:
            data, self._refusals = line + end + self._refusals + others, b""
        self._line_begun = not data.endswith(b"\n")
        if self._operator is not None:
            self._send(self._operator, data)

    def forget_begun(self) -> None:
        """Treat the next byte from the device as the first byte of a line, because the port was
        lost."""
        self._line_begun = False

    def _refuse(self, operator: Writer, text: str) -> None:
        """Send the operator the refusal of a line, between two lines from the device."""
        line = f"error: {text}\r\n".encode()
        if self._line_begun:
            self._refusals += line
        else:
            self._send(operator, line)

    def _send(self, client: Writer, data: bytes) -> None:
        if client.is_closing():
            return
        client.write(data)
        if client.transport.get_write_buffer_size() > MOST_UNREAD_BYTES:
            self._state.dropped_clients += 1
            client.transport.abort()

    async def _serve(self, reader: asyncio.StreamReader, writer: Writer) -> None:
        self._clients += 1
        try:
            await self._serve_client(reader, writer)
        except (OSError, TimeoutError, ValueError, asyncio.LimitOverrunError):
            pass  # the client has disconnected, or has sent no request
        finally:
            self._clients -= 1
            self._watchers.discard(writer)
            self._state.watchers = len(self._watchers)
            if self._operator is writer:
                await self._release()
            writer.close()
            with contextlib.suppress(OSError):
                await writer.wait_closed()

    async def _serve_client(self, reader: asyncio.StreamReader, writer: Writer) -> None:
        if self._clients > MOST_CLIENTS:
            return
        line = await asyncio.wait_for(reader.readline(), FIRST_LINE_S)
        if line.startswith((b"GET ", b"HEAD ")):
            await self._http(line, reader, writer)
            return
        request = _request(line)
        token = str(request.get("token", "")).encode(errors="surrogatepass")
        if not hmac.compare_digest(token, self._token):
            writer.write(
                _line(
                    {
                        "error": "the token is wrong; the file token in the daemon's --store has "
                        "the right one"
                    }
                )
            )
            return
        asked = request.get("ask")
        if asked == "watch":
            latest = request.get("latest", 0)
            if isinstance(latest, bool) or not isinstance(latest, int) or latest < 0:
                found = str(latest)[:40]
                text = f"latest: expected a whole number from 0, found {found}"
                writer.write(_line({"error": text}))
                return
            await self._watch(reader, writer, latest)
        elif asked == "console":
            await self._console(reader, writer)
        elif asked == "status":
            writer.write(_line(self._state.as_dict()))
        elif asked == "capture":
            writer.write(_line(await self._capture()))
        elif asked == "life":
            writer.write(_line(self._life(request.get("alarms"))))
        elif asked == "zero":
            writer.write(_line(self._zero(request.get("degrees"))))
        else:
            known = "watch, console, status, capture, life or zero"
            writer.write(_line({"error": f"no request {str(asked)[:40]!r}; expected {known}"}))

    async def _http(
        self, line: bytes, reader: asyncio.StreamReader, writer: asyncio.StreamWriter
    ) -> None:
        """Answer ``GET /metrics`` if the header ``Authorization: Bearer`` contains the token."""
        given = b""
        for _ in range(MOST_HEADERS):
            header = await asyncio.wait_for(reader.readline(), FIRST_LINE_S)
            if not header.strip():
                break
            name, _, value = header.partition(b":")
            if name.strip().lower() == b"authorization":
                given = value.strip().removeprefix(b"Bearer ").strip()
        path = line.split()[1:2]
        if not hmac.compare_digest(given, self._token):
            status, text = "401 Unauthorized", "send the token: Authorization: Bearer TOKEN\n"
        elif not path:
            status, text = "400 Bad Request", "expected a path, such as GET /metrics\n"
        elif path[0].partition(b"?")[0] != b"/metrics":
            status, text = "404 Not Found", "there is /metrics only\n"
        else:
            status, text = "200 OK", metrics_text(self._state)
        body = text.encode()
        head = [
            f"HTTP/1.1 {status}",
            f"Content-Type: {CONTENT_TYPE}",
            f"Content-Length: {len(body)}",
            "Connection: close",
        ]
        if status.startswith("401"):
            head.append("WWW-Authenticate: Bearer")
        writer.write("\r\n".join([*head, "", ""]).encode())
        writer.write(body if line.startswith(b"GET ") else b"")

    @property
    def _token(self) -> bytes:
        return self._settings.token.encode()

    async def _watch(self, reader: asyncio.StreamReader, writer: Writer, latest: int) -> None:
        earlier = self._turns(min(latest, MOST_LATEST), 0) if latest > 0 else []
        writer.write(_line({"watching": self._settings.port, "earlier": len(earlier)}))
        if latest > 0:
            last = 0
            for turn in earlier:
                writer.write(_line(turn_event(turn.recorded_s, turn.id, turn.fields)))
                last = turn.id
            await asyncio.wait_for(writer.drain(), _LATEST_S)
            for turn in self._turns(MOST_LATEST, last):  # turns recorded in the meantime
                writer.write(_line(turn_event(turn.recorded_s, turn.id, turn.fields)))
        self._watchers.add(writer)
        self._state.watchers = len(self._watchers)
        while await reader.read(MOST_REQUEST_BYTES):
            pass  # a watcher sends no further bytes

    async def _console(self, reader: asyncio.StreamReader, writer: Writer) -> None:
        if self._operator is not None:
            text = "the console is in use by another program: wait until it has ended"
            writer.write(_line({"error": text}))
            return
        if not self._state.connected:
            writer.write(
                _line({"error": "the serial port is lost; the daemon tries to open it again"})
            )
            return
        self._operator = writer
        self._state.console_in_use = True
        writer.write(_line({"console": self._settings.port}))
        begun = b""
        while data := await reader.read(MOST_REQUEST_BYTES):
            # A line ends with CR or LF; an incomplete line stays in ``begun`` until it is complete.
            *lines, begun = (begun + data).replace(b"\n", b"\r").split(b"\r")
            if len(begun) > MOST_REQUEST_BYTES:
                return
            for line in lines:
                refusal = None if self._settings.allow_control else refusal_of(line)
                if refusal is None:
                    self._write(line + b"\r")
                else:
                    self._refuse(writer, refusal)

    async def _release(self) -> None:
        self._operator, self._refusals = None, b""
        self._state.console_in_use = False
        # The operator may have switched telemetry off or left an incomplete line.
        self._write(b"\rtelemetry on\r")
        async with self.console_free:
            self.console_free.notify_all()

    async def close(self) -> None:
        """Stop listening, and close the connections of the watchers and the operator."""
        if self._server is not None:
            self._server.close()
        for client in [*self._watchers, *filter(None, [self._operator])]:
            client.transport.abort()


def turn_event(recorded_s: float, identifier: int | None, fields: dict[str, Any]) -> dict[str, Any]:
    """Return the event for one line of telemetry; an event without an id is not in the record."""
    return {"event": "turn", "recorded_s": recorded_s, "id": identifier, "telemetry": fields}


def _line(content: dict[str, Any]) -> bytes:
    """Return one line of ASCII, because a client may process it like a line of the device."""
    return json.dumps(content).encode() + b"\n"


def _request(line: bytes) -> dict[str, Any]:
    """Read the first line of a client, a request. Raises ValueError."""
    try:
        found = json.loads(line)
    except RecursionError:
        raise ValueError("expected an object, found too many levels") from None
    if not isinstance(found, dict):
        raise ValueError("expected an object")
    return found
