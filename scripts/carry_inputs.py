"""Copies look-up tables for nextpnr, so that each stage of a carry chain has its own look-up table.

nextpnr 0.11.1 puts a look-up table into the slice of the carry chain only if no other cell reads
the table. Otherwise nextpnr adds a second table in the slice, with a long wire between the two
tables. Yosys shares such look-up tables between the chain and other cells; this script makes one
look-up table for the chain and one for the other cells.
"""

from __future__ import annotations

import copy
import json
from collections import Counter
from pathlib import Path
from typing import Any, Final

MOST_INPUTS: Final = 4
"""Largest number of inputs of a copied look-up table. The table and the carry chain's input DI
share five inputs of the slice, so a larger table does not fit."""

Cell = dict[str, Any]


def _inputs(cell: Cell) -> list[int]:
    return [
        bit
        for port, bits in cell["connections"].items()
        if cell["port_directions"][port] == "input"
        for bit in bits
        if isinstance(bit, int)
    ]


def _is_look_up_table(cell: Cell) -> bool:
    return str(cell["type"]).startswith(("LUT", "INV"))


def split_shared_inputs(netlist: Path, top: str) -> int:
    """Rewrite a flat netlist of Yosys (JSON) and return the number of added look-up tables.

    Each look-up table of at most four inputs that drives an S of a CARRY4 and another input is
    copied: the copy drives this S alone.
    """
    design = json.loads(netlist.read_text(encoding="utf-8"))
    module = design["modules"][top]
    cells: dict[str, Cell] = module["cells"]
    readers = Counter(bit for cell in cells.values() for bit in _inputs(cell))
    readers.update(bit for port in module["ports"].values() for bit in port["bits"])
    tables = {
        cell["connections"]["O"][0]: (name, cell)
        for name, cell in cells.items()
        if _is_look_up_table(cell)
    }
    highest = max(
        (
            bit
            for named in (*module["netnames"].values(), *module["ports"].values())
            for bit in named["bits"]
            if isinstance(bit, int)
        ),
        default=1,
    )
    added: dict[str, Cell] = {}
    for cell in cells.values():
        if cell["type"] != "CARRY4":
            continue
        selects = cell["connections"]["S"]
        for place, bit in enumerate(selects):
            if bit not in tables or readers[bit] < 2:
                continue
            name, shared = tables[bit]
            if len(_inputs(shared)) > MOST_INPUTS:
                continue
            own = copy.deepcopy(shared)
            new_bit = highest + len(added) + 1
            own["connections"]["O"] = [new_bit]
            readers[bit] -= 1
            readers.update(_inputs(own))
            selects[place] = new_bit
            new_name = f"{name}$carry{len(added)}"
            module["netnames"][new_name] = {"hide_name": 1, "bits": [new_bit], "attributes": {}}
            added[new_name] = own
    cells.update(added)
    netlist.write_text(json.dumps(design, indent=2), encoding="utf-8")
    return len(added)
