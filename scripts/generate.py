"""Writes what is made from one source: number formats and the register map.

Sources: ``rtl/formats/number_formats_pkg.vhd`` and ``rtl/registers/arctrue_registers.rdl``.
Results: ``build/generated/`` (VHDL, C, HTML) and ``sim/arctrue/generated/`` (Python).
"""

from __future__ import annotations

import re
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

from peakrdl_cheader.c_standards import CStandard
from peakrdl_cheader.exporter import CHeaderExporter
from peakrdl_html import HTMLExporter  # type: ignore[import-untyped]
from peakrdl_regblock_vhdl import RegblockExporter  # type: ignore[import-untyped]
from peakrdl_regblock_vhdl.cpuif.passthrough import (  # type: ignore[import-untyped]
    PassthroughCpuif,
)
from peakrdl_regblock_vhdl.udps import ALL_UDPS  # type: ignore[import-untyped]
from systemrdl.compiler import RDLCompiler
from systemrdl.node import AddrmapNode, FieldNode, MemNode, Node, RegNode

ROOT = Path(__file__).resolve().parents[1]
NUMBER_FORMATS = ROOT / "rtl" / "formats" / "number_formats_pkg.vhd"
REGISTERS = ROOT / "rtl" / "registers" / "arctrue_registers.rdl"
GENERATED = ROOT / "build" / "generated"
GENERATED_PYTHON = ROOT / "sim" / "arctrue" / "generated"

CONSTANT = re.compile(r"^\s*constant\s+(\w+)\s*:\s*(?:positive|natural|integer)\s*:=\s*(\d+)\s*;")


def read_number_formats(package: Path) -> dict[str, int]:
    """The integer constants of a VHDL package, in their order.

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


def write_if_changed(path: Path, text: str) -> None:
    """Write ``text`` unless the file holds it already, so that make sees no false change."""
    path.parent.mkdir(parents=True, exist_ok=True)
    if not path.exists() or path.read_text(encoding="utf-8") != text:
        path.write_text(text, encoding="utf-8")


def write_number_formats() -> None:
    """Write the Python module and the C header of the number formats."""
    constants = read_number_formats(NUMBER_FORMATS)
    source = NUMBER_FORMATS.relative_to(ROOT)
    python = [
        f'"""Generated from {source} by scripts/generate.py. Do not edit."""',
        "",
        "from typing import Final",
        "",
    ]
    python += [f"{name}: Final = {value}" for name, value in constants.items()]
    write_if_changed(GENERATED_PYTHON / "__init__.py", '"""Made by scripts/generate.py."""\n')
    write_if_changed(GENERATED_PYTHON / "number_formats.py", "\n".join(python) + "\n")
    header = [
        f"/* Generated from {source} by scripts/generate.py. Do not edit. */",
        "#ifndef ARCTRUE_NUMBER_FORMATS_H",
        "#define ARCTRUE_NUMBER_FORMATS_H",
        "",
    ]
    header += [f"#define ARCTRUE_{name} {value}" for name, value in constants.items()]
    header += ["", "#endif"]
    write_if_changed(GENERATED / "c" / "arctrue_number_formats.h", "\n".join(header) + "\n")


def compile_registers(source: Path, *, block_only: bool = False) -> AddrmapNode:
    """The elaborated register map of a SystemRDL file; ``block_only``: without what is external.

    Raises systemrdl.RDLCompileError, after the compiler has printed where and why.
    """
    compiler = RDLCompiler()
    for definition in ALL_UDPS:
        compiler.register_udp(definition)
    compiler.compile_file(str(source), defines={"REGISTER_BLOCK_ONLY": ""} if block_only else {})
    top = compiler.elaborate().top
    assert isinstance(top, AddrmapNode)
    return top


def registers_of(node: Node) -> Iterator[RegNode]:
    """Every register below ``node``, in address order."""
    for child in node.children(unroll=True):
        if isinstance(child, RegNode):
            yield child
        elif not isinstance(child, MemNode):
            yield from registers_of(child)


def memories_of(top: AddrmapNode) -> list[MemNode]:
    """The memory windows of the map."""
    return [child for child in top.children(unroll=True) if isinstance(child, MemNode)]


def path_below(top: AddrmapNode, node: Node) -> str:
    """The name of ``node`` below the top, as in ``snapshot.time``."""
    return node.get_path().removeprefix(top.get_path() + ".")


def python_register(top: AddrmapNode, register: RegNode) -> list[str]:
    """The lines of one register in the Python module."""
    path = path_below(top, register)
    lines = [
        "    Register(",
        f'        path="{path}",',
        f"        address=0x{register.absolute_address:05X},",
        f"        width={register.get_property('regwidth')},",
        f"        readable={register.has_sw_readable},",
        f"        writable={register.has_sw_writable},",
        f"        latched={bool(register.get_property('buffer_reads'))},",
        "        fields=(",
    ]
    for field in register.fields():
        reset = field.get_property("reset")
        lines += [
            "            Field(",
            f'                name="{field.inst_name}", shift={field.low}, width={field.width},',
            f"                signed={bool(field.get_property('is_signed'))},"
            f" write_one_to_clear={is_write_one_to_clear(field)},",
            f"                reset={reset if isinstance(reset, int) else None},"
            f" constant={not field.is_hw_writable and not field.is_sw_writable},",
            "            ),",
        ]
    return [*lines, "        ),", "    ),"]


def is_write_one_to_clear(field: FieldNode) -> bool:
    """Whether a 1 written to ``field`` clears it."""
    return bool(field.get_property("woclr"))


def python_registers(top: AddrmapNode) -> str:
    """The Python module of the register map: addresses, masks, shifts and descriptions."""
    registers = list(registers_of(top))
    lines = [
        f'"""Generated from {REGISTERS.relative_to(ROOT)} by scripts/generate.py. Do not edit."""',
        "",
        "from typing import Final",
        "",
        "from arctrue.gateware.register_types import Field, Memory, Register",
        "",
    ]
    for register in registers:
        name = path_below(top, register).replace(".", "_").upper()
        lines += [f"{name}_ADDRESS: Final = 0x{register.absolute_address:05X}"]
        for field in register.fields():
            part = f"{name}_{field.inst_name.upper()}"
            mask = ((1 << field.width) - 1) << field.low
            lines += [f"{part}_MASK: Final = 0x{mask:08X}", f"{part}_SHIFT: Final = {field.low}"]
    for memory in memories_of(top):
        name = memory.inst_name.upper()
        lines += [f"{name}_ADDRESS: Final = 0x{memory.absolute_address:05X}"]
        lines += [f"{name}_WORDS: Final = {memory.get_property('mementries')}"]
    lines += [
        f"MAP_BYTES: Final = 0x{1 << (top.size - 1).bit_length():05X}",
        "",
        "REGISTERS: Final[tuple[Register, ...]] = (",
    ]
    for register in registers:
        lines += python_register(top, register)
    lines += [")", "", "MEMORIES: Final[tuple[Memory, ...]] = ("]
    for memory in memories_of(top):
        lines += [
            f'    Memory(path="{memory.inst_name}", address=0x{memory.absolute_address:05X},'
            f" words={memory.get_property('mementries')}, readable={memory.is_sw_readable},"
            f" writable={memory.is_sw_writable}),"
        ]
    return "\n".join([*lines, ")", ""])


def vhdl_addresses(top: AddrmapNode, block: AddrmapNode) -> str:
    """A VHDL package with the addresses that hand-written VHDL has to know."""
    offset = top.get_child_by_name("coefficient_offset")
    assert isinstance(offset, RegNode)
    named = [(memory.inst_name, memory.absolute_address) for memory in memories_of(top)]
    named += [("coefficient_offset", offset.absolute_address)]
    lines = [
        f"-- Generated from {REGISTERS.relative_to(ROOT)} by scripts/generate.py. Do not edit."
    ]
    lines += ["", "package register_addresses_pkg is", ""]
    for name, address in named:
        lines += [f"  constant {name.upper()}_ADDRESS : natural := 16#{address:05X}#;"]
    lines += [f"  constant REGISTERS_ADDRESS_WIDTH : natural := {(block.size - 1).bit_length()};"]
    return "\n".join([*lines, "", "end package register_addresses_pkg;", ""])


def copy_if_changed(source: Path, destination: Path) -> None:
    """Copy every file below ``source`` whose content differs from that below ``destination``."""
    for path in sorted(source.rglob("*")):
        if path.is_file():
            copy = destination / path.relative_to(source)
            content = path.read_bytes()
            if not copy.exists() or copy.read_bytes() != content:
                copy.parent.mkdir(parents=True, exist_ok=True)
                copy.write_bytes(content)


def write_registers() -> None:
    """Write the register block, its C header, Python names and HTML page."""
    top = compile_registers(REGISTERS)
    block = compile_registers(REGISTERS, block_only=True)
    with tempfile.TemporaryDirectory() as folder:
        made = Path(folder)
        for name in ("vhdl", "c", "html"):
            (made / name).mkdir()
        RegblockExporter().export(
            block,
            str(made / "vhdl"),
            cpuif_cls=PassthroughCpuif,  # register_access has the bus
            reuse_hwif_typedefs=False,  # types named by their place, not by a hash
            err_if_bad_addr=True,
            err_if_bad_rw=True,
            copy_utils_pkg=True,
        )
        CHeaderExporter().export(
            top, path=str(made / "c" / "arctrue_registers.h"), std=CStandard.gnu11
        )
        HTMLExporter(generate_source_links=False).export(top, str(made / "html" / "registers"))
        copy_if_changed(made, GENERATED)
    write_if_changed(GENERATED / "vhdl" / "register_addresses_pkg.vhd", vhdl_addresses(top, block))
    write_if_changed(GENERATED_PYTHON / "registers.py", python_registers(top))


def main() -> int:
    """Write everything; returns the exit code."""
    write_number_formats()
    write_registers()
    return 0


if __name__ == "__main__":
    sys.exit(main())
