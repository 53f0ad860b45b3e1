"""Describes the inputs and outputs of a bitstream build, the same for every flow."""

from __future__ import annotations

import os
import re
import shutil
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from arctrue.generated import number_formats
from scripts.netlist import ROOT, ToolError

CONSTRAINTS = ROOT / "constraints"
OSCILLATOR_MHZ = 125  # oscillator of both boards, at their pin H16


class TimingError(Exception):
    """The design does not run at its clock. The text says by how much and where to read more."""


@dataclass(frozen=True)
class Top:
    """A top level below rtl/top, and its requirements to a flow.

    ``primitives``: number of each cell that ties it to the chip. ``vivado`` and ``scoped`` are
    files in constraints/vivado, which Vivado alone reads: ``vivado`` is for the top's pins,
    ``scoped`` for the entities inside, in order; each is read for every instance of its entity.
    ``has_core``: it has the generics of the core.
    """

    name: str
    clock_mhz: int
    primitives: Mapping[str, int]
    vivado: str
    scoped: tuple[str, ...] = ()
    has_core: bool = True


HEADS_TOPS = {
    "arctrue_zynq_top": "arctrue_zynq_heads_top",
    "encoder_source_top": "encoder_source_heads_top",
}
"""Maps each top level with two heads and pins for more to that for three and four heads."""

DEVICE_CLOCK_MHZ = number_formats.CLOCK_HZ // 1_000_000
DEVICE_PRIMITIVES = {"PS7": 1, "BUFG": 1}
DEVICE_SCOPED = ("zynq_processor", "quadrature_output", "pulse_output", "chip_dna")
TOPS = {
    top.name: top
    for top in (
        *(
            Top(name, DEVICE_CLOCK_MHZ, DEVICE_PRIMITIVES, "arctrue_zynq_top", DEVICE_SCOPED)
            for name in (
                "arctrue_zynq_top",
                "arctrue_zynq_heads_top",
                "arctrue_zynq_differential_top",
            )
        ),
        *(
            Top(
                name,
                OSCILLATOR_MHZ,
                {"PS7": 0, "BUFG": 1},
                vivado="encoder_source_top",
                has_core=False,
            )
            for name in ("encoder_source_top", "encoder_source_heads_top")
        ),
    )
}
TWO_HEADS_TOPS = tuple(name for name in TOPS if name not in HEADS_TOPS.values())
"""Top levels that the user chooses by name. HEADS chooses the others."""


@dataclass(frozen=True)
class Job:
    """One bitstream. ``pins`` is an XDC file, and ``folder`` takes every file that is made."""

    top: Top
    part: str
    generics: Mapping[str, int | str | bool]
    pins: Path
    folder: Path
    seed: int | None = None  # seed of nextpnr's placement; None: nextpnr's default

    @property
    def reports(self) -> Path:
        """Return the folder of logs and reports."""
        return self.folder / "reports"

    @property
    def bitstream(self) -> Path:
        """Return the file that the flow writes."""
        return self.folder / "arctrue.bit"


@dataclass(frozen=True)
class Tool:
    """A program: how the user may name it, and what to do if it is missing.

    ``folder`` of this tree is searched after PATH.
    """

    variable: str
    commands: tuple[str, ...]
    advice: str
    folder: Path | None = None

    def find(self) -> str | None:
        """Return the variable's command if it is set, else the first one found, or None."""
        chosen = os.environ.get(self.variable)
        if chosen:
            return shutil.which(chosen)
        found = [shutil.which(command) for command in self.commands]
        if self.folder:
            found += [shutil.which(command, path=str(self.folder)) for command in self.commands]
        return next((command for command in found if command), None)

    def missing(self) -> str:
        """Return one line that says what was searched, where, and what to do."""
        chosen = os.environ.get(self.variable)
        if chosen:
            looked = f"{self.variable}={chosen} is not a program that can be started"
        else:
            looked = f"{' or '.join(self.commands)} is not on PATH"
        return f"{looked}. {self.advice}"


def all_found(tools: Sequence[Tool], others: Sequence[str] = ()) -> list[str]:
    """Return the commands of ``tools``, in their order.

    Raises ToolError that names everything that is missing at once. ``others`` are sentences about
    further missing things.
    """
    found = [tool.find() for tool in tools]
    lines = [tool.missing() for tool, command in zip(tools, found, strict=True) if not command]
    lines += others
    if lines:
        raise ToolError("missing for this flow:\n" + "\n".join(f"  - {line}" for line in lines))
    return [command for command in found if command]


def in_order_of_use(files: Sequence[Path]) -> list[Path]:
    """Return VHDL files in an order in which each comes after those whose units it uses.

    A unit is used as ``work.<name>``, and a file is named like its unit. Raises ToolError where
    files name each other in a circle.
    """
    by_name = {path.stem: path for path in files}
    names = {}
    for name, path in by_name.items():
        text = re.sub(r"--[^\n]*", "", path.read_text(encoding="utf-8"))
        used = {unit.lower() for unit in re.findall(r"\bwork\.(\w+)", text)}
        names[name] = sorted((used & by_name.keys()) - {name})
    ordered: list[Path] = []
    state: dict[str, bool] = {}

    def place(name: str) -> None:
        if name in state:
            if not state[name]:
                raise ToolError(f"{by_name[name]}: VHDL files name each other in a circle")
            return
        state[name] = False
        for other in names[name]:
            place(other)
        state[name] = True
        ordered.append(by_name[name])

    for name in sorted(by_name):
        place(name)
    return ordered
