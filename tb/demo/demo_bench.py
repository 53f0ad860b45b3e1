"""The demo inside the simulator: capture a turn, calibrate, swap, record a corrected turn."""

from __future__ import annotations

import os
from pathlib import Path

import cocotb
import numpy as np
from cocotb.handle import HierarchyObject
from cocotb.triggers import ClockCycles, First, RisingEdge, Timer
from cocotb.utils import get_sim_time

from arctrue.demo.calibrate import calibrate_capture
from arctrue.demo.files import DemoFiles, ProcessorRun
from arctrue.demo.progress import Progress
from arctrue.demo.settings import DemoSettings
from arctrue.gateware.register_access import RegisterMap
from tb.demo.processor import connect

CLOCK_NS = 10
BUS_INPUTS = (
    *("awvalid", "awaddr", "awprot", "wvalid", "wdata", "wstrb"),
    *("bready", "arvalid", "araddr", "arprot", "rready"),
)


class Clocks:
    """Counts clocks as the played edges do: 0 is the clock in which ``run`` is first seen."""

    def __init__(self) -> None:
        self._start_ns: float | None = None

    def start(self) -> None:
        # Called on a rising edge; the player sees `run` at the next one.
        self._start_ns = float(get_sim_time("ns")) + CLOCK_NS

    def now(self) -> int:
        if self._start_ns is None:
            return 0
        return round((float(get_sim_time("ns")) - self._start_ns) / CLOCK_NS)


@cocotb.test()
async def whole_loop(dut: HierarchyObject) -> None:
    files = DemoFiles(Path(os.environ["ARCTRUE_DEMO_FOLDER"]))
    settings = DemoSettings.read(files.settings)
    clocks = Clocks()
    stage = ["setting up the registers"]

    async def report() -> None:
        while True:
            Progress(stage[0], clocks.now()).write(files.progress)
            await Timer(1000 * CLOCK_NS, "ns")

    cocotb.start_soon(report())
    core = await start(dut, settings)

    await RisingEdge(dut.clock)
    dut.run.value = 1
    clocks.start()
    stage[0] = "the table starts and turns once before both heads"
    await next_interrupt(dut)
    ready = clocks.now()

    stage[0] = "reading the capture memory over AXI while the table turns on"
    capture = await core.read_capture()
    counts = capture.samples.T.astype(np.int64)
    np.save(files.capture, counts)
    raised = {name for name, flag in capture.flags.items() if flag}
    assert raised == {"index_seen1", "index_seen2"}, f"capture header flags: {sorted(raised)}"
    await core.command("capture_release")

    stage[0] = "calibrating, writing the coefficients"
    found = calibrate_capture(counts, settings)
    await core.write_coefficients(found.coefficients)
    await core.clear_interrupts()
    await core.write_raw("interrupt_enable", 0)
    await core.update("interrupt_enable", ramp_done=1)
    await core.command("swap")
    swapped = clocks.now()
    stage[0] = "banks swapped: the correction fades in"
    await next_interrupt(dut)
    # The output trails the pipeline by a few clocks.
    settled = clocks.now() + 100

    stage[0] = "recording a corrected turn"
    turn_clocks = settings.counts_per_rev * settings.clocks_per_count
    await First(Timer((100 + int(1.01 * turn_clocks)) * CLOCK_NS, "ns"), RisingEdge(dut.played_out))
    end = clocks.now()
    await check_faults(core)
    await RisingEdge(dut.clock)
    dut.run.value = 0
    await ClockCycles(dut.clock, 3)
    ProcessorRun(
        capture_first_clock=ready - (counts.shape[1] - 1) * settings.sample_period_clocks,
        capture_ready_clock=ready,
        swap_clock=swapped,
        settled_clock=settled,
        end_clock=end,
        samples=counts.shape[1],
        orders=found.orders,
        amplitudes_counts=found.amplitudes_counts,
        phases_rad=found.phases_rad,
        uncertainties_counts=found.uncertainties_counts,
    ).write(files.run)


async def start(dut: HierarchyObject, settings: DemoSettings) -> RegisterMap:
    """Reset the core and set its registers; the table still stands."""
    dut.run.value = 0
    dut.reset.value = 1
    for name in BUS_INPUTS:
        getattr(dut, f"s_axil_{name}").value = 0
    await ClockCycles(dut.clock, 80)
    core = connect(dut)
    dut.reset.value = 0
    await ClockCycles(dut.clock, 5)
    built = await core.check_identity()
    assert built["lanes"] == settings.lanes, f"the core has {built['lanes']} lanes"
    await core.write("counts_per_rev", settings.counts_per_rev)
    await core.command("rearm")
    # A re-arm holds the compensation in reset for some clocks.
    await ClockCycles(dut.clock, 300)
    assert await core.read("counts_per_rev_active") == settings.counts_per_rev
    await core.write("sample_period", settings.sample_period_clocks)
    await core.write("ramp_rate", settings.ramp_rate)
    await core.write("output_spacing", settings.output_spacing_clocks)
    await core.update("interrupt_enable", capture_ready=1)
    # The coefficients are still zero: compensation is on and corrects by nothing.
    await core.update("control", compensate=1, output_enable=1, capture_enable=1)
    return core


async def next_interrupt(dut: HierarchyObject) -> None:
    """Wait until the interrupt line is high; fails when the edges run out first."""
    if dut.interrupt.value == 1:
        return
    await First(RisingEdge(dut.interrupt), RisingEdge(dut.played_out))
    assert dut.interrupt.value == 1, "the played edges ended before the interrupt came"


async def check_faults(core: RegisterMap) -> None:
    for head in ("head1", "head2"):
        flags = await core.read_fields(f"{head}.flags")
        raised = [name for name in ("index_error", "illegal", "overspeed") if flags[name]]
        assert not raised, f"{head}: sticky flags {', '.join(raised)}"
    assert not await core.read("status.cannot_keep_up"), "the output could not keep up"
    assert await core.read("overrun_count") == 0
