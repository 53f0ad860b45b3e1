"""A table with causes that act between the parts of it, not in one of them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from arctrue.table import RotaryTable, TableState
from arctrue.table.causes.cause import Cause
from arctrue.table.conditions import conditions_of


@dataclass(frozen=True, slots=True)
class LoadedTable(RotaryTable):
    """A rotary table whose disc may be turned against the top, on which a reference sits."""

    def reading_rad(self, head: int, state: TableState) -> NDArray[np.float64]:
        """Reading of head 0 or 1 from the index mark, under the conditions of ``state``."""
        conditions = conditions_of(state)
        turn: NDArray[np.float64] | float = 0.0
        for effect in self.effects:
            if isinstance(effect, Cause):
                turn = turn + effect.disc_turn_rad(conditions)
        turned = conditions.turned(conditions.angle_rad + turn)
        return RotaryTable.reading_rad(self, head, turned)
