"""Reads the number formats from their single source, a VHDL package."""

from __future__ import annotations

import re
from pathlib import Path

NUMBER_FORMATS = Path("rtl/formats/number_formats_pkg.vhd")

CONSTANT = re.compile(r"^\s*constant\s+(\w+)\s*:\s*(?:positive|natural|integer)\s*:=\s*(\d+)\s*;")


def read_number_formats(package: Path) -> dict[str, int]:
    """Return the integer constants of a VHDL package, in the order of declaration.

    Raises ValueError for a constant line of another form.
    """
    constants: dict[str, int] = {}
    for number, line in enumerate(package.read_text(encoding="utf-8").splitlines(), start=1):
        found = CONSTANT.match(line)
        if found:
            constants[found[1].upper()] = int(found[2])
        elif line.strip().lower().startswith("constant "):
            raise ValueError(f"{package}:{number}: expected 'constant NAME : positive := digits;'")
    return constants
