"""Reads all heads of a device at one clock, repeatedly, over the console."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from arctrue.device.console import Console, ConsoleError

TURNS_WANTED = 2.1
"""Number of turns to read: in the first turn every head finds its index, and the second turn shows
the places."""
READINGS_LEAST = 24


@dataclass(frozen=True)
class HeadsReadings:
    """Readings of all heads; all readings in a row are from one clock.

    ``positions`` (n, heads) are counts modulo 2³². ``angles`` (m, heads) are counts after the
    index; they begin when every head marked in ``indexed`` (heads,) has passed its index.
    """

    positions: NDArray[np.int64]
    angles: NDArray[np.int64]
    indexed: NDArray[np.bool_]


def read_heads(
    console: Console,
    counts_per_rev: int,
    seconds: float,
    tell: Callable[[float], None] = lambda turns: None,
) -> HeadsReadings:
    """Read the heads until one of them has moved by 2.1 turns and 24 readings were made, or until
    ``seconds`` have passed.

    ``tell`` is called with the number of turns so far. Raises ConsoleError if the device does not
    have the command or its answer has another form.
    """
    positions, angles, indexed = [], [], []
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        words = [line.split() for line in console.command("heads")]
        if not words or any(len(one) != 4 or not one[0].startswith("head") for one in words):
            raise ConsoleError(f"{console.port}: the answer to heads is not understood: {words}")
        positions.append([int(one[1]) for one in words])
        angles.append([int(one[2]) for one in words])
        indexed.append([one[3] == "indexed" for one in words])
        steps = np.diff(np.array(positions), axis=0).astype(np.uint32).view(np.int32)
        moved = float(np.abs(steps.astype(np.int64).sum(axis=0)).max(initial=0)) / counts_per_rev
        tell(moved)
        if moved >= TURNS_WANTED and len(positions) >= READINGS_LEAST:
            break
    latest = np.array(indexed[-1])
    whole = np.array(indexed)[:, latest].all(axis=1)
    return HeadsReadings(
        np.array(positions, dtype=np.int64), np.array(angles, dtype=np.int64)[whole], latest
    )
