"""Drives an entity of the decoder clock by clock, and compares its outputs with a model's."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from cocotb.clock import Clock
from cocotb.triggers import FallingEdge, Timer
from numpy.typing import NDArray

from arctrue.gateware.edge_counter import CountedEdges
from arctrue.gateware.latest import outputs


def edge_ports(edges: CountedEdges) -> dict[str, NDArray[np.int64]]:
    """Return the elements of the record counted_edge in every clock, each (clocks,), by name."""
    moves = outputs(0, edges.step != 0)[:-1]
    up = outputs(1, edges.up)[:-1]
    return {
        "comes": (edges.step != 0).astype(np.int64),
        "moves": moves,
        "stands": 1 - moves,
        "up": up,
        "down": 1 - up,
        "breaks_order": outputs(0, edges.breaks_order)[:-1],
    }


async def follows(
    dut: Any,
    inputs: Mapping[str, NDArray[Any]],
    expected: Mapping[str, NDArray[Any]],
    at_once: Mapping[str, NDArray[Any]] | None = None,
) -> None:
    """Drive ``inputs``, each (clocks,); check after every clock that the outputs equal
    ``expected``.

    ``expected`` has one more element than the inputs: element t is the output during clock t.
    ``at_once`` has the outputs, each (clocks,), that depend on the inputs of the same clock; they
    are not checked during a reset.
    """
    unregistered = {name: values.tolist() for name, values in (at_once or {}).items()}
    columns = {name: values.astype(np.uint64).tolist() for name, values in inputs.items()}
    widths = {name: len(getattr(dut, name)) for name in (*inputs, *expected)}
    handles = {name: getattr(dut, name) for name in expected}
    words = {
        name: (values.astype(np.uint64) & np.uint64(2 ** widths[name] - 1)).tolist()
        for name, values in expected.items()
    }
    last: dict[str, int] = {}
    Clock(dut.clock, 10, unit="ns", impl="gpi").start()
    await FallingEdge(dut.clock)
    for clock in range(len(next(iter(columns.values())))):
        for name, column in columns.items():
            word = column[clock] & (2 ** widths[name] - 1)
            if word != last.get(name):
                last[name] = word
                getattr(dut, name).value = word
        if unregistered and not last["reset"]:
            await Timer(1, "ns")
            for name, column in unregistered.items():
                got = int(getattr(dut, name).value)
                assert got == column[clock], f"{name} in clock {clock}: {got}"
        await FallingEdge(dut.clock)
        for name, handle in handles.items():
            got = int(handle.value)
            assert got == words[name][clock + 1], (
                f"{name} after clock {clock}: {got}, model {words[name][clock + 1]}"
            )
