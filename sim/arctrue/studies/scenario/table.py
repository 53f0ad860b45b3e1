"""The table of a scenario: what its causes turn, and how old its heads' readings are."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from arctrue.table import RotaryTable, TableState
from arctrue.table.causes.cause import Cause
from arctrue.table.conditions import conditions_of


@dataclass(frozen=True, slots=True)
class ScenarioTable(RotaryTable):
    """A table whose disc may be turned against its top, and whose heads' signals may be late."""

    def reading_rad(self, head: int, state: TableState) -> NDArray[np.float64]:
        """Reading of head 0 or 1 from the index mark, under the conditions of ``state``.

        A late signal shows where the table was: back by delay × speed, which is exact at one
        speed and on a ramp off by acceleration × delay²/2.
        """
        conditions = conditions_of(state)
        turn: NDArray[np.float64] | float = 0.0
        delay_s = 0.0
        for effect in self.effects:
            if isinstance(effect, Cause):
                turn = turn + effect.disc_turn_rad(conditions)
                delay_s += effect.sampling_delay_s(head)
        turned = conditions.angle_rad + turn - delay_s * conditions.speed_rad_s
        moved = replace(conditions, angle_rad=np.asarray(turned))
        return RotaryTable.reading_rad(self, head, moved)
