"""Writes a configured chip as a netlist in Verilog; it starts at the chip's outputs and follows the
signals backwards.

Outputs of the chip are pads and the inputs of the PS7. Inputs of the chip are pads and the PS7's
outputs. The program follows the wires from each output to the pin that drives it, writes the cell
of that pin, follows the wires from the inputs of the cell, and so on. A pin without a driver gets a
separate input in ``open_lines``, to which the simulation of the netlist gives random levels.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Final

from scripts.bitstream_blocks import dsp, ram_half
from scripts.bitstream_routes import Routes, Source
from scripts.bitstream_slices import Slice, Text
from scripts.netlist import ToolError

LEAST_BITS: Final = 96
"""Smallest width of a bus of the netlist; at this width and above, a bus is an array of words in
Verilator's C++."""
RAM_HALVES: Final = {"L": "FIFO18E1", "U": "RAMB18E1", "FIFO18": "FIFO18E1", "RAMB18": "RAMB18E1"}
"""Type of site of half a block RAM, by the letter or type in the name of a wire. A site of type
RAMBFIFO36E1 contains both halves."""
RAM_OUTPUT: Final = re.compile(
    r"BRAM_(?P<site>\w+)_DO(?P<parity>P?)(?P<port>[AB])DOP?(?P<half>[LU]?)(?P<bit>\d+)"
)


@dataclass
class Decoded:
    """Decoded netlist, with the names of the bits of each bus in the order of the bits."""

    verilog: str = ""
    clock: int = 0
    """Number of the input line that is the clock of every register and block."""
    inputs: list[str] = field(default_factory=list)
    outputs: list[str] = field(default_factory=list)
    open_pins: list[str] = field(default_factory=list)
    activity: list[tuple[str, int, int]] = field(default_factory=list)
    """Name, first bit in the bus ``activity`` and number of bits of every DSP, of every half of a
    block RAM, and of every used output of a look-up table as RAM."""


def bus_bits(count: int) -> int:
    """Return the width of a bus for ``count`` lines."""
    return max(LEAST_BITS, count)


class Decoder:
    """Writes the cells of a chip in the order in which the search reaches them."""

    def __init__(
        self,
        routes: Routes,
        pads: Mapping[str, str],
        inputs: Sequence[str],
        wires: Collection[str] = (),
    ) -> None:
        """Store the tables of the ports.

        ``pads``: the port of each pad by its site; ``inputs``: ports of pads and pins of the PS7;
        ``wires``: ports that both sides may pull low and no side drives high.
        """
        self.routes = routes
        self.features = routes.features
        self.chip = routes.chip
        self.pads = dict(pads)
        self.text = Text()
        self.made = Decoded(inputs=list(inputs))
        self._input_bits = {name: bit for bit, name in enumerate(inputs)}
        self._wires = frozenset(wires)
        self._levels: dict[str, str] = {}
        self._slices: dict[tuple[str, int], Slice] = {}
        self._blocks: set[tuple[str, int]] = set()
        self._nets: dict[tuple[str, int, str], str] = {}
        self._waiting: list[tuple[str, int, str]] = []
        self._open: dict[tuple[str, int, str], str] = {}

    def _site(self, tile: str, site: int) -> tuple[str, Mapping[str, str]]:
        found = self.chip.type_of(tile).sites[site]
        return found["type"], found["site_pins"]

    def pin(self, tile: str, site: int, pin: str) -> str:
        """Return the net at an input pin of a site."""
        kind, pins = self._site(tile, site)
        if pin not in pins:
            raise ToolError(f"{tile}: a {kind} has no pin {pin}")
        return self.net(self.routes.source(tile, pins[pin]), (tile, site, pin))

    def net(self, source: Source | None, sink: tuple[str, int, str]) -> str:
        """Return the name of the net that drives a pin."""
        if source is not None and self._is_idle(source):
            source = None
        if source is None:
            if sink not in self._open:
                self._open[sink] = f"open_lines[{len(self._open)}]"
                kind = self._site(sink[0], sink[1])[0]
                self.made.open_pins.append(f"{sink[0]} {kind} {sink[2]}")
            return self._open[sink]
        if source.level is not None:
            return f"1'b{source.level}"
        key = (source.tile, source.site, source.pin)
        if key not in self._nets:
            self._nets[key] = self._enter(*key)
        return self._nets[key]

    def _is_idle(self, source: Source) -> bool:
        """Tell whether a pin belongs to an unused DSP; the output levels of such a DSP are
        unknown."""
        if source.level is not None or self._site(source.tile, source.site)[0] != "DSP48E1":
            return False
        half = self.chip.type_of(source.tile).sites[source.site]["name"][-1]
        return not self._features_of(source.tile, f"DSP48.DSP_{half}")

    def _enter(self, tile: str, site: int, pin: str) -> str:
        """Return the net of an output pin, and add its cell to the list of cells to write."""
        kind, _ = self._site(tile, site)
        if kind in ("BUFGCTRL", "BUFHCE"):
            return self._buffer(tile, site, kind)
        if kind == "ILOGICE3" and pin == "O":
            return self._input_logic(tile, site)
        if kind == "PS7":
            return self._from_outside(pin)
        if kind.startswith("IOB33") and pin == "I":
            return self._level_of(tile, site)
        name = f"{tile}_{site}_{pin}"
        if kind in ("SLICEL", "SLICEM"):
            self._waiting.append((tile, site, pin))
            return name
        if kind == "DSP48E1":
            self._waiting.append((tile, site, pin))
            return self._dsp_net(tile, site, pin)
        if kind in ("RAMB18E1", "FIFO18E1", "RAMBFIFO36E1"):
            return self._ram_net(tile, site, pin)
        raise ToolError(f"{tile}: a {kind} drives something by its pin {pin}: it is not decoded")

    def _from_outside(self, name: str) -> str:
        if name not in self._input_bits:
            raise ToolError(f"{name} drives something, but the design has no such input")
        return f"inputs[{self._input_bits[name]}]"

    def _level_of(self, tile: str, site: int) -> str:
        """Return the level of a pad: low if its driver or the outside pulls it low, otherwise the
        level of the outside."""
        port = self._port_of(tile, site)
        if port not in self._wires:
            return self._from_outside(port)
        if port not in self._levels:
            self._levels[port] = name = f"{tile}_{site}_wire"
            driven, value = (self._pad_pin(tile, site, pin) for pin in "TO")
            self.text.wire(name, f"{self._from_outside(port)} & ({driven} | {value})")
        return self._levels[port]

    def _port_of(self, tile: str, site: int) -> str:
        """Return the port of a pad, or its site if it has no port."""
        own = self.chip.type_of(tile).sites[site]
        names = [str(name) for name in self.chip.tiles[tile]["sites"] if name.startswith("IOB")]
        names.sort(key=lambda name: int(name.rpartition("Y")[2]))
        # A tile at the end of a column has one pad in place of two.
        name = names[int(own["name"][-1]) % len(names)]
        return self.pads.get(name, name)

    def _buffer(self, tile: str, site: int, kind: str) -> str:
        """Write a clock buffer that passes its input to its output. Any other use is refused."""
        there = self.features.of(tile)
        own = self.chip.type_of(tile).sites[site]
        name = f"{kind}.{kind}_{own['name']}" if kind == "BUFHCE" else None
        if name is None:
            name = f"BUFGCTRL.BUFGCTRL_{own['name']}"

        def is_high(pin: str) -> bool:
            level = self.pin(tile, site, pin)
            return level == ("1'b1" if f"{name}.ZINV_{pin}" in there else "1'b0")

        if f"{name}.IN_USE" not in there:
            raise ToolError(f"{tile}: {name} drives a clock and is not in use")
        if kind == "BUFHCE":
            if not is_high("CE"):
                raise ToolError(f"{tile}: {name} is not always enabled")
            return self.pin(tile, site, "I")
        if not (is_high("CE0") and is_high("S0")) or (is_high("CE1") and is_high("S1")):
            raise ToolError(f"{tile}: {name} does not always choose its input I0")
        return self.pin(tile, site, "I0")

    def _input_logic(self, tile: str, site: int) -> str:
        wire = self._site(tile, site)[1]["D"]
        found = re.search(r"ILOGIC(\d)", wire)
        assert found
        net = self.pin(tile, site, "D")
        is_straight = f"ILOGIC_Y{found[1]}.ZINV_D" in self.features.of(tile)
        return net if is_straight else f"~{net}"

    def _output_logic(self, source: Source) -> str:
        """Return the net that an OLOGICE3 passes to a pad or to the pad's enable."""
        there = self.features.of(source.tile)
        found = re.search(r"OLOGIC(\d)", self._site(source.tile, source.site)[1][source.pin])
        assert found
        name = f"OLOGIC_Y{found[1]}"
        if source.pin == "OQ":
            if not {f"{name}.OMUX.D1", f"{name}.OQUSED"} <= there:
                raise ToolError(f"{source.tile}: {name} does not let its data through")
            return self.pin(source.tile, source.site, "D1")
        net = self.pin(source.tile, source.site, "T1")
        if f"{name}.ZINV_T1" in there:
            return net
        return {"1'b0": "1'b1", "1'b1": "1'b0"}.get(net, f"~{net}")

    def _pad_pin(self, tile: str, site: int, pin: str) -> str:
        source = self.routes.source(tile, self._site(tile, site)[1][pin])
        if source is None or source.level is not None:
            return self.net(source, (tile, site, pin))
        if self._site(source.tile, source.site)[0] == "OLOGICE3":
            return self._output_logic(source)
        return self.net(source, (tile, site, pin))

    def add_pad(self, name: str) -> None:
        """Add an output of the design that is a pad. Raises ToolError if the pad is not always
        driven."""
        site_name = next(site for site, port in self.pads.items() if port == name)
        tile = self.chip.of_site[site_name]
        for site, own in enumerate(self.chip.type_of(tile).sites):
            if own["type"].startswith("IOB33") and self._port_of(tile, site) == name:
                if name in self._wires:
                    self._leave(name, self._level_of(tile, site))
                    return
                if self._pad_pin(tile, site, "T") != "1'b0":
                    raise ToolError(f"the pad of {name} is not always driven")
                self._leave(name, self._pad_pin(tile, site, "O"))
                return
        raise ToolError(f"{site_name}, the pad of {name}, is not an IOB33 of {tile}")

    @cached_property
    def _processor(self) -> tuple[str, int]:
        """Return the tile and the site of the PS7."""
        for tile in self.chip.tiles:
            if self.chip.tiles[tile]["type"].startswith("PSS"):
                for site, own in enumerate(self.chip.type_of(tile).sites):
                    if own["type"] == "PS7":
                        return tile, site
        raise ToolError(f"{self.chip.part} has no PS7")

    def add_processor_pin(self, name: str) -> None:
        """Add an output of the design that is an input of the PS7."""
        self._leave(name, self.pin(*self._processor, name))

    def _leave(self, name: str, net: str) -> None:
        self.text.assignments.append(f"assign outputs[{len(self.made.outputs)}] = {net};")
        self.made.outputs.append(name)

    def finish(self) -> Decoded:
        """Write all cells on the list, then return the whole netlist."""
        while self._waiting:
            tile, site, pin = self._waiting.pop()
            kind, _ = self._site(tile, site)
            if kind == "DSP48E1":
                self._add_dsp(tile, site)
            elif kind in RAM_HALVES.values():
                self._add_ram(tile, site)
            else:
                text = self._slice(tile, site).output(pin)
                self.text.wire(f"{tile}_{site}_{pin}", text)
        for made in self._slices.values():
            for net in made.ram_outputs:
                self.text.assignments.append(f"assign {self._block_out(net, 1)} = {net};")
        self.made.clock = self._clock()
        self.made.verilog = self._verilog()
        return self.made

    def _clock(self) -> int:
        nets = {edge.split(" ", 1)[1] for edge in self.text.clocked}
        found = re.fullmatch(r"inputs\[(\d+)\]", nets.pop()) if len(nets) == 1 else None
        if not found:
            raise ToolError(f"expected one clock from outside, found {', '.join(sorted(nets))}")
        return int(found[1])

    def _slice(self, tile: str, site: int) -> Slice:
        if (tile, site) not in self._slices:
            own = self.chip.type_of(tile).sites[site]
            name = f"{own['type']}_X{own['name'][1]}"
            self._slices[tile, site] = Slice(
                f"{tile}_{site}",
                self._features_of(tile, name),
                lambda pin: self.pin(tile, site, pin),
                self.text,
            )
        return self._slices[tile, site]

    def _features_of(self, tile: str, site: str) -> frozenset[str]:
        start = f"{site}."
        there = self.features.of(tile)
        return frozenset(name.removeprefix(start) for name in there if name.startswith(start))

    def _block_out(self, name: str, bits: int) -> str:
        first = sum(count for _, _, count in self.made.activity)
        self.made.activity.append((name, first, bits))
        self.text.declarations.append(f"wire [{bits - 1}:0] {name}_out;")
        self.text.assignments.append(f"assign activity[{first}+:{bits}] = {name}_out;")
        return f"{name}_out"

    def _dsp_net(self, tile: str, site: int, pin: str) -> str:
        found = re.fullmatch(r"P(?:COUT)?(\d+)", pin)
        if not found:
            raise ToolError(f"{tile}: the output {pin} of a DSP48E1 is not decoded")
        return f"{tile}_{site}_out[{found[1]}]"

    def _add_dsp(self, tile: str, site: int) -> None:
        if (tile, site) in self._blocks:
            return
        self._blocks.add((tile, site))
        name = f"{tile}_{site}"
        half = self.chip.type_of(tile).sites[site]["name"][-1]
        features = self._features_of(tile, f"DSP48.DSP_{half}")
        out = self._block_out(name, 48)
        pin = lambda pin: self.pin(tile, site, pin)  # noqa: E731
        self.text.assignments.append(dsp(f"{name}_dsp", features, pin, out))

    def _ram_net(self, tile: str, site: int, pin: str) -> str:
        """Return the net at an output of a block RAM, in the site that has the pin."""
        found = RAM_OUTPUT.fullmatch(self._site(tile, site)[1][pin])
        if not found:
            raise ToolError(f"{tile}: the output {pin} of a block RAM is not decoded")
        half = RAM_HALVES[found["half"] or found["site"]]
        sites = [own["type"] for own in self.chip.type_of(tile).sites]
        place = sites.index(half)
        self._waiting.append((tile, place, pin))
        first = (16 if found["parity"] else 0) + (18 if found["port"] == "B" else 0)
        return f"{tile}_{place}_out[{first + int(found['bit'])}]"

    def _add_ram(self, tile: str, site: int) -> None:
        if (tile, site) in self._blocks:
            return
        self._blocks.add((tile, site))
        name = f"{tile}_{site}"
        kind, pins = self._site(tile, site)
        half = int(kind == "RAMB18E1")
        features = self._features_of(tile, f"RAMB18_Y{half}") | {
            feature.removeprefix("RAMB36.")
            for feature in self.features.of(tile)
            if not feature.startswith("RAMB18_Y")
        }
        out = self._block_out(name, 36)
        pin = lambda pin: self.pin(tile, site, pin)  # noqa: E731
        text = ram_half(f"{name}_ram", features, pin, lambda own: own in pins, out)
        self.text.assignments.append(text)

    def _verilog(self) -> str:
        active = sum(count for _, _, count in self.made.activity)
        buses = (
            ("input", "inputs", len(self.made.inputs)),
            ("input", "open_lines", len(self.made.open_pins)),
            ("output", "outputs", len(self.made.outputs)),
            ("output", "activity", active),
        )
        ports = ", ".join(
            f"{way} wire [{bus_bits(count) - 1}:0] {name}" for way, name, count in buses
        )
        lines = [f"module decoded ({ports});", *self.text.declarations]
        lines += [f"wire clock = inputs[{self.made.clock}];", *self.text.assignments]
        for edge, statements in self.text.clocked.items():
            lines += [f"always @({edge.split(' ', 1)[0]} clock) begin", *statements, "end"]
        for name, used in (("outputs", len(self.made.outputs)), ("activity", active)):
            if used < bus_bits(used):
                lines.append(f"assign {name}[{bus_bits(used) - 1}:{used}] = 0;")
        return "\n".join([*lines, "endmodule", ""])


def pads_of(chip_folder: Path, ports: Mapping[str, str]) -> dict[str, str]:
    """Return the port of each pad by its site; ``ports``: the pin of the package by its port.

    Raises ToolError for a pin that the package does not have.
    """
    rows = (chip_folder / "package_pins.csv").read_text(encoding="ascii").splitlines()[1:]
    sites = {row.split(",")[0]: row.split(",")[2] for row in rows}
    lacking = sorted(pin for pin in ports.values() if pin not in sites)
    if lacking:
        raise ToolError(f"{chip_folder}: the package has no pin {', '.join(lacking)}")
    return {sites[pin]: port for port, pin in ports.items()}
