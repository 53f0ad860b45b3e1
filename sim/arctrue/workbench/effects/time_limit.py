"""Ends a call that takes too long: a thread that watches raises an error in the thread that calls.

The error comes at the next instruction of Python. A call that never comes back from C code (a
sleep, a lock) is ended only when it does.
"""

from __future__ import annotations

import ctypes
import os
import threading
import time
from types import TracebackType
from typing import Self

POLL_S = 0.05
"""Between two looks at the calls that are watched."""


class TookTooLongError(BaseException):
    """No Exception: a file that catches every Exception does not catch it."""


class TimeLimit:
    """``with TimeLimit(60.0) as limit:`` raises TookTooLongError within it after 60 s.

    Limits may stand within each other. ``limit.over`` says whose error it was.
    """

    def __init__(self, seconds: float) -> None:
        """``seconds`` of the clock, from the beginning of the block."""
        self.seconds = seconds
        self.over = False
        self.thread = 0
        self.end = 0.0

    def __enter__(self) -> Self:
        """The time begins."""
        self.thread = threading.get_ident()
        self.end = time.monotonic() + self.seconds
        _watch.add(self)
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """The time no longer counts, and no error of it comes later."""
        while True:
            try:
                _watch.take_away(self)
                break
            except TookTooLongError:
                # It came just now; what must not be left undone is done first.
                continue
        if self.over:
            _raise_in(self.thread, None)


class _Watch:
    """The calls that are watched now, and the thread that looks at them."""

    def __init__(self) -> None:
        self.limits: list[TimeLimit] = []
        self.lock = threading.Lock()
        self.some = threading.Event()
        self.process = 0

    def add(self, limit: TimeLimit) -> None:
        if self.process != os.getpid():
            self._start()
        self.limits.append(limit)
        self.some.set()

    def take_away(self, limit: TimeLimit) -> None:
        with self.lock:
            if limit in self.limits:
                self.limits.remove(limit)

    def _start(self) -> None:
        """In this process; one that was forked has no thread of its parent."""
        self.__init__()  # type: ignore[misc]
        self.process = os.getpid()
        threading.Thread(target=self._look, name="time limit", daemon=True).start()

    def _look(self) -> None:
        while True:
            self.some.wait()
            time.sleep(POLL_S)
            with self.lock:
                now = time.monotonic()
                # Again at each look: a bare except within a loop catches the error once.
                for limit in self.limits:
                    if now > limit.end:
                        limit.over = True
                        _raise_in(limit.thread, TookTooLongError)
                if not self.limits:
                    self.some.clear()


def _raise_in(thread: int, error: type[BaseException] | None) -> None:
    """At the thread's next instruction; None takes an error back that has not come yet."""
    what = None if error is None else ctypes.py_object(error)
    ctypes.pythonapi.PyThreadState_SetAsyncExc(ctypes.c_ulong(thread), what)


_watch = _Watch()
