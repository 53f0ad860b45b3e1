"""Connects the serial port to the event loop: opens the port exclusively, and opens it again after
the port vanished."""

from __future__ import annotations

import asyncio
import os
from collections.abc import Callable

from arctrue.device.port import ConsoleError, SerialTransport

FIRST_WAIT_S, LONGEST_WAIT_S = 0.5, 10.0
"""Shortest and longest wait in seconds between attempts to open the port again; each wait is twice
the previous one, up to the longest."""
MOST_UNSENT_BYTES = 65_536
_BLOCK = 65_536


class SerialLink:
    """Passes received bytes to ``received``, and changes of the connection to ``changed``."""

    def __init__(
        self,
        port: str,
        baud: int,
        received: Callable[[bytes], None],
        changed: Callable[[bool, str], None],
    ) -> None:
        """Store the callbacks; ``changed`` receives whether the port is open, and a sentence."""
        self._port, self._baud = port, baud
        self._received, self._changed = received, changed
        self._transport: SerialTransport | None = None
        self._unsent = b""
        self._lost = asyncio.Event()

    def open(self) -> None:
        """Open the port. Raises ConsoleError, also if another program has the port open."""
        loop = asyncio.get_running_loop()
        transport = SerialTransport(self._port, 0.0, self._baud)
        try:
            number = transport.fileno()
        except OSError as error:
            transport.close()
            raise ConsoleError(f"{self._port}: expected a serial port: {error.strerror}") from error
        try:
            os.set_blocking(number, False)
            loop.add_reader(number, self._read, number)
        except OSError as error:
            transport.close()
            raise ConsoleError(f"{self._port}: cannot be read: {error.strerror}") from error
        self._transport, self._unsent = transport, b""
        self._lost.clear()
        self._changed(True, f"{self._port}: open")

    async def keep_open(self) -> None:
        """Open the port again whenever it is lost; this method runs until it is cancelled."""
        while True:
            await self._lost.wait()
            wait_s = FIRST_WAIT_S
            while True:
                await asyncio.sleep(wait_s)
                try:
                    self.open()
                except ConsoleError:
                    wait_s = min(2 * wait_s, LONGEST_WAIT_S)
                else:
                    break

    def write(self, data: bytes) -> None:
        """Send the data as soon as the port accepts it; while no port is open, the data is
        discarded. If too many bytes wait to be sent, the port is treated as lost."""
        if self._transport is None:
            return
        waiting = bool(self._unsent)
        if len(self._unsent) + len(data) > MOST_UNSENT_BYTES:
            self._lose("the device accepts no bytes")
            return
        self._unsent += data
        if not waiting:
            self._send()

    def _send(self) -> None:
        if self._transport is None:
            return
        number = self._transport.fileno()
        try:
            self._unsent = self._unsent[os.write(number, self._unsent) :]
        except BlockingIOError:
            pass
        except OSError as error:
            self._lose(error.strerror)
            return
        loop = asyncio.get_running_loop()
        if self._unsent:
            loop.add_writer(number, self._send)
        else:
            loop.remove_writer(number)

    def _read(self, number: int) -> None:
        try:
            data = os.read(number, _BLOCK)
        except BlockingIOError:
            return
        except OSError as error:
            self._lose(error.strerror)
            return
        if data:
            self._received(data)
        else:
            self._lose("the port has vanished")

    def _lose(self, why: str | None) -> None:
        self.close()
        self._lost.set()
        self._changed(False, f"{self._port}: lost: {why}")

    def close(self) -> None:
        """Close the port; ``keep_open`` opens only a lost port again, not a closed one."""
        if self._transport is None:
            return
        loop = asyncio.get_running_loop()
        number = self._transport.fileno()
        loop.remove_reader(number)
        loop.remove_writer(number)
        self._transport.close()
        self._transport = None
