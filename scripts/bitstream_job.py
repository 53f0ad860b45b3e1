"""Describes the inputs and outputs of a bitstream build; all flows use this description."""

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
OSCILLATOR_MHZ = 125  # oscillator at pin H16 of Arty Z7-20 and PYNQ-Z2


class TimingError(Exception):
    """Raised if the design does not reach its clock frequency. The message states the shortfall and
    where to read more."""


@dataclass(frozen=True)
class Top:
    """Top level below rtl/top, with the facts that a flow needs to build it.

    ``primitives``: number of each kind of cell that connects the top level to the chip. ``vivado``
    and ``scoped`` name files in constraints/vivado that only Vivado reads. The file ``vivado`` is
    for the top's pins; each file of ``scoped`` is for all instances of one entity inside the top.
    ``has_core``: whether the top has the generics of the core.
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
"""Name of the top level for three and four heads, by the name of the top level for two heads."""

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
"""Names of the top levels that the user chooses directly. The variable HEADS of make selects the
top levels for three and four heads."""


@dataclass(frozen=True)
class Job:
    """Description of a bitstream to build. ``pins`` is an XDC file; ``folder`` is for all files
    that the flow makes."""

    top: Top
    part: str
    generics: Mapping[str, int | str | bool]
    pins: Path
    folder: Path
    seed: int | None = None  # seed of nextpnr's placement; None: nextpnr's default

    @property
    def reports(self) -> Path:
        """Return the folder for logs and reports."""
        return self.folder / "reports"

    @property
    def bitstream(self) -> Path:
        """Return the path of the bitstream that the flow writes."""
        return self.folder / "arctrue.bit"


@dataclass(frozen=True)
class Tool:
    """Program of a flow: its names, the environment variable by which a user chooses it, and advice
    if it is missing.

    ``folder``, a folder of this source tree, is searched after PATH.
    """

    variable: str
    commands: tuple[str, ...]
    advice: str
    folder: Path | None = None

    def find(self) -> str | None:
        """Return the command that the variable names if it is set, otherwise the first of the names
        that is found, or None."""
        chosen = os.environ.get(self.variable)
        if chosen:
            return shutil.which(chosen)
        found = [shutil.which(command) for command in self.commands]
        if self.folder:
            found += [shutil.which(command, path=str(self.folder)) for command in self.commands]
        return next((command for command in found if command), None)

    def missing(self) -> str:
        """Return one line that states which commands are not on PATH, or that the program in the
        variable cannot be started, and what the user can do."""
        chosen = os.environ.get(self.variable)
        if chosen:
            looked = f"{self.variable}={chosen} is not a program that can be started"
        else:
            looked = f"{' or '.join(self.commands)} is not on PATH"
        return f"{looked}. {self.advice}"


def all_found(tools: Sequence[Tool], others: Sequence[str] = ()) -> list[str]:
    """Return the commands of ``tools``, in their order.

    Raises ToolError, which names all missing tools at once. ``others`` are sentences about other
    missing things.
    """
    found = [tool.find() for tool in tools]
    lines = [tool.missing() for tool, command in zip(tools, found, strict=True) if not command]
    lines += others
    if lines:
        raise ToolError("missing for this flow:\n" + "\n".join(f"  - {line}" for line in lines))
    return [command for command in found if command]


def in_order_of_use(files: Sequence[Path]) -> list[Path]:
    """Return VHDL files in an order in which each file comes after the files whose units it uses.

    A unit is used as ``work.<name>``, and a file has the name of its unit. Raises ToolError if
    files use each other in a circle.
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
