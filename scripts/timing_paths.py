"""Finds the longest paths between registers of a flat netlist, and the adders on each.

For every bit that enters a register, the program determines the longest path to this bit, and the
largest number of wide adders and DSPs on any path to it.
"""

from __future__ import annotations

import json
import re
from collections import Counter, defaultdict, deque
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Final

from scripts.cell_delays import Arc, timing_of, wire_ns

# Smallest number of CARRY4 in the carry chain of a wide adder (13 bits or more).
WIDE_CARRY4: Final = 4

# Pattern of net names that tools have made; names from the VHDL are preferred.
GIVEN_BY_TOOL: Final = re.compile(r"(^|\.)(n\d+(_\w)?$|\$)|\$(auto|abc|iopadmap|techmap)")


@dataclass(frozen=True)
class LongPath:
    """Longest path to one register; ``levels`` and ``carry4`` are its numbers of LUTs and of
    CARRY4."""

    start: str
    end: str
    delay_ns: float
    levels: int
    carry4: int
    wires: int


@dataclass(frozen=True)
class Crowded:
    """Register to which a path leads through ``adders`` (more than one) wide adders or DSPs."""

    start: str
    end: str
    adders: int


@dataclass
class _Reached:
    """Longest path to a bit found so far, and the path with the most adders."""

    delay_ns: float = 0.0
    longest: Arc | None = None
    adders: int = 0
    most: Arc | None = None


@dataclass
class Netlist:
    """Flat module of a Yosys JSON file: its bits, and the arcs that connect them."""

    names: dict[int, str] = field(default_factory=dict)
    begins: dict[int, tuple[float, int]] = field(default_factory=dict)
    ends: list[tuple[int, float, int, str]] = field(default_factory=list)
    """Ends of paths: bit, set-up time in ns, number of DSPs, and name of the register."""
    arcs_from: dict[int, list[Arc]] = field(default_factory=lambda: defaultdict(list))
    fan_out: Counter[int] = field(default_factory=Counter)
    wide_bits: set[int] = field(default_factory=set)
    """Output bits of the carry chains of wide adders."""
    carry_bits: set[int] = field(default_factory=set)

    @staticmethod
    def read(path: Path, top: str) -> Netlist:
        """Read ``top`` of a flattened netlist. Raises ValueError for a cell without delays."""
        module = json.loads(path.read_text(encoding="utf-8"))["modules"][top]
        netlist = Netlist()
        netlist._name_bits(module["netnames"])
        cells = list(module["cells"].values())
        for cell in cells:
            timing = timing_of(cell)
            for pin in timing.begins:
                netlist.begins[pin.bit] = (pin.delay_ns, pin.multipliers)
            name = netlist._name_of(cell)
            netlist.ends += [(pin.bit, pin.delay_ns, pin.multipliers, name) for pin in timing.ends]
            for arc in timing.arcs:
                netlist.arcs_from[arc.start].append(arc)
            loads = {pin.bit for pin in timing.ends} | {arc.start for arc in timing.arcs}
            netlist.fan_out.update(loads)
        netlist._find_wide_chains([cell for cell in cells if cell["type"] == "CARRY4"])
        return netlist

    def _name_bits(self, netnames: dict[str, Any]) -> None:
        """Choose the best name of each bit: a short name from the VHDL, of a net with few bits (no
        record)."""
        rank: dict[int, tuple[bool, int, int]] = {}
        for name, net in netnames.items():
            quality = (bool(GIVEN_BY_TOOL.search(name)), len(net["bits"]), len(name))
            for bit in net["bits"]:
                if isinstance(bit, int) and (bit not in rank or quality < rank[bit]):
                    rank[bit] = quality
                    self.names[bit] = name

    def _name_of(self, cell: dict[str, Any]) -> str:
        """Return the name of the net that a register drives; for a memory, the name of the first
        named output."""
        directions = cell.get("port_directions", {})
        kind = str(cell["type"])
        for port, bits in cell["connections"].items():
            if directions.get(port) == "output":
                for bit in bits:
                    if bit in self.names:
                        found = self.names[bit]
                        return found if kind.startswith("FD") else f"{found} ({kind})"
        return kind

    def _find_wide_chains(self, cells: list[dict[str, Any]]) -> None:
        by_carry_in = {}
        for cell in cells:
            for bit in cell["connections"].get("CI", []):
                if isinstance(bit, int):
                    by_carry_in[bit] = cell
        for cell in cells:
            for port in ("O", "CO"):
                self.carry_bits |= {
                    bit for bit in cell["connections"].get(port, []) if isinstance(bit, int)
                }
        fed = {id(cell) for cell in by_carry_in.values()}
        for head in cells:
            carry_in = [bit for bit in head["connections"].get("CI", []) if isinstance(bit, int)]
            if id(head) in fed and any(bit in self.carry_bits for bit in carry_in):
                continue
            chain = [head]
            while True:
                carry_out = chain[-1]["connections"].get("CO", [])
                following = by_carry_in.get(carry_out[3]) if len(carry_out) == 4 else None
                if following is None:
                    break
                chain.append(following)
            if len(chain) >= WIDE_CARRY4:
                for cell in chain:
                    for port in ("O", "CO"):
                        self.wide_bits |= {
                            bit for bit in cell["connections"].get(port, []) if isinstance(bit, int)
                        }

    def _wire_ns(self, arc: Arc, bit: int) -> float:
        """Return the delay of the wire at an arc; 0 within a carry chain, and from a LUT to its
        multiplexer."""
        if arc.is_direct:
            return 0.0
        if not arc.is_carry_entry and bit in self.carry_bits and arc.end in self.carry_bits:
            return 0.0
        return wire_ns(self.fan_out[bit])

    def reached(self) -> dict[int, _Reached]:
        """Return, for every bit that a path from a register reaches, the path with the longest
        delay and the path with the most adders.

        Raises ValueError if logic feeds itself: place and route cannot time such a loop.
        """
        waiting: Counter[int] = Counter()
        for arcs in self.arcs_from.values():
            for arc in arcs:
                waiting[arc.end] += 1
        found: dict[int, _Reached] = {}
        for bit, (delay_ns, multipliers) in self.begins.items():
            found[bit] = _Reached(delay_ns, None, multipliers, None)
        ready = deque(
            bit for bit in {*self.begins, *self.arcs_from} - {b for b, n in waiting.items() if n}
        )
        while ready:
            bit = ready.popleft()
            here = found.setdefault(bit, _Reached())
            for arc in self.arcs_from.get(bit, ()):
                there = found.setdefault(arc.end, _Reached())
                delay_ns = here.delay_ns + self._wire_ns(arc, bit) + arc.delay_ns
                enters = arc.is_carry_entry and arc.end in self.wide_bits
                adders = here.adders + arc.multipliers + enters
                if delay_ns > there.delay_ns:
                    there.delay_ns, there.longest = delay_ns, arc
                if adders > there.adders:
                    there.adders, there.most = adders, arc
                waiting[arc.end] -= 1
                if not waiting[arc.end]:
                    ready.append(arc.end)
        if loop := self._loop({bit for bit, count in waiting.items() if count}):
            raise ValueError(f"the logic feeds itself: {' -> '.join(loop)}")
        return found

    def _loop(self, waiting: set[int]) -> list[str]:
        """Return the names along a loop among ``waiting``, bits that wait for each other; return an
        empty list if there is no loop."""
        before = {
            arc.end: bit
            for bit in waiting
            for arc in self.arcs_from.get(bit, ())
            if arc.end in waiting
        }
        if not before:
            return []
        # Each bit in ``before`` follows a bit that also waits, so that a walk against the arcs must
        # reach a bit a second time.
        bit, walked = next(iter(before)), dict[int, None]()
        while bit not in walked:
            walked[bit] = None
            bit = before[bit]
        along = list(walked)
        return [self.name(bit) for bit in [bit, *reversed(along[along.index(bit) :])]]

    def name(self, bit: int) -> str:
        """Return the name of a net without its bit number."""
        return self.names.get(bit, "?")


def _walk(found: dict[int, _Reached], bit: int, attribute: str) -> tuple[int, list[Arc]]:
    arcs: list[Arc] = []
    while (arc := getattr(found[bit], attribute)) is not None:
        arcs.append(arc)
        bit = arc.start
    return bit, arcs


def longest_paths(netlist: Netlist, found: dict[int, _Reached]) -> list[LongPath]:
    """Return the longest path to each register, longest first; bits of one name are one
    register."""
    worst: dict[str, tuple[float, int, str]] = {}
    for bit, setup_ns, _, end in netlist.ends:
        if bit in found:
            delay_ns = found[bit].delay_ns + wire_ns(netlist.fan_out[bit]) + setup_ns
            if delay_ns > worst.get(end, (0.0, 0, ""))[0]:
                worst[end] = (delay_ns, bit, end)
    paths = []
    for delay_ns, bit, end in sorted(worst.values(), reverse=True):
        start, arcs = _walk(found, bit, "longest")
        in_chain = sum(arc.end in netlist.carry_bits for arc in arcs)
        levels = sum(arc.levels for arc in arcs)
        wires = 1 + sum(netlist._wire_ns(arc, arc.start) > 0 for arc in arcs)
        paths.append(LongPath(netlist.name(start), end, delay_ns, levels, in_chain, wires))
    return paths


def crowded_registers(netlist: Netlist, found: dict[int, _Reached]) -> list[Crowded]:
    """Return every register with a path through more than one wide adder or DSP, most adders
    first."""
    worst: dict[str, Crowded] = {}
    for bit, _, multipliers, end in netlist.ends:
        if bit in found:
            adders = found[bit].adders + multipliers
            if adders > 1 and (end not in worst or adders > worst[end].adders):
                start, _ = _walk(found, bit, "most")
                worst[end] = Crowded(netlist.name(start), end, adders)
    return sorted(worst.values(), key=lambda entry: (-entry.adders, entry.end))
