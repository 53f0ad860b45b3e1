"""Generates the register block in VHDL, with a port that has one select bit per word.

The generator's own block decodes the address in the clock of the access, and selects the read word
after that decoder. In this block the select bits ``s_cpuif_word`` arrive already decoded. One
register holds the selected word if its number is even, another register if it is odd, and the block
returns the OR of both, so that only an OR of words lies between two registers. register_access.vhd
computes the select bits while it checks the access, so a read takes no additional clock. All other
parts are the unchanged output of the generator.
"""

from __future__ import annotations

import re
from pathlib import Path

import jinja2
from peakrdl_regblock_vhdl import RegblockExporter  # type: ignore[import-untyped]
from peakrdl_regblock_vhdl.cpuif.passthrough import (  # type: ignore[import-untyped]
    PassthroughCpuif,
)
from peakrdl_regblock_vhdl.readback.readback_mux_generator import (  # type: ignore[import-untyped]
    ReadbackMuxGenerator,
)
from systemrdl.node import AddrmapNode

TEMPLATES = Path(__file__).with_name("register_block_templates")
COMPARISON = re.compile(r"\(cpuif_addr = ([^()]+)\)")


class _Words(ReadbackMuxGenerator):  # type: ignore[misc]
    """Generates VHDL that assigns each readable word to an element of an array, without a
    comparison of the address."""

    def get_addr_compare_conditional(self, addr: str) -> str:
        """Return "true" in place of the generator's address comparison: every word is assigned."""
        return "true"

    def get_readback_data_var(self, addr: str) -> str:
        """Return the array element for the word at the byte address ``addr``."""
        return f"words(({addr}) / {self.exp.cpuif.data_width_bytes})"


class _DecodedPort(PassthroughCpuif):  # type: ignore[misc]
    """Port of the register block: the generator's port without a bus protocol, plus one select bit
    per word."""

    @property
    def word_count(self) -> int:
        """Return the number of words in the block's range of addresses."""
        return int(2**self.addr_width // self.data_width_bytes)

    @property
    def words(self) -> str:
        """Return VHDL that assigns every readable word."""
        return str(_Words(self.exp).get_content(self.exp.ds.top_node))

    @property
    def port_declaration(self) -> str:
        """Return the declaration of the generator's ports and of ``s_cpuif_word``, which is valid
        in the clock of the request."""
        chosen = f"s_cpuif_word : in std_logic_vector(0 to {self.word_count - 1});"
        return f"{chosen}\n{super().port_declaration}"


def decoded_before(text: str) -> str:
    """Replace each comparison of the address in the block's VHDL by a bit of ``s_cpuif_word``.

    The generator has no option for this. Raises ValueError if the generator's text has changed.
    """
    text, replaced = COMPARISON.subn(r"s_cpuif_word((\1) / 4)", text)
    if not replaced or "cpuif_addr =" in text:
        raise ValueError(
            "scripts/register_block.py does not know how this peakrdl-regblock-vhdl compares the "
            "address: expected '(cpuif_addr = 16#..#)' in the block; adapt COMPARISON to it"
        )
    return text


def write_register_block(block: AddrmapNode, folder: Path) -> None:
    """Write the register block ``block`` and its package into ``folder``."""
    exporter = RegblockExporter()
    exporter.jj_env.loader = jinja2.ChoiceLoader(
        [jinja2.FileSystemLoader(TEMPLATES), exporter.jj_env.loader]
    )
    exporter.export(
        block,
        str(folder),
        cpuif_cls=_DecodedPort,  # register_access contains the bus protocol
        reuse_hwif_typedefs=False,  # names of types contain their place, not a hash
        copy_utils_pkg=True,  # access_guard refuses accesses, not this block
    )
    made = folder / f"{block.inst_name}.vhd"
    made.write_text(decoded_before(made.read_text(encoding="utf-8")), encoding="utf-8")
