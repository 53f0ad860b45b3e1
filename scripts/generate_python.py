"""Writes the generated Python modules, the package ``arctrue.generated``.

``make generate`` writes the modules into the source tree, the build of a wheel writes them into the
wheel (scripts/build_package.py). Therefore this script imports only packages that pyproject.toml
requires for a build.
"""

from __future__ import annotations

from pathlib import Path

from systemrdl.node import AddrmapNode, FieldNode, RegNode

from scripts.number_formats import NUMBER_FORMATS, read_number_formats
from scripts.register_map import (
    REGISTERS,
    compile_registers,
    memories_of,
    path_below,
    registers_of,
)


def write_if_changed(path: Path, text: str) -> None:
    """Write ``text`` to a file only if its content differs, so that make starts no unnecessary
    step."""
    path.parent.mkdir(parents=True, exist_ok=True)
    if not path.exists() or path.read_text(encoding="utf-8") != text:
        path.write_text(text, encoding="utf-8")


def python_number_formats(constants: dict[str, int]) -> str:
    """Return the Python module of the number formats."""
    lines = [
        f'"""Generated from {NUMBER_FORMATS} by scripts/generate_python.py. Do not edit."""',
        "",
        "from typing import Final",
        "",
    ]
    lines += [f"{name}: Final = {value}" for name, value in constants.items()]
    return "\n".join([*lines, ""])


def python_register(top: AddrmapNode, register: RegNode) -> list[str]:
    """Return the lines for one register in the Python module."""
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
    """Tell whether writing 1 to ``field`` clears it."""
    return bool(field.get_property("woclr"))


def python_registers(top: AddrmapNode) -> str:
    """Return the Python module of the register map: addresses, masks and shifts as constants, and
    lists of the registers, their fields and the memories."""
    registers = list(registers_of(top))
    lines = [
        f'"""Generated from {REGISTERS} by scripts/generate_python.py. Do not edit."""',
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


def write_python(root: Path, folder: Path) -> None:
    """Write the package ``arctrue.generated`` of the source tree ``root`` into ``folder``."""
    constants = read_number_formats(root / NUMBER_FORMATS)
    registers = compile_registers(root / REGISTERS)
    note = '"""Made by scripts/generate_python.py. Do not edit."""\n'
    write_if_changed(folder / "__init__.py", note)
    write_if_changed(folder / "number_formats.py", python_number_formats(constants))
    write_if_changed(folder / "registers.py", python_registers(registers))
