"""Runs the demo in the simulator, with the edges of the table's heads and the firmware's C code.

The bench types the settings on the firmware's console, runs the firmware's main loop while the
table turns, and records the output of the console. It ends when a corrected turn has been recorded.
"""

from __future__ import annotations

import os
from pathlib import Path

import cocotb
import numpy as np
from cocotb.handle import HierarchyObject
from cocotb.triggers import ClockCycles, RisingEdge, Timer
from cocotb.utils import get_sim_time

from arctrue.studies.demo.bench_stage import BenchStage
from arctrue.studies.demo.files import ConsoleLine, DemoFiles, ProcessorRun
from arctrue.studies.demo.settings import DemoSettings
from tb.firmware.processor import Processor

CLOCK_NS = 10
BUS_INPUTS = (
    *("awvalid", "awaddr", "wvalid", "wdata", "wstrb"),
    *("bready", "arvalid", "araddr", "rready"),
)
# LOOKS_A_TURN: number of times per turn at which the main loop runs without an interrupt of the
# core. On the device the timer wakes the firmware every 5 ms, but a turn of this table is shorter
# than that.
LOOKS_A_TURN = 64
# OUTPUT_CLOCKS: number of clocks to wait after the ramp, because the output follows the pipeline
# some clocks later.
OUTPUT_CLOCKS = 100
# Number of recorded turns: the turn that is evaluated, and a little more.
RECORDED_TURNS = 1.01


class Clocks:
    """Counts clocks like the file of edges: ``run`` of edge_player is first high in clock 0."""

    def __init__(self) -> None:
        self._start_ns: float | None = None

    def start(self) -> None:
        # This function is called at a rising edge; edge_player samples `run` high at the next one.
        self._start_ns = float(get_sim_time("ns")) + CLOCK_NS

    def now(self) -> int:
        if self._start_ns is None:
            return 0
        return round((float(get_sim_time("ns")) - self._start_ns) / CLOCK_NS)


class Operator:
    """Types on the firmware's console, stores the lines of the console, and reports progress."""

    def __init__(self, dut: HierarchyObject, files: DemoFiles) -> None:
        self.clocks = Clocks()
        self.lines: list[ConsoleLine] = []
        self._files = files
        self.stage = "setting up the gateware"
        self.processor = Processor(dut, self._reading)

    def _reading(self) -> None:
        self.stage = "firmware: reading a captured turn over AXI while the table turns on"

    async def report(self) -> None:
        """Report the progress without end; the test runs this coroutine as a parallel task."""
        while True:
            BenchStage(self.stage, self.clocks.now()).write(self._files.progress)
            await Timer(1000 * CLOCK_NS, "ns")

    def _note(self, text: str, *, typed: bool = False) -> None:
        clock = self.clocks.now()
        self.lines += [ConsoleLine(clock, typed, line) for line in text.splitlines()]

    async def type(self, line: str) -> None:
        self._note(line, typed=True)
        answer = await self.processor.type(line)
        self._note(answer)
        assert answer.splitlines()[-1].startswith("ok"), f"{line!r} was answered {answer!r}"

    async def look(self, pause_clocks: int) -> None:
        """Run the firmware's main loop once, then sleep until an interrupt or until
        ``pause_clocks`` have passed."""
        self._note(await self.processor.work())
        await self.processor.sleep(pause_clocks * CLOCK_NS)


def still_turning(dut: HierarchyObject, operator: Operator) -> None:
    assert not dut.played_out.value, (
        f"the edges ran out at: {operator.stage}; the firmware's phase is "
        f"{operator.processor.phase}, its last line {operator.lines[-1].text!r}"
    )


@cocotb.test()
async def whole_loop(dut: HierarchyObject) -> None:
    files = DemoFiles(Path(os.environ["ARCTRUE_DEMO_FOLDER"]))
    settings = DemoSettings.read(files.settings)
    dut.run.value = 0
    dut.reset.value = 1
    for name in BUS_INPUTS:
        getattr(dut, f"s_axil_{name}").value = 0
    await ClockCycles(dut.clock, 80)
    operator = Operator(dut, files)
    processor = operator.processor
    cocotb.start_soon(operator.report())
    dut.reset.value = 0
    await ClockCycles(dut.clock, 5)
    await processor.start()
    for line in settings.console_commands():
        await operator.type(line)
    assert processor.phase == "wait_for_index"

    await RisingEdge(dut.clock)
    dut.run.value = 1
    operator.clocks.start()
    pause = int(settings.counts_per_rev * settings.clocks_per_count / LOOKS_A_TURN)

    operator.stage = "table: it starts and turns once before both heads"
    while not processor.swaps:
        await operator.look(pause)
        still_turning(dut, operator)
    np.save(files.capture, processor.core.banks[0].reshape(-1, 2).T.astype(np.int64))
    operator.stage = "firmware: calibrated and swapped; the correction fades in"
    while not await processor.settled():
        await operator.look(pause)
        still_turning(dut, operator)
    settled = operator.clocks.now() + OUTPUT_CLOCKS
    end = settled + int(RECORDED_TURNS * settings.counts_per_rev * settings.clocks_per_count)
    while operator.clocks.now() < end and not dut.played_out.value:
        operator.stage = "recording a corrected turn; the firmware goes on watching"
        await operator.look(pause)
    end = operator.clocks.now()
    await operator.type("status")
    dut.run.value = 0
    ProcessorRun(
        settled_clock=settled,
        end_clock=end,
        words_moved=processor.core.words_moved,
        console=operator.lines,
    ).write(files.run)
    # GHDL checks only after a timer whether cocotb has finished: if the test ended at an edge, the
    # simulation would run for ever.
    await Timer(3 * CLOCK_NS, "ns")
