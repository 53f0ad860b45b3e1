"""Passes curves to the harness during a run."""

from __future__ import annotations

from concurrent.futures import Future, ThreadPoolExecutor
from typing import Any

import numpy as np

from arctrue.instrument.curves import Curve, Curves
from arctrue.instrument.library import NEED_PIECE

_PIECE_CLOCKS = 1 << 18


class CurveFeeder:
    """Passes curves to the harness piece by piece, and computes the next piece while the harness
    runs."""

    def __init__(self, library: Any, handle: Any, start: int, curves: Curves) -> None:
        """Store the harness, and ``start``, the clock at which the curves begin."""
        self._library, self._handle = library, handle
        self._curves, self._start = curves, start
        self._pool = ThreadPoolExecutor(1)
        self._next: tuple[int, Future[tuple[int, *tuple[Curve, ...]]]] | None = None
        self.error: BaseException | None = None
        self.callback = NEED_PIECE(self._hand_over)

    def close(self) -> None:
        """End the calculation of pieces."""
        self._pool.shutdown(wait=True, cancel_futures=True)

    def _hand_over(self, _: int | None, clock: int) -> int:
        try:
            first = clock - self._start
            if self._next is not None and self._next[0] == first:
                knot, *values = self._next[1].result()
            else:
                knot, *values = self._curves.piece(first, _PIECE_CLOCKS)
            rows = np.ascontiguousarray(values, dtype=np.float64)
            heads, knots = rows.shape[0] - 1, rows.shape[1]
            self._library.instrument_piece(
                self._handle, clock, knot, knots, heads, rows.ctypes.data
            )
            following = first + knot * (knots - 3)
            self._next = None
            if following < self._curves.clocks:
                future = self._pool.submit(self._curves.piece, following, _PIECE_CLOCKS)
                self._next = (following, future)
        except Exception as error:
            self.error = error
            return 1
        return 0
