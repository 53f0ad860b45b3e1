"""Compares the VHDL index_zero with its model, for the index marks of the decoder's scenarios."""

from __future__ import annotations

from typing import Any

import cocotb
import numpy as np
from sim.tests.gateware.quadrature_decoder_scenarios import (
    FAULTY,
    RANDOM_SEEDS,
    SCATTERED,
    stimuli,
)

from arctrue.gateware.edge_counter import counted_edges, edge_counter
from arctrue.gateware.index_zero import index_zero
from tb.decoder.drive import edge_ports, follows

SETTINGS = ("counts_per_rev", "index_tolerance", "rearm", "zero_again", "heal", "other_head_agrees")
NAMES = [*SCATTERED, *FAULTY, *RANDOM_SEEDS]
# The scenario that is left out is long and tests only the spacing of edges, on which index_zero
# does not depend.
NAMES.remove("edges_65535_clocks_apart")


@cocotb.test()
@cocotb.parametrize(name=NAMES)
async def follows_the_model(dut: Any, name: str) -> None:
    """The outputs equal the model's; the bench drives the levels of the scenario without
    synchroniser and filter."""
    given = stimuli(name)
    column = given.columns
    a, b, z = column["a"], column["b"], column["z"]
    reset = column["reset"] != 0
    preload = reset | (np.convolve(reset, np.ones(3), "full")[: reset.size] > 0)
    edges = counted_edges(a, b, preload, reset)
    counter = edge_counter(a, b, preload, reset, given.timestamp)
    flags = {key: column[key] for key in SETTINGS}
    for key in ("rearm", "zero_again", "heal", "other_head_agrees"):
        flags[key] = flags[key] != 0
    trace, misplaced = index_zero(
        z, edges, counter.position[1:], **flags, preload=preload, reset=reset
    )
    inputs = {
        **flags,
        **edge_ports(edges),
        "z": z,
        "position": counter.position[:-1],
        "preload": preload,
        "reset": reset,
    }
    await follows(dut, inputs, vars(trace), at_once={"misplaced": misplaced})
