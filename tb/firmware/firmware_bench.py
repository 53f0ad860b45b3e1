"""The firmware, compiled for this machine, as the processor of the real core.

Every register access of the C code is an AXI4-Lite access in the simulation; its calculations
take no time there.
"""

from __future__ import annotations

import json
import os
from pathlib import Path
from typing import Any

import cocotb
import numpy as np
from cocotb.handle import HierarchyObject
from cocotb.task import bridge, resume
from cocotb.triggers import ClockCycles, First, RisingEdge, Timer
from cocotbext.axi import AxiLiteBus, AxiLiteMaster, AxiResp
from sim.tests.firmware.library import firmware
from sim.tests.firmware.model_core import Firmware

from arctrue.demo.files import DemoFiles
from arctrue.demo.settings import DemoSettings
from arctrue.gateware.register_access import register_named
from tb.demo.demo_bench import BUS_INPUTS, CLOCK_NS, Clocks

CAPTURE = 0x20000
CLOCKS_BETWEEN_STEPS = 250


class SimulatedCore:
    """What the firmware reads and writes; its calls come from a thread of their own."""

    def __init__(self, dut: HierarchyObject) -> None:
        self.master = AxiLiteMaster(AxiLiteBus.from_prefix(dut, "s_axil"), dut.clock, dut.reset)
        for interface in (self.master.write_if, self.master.read_if):
            interface.log.setLevel("WARNING")
        self.accesses = 0
        self.bank = np.zeros(0, dtype=np.int32)
        ffi, _ = firmware()
        self._calls = (
            ffi.callback("core_read_word", self._read),
            ffi.callback("core_write_word", self._write),
            ffi.callback("core_capture_words", self._capture),
        )
        self.access = ffi.new("struct core_access *", list(self._calls))

    def _read(self, _: Any, offset: int) -> int:
        return int.from_bytes(self._bytes(offset, 4), "little")

    def _bytes(self, offset: int, number: int) -> bytes:
        self.accesses += 1
        answer = resume(self.master.read)(offset, number)
        assert answer.resp == AxiResp.OKAY, f"read at 0x{offset:05X}: {answer.resp!r}"
        return bytes(answer.data)

    def _write(self, _: Any, offset: int, word: int) -> None:
        self.accesses += 1
        answer = resume(self.master.write)(offset, word.to_bytes(4, "little"))
        assert answer.resp == AxiResp.OKAY, f"write at 0x{offset:05X}: {answer.resp!r}"

    def _capture(self, _: Any, number: int) -> Any:
        # The processor reads in place; here every word would be a step of the simulator.
        self.bank = np.frombuffer(self._bytes(CAPTURE, 4 * number), dtype="<i4").copy()
        return firmware()[0].cast("int32_t *", self.bank.ctypes.data)


@cocotb.test()
async def from_the_index_to_the_corrected_output(dut: HierarchyObject) -> None:
    files = DemoFiles(Path(os.environ["ARCTRUE_DEMO_FOLDER"]))
    settings = DemoSettings.read(files.settings)
    clocks = Clocks()
    dut.run.value = 0
    dut.reset.value = 1
    for name in BUS_INPUTS:
        getattr(dut, f"s_axil_{name}").value = 0
    await ClockCycles(dut.clock, 80)
    core = SimulatedCore(dut)
    dut.reset.value = 0
    await ClockCycles(dut.clock, 5)

    made = Firmware(core)
    parameters = made.application.parameters
    parameters.counts_per_rev = settings.counts_per_rev
    parameters.sample_period = settings.sample_period_clocks
    parameters.ramp_rate = settings.ramp_rate
    parameters.output_spacing = settings.output_spacing_clocks
    parameters.orders = settings.fitted_orders
    await bridge(lambda: made.library.application_start(made.application))()
    assert made.phase == "wait_for_index"
    made.send("telemetry on")

    await RisingEdge(dut.clock)
    dut.run.value = 1
    clocks.start()
    phases = [made.phase]
    told = ""
    while not (told and made.phase == "capture" and settled(await snapshot(made))):
        told += await bridge(made.step)()
        if made.phase != phases[-1]:
            phases.append(made.phase)
        await Timer(CLOCKS_BETWEEN_STEPS * CLOCK_NS, "ns")
        await RisingEdge(dut.clock)
        assert not dut.played_out.value, f"the table ran out; phases {phases}, told {told!r}"
    assert phases == ["wait_for_index", "capture", "swap", "capture"]
    # The output trails the pipeline by a few clocks.
    settled_clock = clocks.now() + 100
    status = await bridge(lambda: made.send("status"))()
    turn_clocks = settings.counts_per_rev * settings.clocks_per_count
    await First(Timer((100 + int(1.02 * turn_clocks)) * CLOCK_NS, "ns"), RisingEdge(dut.played_out))
    dut.run.value = 0
    await ClockCycles(dut.clock, 3)
    outcome = {
        "settled_clock": settled_clock,
        "told": json.loads(told.splitlines()[0]),
        "status": status,
        "accesses": core.accesses,
        "bank": core.bank.tolist(),
    }
    files.run.write_text(json.dumps(outcome), encoding="utf-8")


async def snapshot(made: Firmware) -> dict[str, bool]:
    status = await bridge(lambda: made.library.core_status(made.core.access))()
    return {"ramp_busy": status.ramp_busy, "compensating": status.compensating}


def settled(status: dict[str, bool]) -> bool:
    return status["compensating"] and not status["ramp_busy"]


assert register_named("control").address == 0x20, "the map that the firmware was compiled for"
