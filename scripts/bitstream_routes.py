"""Follows the wires of a configured chip from an input pin to the driver of its signal."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Final

from scripts.bitstream_database import Chip, Wire
from scripts.bitstream_features import Features
from scripts.netlist import ToolError

TIE_OFF = {"HARD0": 0, "HARD1": 1}
"""Level at each output pin of a site of type TIEOFF."""
CASCADE: Final = re.compile(r"BRAM_CASCOUT_ADDR(?P<port>ARD|BWR)ADDRU\d+")
"""Name of a wire by which a block RAM passes its address to a neighbour, if ``CASCOUT_…_ACTIVE`` is
set."""


@dataclass(frozen=True)
class Source:
    """Driver of a wire: a pin of a site, or a constant ``level``."""

    tile: str = ""
    site: int = 0
    pin: str = ""
    level: int | None = None


class Routes:
    """Finds the drivers of wires and stores them, so that the driver of each wire is searched
    once."""

    def __init__(self, features: Features) -> None:
        """Store the ``features`` of the whole chip."""
        self.features = features
        self.chip: Chip = features.chip
        self._known: dict[Wire, Source | None] = {}

    def source(self, tile: str, wire: str) -> Source | None:
        """Find the driver of a wire; return None if the wire has no driver.

        Raises ToolError if a wire has two drivers or drives itself.
        """
        passed: list[set[Wire]] = []
        seen: set[Wire] = set()
        at: Wire | None = (tile, wire)
        found: Source | None = None
        while at is not None:
            if at in self._known:
                found = self._known[at]
                break
            node = self.chip.node(at)
            if seen & node:
                raise ToolError(f"{tile}: {wire} is driven by itself, by way of {at[0]}/{at[1]}")
            seen |= node
            passed.append(node)
            at, found = self._step(node)
        for node in passed:
            for entry in node:
                self._known[entry] = found
        return found

    def _is_active(self, tile: str, wire: str) -> bool:
        """Tell whether a permanent connection passes a signal to this wire."""
        found = CASCADE.fullmatch(wire)
        return not found or f"CASCOUT_{found['port']}_ACTIVE" in self.features.of(tile)

    def _step(self, node: set[Wire]) -> tuple[Wire | None, Source | None]:
        """Return the driver of a node: (wire, None), (None, pin or constant), or (None, None) if
        the node has no driver."""
        chosen: set[Wire] = set()
        default: set[Wire] = set()
        pins: set[Source] = set()
        for tile, wire in node:
            own = self.chip.type_of(tile)
            driver = self.features.drivers(tile).get(wire)
            if driver is None and wire not in own.driven_by_pin:
                # If a pin of the node is an output, the permanent connection leads through this
                # pin's site.
                driver = own.permanent.get(wire) if self._is_active(tile, wire) else None
            if driver is not None:
                chosen.add((tile, driver))
            elif wire in own.defaults:
                default.add((tile, own.defaults[wire]))
            if wire in own.driven_by_pin:
                site, pin = own.driven_by_pin[wire]
                level = TIE_OFF.get(pin) if own.sites[site]["type"] == "TIEOFF" else None
                pins.add(Source(level=level) if level is not None else Source(tile, site, pin))
        if not chosen and not pins:
            chosen = default
        if len(chosen) + len(pins) > 1:
            drivers = sorted(f"{tile}/{wire}" for tile, wire in chosen)
            drivers += sorted(f"pin {pin.pin} in {pin.tile}" for pin in pins)
            raise ToolError(f"{sorted(node)[0]} is driven by {' and '.join(drivers)}")
        return next(iter(chosen), None), next(iter(pins), None)
