"""Simulates the processor of the core: runs the firmware's C code, compiled for this machine.

Every register access of the C code becomes an AXI4-Lite access in the simulation. The calculations
of the C code take no simulated time.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar

import numpy as np
from cocotb.handle import HierarchyObject
from cocotb.task import bridge, resume
from cocotb.triggers import First, RisingEdge, Timer
from cocotbext.axi import AxiLiteBus, AxiLiteMaster, AxiResp
from numpy.typing import NDArray
from sim.tests.firmware.library import firmware
from sim.tests.firmware.model_core import Firmware

from arctrue.generated.registers import CAPTURE_ADDRESS

Answer = TypeVar("Answer")


class BusError(RuntimeError):
    """Raised if the core answers an access with an error."""


class SimulatedCore:
    """Performs the register accesses of the firmware, which runs in another thread, on the
    simulated bus."""

    def __init__(self, dut: HierarchyObject, on_capture: Callable[[], None]) -> None:
        """Connect to ``dut``; ``on_capture`` is called before each read of a captured bank."""
        self._master = AxiLiteMaster(AxiLiteBus.from_prefix(dut, "s_axil"), dut.clock, dut.reset)
        for interface in (self._master.write_if, self._master.read_if):
            interface.log.setLevel("WARNING")
        self._on_capture = on_capture
        self.words_moved = 0
        self.banks: list[NDArray[np.int32]] = []
        """Captured words of each bank that the firmware has read."""
        self.error: BusError | None = None
        """First error of an access, stored here because an exception cannot pass through the C
        code."""
        ffi, _ = firmware()
        self._calls = (
            ffi.callback("core_read_word", self._read),
            ffi.callback("core_write_word", self._write),
            ffi.callback("core_capture_words", self._capture),
        )
        self.access = ffi.new("struct core_access *", list(self._calls))

    def _read(self, _: Any, offset: int) -> int:
        return int.from_bytes(self._bytes(offset, 1), "little")

    def _bytes(self, offset: int, words: int) -> bytes:
        self.words_moved += words
        answer = resume(self._master.read)(offset, 4 * words)
        self._judge(answer.resp, f"read of {words} words at 0x{offset:05X}")
        return bytes(answer.data)

    def _write(self, _: Any, offset: int, word: int) -> None:
        self.words_moved += 1
        answer = resume(self._master.write)(offset, word.to_bytes(4, "little"))
        self._judge(answer.resp, f"write at 0x{offset:05X}")

    def _judge(self, response: AxiResp, what: str) -> None:
        if response != AxiResp.OKAY and self.error is None:
            self.error = BusError(f"{what} answered {response!r}")

    def _capture(self, _: Any, number: int) -> Any:
        # On the device the processor reads words in the capture memory itself, some of them many
        # times; here each word is read over the bus once.
        self._on_capture()
        bank = np.frombuffer(self._bytes(CAPTURE_ADDRESS, number), dtype="<i4").copy()
        self.banks.append(bank)
        return firmware()[0].cast("int32_t *", bank.ctypes.data)


class Processor:
    """Runs the firmware's application and console on the simulated core."""

    def __init__(self, dut: HierarchyObject, on_capture: Callable[[], None]) -> None:
        self._interrupt = dut.interrupt
        self._clock = dut.clock
        self.core = SimulatedCore(dut, on_capture)
        self._firmware = Firmware(self.core)

    async def _call(self, function: Callable[[], Answer]) -> Answer:
        answer: Answer = await bridge(function)()
        if self.core.error is not None:
            raise self.core.error
        return answer

    async def start(self) -> None:
        """Start the firmware as the processor does after a reset."""
        library, application = self._firmware.library, self._firmware.application
        await self._call(lambda: library.application_start(application))

    async def type(self, line: str) -> str:
        """Type a line on the firmware's console; return the answer."""
        return await self._call(lambda: self._firmware.send(line))

    async def work(self) -> str:
        """Run the main loop of firmware/board/main.c once; return the console's output."""
        if self._interrupt.value == 1:
            library, application = self._firmware.library, self._firmware.application
            await self._call(lambda: library.application_interrupt(application))
        return await self._call(self._firmware.step)

    async def sleep(self, most_ns: int) -> None:
        """Sleep until an interrupt of the core, at most ``most_ns``; return at a rising edge of the
        clock."""
        await First(RisingEdge(self._interrupt), Timer(most_ns, "ns"))
        await RisingEdge(self._clock)

    @property
    def phase(self) -> str:
        """Return the phase of the firmware's application."""
        return self._firmware.phase

    @property
    def swaps(self) -> int:
        """Return the number of banks that the application has swapped since its start."""
        return int(self._firmware.application.swaps)

    async def settled(self) -> bool:
        """Tell whether the firmware's own coefficients are active and their ramp has ended."""
        library = self._firmware.library
        status = await self._call(lambda: library.core_status(self.core.access))
        return bool(self.swaps and status.compensating and not status.ramp_busy)
