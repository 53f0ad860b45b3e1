"""Checks pin files before the long run of a place-and-route tool. Pin files use only the subset of
XDC that every such tool reads.

A line of a pin file is empty, a comment, or ``set_property PROPERTY value [get_ports name]`` with
the property LOC, IOSTANDARD or PULLTYPE.
"""

from __future__ import annotations

import re
from collections.abc import Iterable
from pathlib import Path

from scripts.make_docs import read_entity
from scripts.netlist import ROOT

PROPERTY = re.compile(
    r"set_property\s+(?P<property>LOC|IOSTANDARD|PULLTYPE)\s+(?P<value>\w+)\s+"
    r"\[\s*get_ports\s+(?P<port>\w+)\s*\]"
)
PIN = re.compile(r"[A-Z]{1,2}[1-9][0-9]?")
STANDARDS = frozenset(
    {"LVCMOS33", "LVCMOS25", "LVCMOS18", "LVCMOS15", "LVCMOS12", "LVTTL", "LVDS_25", "TMDS_33"}
)
PULLS = ("NONE", "PULLDOWN", "PULLUP", "KEEPER")


class ConstraintError(Exception):
    """Raised if a pin file does not fit the top level. The message states every fault with its
    line."""


def read_pins(path: Path) -> dict[str, dict[str, tuple[str, int]]]:
    """Return, for each port of a pin file, its properties with value and line number.

    Raises ConstraintError for a file that cannot be read, for a line outside the subset, and for a
    property that is set twice.
    """
    try:
        lines = path.read_text(encoding="utf-8").splitlines()
    except OSError as error:
        raise ConstraintError(f"{path}: the pin file cannot be read: {error.strerror}") from error
    except UnicodeDecodeError as error:
        raise ConstraintError(f"{path}: expected text in UTF-8, found {error.reason}") from error
    found: dict[str, dict[str, tuple[str, int]]] = {}
    faults = []
    for number, line in enumerate(lines, start=1):
        text = line.partition("#")[0].strip()
        if not text:
            continue
        entry = PROPERTY.fullmatch(text)
        if not entry:
            faults.append(
                f"{path}:{number}: expected set_property LOC|IOSTANDARD|PULLTYPE value "
                f"[get_ports name], found '{text}'"
            )
            continue
        of_port = found.setdefault(entry["port"], {})
        if before := of_port.get(entry["property"]):
            faults.append(
                f"{path}:{number}: {entry['property']} of {entry['port']} is given again, "
                f"first in line {before[1]}"
            )
            continue
        of_port[entry["property"]] = (entry["value"], number)
    if faults:
        raise ConstraintError("\n".join(faults))
    return found


def ports_of(top: str) -> list[str]:
    """Return the ports of a top level below rtl/, in the order of declaration."""
    entity = read_entity(ROOT, Path("rtl") / "top" / f"{top}.vhd")
    return [name for item in entity.ports for name in item.names.split(", ")]


def check_pins(path: Path, ports: Iterable[str]) -> dict[str, str]:
    """Check a pin file against the ports of a top level; return the pin of each port.

    Every port must have an I/O standard, and a pin that differs from the pins of all other ports.
    Raises ConstraintError, which names all faults.
    """
    found = read_pins(path)
    ports = list(ports)
    faults = [
        f"{path}:{min(line for _, line in found[port].values())}: the top level has no port {port}"
        for port in found
        if port not in ports
    ]
    owners: dict[str, str] = {}
    for port in ports:
        given = found.get(port, {})
        faults += [
            f"{path}: port {port} has no {kind}"
            for kind in ("LOC", "IOSTANDARD")
            if kind not in given
        ]
        if "LOC" in given:
            pin, line = given["LOC"]
            if not PIN.fullmatch(pin):
                faults.append(f"{path}:{line}: expected a pin such as Y18, found '{pin}'")
            elif pin in owners:
                faults.append(f"{path}:{line}: {pin} is already the pin of {owners[pin]}")
            owners.setdefault(pin, port)
        if "IOSTANDARD" in given:
            standard, line = given["IOSTANDARD"]
            if standard not in STANDARDS:
                known = ", ".join(sorted(STANDARDS))
                faults.append(
                    f"{path}:{line}: '{standard}' is not an accepted I/O standard; expected one of "
                    f"{known}"
                )
        if "PULLTYPE" in given:
            pull, line = given["PULLTYPE"]
            if pull not in PULLS:
                known = ", ".join(PULLS)
                faults.append(f"{path}:{line}: '{pull}' is not a PULLTYPE; expected one of {known}")
    if faults:
        raise ConstraintError("\n".join(faults))
    return {port: pin for pin, port in owners.items()}
