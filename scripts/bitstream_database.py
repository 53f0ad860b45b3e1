"""Reads Project X-Ray's database of a chip: its tiles, the meaning of their bits, and the
connections of their wires.

Project X-Ray's documentation ("Database") describes the files. ``tilegrid.json`` has the tiles and
the places of their bits. ``segbits_*.db`` has the bits of each feature. ``ppips_*.db`` has the
connections without bits, which always exist, or exist if nothing else drives the wire.
``tile_type_*.json`` has the sites, their pins and the tile's connections. ``tileconn.json`` states
which wires of neighbours are connected.
"""

from __future__ import annotations

import json
from collections import defaultdict
from collections.abc import Iterator
from functools import cached_property
from pathlib import Path
from typing import Any, Final

from scripts.netlist import ToolError

Bit = tuple[int, int, bool]
"""Bit of a feature: frame within the tile, bit within the tile's words, and whether the bit is
set."""
Wire = tuple[str, str]
"""Wire of a tile: names of the tile and of the wire."""

ALWAYS: Final = "always"
DEFAULT: Final = "default"


def _bits(text: str) -> list[Bit]:
    """Read bits such as ``28_05 !27_11``: each has the form frame_bit, and ! means that the feature
    clears the bit."""
    found = []
    for word in text.split():
        frame, _, bit = word.removeprefix("!").partition("_")
        found.append((int(frame), int(bit), not word.startswith("!")))
    return found


class TileType:
    """Type of tile: its features with their bits and the kind of frames, and its sites and
    connections."""

    def __init__(self, family: Path, name: str) -> None:
        """Read the type ``name`` from ``family``, the database's folder of the family."""
        lower = name.lower()
        self.family = family
        self.name = name
        self.features: dict[str, tuple[str, list[Bit]]] = {}
        for kind, file in (
            ("CLB_IO_CLK", f"segbits_{lower}.db"),
            ("BLOCK_RAM", f"segbits_{lower}.block_ram.db"),
        ):
            for feature, bits in self._entries(family / file):
                self.features[feature] = (kind, _bits(bits))
        # These connections always exist or depend on other connections, so they set no bits.
        self.without_bits = dict(self._entries(family / f"ppips_{lower}.db"))

    @staticmethod
    def _entries(path: Path) -> Iterator[tuple[str, str]]:
        if path.exists():
            for line in path.read_text(encoding="ascii").splitlines():
                entry, _, rest = line.partition(" ")
                if entry:
                    yield entry.partition(".")[2], rest

    def find(self, feature: str, index: int | None) -> tuple[str, list[Bit]] | None:
        """Return the kind of frames and the bits of a feature; the list of bits is empty if the
        feature sets no bits. Return None if the database does not have the feature."""
        if feature in self.without_bits:
            return "", []
        if not index and feature in self.features:
            return self.features[feature]
        for digits in (1, 2, 3):
            found = self.features.get(f"{feature}[{index or 0:0{digits}d}]")
            if found:
                return found
        return None

    @cached_property
    def by_bit(self) -> dict[tuple[str, int, int], list[str]]:
        """Return the features by the first bit that each feature sets; the key is the kind of
        frame, the frame and the bit."""
        found: dict[tuple[str, int, int], list[str]] = defaultdict(list)
        for name, (kind, bits) in self.features.items():
            first = next((bit for bit in bits if bit[2]), None)
            if first:
                found[kind, first[0], first[1]].append(name)
        return found

    @cached_property
    def _tile(self) -> dict[str, Any]:
        path = self.family / f"tile_type_{self.name}.json"
        if not path.exists():
            return {"pips": {}, "sites": []}
        found: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
        return found

    @cached_property
    def sites(self) -> list[dict[str, Any]]:
        """Return the sites of the type with ``name``, ``type``, ``prefix`` and ``site_pins`` (pin
        to ``wire``)."""
        return [
            {
                **site,
                "site_pins": {
                    pin: entry["wire"] if isinstance(entry, dict) else entry
                    for pin, entry in site["site_pins"].items()
                    if entry
                },
            }
            for site in self._tile["sites"]
        ]

    @cached_property
    def pips(self) -> dict[str, set[str]]:
        """Return, for each wire, the wires of the tile that can drive it."""
        found: dict[str, set[str]] = defaultdict(set)
        for pip in self._tile["pips"].values():
            found[pip["dst_wire"]].add(pip["src_wire"])
            if pip["is_directional"] == "0":
                found[pip["src_wire"]].add(pip["dst_wire"])
        return found

    @cached_property
    def permanent(self) -> dict[str, str]:
        """Return the permanent driver of each wire that has a permanent driver."""
        return dict(
            entry.split(".", 1) for entry, kind in self.without_bits.items() if kind == ALWAYS
        )

    @cached_property
    def defaults(self) -> dict[str, str]:
        """Return the driver that a wire has without an enabled feature: the documented default, or
        the driver whose feature sets no bits."""
        found = {
            destination: source
            for destination, _, source in (
                name.partition(".")
                for name, (_, bits) in self.features.items()
                if bits and not any(bit[2] for bit in bits)
            )
            if source in self.pips.get(destination, ())
        }
        documented = (
            entry.split(".", 1) for entry, kind in self.without_bits.items() if kind == DEFAULT
        )
        return found | dict(documented)

    @cached_property
    def driven_by_pin(self) -> dict[str, tuple[int, str]]:
        """Return, for each wire that a site drives, the index of the site in ``sites`` and the
        output pin."""
        found = {}
        for place, site in enumerate(self.sites):
            path = self.family / f"site_type_{site['type']}.json"
            directions = json.loads(path.read_text(encoding="utf-8"))["site_pins"]
            for pin, wire in site["site_pins"].items():
                if directions[pin]["direction"] == "OUT":
                    found[wire] = (place, pin)
        return found


class Chip:
    """Tiles of a part, their types, and the connections of their wires."""

    def __init__(self, family: Path, part: str) -> None:
        """Read the part from ``family``, the database's folder. Raises ToolError if it lacks the
        part."""
        grids = [
            path for path in family.glob("*/tilegrid.json") if part.startswith(path.parent.name)
        ]
        if not grids:
            raise ToolError(f"{family} has no tilegrid.json for the part {part}")
        self.family = family
        self.part = part
        self.folder = grids[0].parent
        self.tiles: dict[str, Any] = json.loads(grids[0].read_text(encoding="utf-8"))
        self._types: dict[str, TileType] = {}

    def type(self, name: str) -> TileType:
        """Return the type of tile with this name."""
        if name not in self._types:
            self._types[name] = TileType(self.family, name)
        return self._types[name]

    def type_of(self, tile: str) -> TileType:
        """Return the type of the tile with the name ``tile``."""
        return self.type(self.tiles[tile]["type"])

    def alias(self, tile: str) -> tuple[TileType, dict[str, str], int] | None:
        """Return, for a tile at the chip's edge, the type whose bits it uses, the names of its
        sites in that type, and the first word; return None for other tiles. Such a tile has only
        one of the two sites of the type."""
        for block in self.tiles[tile]["bits"].values():
            if "alias" in block:
                alias = block["alias"]
                return self.type(alias["type"]), alias["sites"], alias["start_offset"]
        return None

    @cached_property
    def at(self) -> dict[tuple[int, int], str]:
        """Return the name of the tile at each column and row of the grid."""
        return {(tile["grid_x"], tile["grid_y"]): name for name, tile in self.tiles.items()}

    @cached_property
    def of_site(self) -> dict[str, str]:
        """Return the name of the tile in which each site is."""
        return {site: name for name, tile in self.tiles.items() for site in tile.get("sites", {})}

    @cached_property
    def _joints(self) -> dict[tuple[str, str], list[tuple[int, int, str, str]]]:
        """Return, for each type of tile and wire, the connected wires of neighbours: columns to the
        right, rows down, type of tile and wire."""
        path = self.folder / "tileconn.json"
        found: dict[tuple[str, str], list[tuple[int, int, str, str]]] = defaultdict(list)
        for entry in json.loads(path.read_text(encoding="utf-8")):
            right, down = entry["grid_deltas"]
            one, other = entry["tile_types"]
            for here, there in entry["wire_pairs"]:
                found[one, here].append((right, down, other, there))
                found[other, there].append((-right, -down, one, here))
        return found

    def node(self, wire: Wire) -> set[Wire]:
        """Return all wires that are connected to ``wire`` without a switch."""
        found = {wire}
        waiting = [wire]
        while waiting:
            tile_name, name = waiting.pop()
            tile = self.tiles[tile_name]
            for right, down, other_type, other_wire in self._joints.get((tile["type"], name), ()):
                other = self.at.get((tile["grid_x"] + right, tile["grid_y"] + down))
                if other is None or self.tiles[other]["type"] != other_type:
                    continue
                entry = (other, other_wire)
                if entry not in found:
                    found.add(entry)
                    waiting.append(entry)
        return found
