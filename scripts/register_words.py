"""Writes a VHDL entity with one port per register, in place of the records of the register block.

The bench of the registers runs this entity, because cocotb cannot access elements of a record. The
units that drive it are in ``tb/registers/register_access_harness.vhd``.
"""

from __future__ import annotations

from systemrdl.node import AddrmapNode, FieldNode, RegNode

from scripts.register_map import REGISTERS, path_below, registers_of

ENTITY = "arctrue_registers_harness"
HARNESS = "register_access_harness"


def _slice(field: FieldNode) -> str:
    if field.width == 1:
        return f"({field.low})"
    return f"({field.high} downto {field.low})"


def _inputs(top: AddrmapNode, register: RegNode, port: str) -> list[str]:
    """Return lines that assign the fields that the gateware drives, each from its bits of the
    port."""
    lines = []
    for field in register.fields():
        if field.is_hw_writable:
            bits = f"{port}{_slice(field)}"
            if field.get_property("is_signed"):
                bits = f"signed({bits})"
            lines.append(f"  hwif_in.{path_below(top, field)}.next_q <= {bits};")
    return lines


def _outputs(top: AddrmapNode, register: RegNode, port: str) -> list[str]:
    """Return lines that assign each bit of the port: a bit of a field that the gateware reads, or 0
    without a field. Return no lines if the gateware reads no field of the register."""
    lines, free = [], set(range(register.get_property("regwidth")))
    for field in register.fields():
        if field.is_hw_readable and not field.is_hw_writable:
            value = f"hwif_out.{path_below(top, field)}.value"
            if field.width > 1:
                value = f"std_ulogic_vector({value})"
            lines.append(f"  {port}{_slice(field)} <= {value};")
            free -= set(range(field.low, field.high + 1))
    return lines + [f"  {port}({bit}) <= '0';" for bit in sorted(free)] if lines else []


def register_words(top: AddrmapNode) -> str:
    """Return the VHDL of the entity."""
    ports = [
        "clock : in std_ulogic",
        "reset : in std_ulogic",
        "s_axil_request : in axi_lite_request",
        "s_axil_response : out axi_lite_response",
        "interrupt : out std_ulogic",
        "memory_latency : in u_unsigned(3 downto 0)",
    ]
    wiring: list[str] = []
    for register in registers_of(top):
        port = path_below(top, register).replace(".", "_")
        driven, shown = _inputs(top, register, port), _outputs(top, register, port)
        if driven and shown:
            raise ValueError(f"register {port}: expected fields of one direction, found both")
        if driven or shown:
            width = register.get_property("regwidth")
            mode = "in" if driven else "out"
            ports.append(f"{port} : {mode} std_ulogic_vector({width - 1} downto 0)")
        wiring += driven + shown
    joined = (
        "clock",
        "reset",
        "s_axil_request",
        "s_axil_response",
        "interrupt",
        "memory_latency",
        "hwif_in",
        "hwif_out",
    )
    return "\n".join(
        [
            f"-- Generated from {REGISTERS} by scripts/generate.py. Do not edit.",
            "--",
            "-- For simulation: one port per register; each field has its bits of the map.",
            "",
            "library ieee;",
            "  use ieee.std_logic_1164.all;",
            "  use ieee.numeric_std.all;",
            "",
            "  use work.arctrue_registers_pkg.all;",
            "  use work.axi_lite_pkg.all;",
            "",
            f"entity {ENTITY} is",
            "  generic (",
            "    LANES         : positive := 4;",
            "    CAPTURE_DEPTH : positive := 100;",
            "    HEADS         : positive := 2;",
            "    MEAN          : boolean  := false;",
            "    FAILOVER      : boolean  := false;",
            "    LOCAL_TABLE   : boolean  := false;",
            "    REAL_ORDERS   : boolean  := false",
            "  );",
            "  port (",
            ";\n".join(f"    {port}" for port in ports),
            "  );",
            f"end entity {ENTITY};",
            "",
            f"architecture simulation of {ENTITY} is",
            "  signal hwif_in  : arctrue_registers_in_t;",
            "  signal hwif_out : arctrue_registers_out_t;",
            "begin",
            f"  harness : entity work.{HARNESS}",
            "    generic map (LANES, CAPTURE_DEPTH, HEADS, MEAN, FAILOVER, LOCAL_TABLE,",
            "                 REAL_ORDERS)",
            "    port map (" + ", ".join(f"{name} => {name}" for name in joined) + ");",
            *wiring,
            "end architecture simulation;",
            "",
        ]
    )
