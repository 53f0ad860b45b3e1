"""Turns the virtual instrument's table in a thread, and serves its console at a serial port."""

from __future__ import annotations

import queue
import threading
import time
from collections.abc import Callable

from arctrue.instrument import Firmware, Instrument
from arctrue.instrument.serial_port import SerialPort


class Turning(threading.Thread):
    """A thread that turns the table until turn ``last`` of the telemetry, and serves ``port`` until
    the test calls ``end``."""

    def __init__(self, instrument: Instrument, poll_clocks: int) -> None:
        super().__init__(daemon=True)
        self.instrument, self.firmware = instrument, instrument.firmware
        self.port = SerialPort(instrument.firmware)
        self.last = 0
        self._poll_clocks = poll_clocks
        self._ended = False
        self._failure: BaseException | None = None
        self._orders: queue.SimpleQueue[Callable[[Firmware], object]] = queue.SimpleQueue()

    def order(self, work: Callable[[Firmware], object]) -> None:
        """Make the thread call ``work`` with the firmware."""
        self._orders.put(work)

    def turns(self) -> int:
        return max((int(line["turn"]) for line in self.firmware.telemetry), default=0)

    def end(self) -> None:
        """End the thread and close the instrument; a failure of the thread fails the test."""
        self._ended = True
        self.join(60.0)
        assert self._failure is None, self._failure
        assert not self.is_alive()

    def run(self) -> None:
        try:
            self._serve()
        except BaseException as error:
            self._failure = error
            raise
        finally:
            self.port.close()
            self.instrument.close()

    def _serve(self) -> None:
        while not self._ended:
            self.port.exchange()
            while not self._orders.empty():
                self._orders.get()(self.firmware)
            if self.turns() < self.last:
                self.firmware.run(self._poll_clocks, poll_clocks=self._poll_clocks)
            else:
                # Now the table turns only during the bus accesses of commands on the console.
                time.sleep(0.005)
