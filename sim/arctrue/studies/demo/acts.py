"""Runs an act of the demo in the background, so that both acts run in parallel."""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import Generic, TypeVar

_T = TypeVar("_T")
_LOOK_S = 0.5


class Background(Generic[_T]):
    """Runs a function in a thread of its own, which starts at once.

    The thread ends with the process, so that Ctrl-C can stop the demo.
    """

    def __init__(self, work: Callable[[], _T]) -> None:
        """Start ``work`` in a thread; if ``work`` raises an exception, :meth:`wait` raises this
        exception again."""
        self._work = work
        self._results: list[_T] = []
        self._error: Exception | None = None
        self._thread = threading.Thread(target=self._run, daemon=True)
        self._thread.start()

    def _run(self) -> None:
        try:
            self._results.append(self._work())
        except Exception as error:
            self._error = error

    def wait(self) -> _T:
        """Return the result of the work, or raise the exception that the work raised."""
        while self._thread.is_alive():
            # A join without timeout cannot be interrupted on every system.
            self._thread.join(_LOOK_S)
        if self._error is not None:
            raise self._error
        return self._results[0]
