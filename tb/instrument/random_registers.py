"""Gives the registers of a netlist random initial values, as in a chip that loads none."""

from __future__ import annotations

import re

_INITIAL = re.compile(r"  initial\s+n\d+_q = \d+'b[01xXzZ]+;\n")
_REGISTER = re.compile(r"^  reg (?:\[(\d+):0\] )?(n\d+_q);$", re.MULTILINE)


def with_random_registers(netlist: str) -> str:
    """Return GHDL's Verilog with random initial values of registers, but not of tables and
    memories.

    The program that is compiled from the netlist draws the values from its seed when it starts.
    """

    def begin(found: re.Match[str]) -> str:
        width = int(found[1] or 0) + 1
        drawn = ", ".join(["$urandom"] * -(-width // 32))
        return f"{found[0]}\n  initial {found[2]} = {width}'({{{drawn}}});"

    return _REGISTER.sub(begin, _INITIAL.sub("", netlist))
