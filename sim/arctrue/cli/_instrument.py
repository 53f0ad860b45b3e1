"""What the commands that run the virtual instrument share: progress, and errors for people."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

from arctrue.cli._progress import Progress

if TYPE_CHECKING:
    from arctrue.instrument import RunProgress


class Shown:
    """What the instrument tells, on stderr."""

    def __init__(self, step: Progress) -> None:
        """``step`` is what is shown while the command runs."""
        self._step = step

    def say(self, text: str) -> None:
        """A line that stays."""
        self._step.keep(text)

    def progress(self, now: RunProgress) -> None:
        """How far the run is."""
        self._step.now(now.words)


@contextmanager
def on_the_instrument(what: str = "") -> Iterator[Shown]:
    """Shows what the instrument tells; its errors become those of :func:`for_people`.

    ``what`` stands before the message of such an error. Raises ValueError.
    """
    from arctrue.instrument import InstrumentError

    with Progress("building the instrument") as step:
        try:
            yield Shown(step)
        except InstrumentError as error:
            raise ValueError(f"{what}: {error}" if what else str(error)) from error
