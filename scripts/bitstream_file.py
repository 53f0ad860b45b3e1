"""Looks into a bitstream: is it whole, and is it for the chip? Source: UG470, chapter 5."""

from __future__ import annotations

import re
from pathlib import Path

from scripts.netlist import ToolError

SYNC_WORD = bytes.fromhex("AA995566")
IDCODE_WRITE = bytes.fromhex("30018001")  # one word to register IDCODE
REVISION = 0xF000_0000  # the top four bits of an identification code are the silicon's revision

# Identification code and the bytes of all configuration frames (UG585, table of bitstream lengths).
DIES = {
    "xc7z010": (0x0372_2093, 2_083_740),
    "xc7z020": (0x0372_7093, 4_045_564),
}
LONGEST_HEAD = 1024  # bytes before the sync word: Xilinx' tagged fields, dummy words
LONGEST_REST = 4096  # bytes of commands round the frames


def check_bitstream(path: Path, part: str) -> str:
    """One sentence about the bitstream of ``part``.

    Raises ToolError when there is none, when it is cut off, or made for another chip.
    """
    if not path.exists():
        raise ToolError(f"{path}: the flow ended without a bitstream")
    data = path.read_bytes()
    start = data.find(SYNC_WORD, 0, LONGEST_HEAD)
    if start < 0:
        raise ToolError(f"{path}: no sync word AA995566 in the first {LONGEST_HEAD} bytes")
    die = re.match(r"xc7z\d{3}", part)
    if not die or die[0] not in DIES:
        return f"{path}: {len(data):,} bytes (length and code of {part} are not known here)"
    code, frames = DIES[die[0]]
    length = len(data) - start
    if not frames <= length <= frames + LONGEST_REST:
        raise ToolError(
            f"{path}: {length:,} bytes from the sync word on; expected {frames:,} of frames and at "
            f"most {LONGEST_REST:,} more for {part}"
        )
    place = data.find(IDCODE_WRITE, start, start + LONGEST_HEAD)
    found = int.from_bytes(data[place + 4 : place + 8], "big") if place >= 0 else -1
    if found < 0 or found & ~REVISION != code & ~REVISION:
        told = "none" if found < 0 else f"0x{found:08X}"
        raise ToolError(f"{path}: expected the code 0x{code:08X} of {part}, found {told}")
    return f"{path}: {len(data):,} bytes for {part}"
