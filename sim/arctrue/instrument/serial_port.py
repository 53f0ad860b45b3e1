"""Connects the console of the virtual instrument to other programs by a pseudo-terminal, which acts
as its serial port."""

from __future__ import annotations

import os
import pty
import tty
from collections import deque

from arctrue.instrument.firmware import Firmware

MOST_BYTES = 1 << 20
"""Largest number of bytes that wait for a slow reader; output that exceeds this number is lost, as
on a serial line."""


class SerialPort:
    """A pseudo-terminal that connects the firmware's console with a program that opens ``name``.

    The console receives characters only within :meth:`exchange`: call it between rounds of the
    firmware's main loop.
    """

    def __init__(self, firmware: Firmware) -> None:
        """Open the pseudo-terminal. Raises OSError."""
        self._firmware = firmware
        self._end, far = pty.openpty()
        tty.setraw(far)
        self.name = os.ttyname(far)
        """Path of the port for other programs; one program at a time may open it."""
        os.close(far)
        os.set_blocking(self._end, False)
        self._waiting: deque[bytes] = deque()
        self._size = 0
        firmware.listener = self._print

    def exchange(self) -> None:
        """Pass received characters to the console, and send the console's output to the port."""
        try:
            received = os.read(self._end, 4096)
        except OSError:  # the other program sent nothing, or no program has the port open
            received = b""
        if received:
            self._firmware.type(received.replace(b"\0", b""))
        while self._waiting:
            data = self._waiting[0]
            try:
                written = os.write(self._end, data)
            except OSError:  # the reader is slow, or no program has the port open
                return
            self._size -= written
            if written < len(data):
                self._waiting[0] = data[written:]
                return
            self._waiting.popleft()

    def close(self) -> None:
        """Close the port; a program that has it open gets an error."""
        self._firmware.listener = None
        os.close(self._end)

    def _print(self, text: str) -> None:
        data = text.encode()
        if self._size + len(data) <= MOST_BYTES:
            self._waiting.append(data)
            self._size += len(data)
