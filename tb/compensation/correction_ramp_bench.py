"""Compares correction_ramp with its model in a cocotb test."""

from __future__ import annotations

from typing import Any

import cocotb
import numpy as np
from cocotb.clock import Clock
from cocotb.triggers import RisingEdge
from sim.tests.gateware.correction_ramp_scenarios import SCENARIOS, RampScenario

from arctrue.gateware.correction_ramp import correction_ramp

LATENCY = 1


@cocotb.test()
@cocotb.parametrize(scenario=SCENARIOS)
async def equals_the_model(dut: Any, scenario: RampScenario) -> None:
    """Total, `limited` and `busy` equal the model's in every clock."""
    dut.reset.value = 1
    dut.marker.value = 0
    dut.correction.value = 0
    dut.withdrawn.value = 0
    dut.limit.value = scenario.limit
    dut.ramp_rate.value = scenario.ramp_rate
    dut.ramp_acceleration.value = scenario.ramp_acceleration
    cocotb.start_soon(Clock(dut.clock, 10, unit="ns", impl="gpi").start())
    for _ in range(2):
        await RisingEdge(dut.clock)
    dut.reset.value = 0
    seen = []
    clocks = scenario.correction.size
    for clock in range(clocks + LATENCY):
        now = min(clock, clocks - 1)
        dut.correction.value = int(scenario.correction[now])
        dut.marker.value = int(scenario.marker[now])
        if scenario.inserted.size:
            dut.withdrawn.value = -int(scenario.inserted[now])
        await RisingEdge(dut.clock)
        seen.append((dut.total.value.to_signed(), int(dut.limited.value), int(dut.busy.value)))
    model = correction_ramp(
        scenario.correction,
        scenario.marker,
        scenario.limit,
        scenario.ramp_rate,
        inserted=scenario.inserted if scenario.inserted.size else None,
        ramp_acceleration=scenario.ramp_acceleration,
    )
    expected = list(
        zip(model.total.tolist(), model.limited.tolist(), model.busy.tolist(), strict=True)
    )
    different = [clock for clock in range(clocks) if seen[clock + LATENCY] != expected[clock]]
    assert not different, (
        f"clock {different[0]}: found {seen[different[0] + LATENCY]}, "
        f"expected {expected[different[0]]}"
    )
    assert np.any(model.total) or np.any(model.busy)
