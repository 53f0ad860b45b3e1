"""Ties the constant pins of all DSP48E1 cells, because place and route leaves some of these pins
without a tie.

nextpnr-himbaechel 0.11.1 (and nextpnr-xilinx: openXC7/nextpnr-xilinx, pull request 159) writes
neither a tie-off nor an inverter bit for constants at INMODE, ALUMODE2, ALUMODE3 and OPMODE6. A
design without these bits multiplied wrongly on hardware. Three bits tie a pin: connection to
ground, connection to the supply, and ``ZIS_…_INVERTED``, which is set if the pin is *not* inverted.
Their right values are 1 0 1 for a constant 0 and 0 1 1 for a constant 1; the same pull request
states these values, from Vivado on two parts. The database states which pins have these
connections; the routed netlist states which constant each pin needs.
"""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any, Final

from scripts.bitstream_database import Chip, TileType
from scripts.netlist import ToolError

SUPPLIES: Final = ("GND", "VCC")
"""Name of the supply at each level; the index is the level."""
PLACE: Final = re.compile(r"X(?P<column>\d+)Y(?P<row>\d+)/DSP48_X\d+Y(?P<half>\d+)\.DSP48E1")
"""Form of a placement by nextpnr-himbaechel: a tile of the grid and a site of the tile."""
SITE: Final = re.compile(r"(?P<site>DSP48_X\d+Y(?P<half>\d+))/DSP48E1")
"""Form of a placement by nextpnr-xilinx: a site of the chip; each tile has two sites."""
TIED: Final = re.compile(r"DSP_(?P<half>\d)_(?P<pin>\w+)\.DSP_(?P<supply>GND|VCC)_[LR]")
BIT: Final = re.compile(r"(?P<port>[A-Z]+)(?P<bit>\d*)")


def tie_feature(own: TileType, half: int, pin: str, level: int) -> str:
    """Return the feature of a DSP's tile that connects a pin to ground (``level`` 0) or to the
    supply (``level`` 1)."""
    side = own.name[-1]
    return f"DSP_{half}_{pin}.DSP_{SUPPLIES[level]}_{side}"


def inverter_feature(own: TileType, half: int, pin: str) -> str | None:
    """Return the feature that is set if a pin is not inverted; None if the pin has no inverter."""
    found = BIT.fullmatch(pin)
    assert found
    name = f"DSP48.DSP_{half}.ZIS_{found['port']}_INVERTED"
    feature = f"{name}[{found['bit']}]" if found["bit"] else name
    return feature if feature in own.features else None


def tied_pins(own: TileType, half: int) -> list[str]:
    """Return the pins of a DSP that the database can tie to ground and to the supply."""
    return sorted(
        found["pin"]
        for found in map(TIED.fullmatch, own.features)
        if found and int(found["half"]) == half and found["supply"] == "GND"
    )


def _tile_of(chip: Chip, cell: str, placed: str) -> tuple[str, int]:
    """Return tile and half (0 or 1) of a placed DSP. Raises ToolError if the DSP is not placed."""
    by_grid, by_site = PLACE.fullmatch(placed), SITE.fullmatch(placed)
    if by_grid:
        tile = chip.at.get((int(by_grid["column"]), int(by_grid["row"])), "")
    else:
        tile = chip.of_site.get(by_site["site"], "") if by_site else ""
    if not tile or not chip.tiles[tile]["type"].startswith("DSP_"):
        raise ToolError(f"the DSP48E1 {cell} is placed at '{placed}', where no DSP tile is known")
    half = by_grid or by_site
    assert half
    return tile, int(half["half"]) % 2


def _constants(module: dict[str, Any]) -> dict[int, int]:
    """Return the level of each constant net of a routed netlist."""
    found = {}
    for level, supply in enumerate(SUPPLIES):
        for bit in module["netnames"].get(f"$PACKER_{supply}_NET", {"bits": []})["bits"]:
            found[bit] = level
    return found


def _is_inverted(cell: dict[str, Any], pin: str) -> bool:
    found = BIT.fullmatch(pin)
    assert found
    port, bit = found["port"], int(found["bit"] or 0)

    def parameter(name: str) -> int:
        return int(str(cell["parameters"].get(name, "0")), 2)

    one = parameter(f"IS_{port}[{bit}]_INVERTED") & 1
    return bool(one or parameter(f"IS_{port}_INVERTED") >> bit & 1)


def ties(routed: Path, chip: Chip) -> list[str]:
    """Return the lines of FASM that are necessary for the constant pins of all DSPs of a routed
    netlist.

    Raises ToolError for a netlist that is not placed.
    """
    modules = json.loads(routed.read_text(encoding="utf-8"))["modules"]
    lines = []
    for module in modules.values():
        constants = _constants(module)
        for name, cell in module["cells"].items():
            if not cell["type"].startswith("DSP48E1"):
                continue
            tile, half = _tile_of(chip, name, str(cell["attributes"].get("NEXTPNR_BEL", "")))
            own = chip.type_of(tile)
            for pin in tied_pins(own, half):
                bits = cell["connections"].get(pin, [])
                if not bits or bits[0] not in constants:
                    continue
                level = constants[bits[0]] ^ _is_inverted(cell, pin)
                features = (tie_feature(own, half, pin, level), inverter_feature(own, half, pin))
                lines += [f"{tile}.{feature}" for feature in features if feature]
    return lines


def tie_constants(fasm: Path, routed: Path, chip: Chip, tied: Path) -> int:
    """Write to ``tied`` the lines of ``fasm`` and the added lines for the DSPs' constants; return
    the number of added lines."""
    lines = ties(routed, chip)
    text = fasm.read_text(encoding="ascii")
    added = "".join(f"{line}\n" for line in lines)
    tied.write_text(f"{text}\n# constant pins of the DSPs\n{added}", encoding="ascii")
    return len(lines)
