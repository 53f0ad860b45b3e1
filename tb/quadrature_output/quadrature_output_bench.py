"""Compares the VHDL quadrature output with its model, in every clock of every scenario."""

from __future__ import annotations

import cocotb
import numpy as np
from cocotb.clock import Clock
from cocotb.triggers import FallingEdge
from sim.tests.gateware.quadrature_output_scenarios import SCENARIOS, stimuli

from arctrue.gateware.quadrature_output import OutputInputs, quadrature_output

PINS = ("a", "b", "z", "cannot_keep_up")


@cocotb.test()
@cocotb.parametrize(name=list(SCENARIOS))
async def follows_the_model(dut, name: str) -> None:
    # The scenario follows 8 clocks of reset, in which VHDL and model are compared too.
    resets = 8
    columns = {
        key: [column[0].item()] * resets + column.tolist()
        for key, column in stimuli(SCENARIOS[name]).items()
    }
    columns["reset"][:resets] = [1] * resets
    columns["clear"][:resets] = [0] * resets
    clocks = len(columns["reset"])
    Clock(dut.clock, 10, unit="ns", impl="gpi").start()
    for key, column in columns.items():
        getattr(dut, key).value = column[0] % 2**32
    # The reset is longer than the pipeline of the entity, so that no edge of an earlier scenario
    # remains in the pipeline.
    for _ in range(8):
        await FallingEdge(dut.clock)

    # A reset does not change A and B, so they may have any levels from an earlier scenario.
    held_phase = (0, 3, 1, 2)[2 * int(dut.a.value) + int(dut.b.value)]
    handles = [getattr(dut, pin) for pin in PINS]
    seen = []
    last: dict[str, int] = {}
    for clock in range(clocks + 1):
        error = dut.following_error.value.to_signed()
        seen.append((*(int(handle.value) for handle in handles), error))
        if clock == clocks:
            break
        for key, column in columns.items():
            if column[clock] != last.get(key):
                last[key] = column[clock]
                getattr(dut, key).value = column[clock] % 2**32
        await FallingEdge(dut.clock)

    model = quadrature_output(OutputInputs(**columns), held_phase)
    got = np.array(seen)
    for column, output in enumerate((*PINS, "following_error")):
        expected = getattr(model, output)
        wrong = np.flatnonzero(got[:, column] != expected)
        assert not wrong.size, (
            f"{output}: first of {wrong.size} differences from the model in clock {wrong[0]}: "
            f"{got[wrong[0], column]}, model {expected[wrong[0]]}"
        )
