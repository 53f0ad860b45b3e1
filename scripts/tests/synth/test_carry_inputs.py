"""Tests that a look-up table is copied for nextpnr if a carry chain and another cell read it."""

from __future__ import annotations

import json
from collections import Counter
from pathlib import Path
from typing import Any

from scripts.carry_inputs import split_shared_inputs


def table(kind: str, inputs: list[int | str], output: int) -> dict[str, Any]:
    ports = [f"I{place}" for place in range(len(inputs))]
    return {
        "type": kind,
        "parameters": {"INIT": "0110"},
        "port_directions": {**dict.fromkeys(ports, "input"), "O": "output"},
        "connections": {
            **{port: [bit] for port, bit in zip(ports, inputs, strict=True)},
            "O": [output],
        },
    }


def carry(selects: list[int | str], first_output: int) -> dict[str, Any]:
    return {
        "type": "CARRY4",
        "port_directions": {"S": "input", "DI": "input", "O": "output"},
        "connections": {
            "S": selects,
            "DI": [2, 3, 4, "0"],
            "O": list(range(first_output, first_output + 4)),
        },
    }


def split(folder: Path, cells: dict[str, Any], ports: dict[str, Any]) -> tuple[int, dict[str, Any]]:
    """Rewrite a module with these cells; return the number of added tables, and the module."""
    path = folder / "made.json"
    netnames = {"all": {"bits": list(range(2, 64))}}
    module = {"ports": ports, "netnames": netnames, "cells": cells}
    path.write_text(json.dumps({"modules": {"made": module}}), encoding="utf-8")
    added = split_shared_inputs(path, "made")
    return added, json.loads(path.read_text(encoding="utf-8"))["modules"]["made"]


def test_a_shared_look_up_table_becomes_one_for_each_reader(tmp_path: Path) -> None:
    shared = table("LUT2", [2, 3], 40)
    of_port = table("LUT2", [3, 4], 41)
    own = table("LUT2", [4, 5], 42)
    large = table("LUT6", [2, 3, 4, 5, 6, "1"], 43)
    cells = {
        "shared": shared,
        "of_port": of_port,
        "own": own,
        "large": large,
        "reader": table("LUT2", [40, 43], 50),
        "first": carry([40, 41, 42, 43], 52),
        "second": carry([40, "0", 6, 43], 56),
    }
    ports = {"out": {"direction": "output", "bits": [41, "0"]}}
    added, module = split(tmp_path, cells, ports)
    # Bit 40 has three readers, so that each chain gets a copy of its table. A chain and a port read
    # bit 41.
    assert added == 3
    after = module["cells"]
    drivers = {
        cell["connections"]["O"][0]: cell for cell in after.values() if "I0" in cell["connections"]
    }
    for chain, place, old in (("first", 0, shared), ("second", 0, shared), ("first", 1, of_port)):
        new = drivers[after[chain]["connections"]["S"][place]]
        assert new["connections"]["O"] != old["connections"]["O"]
        for part in ("type", "parameters", "port_directions"):
            assert new[part] == old[part]
        assert {**new["connections"], "O": 0} == {**old["connections"], "O": 0}
    # The script leaves three kinds of cells unchanged: cells without another reader, cells with too
    # many inputs for a slice, and cells of other types.
    assert after["first"]["connections"]["S"][2:] == [42, 43]
    assert after["second"]["connections"]["S"][1:] == ["0", 6, 43]
    assert after["reader"] == cells["reader"]
    outputs = Counter(bit for cell in after.values() for bit in cell["connections"]["O"])
    assert max(outputs.values()) == 1, "no bit has two drivers"
    assert {bit for name in module["netnames"].values() for bit in name["bits"]} >= set(drivers)


def test_the_last_reader_keeps_the_look_up_table(tmp_path: Path) -> None:
    """The last reader keeps the original look-up table: only two chains read the table, so one copy
    is enough."""
    cells = {
        "shared": table("INV", [2], 40),
        "first": carry([40, 2, 3, 4], 52),
        "second": carry([40, 2, 3, 4], 56),
    }
    added, module = split(tmp_path, cells, {})
    assert added == 1
    selects = {module["cells"][name]["connections"]["S"][0] for name in ("first", "second")}
    assert len(selects) == 2
    assert 40 in selects
