"""What a bitstream was built with beyond lanes, and what a coefficient file needs of it."""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import Final

HEADS_MOST: Final = 4


@dataclass(frozen=True)
class Capability:
    """Generics of ``arctrue_core`` as the register ``capability`` gives them; the default build.

    The same structure says what a coefficient file needs: the least that loads it.
    """

    heads: int = 2
    mean: bool = False
    modulators: bool = False
    real_orders: bool = False
    local_table: bool = False
    failover: bool = False

    def lacking(self, needed: Capability) -> list[str]:
        """Generics that ``needed`` asks for and this bitstream lacks, as ``"HEADS = 4"``."""
        found = []
        for field in fields(self):
            wanted, built = getattr(needed, field.name), getattr(self, field.name)
            if wanted > built:
                value = "true" if wanted is True else str(wanted)
                found.append(f"{field.name.upper()} = {value}")
        return found


EVERYTHING: Final = Capability(HEADS_MOST, True, True, True, True, True)
"""For a reader that only looks at a file and loads it nowhere."""
