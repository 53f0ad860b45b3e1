"""Compiles the register map from its single source, a SystemRDL file, and lists its registers and
memories."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from peakrdl_regblock_vhdl.udps import ALL_UDPS  # type: ignore[import-untyped]
from systemrdl.compiler import RDLCompiler
from systemrdl.node import AddrmapNode, MemNode, Node, RegNode

REGISTERS = Path("rtl/registers/arctrue_registers.rdl")


def compile_registers(source: Path, *, block_only: bool = False) -> AddrmapNode:
    """Return the elaborated register map of a SystemRDL file.

    ``block_only`` leaves out external parts. Raises systemrdl.RDLCompileError after the compiler
    has printed the place of the error and its reason.
    """
    compiler = RDLCompiler()
    for definition in ALL_UDPS:
        compiler.register_udp(definition)
    compiler.compile_file(str(source), defines={"REGISTER_BLOCK_ONLY": ""} if block_only else {})
    top = compiler.elaborate().top
    assert isinstance(top, AddrmapNode)
    return top


def registers_of(node: Node) -> Iterator[RegNode]:
    """Yield every register below ``node``, in address order."""
    for child in node.children(unroll=True):
        if isinstance(child, RegNode):
            yield child
        elif not isinstance(child, MemNode):
            yield from registers_of(child)


def memories_of(top: AddrmapNode) -> list[MemNode]:
    """Return the memory windows of the register map."""
    return [child for child in top.children(unroll=True) if isinstance(child, MemNode)]


def path_below(top: AddrmapNode, node: Node) -> str:
    """Return the name of ``node`` below the top, for example ``snapshot.time``."""
    return node.get_path().removeprefix(top.get_path() + ".")
