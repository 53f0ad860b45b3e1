"""Generates the files of the number formats and of the register map, each from a single source.

Sources: ``rtl/formats/number_formats_pkg.vhd`` and ``rtl/registers/arctrue_registers.rdl``.
Results: ``build/generated/`` (VHDL, C, HTML) and ``sim/arctrue/generated/`` (Python, by
scripts/generate_python.py).
"""

from __future__ import annotations

import argparse
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path

from peakrdl_cheader.c_standards import CStandard
from peakrdl_cheader.exporter import CHeaderExporter
from peakrdl_html import HTMLExporter  # type: ignore[import-untyped]
from systemrdl.node import AddrmapNode, RegfileNode, RegNode

from scripts.generate_python import write_if_changed, write_python
from scripts.number_formats import NUMBER_FORMATS, read_number_formats
from scripts.register_block import write_register_block
from scripts.register_map import REGISTERS, compile_registers, memories_of, registers_of
from scripts.register_words import ENTITY, register_words

ROOT = Path(__file__).resolve().parents[1]
GENERATED = ROOT / "build" / "generated"
GENERATED_PYTHON = ROOT / "sim" / "arctrue" / "generated"


def c_number_formats(constants: dict[str, int]) -> str:
    """Return the C header of the number formats."""
    lines = [
        f"/* Generated from {NUMBER_FORMATS} by scripts/generate.py. Do not edit. */",
        "#ifndef ARCTRUE_NUMBER_FORMATS_H",
        "#define ARCTRUE_NUMBER_FORMATS_H",
        "",
    ]
    lines += [f"#define ARCTRUE_{name} {value}" for name, value in constants.items()]
    return "\n".join([*lines, "", "#endif", ""])


def legal_words(block: AddrmapNode, words: int, kind: str) -> str:
    """Return a text with a digit per word: 1 if the access ``kind`` (``read`` or ``written``) is
    legal."""
    legal = ["0"] * words
    for register in registers_of(block):
        allowed = register.has_sw_readable if kind == "read" else register.has_sw_writable
        first = register.absolute_address // 4
        for word in range(first, first + register.size // 4):
            legal[word] = "1" if allowed else "0"
    return "".join(legal)


def vhdl_addresses(top: AddrmapNode, block: AddrmapNode) -> str:
    """Return a VHDL package with the addresses that hand-written VHDL needs."""
    offset = top.get_child_by_name("coefficient_offset")
    assert isinstance(offset, RegNode)
    named = [(memory.inst_name, memory.absolute_address) for memory in memories_of(top)]
    named += [("coefficient_offset", offset.absolute_address)]
    for name in ("head3", "conditions", "local_place", "snapshot"):
        group = top.get_child_by_name(name)
        assert isinstance(group, RegfileNode)
        named += [(name, group.absolute_address)]
    lines = [f"-- Generated from {REGISTERS} by scripts/generate.py. Do not edit."]
    lines += ["", "library ieee;", "  use ieee.std_logic_1164.all;"]
    lines += ["", "package register_addresses_pkg is", ""]
    for name, address in named:
        lines += [f"  constant {name.upper()}_ADDRESS : natural := 16#{address:05X}#;"]
    width = (block.size - 1).bit_length()
    words = 2 ** (width - 2)
    lines += [f"  constant REGISTERS_ADDRESS_WIDTH : natural := {width};"]
    lines += [
        "",
        "  -- Whether the word in this place of the register block may be read, and written.",
    ]
    for kind in ("read", "written"):
        bits = legal_words(block, words, kind)
        lines += [f"  constant MAY_BE_{kind.upper()} : std_ulogic_vector(0 to {words - 1}) :="]
        rows = [f'    "{bits[first : first + 64]}"' for first in range(0, words, 64)]
        lines += [" &\n".join(rows) + ";"]
    return "\n".join([*lines, "", "end package register_addresses_pkg;", ""])


def copy_if_changed(source: Path, destination: Path) -> None:
    """Copy every file below ``source`` whose content differs from the file with the same path below
    ``destination``."""
    for path in sorted(source.rglob("*")):
        if path.is_file():
            copy = destination / path.relative_to(source)
            content = path.read_bytes()
            if not copy.exists() or copy.read_bytes() != content:
                copy.parent.mkdir(parents=True, exist_ok=True)
                copy.write_bytes(content)


def write_registers() -> None:
    """Write the register block, its C header and its HTML page."""
    top = compile_registers(ROOT / REGISTERS)
    block = compile_registers(ROOT / REGISTERS, block_only=True)
    with tempfile.TemporaryDirectory() as folder:
        made = Path(folder)
        for name in ("vhdl", "c", "html"):
            (made / name).mkdir()
        write_register_block(block, made / "vhdl")
        CHeaderExporter().export(
            top, path=str(made / "c" / "arctrue_registers.h"), std=CStandard.gnu11
        )
        HTMLExporter(generate_source_links=False).export(top, str(made / "html" / "registers"))
        copy_if_changed(made, GENERATED)
    write_if_changed(GENERATED / "vhdl" / "register_addresses_pkg.vhd", vhdl_addresses(top, block))
    write_if_changed(GENERATED / "vhdl" / f"{ENTITY}.vhd", register_words(block))


def main(arguments: Sequence[str] | None = None) -> int:
    """Write all generated files; return the exit code."""
    argparse.ArgumentParser(description=__doc__).parse_args(arguments)
    write_python(ROOT, GENERATED_PYTHON)
    constants = read_number_formats(ROOT / NUMBER_FORMATS)
    write_if_changed(GENERATED / "c" / "arctrue_number_formats.h", c_number_formats(constants))
    write_registers()
    return 0


if __name__ == "__main__":
    sys.exit(main())
