"""Checks that every input pin of DSPs, block RAMs and look-up tables as RAM is driven.

A pin has a route from another pin, a constant by a route or a tie-off, or a default that the
database documents (a wire of the interconnect without a driver is 1). This module lists the pins
that may stay open nevertheless, each with its reason. The module refuses a tie-off if the pin's
inverter is on, as Vivado does. It also refuses a signal at INMODE, ALUMODE2, ALUMODE3 or OPMODE6 of
a DSP, because the database has no feature for such a connection.
"""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Final

from scripts.bitstream_features import Features
from scripts.bitstream_lut_rams import ram_pins
from scripts.bitstream_routes import Routes
from scripts.bitstream_ties import inverter_feature, tie_feature, tied_pins
from scripts.netlist import ToolError

SHOWN: Final = 12
OUTPUT_REGISTERS: Final = {
    "REGCLKARDRCLK": "DOA_REG",
    "RDRCLK": "DOA_REG",
    "REGCLKB": "DOB_REG",
}
"""Feature that enables an output register of a block RAM, by the pin of the register's clock. The
clock may stay open if the register is not used (UG473)."""
CASCADE_INPUTS: Final = ("ACIN", "BCIN", "PCIN", "CARRYCASCIN", "MULTSIGNIN")
"""Names of the inputs of a DSP that only the DSP below can drive (UG479); the pins of a bus have a
number after the name."""


@cache
def inputs_of(family: Path, site_type: str) -> frozenset[str]:
    """Return the names of the input pins of a type of site."""
    text = (family / f"site_type_{site_type}.json").read_text(encoding="utf-8")
    pins = json.loads(text)["site_pins"]
    return frozenset(pin for pin, entry in pins.items() if entry["direction"] == "IN")


def blocks_in_use(features: Features) -> Iterator[tuple[str, int, str]]:
    """Yield, for every used DSP and half block RAM, the tile, the index in the tile's ``sites``,
    and the name in the features."""
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


def slices_with_ram(features: Features) -> Iterator[tuple[str, int, frozenset[str]]]:
    """Yield, for every slice with look-up tables as RAM, the tile, the index in the tile's
    ``sites``, and the features of the slice."""
    for tile in features.tiles:
        for place, site in enumerate(features.chip.type_of(tile).sites):
            if site["type"] != "SLICEM":
                continue
            start = f"SLICEM_X{site['name'][1]}."
            there = features.of(tile)
            own = frozenset(name.removeprefix(start) for name in there if name.startswith(start))
            if ram_pins(own):
                yield tile, place, own


def open_ram_pins(routes: Routes) -> list[str]:
    """Return a sentence for every undriven pin on which look-up tables as RAM depend."""
    faults = []
    for tile, place, own in slices_with_ram(routes.features):
        wires = routes.chip.type_of(tile).sites[place]["site_pins"]
        faults += [
            f"{tile} SLICEM, look-up tables as RAM: {pin} has no route, no tie-off and no default"
            for pin in ram_pins(own)
            if routes.source(tile, wires[pin]) is None
        ]
    return faults


def has_no_source(tile: str, name: str, pin: str) -> bool:
    """Tell whether no wire of the chip leads to a pin: a cascade input of a column's lowest DSP.

    The DSP must not depend on this pin, which has random levels in the decoded netlist.
    """
    is_lowest = name == "DSP48.DSP_0" and tile.endswith("Y0")
    return is_lowest and pin.rstrip("0123456789") in CASCADE_INPUTS


def open_pins(routes: Routes) -> list[str]:
    """Return a sentence for every undriven pin that must be driven, and for every tie-off of a
    DSP's pin whose inverter is on."""
    features = routes.features
    chip = features.chip
    faults = open_ram_pins(routes)
    for tile, place, name in blocks_in_use(features):
        own, there = chip.type_of(tile), features.of(tile)
        site = own.sites[place]
        for pin in sorted(inputs_of(chip.family, site["type"]) & site["site_pins"].keys()):
            register = OUTPUT_REGISTERS.get(pin)
            if register and f"{name}.{register}" not in there:
                continue
            if has_no_source(tile, name, pin):
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


@dataclass(frozen=True)
class Driven:
    """Numbers of the blocks whose pins are all driven."""

    blocks: int
    """Number of DSPs and halves of block RAMs."""
    slices: int
    """Number of slices with look-up tables as RAM."""

    def __str__(self) -> str:
        """Return both numbers in words, as a part of a sentence."""
        return (
            f"{self.blocks} DSPs and halves of block RAMs and {self.slices} slices with look-up "
            "tables as RAM, every pin driven"
        )


def check_pins_driven(routes: Routes) -> Driven:
    """Check that all pins are driven; return the numbers of blocks. Raises ToolError with the names
    of undriven pins."""
    faults = open_pins(routes)
    if faults:
        shown = "\n".join(f"  - {fault}" for fault in faults[:SHOWN])
        more = f"\n  and {len(faults) - SHOWN} more" if len(faults) > SHOWN else ""
        raise ToolError(
            f"{len(faults)} pins of DSPs or RAMs are not driven, so the results of the chip are "
            f"unknown:\n{shown}{more}"
        )
    features = routes.features
    return Driven(
        sum(1 for _ in blocks_in_use(features)), sum(1 for _ in slices_with_ram(features))
    )
