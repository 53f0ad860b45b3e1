"""The processor of the demo: everything it does passes through AXI4-Lite."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from cocotb.handle import HierarchyObject
from cocotbext.axi import AxiLiteBus, AxiLiteMaster, AxiResp

from arctrue.gateware.register_access import RegisterMap


class BusError(RuntimeError):
    """The core answered an access with an error."""


def connect(dut: HierarchyObject) -> RegisterMap:
    """The registers of the core behind the ports ``s_axil_*`` of ``dut``."""
    master = AxiLiteMaster(AxiLiteBus.from_prefix(dut, "s_axil"), dut.clock, dut.reset)

    async def read_words(address: int, count: int) -> Sequence[int]:
        answer = await master.read(address, 4 * count)
        if answer.resp != AxiResp.OKAY:
            raise BusError(f"read of {count} words at 0x{address:05x} answered {answer.resp!r}")
        words: list[int] = np.frombuffer(answer.data, dtype="<u4").tolist()
        return words

    async def write_words(address: int, words: Sequence[int]) -> None:
        answer = await master.write(address, np.array(words, dtype="<u4").tobytes())
        if answer.resp != AxiResp.OKAY:
            raise BusError(f"write at 0x{address:05x} answered {answer.resp!r}")

    return RegisterMap(read_words, write_words)
