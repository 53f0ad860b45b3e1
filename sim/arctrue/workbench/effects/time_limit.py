"""Calls a function in a thread of its own and waits for it for a limited time.

Python cannot end a thread from outside. When the time is over, the caller continues, whatever the
function does; this module then raises an error in the function's thread again and again until the
thread ends. A function whose loop catches every error cannot be stopped; its daemon thread ends
with the program at the latest.
"""

from __future__ import annotations

import contextvars
import ctypes
import sys
import threading
import time
from collections.abc import Callable
from types import FrameType
from typing import Any

POLL_S = 0.05
"""Time between two errors that are raised in a thread that is to end."""


class TookTooLongError(Exception):
    """The function did not return within its time.

    ``frames``: the position of its thread at the end of that time, innermost first, as (file,
    line).
    """

    def __init__(self, seconds: float, frames: list[tuple[str, int]]) -> None:
        """Store the limit ``seconds`` and the frames."""
        super().__init__(f"took longer than {seconds:g} s")
        self.frames = frames


def call_within(seconds: float, function: Callable[..., Any], *arguments: Any, **named: Any) -> Any:
    """Return the result of ``function(*arguments, **named)``, or raise its error.

    Raises TookTooLongError after ``seconds`` without a result.
    """
    call = _Call(function, arguments, named)
    try:
        ended = call.done.wait(seconds)
    except BaseException:  # Ctrl-C while waiting
        call.end()
        raise
    if not ended:
        frames = call.frames()
        call.end()
        raise TookTooLongError(seconds, frames)
    if call.error is not None:
        raise call.error
    return call.result


class _EndOfThreadError(SystemExit):
    """Error that ends a thread.

    It derives from SystemExit: ``except Exception`` in a user's effect file does not catch it, and
    Python prints no traceback for it.
    """


class _Call:
    """One call and its thread."""

    def __init__(
        self, function: Callable[..., Any], arguments: tuple[Any, ...], named: dict[str, Any]
    ) -> None:
        self.call = (function, arguments, named)
        self.result: Any = None
        self.error: BaseException | None = None
        self.done = threading.Event()
        self.left = False
        self.lock = threading.Lock()
        # The new thread gets a copy of the caller's context, in which numpy keeps its settings for
        # numerical errors.
        run = contextvars.copy_context().run
        self.thread = threading.Thread(target=run, args=(self._run,), daemon=True)
        self.thread.start()

    def _run(self) -> None:
        function, arguments, named = self.call
        try:
            self.result = function(*arguments, **named)
        except BaseException as error:  # a user's effect file may even call sys.exit
            self.error = error
        while not self.left:
            try:
                with self.lock:
                    self.left = True
            except _EndOfThreadError:
                continue
        self.done.set()

    def frames(self) -> list[tuple[str, int]]:
        frame: FrameType | None = sys._current_frames().get(self.thread.ident or 0)
        found = []
        while frame is not None:
            found.append((frame.f_code.co_filename, frame.f_lineno))
            frame = frame.f_back
        return found

    def end(self) -> None:
        threading.Thread(target=self._send_ends, name="end of a call", daemon=True).start()

    def _send_ends(self) -> None:
        while self.thread.is_alive() and not self.left:
            # While this lock is held the thread cannot finish, so its identifier cannot yet belong
            # to another thread that would get the error.
            with self.lock:
                if not self.left:
                    ctypes.pythonapi.PyThreadState_SetAsyncExc(
                        ctypes.c_ulong(self.thread.ident or 0), ctypes.py_object(_EndOfThreadError)
                    )
            time.sleep(POLL_S)
