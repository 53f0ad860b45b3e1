"""Defines the options and the progress bar of every command that runs a campaign (many independent
tasks)."""

from __future__ import annotations

import functools
import sys
import time
from collections.abc import Callable
from typing import Any, Self

import click
from rich.progress import BarColumn, MofNCompleteColumn, TextColumn
from rich.progress import Progress as Bar

from arctrue.base.printable import time_left
from arctrue.cli._progress import SECONDS_BETWEEN_LINES, progress_console
from arctrue.cli._terminal import note, tell_error
from arctrue.studies.campaign import CampaignError, Interrupted, Speed

EXIT_INTERRUPTED = 130


class _Shard(click.ParamType[tuple[int, int]]):
    """Accepts ``i/n``, which selects part i of n parts of the tasks."""

    name = "i/n"

    def convert(
        self, value: Any, param: click.Parameter | None, ctx: click.Context | None
    ) -> tuple[int, int]:
        try:
            place, number = (int(item) for item in str(value).split("/"))
        except ValueError:
            self.fail(f"expected a shard such as 3/10, found {value!r}", param, ctx)
        if not 1 <= place <= number:
            self.fail(f"a shard is 1/{number} … {number}/{number}, found {value!r}", param, ctx)
        return place, number


def campaign_options(function: Callable[..., None]) -> Callable[..., None]:
    """Add the options --workers, --scheduler and --shard to a command."""
    for option in (
        click.option("--shard", type=_Shard(), help="Do every N-th task, beginning with the I-th."),
        click.option(
            "--scheduler",
            metavar="ADDRESS",
            help="Address of a Dask scheduler that runs the tasks.",
        ),
        click.option(
            "--workers",
            type=click.IntRange(min=1),
            help="Number of processes on this machine.  [default: number of its cores]",
        ),
    ):
        function = option(function)
    return function


def interruptible(function: Callable[..., None]) -> Callable[..., None]:
    """Print one sentence and end the command if Ctrl-C (exit code 130) or a dead worker (2) stops
    it."""

    @functools.wraps(function)
    def wrapped(*arguments: Any, **options: Any) -> None:
        try:
            function(*arguments, **options)
        except Interrupted as stop:
            tell_error(str(stop))
            raise SystemExit(EXIT_INTERRUPTED) from None
        except CampaignError as error:
            tell_error(str(error))
            raise SystemExit(2) from error

    return wrapped


class CampaignBar:
    """Shows on stderr how many tasks are done: as a bar on a terminal, otherwise as a line every 10
    s."""

    def __init__(self, what: str) -> None:
        """Store ``what``, which names the tasks in the plural, for example sets or turns."""
        self._what = what
        self._last_line = time.monotonic()
        self._bar = Bar(
            TextColumn("{task.description}"),
            BarColumn(),
            MofNCompleteColumn(),
            TextColumn("{task.fields[speed]}"),
            console=progress_console,
            disable=not sys.stderr.isatty(),
        )
        self._task = self._bar.add_task(what, total=None, speed="")

    def __enter__(self) -> Self:
        """Show the bar until the ``with`` block ends."""
        self._bar.start()
        return self

    def __exit__(self, *_: object) -> None:
        """Stop the bar; its last state remains on the terminal."""
        self._bar.stop()

    def show(self, speed: Speed) -> None:
        """Show how many tasks are done, how fast they are done, and how much time remains."""
        text = f"{speed.tasks_per_s:.2g} {self._what}/s, {time_left(speed.seconds_left)} left"
        self._bar.update(self._task, completed=speed.done, total=speed.total, speed=text)
        if self._bar.disable and time.monotonic() - self._last_line > SECONDS_BETWEEN_LINES:
            self._last_line = time.monotonic()
            note(f"{speed.done} of {speed.total} {self._what}, {text}")
