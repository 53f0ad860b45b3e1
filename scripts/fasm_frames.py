"""Converts nextpnr's FASM to the chip's configuration frames: ``python -m scripts.fasm_frames``.

The script uses Project X-Ray's database, because no package contains fasm2frames, Project X-Ray's
own program for this. The database of a tile's type names each feature of the tile, with the bits
that it sets and clears; the tile grid states where the tile's bits lie. Banks below 3.3 V also need
STEPDOWN in the unused pads of their bank. The script refuses such banks; no board in constraints/
has one.
"""

from __future__ import annotations

import argparse
import re
import sys
from collections.abc import Iterable
from pathlib import Path
from typing import Final

from scripts.bitstream_database import Chip
from scripts.bitstream_file import WORDS_A_FRAME
from scripts.netlist import ToolError

WORD_BITS: Final = 32
SHOWN: Final = 5

FEATURE = re.compile(
    r"(?P<tile>\w+)\.(?P<name>[\w.]+)"
    r"(?:\[(?P<high>\d+)(?::(?P<low>\d+))?\])?"
    r"(?:\s*=\s*(?:\d+'(?P<base>[bhd]))?(?P<value>[0-9a-fA-F_]+))?"
)
BASES: Final = {"b": 2, "h": 16, "d": 10, None: 10}


class Frames:
    """Configuration frames of a chip; at first all bits are zero."""

    def __init__(self, chip: Chip) -> None:
        """Store the ``chip`` of the database."""
        self.chip = chip
        self.set_by: dict[tuple[int, int, bool], str] = {}
        self.words: dict[int, list[int]] = {}
        for tile in self.chip.tiles.values():
            for block in tile["bits"].values():
                base = int(block["baseaddr"], 16)
                for address in range(base, base + block["frames"]):
                    self.words.setdefault(address, [0] * WORDS_A_FRAME)

    def enable(self, tile_name: str, feature: str, index: int | None, line: str) -> bool:
        """Set the bits of a feature; return False if the database does not have the feature.

        Raises ToolError if one feature sets a bit that another feature clears.
        """
        tile = self.chip.tiles.get(tile_name)
        if tile is None:
            return False
        own = self.chip.type_of(tile_name)
        if feature in own.without_bits:
            return True
        start = 0
        alias = self.chip.alias(tile_name)
        if alias:
            own, sites, start = alias
            site, dot, rest = feature.partition(".")
            feature = sites.get(site, site) + dot + rest
        found = own.find(feature, index)
        if found is None:
            return False
        kind, bits = found
        for frame, bit, is_set in bits:
            block = tile["bits"][kind]
            first_word = block["offset"] - start
            self._put(
                int(block["baseaddr"], 16) + frame, first_word * WORD_BITS + bit, is_set, line
            )
        return True

    def _put(self, address: int, bit: int, is_set: bool, line: str) -> None:
        other = self.set_by.get((address, bit, not is_set))
        if other is not None:
            raise ToolError(
                f"bit {bit} of frame 0x{address:08X} is {'set' if is_set else 'cleared'} "
                f"by '{line}' and {'cleared' if is_set else 'set'} by '{other}'"
            )
        self.set_by.setdefault((address, bit, is_set), line)
        if is_set:
            self.words[address][bit // WORD_BITS] |= 1 << bit % WORD_BITS

    def add(self, lines: Iterable[str], name: str) -> None:
        """Enable the features of ``lines``, one per line; messages contain the file's ``name``.

        Raises ToolError for a line that is not a feature, for a feature STEPDOWN, for features that
        the database does not have, and for the conflicts that ``enable`` finds.
        """
        unknown = []
        for number, whole in enumerate(lines, start=1):
            line = whole.partition("#")[0].strip()
            if not line:
                continue
            found = FEATURE.fullmatch(line)
            if found is None:
                raise ToolError(f"{name}:{number}: expected a feature of FASM, found '{line}'")
            if "STEPDOWN" in found["name"]:
                raise ToolError(
                    f"{name}:{number}: '{line}': a bank below 3.3 V needs Project X-Ray's own "
                    "fasm2frames; name it: FASM2FRAMES=/path/to/fasm2frames"
                )
            unknown += [
                f"{name}:{number}: {line}"
                for index in _indices(found)
                if not self.enable(found["tile"], found["name"], index, line)
            ]
        if unknown:
            raise ToolError(
                f"{len(unknown)} features are not in {self.chip.family} for {self.chip.part}; "
                "the first:\n" + "\n".join(unknown[:SHOWN])
            )

    def write(self, path: Path) -> None:
        """Write the frames in the form that xc7frames2bit reads: address and words, in order."""
        with path.open("w", encoding="ascii") as file:
            for address in sorted(self.words):
                words = ",".join(f"0x{word:08X}" for word in self.words[address])
                file.write(f"0x{address:08X} {words}\n")


def _indices(found: re.Match[str]) -> list[int | None]:
    """Return the enabled indices: [None] for a feature without an index, [] if the value is 0."""
    value = int(found["value"].replace("_", ""), BASES[found["base"]]) if found["value"] else 1
    if found["high"] is None:
        return [None] if value else []
    low = int(found["low"] or found["high"])
    return [low + place for place in range(value.bit_length()) if value >> place & 1]


def frames_of(fasm: Path, chip: Chip) -> Frames:
    """Return the frames of a FASM file, plus the features that the part requires. Raises ToolError
    like ``Frames.add``."""
    frames = Frames(chip)
    required = chip.family / chip.part / "required_features.fasm"
    for path in (fasm, required):
        if path == fasm or path.exists():
            with path.open(encoding="ascii") as lines:
                frames.add(lines, str(path))
    return frames


def main(arguments: list[str] | None = None) -> int:
    """Convert the FASM file that the command line names; return the exit code."""
    parser = argparse.ArgumentParser(prog="fasm_frames", description=__doc__)
    parser.add_argument("--part", required=True, help="chip, package and speed grade")
    parser.add_argument("--db-root", type=Path, required=True, help="the family's folder")
    parser.add_argument("fasm", type=Path, help="file of features")
    parser.add_argument("frames", type=Path, help="file that is written")
    chosen = parser.parse_args(arguments)
    try:
        frames_of(chosen.fasm, Chip(chosen.db_root, chosen.part)).write(chosen.frames)
    except (ToolError, OSError, ValueError) as error:
        print(f"fasm_frames: {error}", file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
