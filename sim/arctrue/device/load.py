"""A coefficient file into a running device, in frames that its console checks.

Each frame is a line of the console with a CRC-32 over its numbers, as little-endian words in the
order in which they stand there; the last frame has that of all words before it. The device takes
the set whole or not at all, and judges it on the next turn that it captures.
"""

from __future__ import annotations

import struct
import time
import zlib
from collections.abc import Callable, Sequence

from arctrue.device.console import Console, ConsoleError
from arctrue.device.refusal import explained, reason_of
from arctrue.gateware.coefficients import Coefficients

ATTEMPTS = 3
"""Of the whole set, where a line was spoiled on the way."""
_SPOILED = ("wrong_crc", "wrong_frame", "not_whole")
"""Reasons of the device that say nothing of the set."""


class LoadRefusedError(Exception):
    """The device does not take the coefficients; the message says why and what to do."""


def _words(values: Sequence[int]) -> bytes:
    return struct.pack(f"<{len(values)}I", *(value & 0xFFFF_FFFF for value in values))


def _frame(name: str, values: Sequence[int]) -> str:
    numbers = " ".join(str(value) for value in values)
    return f"load {name} {numbers} {zlib.crc32(_words(values)):08X}"


def load_frames(coefficients: Coefficients, *, force: bool = False) -> list[str]:
    """The lines of the console that load the lanes whose amplitude is not 0.

    With ``force`` the device takes orders that no turn can judge.

    Raises ValueError for an offset, which the device does not take.
    """
    if coefficients.offset:
        raise ValueError(
            f"offset.word is {coefficients.offset}; expected 0: the device corrects no mean, which "
            "is the choice of zero"
        )
    thermal = coefficients.thermal
    following = set(thermal.orders) if thermal is not None else set()
    lanes = [
        lane
        for lane, order in enumerate(coefficients.orders.tolist())
        if coefficients.amplitudes[lane] or order in following
    ]
    begin = [len(lanes), coefficients.counts_per_rev]
    rows = [
        [
            number,
            int(coefficients.orders[lane]),
            int(coefficients.phase_offsets[lane]),
            int(coefficients.amplitudes[lane]),
        ]
        for number, lane in enumerate(lanes)
    ]
    named = [("begin", begin), *(("lane", row) for row in rows)]
    if thermal is not None:
        milli = [round(1000 * thermal.reference_c), round(1000 * thermal.time_constant_s)]
        named.append(("temperature", milli))
        if not thermal.has_default_range:
            span = [round(1000 * thermal.least_c), round(1000 * thermal.most_c)]
            named.append(("range", span))
        named += [
            ("slope", [number, order, *thermal.slopes[number].tolist()])
            for number, order in enumerate(thermal.orders)
        ]
    if force:
        named.append(("force", [1]))
    whole = zlib.crc32(b"".join(_words(values) for _, values in named))
    return [*(_frame(name, values) for name, values in named), f"load end {whole:08X}"]


def send_coefficients(
    console: Console, coefficients: Coefficients, progress: Callable[[int, int], None]
) -> None:
    """All frames, again from the first where one was spoiled; ``progress`` hears done and all.

    Raises LoadRefusedError where the device refuses the set, ConsoleError where it does not
    answer, ValueError as :func:`load_frames`.
    """
    frames = load_frames(coefficients)
    for attempt in range(1, ATTEMPTS + 1):
        try:
            for number, frame in enumerate(frames, start=1):
                console.command(frame)
                progress(number, len(frames))
            return
        except ConsoleError as error:
            reason = reason_of(error, "load")
            if reason is not None and reason not in _SPOILED:
                raise LoadRefusedError(explained(console, reason)) from error
            if attempt == ATTEMPTS:
                raise


def wait_until_judged(console: Console, seconds: float) -> None:
    """Until a captured turn has judged what was sent.

    Raises LoadRefusedError where the turn speaks against it, ConsoleError where none comes.
    """
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        told = [line for line in console.command("load status") if line.startswith("load ")]
        if len(told) != 1:
            raise ConsoleError(
                f"{console.port}: the answer to 'load status' has {len(told)} lines that begin "
                "with 'load'; expected one: is another program using the device?"
            )
        words = told[0].split()
        if words[1] == "refused":
            raise LoadRefusedError(explained(console, words[2]))
        if words[1] in ("active", "none"):
            return
        time.sleep(0.2)
    console.command("load abort")
    raise ConsoleError(
        f"{console.port}: no turn judged the coefficients within {seconds:g} s, nothing is loaded; "
        "does the table turn? The console's status tells why turns are refused"
    )
