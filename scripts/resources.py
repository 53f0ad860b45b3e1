"""Counts cells of the 7 series in the JSON netlist that Yosys writes."""

from __future__ import annotations

import re
from collections import Counter
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path

# Number of LUT sites that each type of cell occupies (UG474 for the memories in LUTs).
LUTS = {
    **{f"LUT{inputs}": 1 for inputs in range(1, 7)},
    "INV": 1,
    "SRL16E": 1,
    "SRLC32E": 1,
    "RAM32X1S": 1,
    "RAM64X1S": 1,
    "RAM32X1D": 2,
    "RAM64X1D": 2,
    "RAM128X1S": 2,
    "RAM128X1D": 4,
    "RAM32M": 4,
    "RAM64M": 4,
    "RAM256X1S": 4,
}
FLIP_FLOPS = re.compile(r"FD[RSCP]E(_1)?")
LATCHES = re.compile(r"LD[CP]E|\$_?dlatch.*|\$_DLATCH.*", re.IGNORECASE)
RAMB36 = {"RAMB36E1": 1.0, "RAMB18E1": 0.5}

# Yosys writes one name or type per line, so that the file can be read line by line.
MODULE_LINE = re.compile(r'^    "([^"]+)": \{$')
BOX_LINE = re.compile(r'^        "(?:blackbox|whitebox)": ')
TYPE_LINE = re.compile(r'^          "type": "([^"]+)",?$')


@dataclass(frozen=True)
class Resources:
    """Resources of a part of the design; ``ramb36`` counts a RAMB18 as a half."""

    lut: int = 0
    ff: int = 0
    dsp: int = 0
    ramb36: float = 0.0
    carry4: int = 0
    latches: int = 0

    @staticmethod
    def of_cells(cells: Counter[str]) -> Resources:
        """Return the sum of the resources of cells, whose numbers are given by type; all types that
        this module does not name need no resources."""
        return Resources(
            lut=sum(LUTS.get(kind, 0) * count for kind, count in cells.items()),
            ff=sum(count for kind, count in cells.items() if FLIP_FLOPS.fullmatch(kind)),
            dsp=cells["DSP48E1"],
            ramb36=sum(RAMB36.get(kind, 0.0) * count for kind, count in cells.items()),
            carry4=cells["CARRY4"],
            latches=sum(count for kind, count in cells.items() if LATCHES.fullmatch(kind)),
        )

    def __add__(self, other: Resources) -> Resources:
        """Return the sum of two resources, kind by kind."""
        return Resources(
            self.lut + other.lut,
            self.ff + other.ff,
            self.dsp + other.dsp,
            self.ramb36 + other.ramb36,
            self.carry4 + other.carry4,
            self.latches + other.latches,
        )


@dataclass
class Design:
    """Numbers of cells in a netlist, by module and type."""

    cells: dict[str, Counter[str]] = field(default_factory=dict)

    @staticmethod
    def read(path: Path) -> Design:
        """Read a file of Yosys' ``write_json``. Raises ValueError for a file without a module."""
        design = Design()
        module = ""
        inside = False
        with path.open(encoding="utf-8") as lines:
            for line in lines:
                if not inside:
                    inside = line.startswith('  "modules"')
                elif found := MODULE_LINE.match(line):
                    module = found[1]
                    design.cells[module] = Counter()
                elif BOX_LINE.match(line):
                    del design.cells[module]  # the module is the model of a cell of the family
                    module = ""
                elif module and (found := TYPE_LINE.match(line)):
                    design.cells[module][found[1].removeprefix("\\")] += 1
        if not design.cells:
            raise ValueError(f"{path}: no module in it; it should be written by Yosys' write_json")
        return design

    def total(self, module: str) -> Resources:
        """Return the resources of a module together with all modules below it."""

        @cache
        def below(name: str) -> Resources:
            sum_ = Resources.of_cells(self.cells[name])
            for kind, count in self.cells[name].items():
                if self.cells.get(kind):
                    for _ in range(count):
                        sum_ = sum_ + below(kind)
            return sum_

        return below(module)

    def units(self, top: str) -> list[tuple[str, int, int, Resources]]:
        """Return each module with its depth, number of instances in its parent, and resources of
        one instance; the modules below a module follow it, those with the most LUTs first."""
        rows: list[tuple[str, int, int, Resources]] = []

        def walk(name: str, depth: int, count: int) -> None:
            rows.append((name, depth, count, self.total(name)))
            children = [kind for kind in self.cells[name] if self.cells.get(kind)]
            for kind in sorted(children, key=lambda kind: -self.total(kind).lut):
                walk(kind, depth + 1, self.cells[name][kind])

        walk(top, 0, 1)
        return rows
