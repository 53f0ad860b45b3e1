"""Decodes configuration frames to features, which state how each tile of a chip is configured."""

from __future__ import annotations

import re
import subprocess
from collections import defaultdict
from collections.abc import Mapping
from functools import cached_property
from pathlib import Path
from typing import Final

from scripts.bitstream_database import Chip, TileType
from scripts.netlist import ToolError

WORD_BITS: Final = 32
SHOWN: Final = 5
INDEXED: Final = re.compile(r"(?P<name>.*)\[(?P<index>\d+)\]")

Bits = Mapping[int, frozenset[int]]
"""Numbers of the set bits of each frame, by the frame's address; the numbers count from bit 0 of
word 0."""


def bits_of_frames(path: Path) -> Bits:
    """Return the set bits in a file of frames that scripts/fasm_frames.py or fasm2frames has
    written."""
    found = {}
    for line in path.read_text(encoding="ascii").splitlines():
        address, _, words = line.partition(" ")
        bits = {
            place * WORD_BITS + bit
            for place, word in enumerate(words.split(","))
            if (value := int(word, 16))
            for bit in range(WORD_BITS)
            if value >> bit & 1
        }
        if bits:
            found[int(address, 16)] = frozenset(bits)
    return found


def bits_of_bitstream(bitstream: Path, reader: str, part_file: Path) -> Bits:
    """Return the set bits of a bitstream, read by Project X-Ray's ``bitread``.

    Raises ToolError if ``bitread`` fails.
    """
    listed = bitstream.with_suffix(".bits")
    command = [reader, "-part_file", str(part_file), "-y", "-z", "-o", str(listed), str(bitstream)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode:
        raise ToolError(f"{reader} failed for {bitstream}: {done.stderr.strip()[-300:]}")
    found: dict[int, set[int]] = defaultdict(set)
    for line in listed.read_text(encoding="ascii").split():
        _, address, word, bit = line.split("_")
        found[int(address, 16)].add(int(word) * WORD_BITS + int(bit))
    listed.unlink()
    return {address: frozenset(bits) for address, bits in found.items()}


class Features:
    """Enabled features of every tile of a chip."""

    def __init__(self, chip: Chip, bits: Bits) -> None:
        """Store ``bits``, the set bits of a whole configuration."""
        self.chip = chip
        self._bits = bits
        self._found: dict[str, frozenset[str]] = {}
        self._drivers: dict[str, dict[str, str]] = {}

    def of(self, tile: str) -> frozenset[str]:
        """Return the enabled features of a tile, as named in the tile's type; a feature is enabled
        if each of its bits has the level that the database states."""
        if tile not in self._found:
            self._found[tile] = self._read(tile)
        return self._found[tile]

    def _read(self, tile: str) -> frozenset[str]:
        own = self.chip.type_of(tile)
        start = 0
        names: dict[str, str] = {}
        alias = self.chip.alias(tile)
        if alias:
            own, sites, start = alias
            names = {there: here for here, there in sites.items()}
        ones = self._ones(tile, start)
        found = set()
        for place in ones:
            for name in own.by_bit.get(place, ()):
                kind, bits = own.features[name]
                if all(((kind, frame, bit) in ones) == is_set for frame, bit, is_set in bits):
                    site, dot, rest = name.partition(".")
                    found.add(names.get(site, site) + dot + rest if names else name)
        return frozenset(found)

    def _ones(self, tile: str, start: int) -> set[tuple[str, int, int]]:
        """Return the kind of frame, frame in the tile and bit in the tile of every set bit of a
        tile."""
        found = set()
        for kind, block in self.chip.tiles[tile]["bits"].items():
            base = int(block["baseaddr"], 16)
            low = block["offset"] * WORD_BITS
            high = low + block["words"] * WORD_BITS
            shift = (block["offset"] - start) * WORD_BITS
            for frame in range(block["frames"]):
                for bit in self._bits.get(base + frame, ()):
                    if low <= bit < high:
                        found.add((kind, frame, bit - shift))
        return found

    @cached_property
    def tiles(self) -> list[str]:
        """Return the tiles that have an enabled feature."""
        return [tile for tile in self.chip.tiles if self.of(tile)]

    def drivers(self, tile: str) -> dict[str, str]:
        """Return, for each wire of a tile, the driver that an enabled feature selects.

        Raises ToolError if two features drive one wire.
        """
        if tile not in self._drivers:
            self._drivers[tile] = self._read_drivers(tile)
        return self._drivers[tile]

    def _read_drivers(self, tile: str) -> dict[str, str]:
        own = self.chip.type_of(tile)
        choices: dict[str, list[str]] = defaultdict(list)
        for name in self.of(tile):
            wire, _, driver = name.partition(".")
            if driver in own.pips.get(wire, ()):
                choices[wire].append(driver)
        return {wire: self._only(own, tile, wire, drivers) for wire, drivers in choices.items()}

    @staticmethod
    def _only(own: TileType, tile: str, wire: str, drivers: list[str]) -> str:
        """Return the one driver in ``drivers`` whose bits are not a subset of another driver's
        bits. Raises ToolError if there are several such drivers."""

        def ones(driver: str) -> set[tuple[int, int]]:
            return {
                (frame, bit) for frame, bit, is_set in own.features[f"{wire}.{driver}"][1] if is_set
            }

        whole = [one for one in drivers if not any(ones(one) < ones(other) for other in drivers)]
        if len(whole) > 1:
            raise ToolError(f"{tile}: {wire} is driven by {' and '.join(sorted(whole))}")
        return whole[0]

    def unexplained(self) -> list[str]:
        """Return frame, word and bit of each set bit that belongs to no enabled feature."""
        explained: dict[int, set[int]] = defaultdict(set)
        for tile in self.tiles:
            own = self.chip.type_of(tile)
            start = 0
            sites: dict[str, str] = {}
            alias = self.chip.alias(tile)
            if alias:
                own, sites, start = alias
            for name in self.of(tile):
                site, dot, rest = name.partition(".")
                kind, bits = own.features[sites.get(site, site) + dot + rest if sites else name]
                block = self.chip.tiles[tile]["bits"][kind]
                shift = (block["offset"] - start) * WORD_BITS
                base = int(block["baseaddr"], 16)
                for frame, bit, is_set in bits:
                    if is_set:
                        explained[base + frame].add(bit + shift)
        return [
            f"frame 0x{address:08X} word {bit // WORD_BITS} bit {bit % WORD_BITS}"
            for address, bits in sorted(self._bits.items())
            for bit in sorted(bits - explained[address])
        ]


def vector(features: frozenset[str], name: str) -> int:
    """Return the number in which bit i is 1 if ``features`` contain ``name[i]``."""
    value = 0
    for feature in features:
        found = INDEXED.fullmatch(feature)
        if found and found["name"] == name:
            value |= 1 << int(found["index"])
    return value
