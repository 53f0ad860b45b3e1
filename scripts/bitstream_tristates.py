"""Adds the feature that place and route omits at every tri-state pad: the pad's enable is not
inverted.

A pad does not drive while its input T is high. The fabric's signal for T passes through the pin T1
of the pad's OLOGIC, which inverts the signal unless ``ZINV_T1`` is set (Project X-Ray).
nextpnr-himbaechel 0.11.1 routes T1 without setting this feature, as did nextpnr-xilinx
(openXC7/nextpnr-xilinx, issue 14): a pad then drives when it must not. At a pad that always drives,
T1 is open and reads 1, so this pad needs the inversion.
"""

from __future__ import annotations

import re
from pathlib import Path
from typing import Final

ROUTED: Final = re.compile(r"^(?P<tile>\w+)\.IOI_OLOGIC(?P<half>[01])_T1\.\w+$", re.MULTILINE)


def straight_enables(fasm: str) -> list[str]:
    """Return the missing lines of FASM: one for each routed T1 that lacks the feature
    ``ZINV_T1``."""
    wanted = (f"{found['tile']}.OLOGIC_Y{found['half']}.ZINV_T1" for found in ROUTED.finditer(fasm))
    there = set(fasm.splitlines())
    return [line for line in wanted if line not in there]


def add_straight_enables(fasm: Path) -> int:
    """Append the missing lines to a FASM file; return the number of appended lines."""
    lines = straight_enables(fasm.read_text(encoding="ascii"))
    with fasm.open("a", encoding="ascii") as file:
        file.write("".join(f"{line}\n" for line in ("# enables of tri-state pads", *lines)))
    return len(lines)
