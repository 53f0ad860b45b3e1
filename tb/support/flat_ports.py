"""Writes wrappers without record ports, because cocotb cannot access the elements of a record.

If an entity has record ports, the simulation runs its wrapper. The wrapper has the same generics
and ports, but one port for each element of a record port: the port ``s_axil_request`` becomes
``s_axil_awvalid``, ``s_axil_awaddr`` and so on. The instance ``unit`` in the wrapper is the entity.
"""

from __future__ import annotations

import re
from collections.abc import Iterable

RECORD = re.compile(r"^  type (\w+) is record\n(.*?)^  end record", re.MULTILINE | re.DOTALL)
DECLARATION = re.compile(r"^    (\w+) *: ([^;\n]+?)(?:;.*| *--.*)?$", re.MULTILINE)
MODE_AND_TYPE = re.compile(r"(in|out|inout) +(\w+)")
CONTEXT = re.compile(r"^(?:library|  use) .*;$", re.MULTILINE)


def flat_name(record_port: str, element: str) -> str:
    """Return the name of an element's port: the record port without its last word, then the
    element.

    The last word of a record port's name is its direction. If the name is a single word, the
    elements keep their own names.
    """
    bus = record_port.rpartition("_")[0]
    return f"{bus}_{element}" if bus else element


def _clause(entity: str, keyword: str) -> str:
    found = re.search(rf"^  {keyword} \(\n(.*?)^  \);", entity, re.MULTILINE | re.DOTALL)
    return found[1].rstrip() if found else ""


def wrapper(name: str, text: str, packages: Iterable[str]) -> str | None:
    """Return the VHDL of the wrapper ``<name>_flat``, or None if the entity has no record ports.

    ``text`` is the text of the entity's file; ``packages`` has the texts of the packages that it
    uses.
    """
    records = {
        record: DECLARATION.findall(body)
        for package in packages
        for record, body in RECORD.findall(package)
    }
    entity = text[text.index(f"entity {name} is") : text.index(f"end entity {name};")]
    ports: list[str] = []
    joined: list[str] = []
    for port, declared in DECLARATION.findall(_clause(entity, "port")):
        found = MODE_AND_TYPE.match(declared)
        assert found, f"{name}: the port {port} has no mode and type"
        for element, subtype in records.get(found[2], []):
            ports.append(f"{flat_name(port, element)} : {found[1]} {subtype}")
            joined.append(f"{port}.{element} => {flat_name(port, element)}")
        if found[2] not in records:
            ports.append(f"{port} : {declared}")
            joined.append(f"{port} => {port}")
    if not any("." in line for line in joined):
        return None
    generics = _clause(entity, "generic")
    given = [f"{generic} => {generic}" for generic, _ in DECLARATION.findall(generics)]
    between = ",\n      "
    return "\n".join(
        (
            *CONTEXT.findall(text[: text.index(entity)]),
            f"entity {name}_flat is",
            *([f"  generic (\n{generics}\n  );"] if given else []),
            "  port (\n    " + ";\n    ".join(ports) + "\n  );",
            f"end entity {name}_flat;",
            f"architecture simulation of {name}_flat is\nbegin",
            f"  unit : entity work.{name}",
            *([f"    generic map (\n      {between.join(given)}\n    )"] if given else []),
            f"    port map (\n      {between.join(joined)}\n    );",
            "end architecture simulation;\n",
        )
    )
