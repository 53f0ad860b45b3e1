"""Compares generics of a bitstream (heads and extensions, not the number of lanes) with those that
a coefficient file requires."""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import Final

from arctrue.generated.number_formats import HEADS_MAX


@dataclass(frozen=True)
class Capability:
    """Generics of ``arctrue_core`` as the register ``capability`` states them; the defaults
    describe the default build.

    An object of this class also states the requirements of a coefficient file, as the smallest
    build that can load the file.
    """

    heads: int = 2
    mean: bool = False
    modulators: bool = False
    real_orders: bool = False
    local_table: bool = False
    failover: bool = False

    def lacking(self, needed: Capability) -> list[str]:
        """Return the generics that ``needed`` requires and this bitstream lacks, each as a text
        such as ``"HEADS = 4"``."""
        found = []
        for field in fields(self):
            wanted, built = getattr(needed, field.name), getattr(self, field.name)
            if wanted > built:
                value = "true" if wanted is True else str(wanted)
                found.append(f"{field.name.upper()} = {value}")
        return found


EVERYTHING: Final = Capability(HEADS_MAX, True, True, True, True, True)
"""Capability that satisfies every file, for a reader that only displays a file."""
