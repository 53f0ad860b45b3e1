"""Compares outputs recorded in GHDL with the compiled netlist's, bit by bit in every clock."""

from __future__ import annotations

import json
from collections.abc import Container
from pathlib import Path

from tb.instrument.replay import Replay


def differences(
    noted: dict[str, list[str]],
    from_netlist: dict[str, list[int]],
    settled: int,
    undefined: Container[str] = (),
) -> list[str]:
    """Return a line for each output that differs; before clock ``settled``, unknown bits are
    ignored.

    ``noted`` has every output in each clock as GHDL writes it, high bit first. Outputs in
    ``undefined`` may have unknown bits in any clock; only their known bits are compared.
    """
    found = []
    for name, texts in noted.items():
        assert len(texts) == len(from_netlist[name])
        wrong = [
            clock
            for clock, (text, value) in enumerate(zip(texts, from_netlist[name], strict=True))
            if not _agrees(text, value, clock < settled or name in undefined)
        ]
        if wrong:
            clock = wrong[0]
            width = len(texts[clock])
            found.append(
                f"{name}: {len(wrong)} of {len(texts)} clocks differ, first clock {clock}: "
                f"GHDL {texts[clock]}, netlist {from_netlist[name][clock]:0{width}b}"
            )
    return found


def _agrees(text: str, value: int, may_be_unknown: bool) -> bool:
    if set(text) <= {"0", "1"}:
        return int(text, 2) == value
    if not may_be_unknown:
        return False
    bits = f"{value:0{len(text)}b}"
    return all(known not in "01" or known == bit for known, bit in zip(text, bits, strict=True))


def compare(
    replay: Replay, folder: Path, settled: int, undefined: Container[str] = ()
) -> list[str]:
    """Replay GHDL's inputs in ``folder`` in the netlist; return the differences of outputs."""
    inputs = json.loads((folder / "inputs.json").read_text(encoding="utf-8"))
    noted = json.loads((folder / "noted.json").read_text(encoding="utf-8"))
    outputs = {port.name for port in replay.ports if not port.is_input}
    assert outputs == set(noted), "GHDL and the netlist have different outputs"
    return differences(noted, replay.outputs(inputs, folder), settled, undefined)
