"""Checks that a bitstream is complete and made for the chip; UG470, chapter 5, defines the
format."""

from __future__ import annotations

import re
from pathlib import Path

from scripts.netlist import ToolError

SYNC_WORD = bytes.fromhex("AA995566")
# Header of the packet that writes one word to the register IDCODE
IDCODE_WRITE = bytes.fromhex("30018001")
FRAMES_WRITE = bytes.fromhex(
    "30004000"
)  # header of a packet to the register FDRI; a packet of type 2 states the number of words
PACKET_TYPE_2 = 0b010
TYPE_2_WORDS = 0x07FF_FFFF
REVISION = 0xF000_0000  # the top four bits of an identification code are the silicon's revision
WORDS_A_FRAME = 101

# Identification code and number of configuration frames, including those that only fill the end of
# a row. The length of a whole bitstream in UG585 is 2,332 bytes larger, because it contains the
# commands.
DIES = {
    "xc7z010": (0x0372_2093, 5_152),
    "xc7z020": (0x0372_7093, 10_008),
}
# Largest number of bytes before the sync word (fields of the header), and largest number of bytes
# from the sync word to the frames (commands)
LONGEST_HEAD = 1024


def check_bitstream(path: Path, part: str) -> str:
    """Return one sentence about the bitstream of ``part``.

    Raises ToolError for a file that is missing, truncated, or made for another chip.
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
    place = data.find(IDCODE_WRITE, start, start + LONGEST_HEAD)
    found = int.from_bytes(data[place + 4 : place + 8], "big") if place >= 0 else -1
    if found < 0 or found & ~REVISION != code & ~REVISION:
        stated = "none" if found < 0 else f"0x{found:08X}"
        raise ToolError(f"{path}: expected the code 0x{code:08X} of {part}, found {stated}")
    words, there = _frame_words(data, start)
    if words != frames * WORDS_A_FRAME:
        raise ToolError(
            f"{path}: expected {frames * WORDS_A_FRAME:,} words of frames for {part}, "
            f"found {words:,} (is it compressed or partial?)"
        )
    if there < words:
        raise ToolError(f"{path}: cut off: {there:,} of {words:,} words of frames are there")
    return f"{path}: {len(data):,} bytes for {part}"


def _frame_words(data: bytes, start: int) -> tuple[int, int]:
    """Return the number of frame words that the file states, and the number of frame words that the
    file contains."""
    place = data.find(FRAMES_WRITE, start, start + LONGEST_HEAD)
    if place < 0:
        return 0, 0
    header = int.from_bytes(data[place + 4 : place + 8], "big")
    words = header & TYPE_2_WORDS if header >> 29 == PACKET_TYPE_2 else 0
    return words, (len(data) - place - 8) // 4
