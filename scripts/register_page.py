"""Makes docs/registers.md, a readable page of the register map, from the SystemRDL file."""

from __future__ import annotations

from pathlib import Path

from systemrdl.node import FieldNode, MemNode, RegfileNode, RegNode

from scripts.register_map import (
    REGISTERS,
    compile_registers,
    memories_of,
    path_below,
    registers_of,
)


def _words(node: FieldNode | MemNode | RegNode | RegfileNode) -> str:
    """Return the description of a node, joined to one line."""
    return " ".join((node.get_property("desc") or "").split())


def _cell(text: str) -> str:
    return text.replace("|", "\\|")


def _access(node: FieldNode | MemNode) -> str:
    return ("r" if node.is_sw_readable else "") + ("w" if node.is_sw_writable else "")


def _field_row(field: FieldNode) -> str:
    bits = str(field.low) if field.low == field.high else f"{field.high}..{field.low}"
    reset = field.get_property("reset")
    value = "" if reset is None else str(reset)
    return f"| {bits} | `{field.inst_name}` | {_access(field)} | {value} | {_cell(_words(field))} |"


def register_page(root: Path) -> str:
    """Return the register map as a page in Markdown."""
    top = compile_registers(root / REGISTERS)
    lines = [
        f"<!-- Made by scripts/register_page.py from {REGISTERS}. Do not edit: make docs -->",
        "",
        "# Register map",
        "",
        f"This page comes from [{REGISTERS}](../{REGISTERS}), the single source of the registers. "
        "`make generate` makes",
        "from it the VHDL block, the C header `build/generated/c/arctrue_registers.h`,",
        "the Python module `arctrue.generated.registers` and a page to browse,",
        "`build/generated/html/registers/index.html`.",
        "",
        (top.get_property("desc") or "").strip(),
        "",
        "## Memory windows",
        "",
        "| Address | Window | Words | Access | |",
        "|---|---|---|---|---|",
    ]
    for memory in memories_of(top):
        lines.append(
            f"| 0x{memory.absolute_address:05X} | `{memory.inst_name}` "
            f"| {memory.get_property('mementries')} of {memory.get_property('memwidth')} bits "
            f"| {_access(memory)} | {_cell(_words(memory))} |"
        )
    group = ""
    for register in registers_of(top):
        parent = register.parent
        if isinstance(parent, RegfileNode) and parent.inst_name != group:
            group = parent.inst_name
            lines += ["", f"## Group {group}", "", _words(parent)]
        lines += [
            "",
            f"## 0x{register.absolute_address:05X} {path_below(top, register)}",
            "",
            _words(register),
            "",
            "| Bits | Field | Access | Reset | |",
            "|---|---|---|---|---|",
        ]
        lines += [_field_row(field) for field in register.fields()]
    return "\n".join(lines) + "\n"
