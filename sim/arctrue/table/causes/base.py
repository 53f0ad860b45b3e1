"""What a physical cause can move: the axis, the disc, a head, a line, or a head's signal."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from arctrue.table.state import TableState

Points = NDArray[np.complex128]
"""Points or displacements in the plane, x + jy in metres, shape ``(n,)``."""


class PhysicalEffect:
    """Base of every cause: moves nothing. A cause overrides what it moves.

    The table adds what its effects return, each in the frame named by the method. An effect
    says what happens, never what a reading becomes of it: that follows from the geometry.
    """

    def axis_shift_m(self, state: TableState) -> Points | complex:
        """Displacement of the axis in the stator frame."""
        return 0.0

    def disc_shift_m(self, state: TableState) -> Points | complex:
        """Displacement of the disc centre from the axis in the frame of the turning table."""
        return 0.0

    def head_shift_m(self, head: int, state: TableState) -> Points | complex:
        """Displacement of head 0 or 1 in the stator frame."""
        return 0.0

    def graduation_error_rad(
        self, disc_angle_rad: NDArray[np.float64], state: TableState
    ) -> NDArray[np.float64] | float:
        """What the lines at a disc angle say too much; period one turn."""
        return 0.0

    def signal_error_rad(
        self, head: int, disc_reading_rad: NDArray[np.float64], state: TableState
    ) -> NDArray[np.float64] | float:
        """What the signal of head 0 or 1 adds to the lines that it sees."""
        return 0.0
