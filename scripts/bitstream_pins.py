"""Checks that every input pin of every DSP and block RAM in a configuration is driven.

A pin has a route from another pin, a constant by a route or a tie-off, or a default that the
database documents (interconnect without a driver is 1). What else may stay open is named here with
its reason. A tie-off is refused where the pin's inverter is on, as Vivado refuses it. A signal at
INMODE, ALUMODE2, ALUMODE3 or OPMODE6 of a DSP is refused too: the database has no feature for it.
"""

from __future__ import annotations

import json
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import Final

from scripts.bitstream_features import Features
from scripts.bitstream_routes import Routes
from scripts.bitstream_ties import inverter_feature, tie_feature, tied_pins
from scripts.netlist import ToolError

SHOWN: Final = 12
OUTPUT_REGISTERS: Final = {
    "REGCLKARDRCLK": "DOA_REG",
    "RDRCLK": "DOA_REG",
    "REGCLKB": "DOB_REG",
}
"""Clocks of a block RAM's output registers, open where the register is not used (UG473)."""


@cache
def inputs_of(family: Path, site_type: str) -> frozenset[str]:
    """The input pins of a type of site."""
    text = (family / f"site_type_{site_type}.json").read_text(encoding="utf-8")
    pins = json.loads(text)["site_pins"]
    return frozenset(pin for pin, entry in pins.items() if entry["direction"] == "IN")


def blocks_in_use(features: Features) -> Iterator[tuple[str, int, str]]:
    """Tile, place in its type's sites and name in features of every DSP and half of a block RAM."""
    for tile in features.tiles:
        own = features.chip.type_of(tile)
        kind = own.name.partition("_")[0]
        if kind not in ("DSP", "BRAM"):
            continue
        there = features.of(tile)
        for place, site in enumerate(own.sites):
            half = int(site["name"][-1])
            name = f"DSP48.DSP_{half}" if kind == "DSP" else f"RAMB18_Y{half}"
            if site["type"] not in ("DSP48E1", "FIFO18E1", "RAMB18E1"):
                continue
            if kind == "BRAM" and f"{name}.IN_USE" not in there:
                continue
            if any(feature.startswith(f"{name}.") for feature in there):
                yield tile, place, name


def open_pins(routes: Routes) -> list[str]:
    """A sentence for every pin that nothing drives, and for every tie-off that is inverted."""
    features = routes.features
    chip = features.chip
    faults = []
    for tile, place, name in blocks_in_use(features):
        own, there = chip.type_of(tile), features.of(tile)
        site = own.sites[place]
        for pin in sorted(inputs_of(chip.family, site["type"]) & site["site_pins"].keys()):
            register = OUTPUT_REGISTERS.get(pin)
            if register and f"{name}.{register}" not in there:
                continue
            if routes.source(tile, site["site_pins"][pin]) is None:
                faults.append(f"{tile} {name}: {pin} has no route, no tie-off and no default")
        if name.startswith("DSP48"):
            half = int(name[-1])
            for pin in tied_pins(own, half):
                inverter = inverter_feature(own, half, pin)
                is_tied = any(tie_feature(own, half, pin, level) in there for level in (0, 1))
                if is_tied and inverter and inverter not in there:
                    faults.append(f"{tile} {name}: {pin} is tied off and inverted")
    return faults


def check_pins_driven(routes: Routes) -> int:
    """How many DSPs and halves of block RAMs there are, all their pins driven.

    Raises ToolError that names the pins that are not.
    """
    faults = open_pins(routes)
    if faults:
        shown = "\n".join(f"  - {fault}" for fault in faults[:SHOWN])
        more = f"\n  and {len(faults) - SHOWN} more" if len(faults) > SHOWN else ""
        raise ToolError(
            f"{len(faults)} pins of DSPs or block RAMs are not driven, so what the chip would "
            f"compute is not known:\n{shown}{more}"
        )
    return sum(1 for _ in blocks_in_use(routes.features))
