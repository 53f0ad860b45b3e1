"""Finds the cells that Vivado creates from VHDL sources, with the names that Vivado's constraints
use.

The module searches the text for instances of entities and of components, and finds a register for
each signal or port that a clocked process assigns.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

INSTANCE = re.compile(r"(\w+)\s*:\s*(entity\s+work\.|component\s+)(\w+)", re.IGNORECASE)
PORT = re.compile(r"^\s+(\w+)\s*:\s*(?:in|out|inout)\s+(\w+)(?:\((\d+) downto 0\))?", re.MULTILINE)
SIGNAL = re.compile(r"^\s+signal\s+(\w+)\s*:\s*(\w+)", re.MULTILINE)
PROCESS = re.compile(r"\bprocess\b.*?\bend process\b", re.DOTALL)
ASSIGNED = re.compile(r"^\s*(\w+)(?:\([^<\n]*\))?\s*<=", re.MULTILINE)
SCALARS = ("std_ulogic", "std_logic", "boolean")
REGISTER_PINS = ("C", "CE", "D", "Q")


@dataclass(frozen=True)
class Cell:
    """Cell of the netlist: ``name`` is its path from the top, ``pins`` are the pins of a
    primitive."""

    name: str
    reference: str
    pins: tuple[str, ...] = ()


def texts_of(paths: list[Path]) -> dict[str, str]:
    """Return the sources without comments, by the names of their units, which equal the names of
    the files."""
    return {path.stem: re.sub(r"--.*", "", path.read_text(encoding="utf-8")) for path in paths}


def relabelled(texts: Mapping[str, str]) -> dict[str, str]:
    """Return the sources of the same design, in which every instance of an entity has another
    label."""

    def other(match: re.Match[str]) -> str:
        return f"part_{len(match[1])}_{match[1][::-1]} : {match[2]}{match[3]}"

    labels = re.compile(INSTANCE.pattern.replace(r"|component\s+", ""), re.IGNORECASE)
    return {name: labels.sub(other, text) for name, text in texts.items()}


def cells_of(texts: Mapping[str, str], entity: str, above: str = "") -> Iterator[Cell]:
    """Yield all cells below an instance of ``entity``; ``above`` is its path with a final ``/``."""
    text = texts[entity]
    kinds = dict(SIGNAL.findall(text)) | {name: kind for name, kind, _ in PORT.findall(text)}
    registers = {
        name
        for process in PROCESS.findall(text)
        if "rising_edge" in process
        for name in ASSIGNED.findall(process)
        if name in kinds
    }
    for name in sorted(registers):
        bit = "" if kinds[name].lower() in SCALARS else "[0]"
        yield Cell(f"{above}{name}_reg{bit}", "FDRE", REGISTER_PINS)
    for label, kind, unit in INSTANCE.findall(text):
        path = f"{above}{label}"
        if kind.lower().startswith("component"):
            yield Cell(path, unit, tuple(pins_of(text, unit)))
        else:
            yield Cell(path, unit)
            yield from cells_of(texts, unit.lower(), f"{path}/")


def pins_of(text: str, component: str) -> Iterator[str]:
    """Yield the pins of a primitive, one per bit, as the declaration of its component states."""
    declaration = re.search(rf"\bcomponent {component} is(.*?)end component", text, re.DOTALL)
    assert declaration, component
    for name, _, highest in PORT.findall(declaration[1]):
        if highest:
            yield from (f"{name}[{bit}]" for bit in range(int(highest) + 1))
        else:
            yield name


def write_netlist(path: Path, cells: list[Cell], ports: list[str]) -> None:
    """Write the cells and ports into a file that vivado_netlist.tcl reads."""
    lines = [f"port {port}" for port in ports]
    lines += [f"cell {cell.name} {cell.reference} {' '.join(cell.pins)}" for cell in cells]
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
