"""Sends a coefficient file to a running device, in frames that its console checks.

Each frame is a line of the console with a CRC-32 over its numbers, as little-endian words in the
order of the line. The last frame has the CRC of all words before it. The device accepts the
coefficients completely or not at all, and tests each order with the turns that it captures. A lane
is the part of the gateware that corrects one harmonic; a set for a missing head contains the
coefficients with which the mean works without this head.
"""

from __future__ import annotations

import struct
import time
import zlib
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from arctrue.base.progress import ReportCount
from arctrue.device.console import Console, ConsoleError
from arctrue.device.refusal import explained, reason_of
from arctrue.gateware.capability import Capability
from arctrue.gateware.coefficients import Coefficients
from arctrue.gateware.extension import MODULATORS
from arctrue.gateware.local_table import LocalTable
from arctrue.gateware.mean_set import MeanSet
from arctrue.gateware.table_conditions import condition_registers
from arctrue.generated.number_formats import HEADS_MAX

DEVICE_LOADS = Capability(
    heads=HEADS_MAX,
    mean=True,
    modulators=True,
    real_orders=True,
    local_table=True,
    failover=True,
)
"""Parts of a coefficient file that the console can accept; a core that lacks one of them refuses
the set."""
TABLE_WINDOWS = 4
"""Number of windows of the local table whose starts a frame contains; an unused window has the
start 0."""
ATTEMPTS = 3
"""Number of attempts to send the whole set if a line is damaged or an answer is missing."""
_FIRST_WORD_OF_PROCESSOR = MODULATORS.index("word_a")
_SPOILED = ("wrong_crc", "wrong_frame", "not_whole")
"""Reasons for a refusal that are faults of the transmission, not of the set."""


class LoadRefusedError(Exception):
    """Is raised if the device refuses the coefficients; the message states the reason and the
    remedy."""


def _words(values: Sequence[int]) -> bytes:
    return struct.pack(f"<{len(values)}I", *(value & 0xFFFF_FFFF for value in values))


def _frame(name: str, values: Sequence[int]) -> str:
    numbers = " ".join(str(value) for value in values)
    return f"load {name} {numbers} {zlib.crc32(_words(values)):08X}"


def _mean_of(coefficients: Coefficients) -> MeanSet | None:
    """Return the definition of the heads' mean in the file, or None.

    Raises ValueError if a lane whose order is not an integer follows a condition, because the
    device has no command for such a lane.
    """
    extension = coefficients.extension
    if extension is None:
        return None
    if {lane for lane, _ in extension.turn_steps} & {lane for lane, _ in extension.modulators}:
        raise ValueError("the device loads no lane of a real order that follows a condition")
    return extension.mean


def _sets(coefficients: Coefficients) -> tuple[tuple[MeanSet, Coefficients], ...]:
    """Return the mean and the prepared set for each missing head."""
    if coefficients.extension is None:
        return ()
    sets = ((entry.extension, entry) for entry in coefficients.extension.without)
    means = ((extension.mean, entry) for extension, entry in sets if extension is not None)
    return tuple((mean, entry) for mean, entry in means if mean is not None)


def _follows(coefficients: Coefficients) -> bool:
    """Tell whether any lane of the file or of its prepared sets follows the temperature or a
    condition."""
    every = (coefficients, *(entry for _, entry in _sets(coefficients)))
    return any(
        one.thermal is not None or (one.extension is not None and one.extension.modulators)
        for one in every
    )


def heads_without_sets(coefficients: Coefficients) -> tuple[int, ...]:
    """Return the heads for whose loss the file has a prepared set that is not sent.

    The device accepts no prepared sets if lanes follow the temperature or a condition: the firmware
    would have to write all sets again with every change.
    """
    sets = _sets(coefficients)
    return tuple(mean.missing for mean, _ in sets) if _follows(coefficients) else ()


def _mean_values(mean: MeanSet, offset: int) -> list[tuple[str, list[int]]]:
    """Return names and numbers of the frames that define a mean."""
    used = sum(1 << head for head, is_used in enumerate(mean.used) if is_used)
    delays = sum(clocks << 8 * head for head, clocks in enumerate(mean.delays_clocks))
    heads = enumerate(zip(mean.weights, mean.offsets, strict=True))
    return [
        ("mean", [mean.carrier - 1, used, offset, delays]),
        *(("head", [head, weight, place]) for head, (weight, place) in heads),
    ]


POINTS_A_FRAME = 5


def _table_values(coefficients: Coefficients) -> list[tuple[str, list[int]]]:
    """Return names and numbers of the frames of the local table; the points after the file's last
    point are not sent."""
    extension = coefficients.extension
    if extension is None or extension.local_table is None:
        return []
    table = LocalTable.of_file(extension.local_table, coefficients.counts_per_rev)
    points = list(extension.local_table.points)
    points += [0] * (-len(points) % POINTS_A_FRAME)
    return [
        ("table", table.place_words()[: 1 + TABLE_WINDOWS]),
        *(
            ("points", [first, *points[first : first + POINTS_A_FRAME]])
            for first in range(0, len(points), POINTS_A_FRAME)
        ),
    ]


def _set_values(mean: MeanSet, entry: Coefficients) -> list[tuple[str, list[int]]]:
    """Return names and numbers of the frames of the set for a missing head, in ascending order of
    the lanes."""
    (_, choice), *heads = _mean_values(mean, entry.offset)
    rows = zip(
        entry.orders.tolist(),
        entry.phase_offsets.tolist(),
        entry.amplitudes.tolist(),
        strict=True,
    )
    lanes = sorted(row for row in rows if row[2])
    return [
        ("without", [mean.missing, len(lanes), *choice[:3]]),
        *((f"without_{name}", numbers) for name, numbers in heads),
        *(("without_lane", [number, *row]) for number, row in enumerate(lanes)),
    ]


def load_frames(
    coefficients: Coefficients,
    *,
    force: bool = False,
    unseen: bool = False,
    sets: bool = True,
) -> list[str]:
    """Return the console lines that load the coefficients; unused lanes are omitted.

    With ``unseen`` the device also accepts lanes that no turn of two heads shows: order 0, orders
    that the heads cannot see, lanes that follow a word of the processor. With ``force`` it also
    accepts orders that turns leave undecided. Without ``sets`` the sets for a missing head are
    omitted. If the set corrects a mean of heads, the lines also define this mean. Raises ValueError
    for an offset without a mean, which the device refuses, and for parts that no console command
    can load.
    """
    mean = _mean_of(coefficients)
    if coefficients.offset and mean is None:
        raise ValueError(
            f"offset.word is {coefficients.offset}; expected 0: the device does not correct the "
            "mean error, because the mean depends on the choice of zero"
        )
    thermal = coefficients.thermal
    following = set(thermal.orders) if thermal is not None else set()
    followed = dict(coefficients.extension.modulators) if coefficients.extension else {}
    real = dict(coefficients.extension.turn_steps) if coefficients.extension else {}
    sources = dict(coefficients.extension.phase_sources) if coefficients.extension else {}
    # If an order has a second lane that follows a condition, its constant lane is sent even with an
    # amplitude of 0, so that the calibration does not change the constant lane.
    waves = {int(coefficients.orders[lane]) for lane in followed} - {0}
    lanes = [
        lane
        for lane, order in enumerate(coefficients.orders.tolist())
        if lane not in followed
        and lane not in real
        and (coefficients.amplitudes[lane] or order in following or order in waves)
    ]
    begin = [len(lanes), coefficients.counts_per_rev]

    def words(lane: int) -> list[int]:
        arrays = (coefficients.orders, coefficients.phase_offsets, coefficients.amplitudes)
        return [int(array[lane]) for array in arrays]

    rows = [[number, *words(lane)] for number, lane in enumerate(lanes)]
    named = [("begin", begin), *(("lane", row) for row in rows)]
    for number, lane in enumerate(sorted(followed)):
        modulator = int(coefficients.modulator_numbers[lane])
        named.append(("followed", [number, modulator, *words(lane)]))
    for number, (lane, step) in enumerate(sorted(real.items())):
        amplitude = int(coefficients.amplitudes[lane])
        whole = int(coefficients.real_orders[lane])
        named.append(("real", [number, whole, step & 0xFFFF_FFFF, step >> 32, amplitude]))
        if lane in sources:
            named.append(("source", [number, *sources[lane].numbers]))
    if coefficients.extension is not None and coefficients.extension.conditions is not None:
        registers = condition_registers(
            coefficients.extension.conditions, coefficients.counts_per_rev
        )
        named.append(("conditions", list(registers.values())))
    named += _table_values(coefficients)
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
    if mean is not None:
        named += _mean_values(mean, coefficients.offset)
        for mean_of_set, entry in (
            _sets(coefficients) if sets and not _follows(coefficients) else ()
        ):
            named += _set_values(mean_of_set, entry)
    if force or unseen:
        named.append(("force", [1 if force else 2]))
    whole = zlib.crc32(b"".join(_words(values) for _, values in named))
    return [*(_frame(name, values) for name, values in named), f"load end {whole:08X}"]


def phase_commands(coefficients: Coefficients, turn: int) -> list[str]:
    """Return the console lines that state the phases of the lanes whose order is not an integer.

    The lines omit phases that the device finds itself. ``turn``: the core's number of the turn that
    is turn 0 of the file; the phases in the file are valid for this turn.
    """
    if coefficients.extension is None:
        return []
    degrees = np.degrees(coefficients.phases_rad)
    return [
        f"load phase {number} {degrees[lane]:.6f} {turn}"
        for number, (lane, _) in enumerate(sorted(coefficients.extension.turn_steps))
        if lane not in dict(coefficients.extension.phase_sources)
    ]


@dataclass(frozen=True)
class SentSet:
    """The set that was sent: its orders, and the CRC of all frames, by which the device identifies
    the set."""

    crc: int
    orders: tuple[int, ...]
    followed: int = 0
    """Number of lanes that follow a condition."""
    real: int = 0
    """Number of lanes whose order is not an integer; they are off until their phase is sent or
    found."""
    sought: int = 0
    """Number of these lanes whose phase the device finds from the heads or the probe."""
    unseen_followed: int = 0
    """Number of lanes that follow a condition and that no turn of two heads shows: lanes of order
    0, and lanes that follow a word of the processor."""
    has_table: bool = False
    """Whether the set has a local table."""
    has_sets: bool = False
    """Whether the device has accepted sets for a missing head."""
    lacks_failover: bool = False
    """Whether the file has sets for a missing head, but the gateware was built without FAILOVER."""

    @property
    def is_empty(self) -> bool:
        """Tell whether the set contains no lane and no table, so that the device has no loaded set
        afterwards."""
        return not (self.orders or self.followed or self.real or self.has_table)


def _takes_sets(console: Console, frames: Sequence[str]) -> bool:
    """Send the first frame of the file's sets for a missing head, and tell whether the device
    accepts such sets; a gateware without FAILOVER and older firmware refuse this frame."""
    first = next(frame for frame in frames if frame.startswith("load without "))
    try:
        console.command(first)
    except ConsoleError as error:
        return reason_of(error, "load") not in ("no_failover", None)
    return True


def send_coefficients(
    console: Console,
    coefficients: Coefficients,
    report_count: ReportCount,
    *,
    force: bool = False,
    unseen: bool = False,
) -> SentSet:
    """Send all frames; after a damaged frame or a missing answer, send all of them again.

    ``report_count`` gets the number of sent frames and the number of all frames. ``force`` and
    ``unseen`` are those of :func:`load_frames`. Raises LoadRefusedError if the device refuses the
    set, ConsoleError if it does not answer, and the ValueError of :func:`load_frames`. A core
    without FAILOVER receives no sets for a missing head.
    """
    frames = load_frames(coefficients, force=force, unseen=unseen)
    has_sets = any(frame.startswith("load without ") for frame in frames)
    if has_sets and not _takes_sets(console, frames):
        frames = load_frames(coefficients, force=force, unseen=unseen, sets=False)
    orders = [int(frame.split()[3]) for frame in frames if frame.startswith("load lane ")]
    for attempt in range(1, ATTEMPTS + 1):
        try:
            for number, frame in enumerate(frames, start=1):
                console.command(frame)
                report_count(number, len(frames))
        except ConsoleError as error:
            reason = reason_of(error, "load")
            if reason is not None and reason not in _SPOILED:
                raise LoadRefusedError(explained(console, reason)) from error
            if attempt == ATTEMPTS:
                raise
        else:
            break
    followed = [frame.split() for frame in frames if frame.startswith("load followed ")]
    unseen_followed = sum(
        int(words[3]) >= _FIRST_WORD_OF_PROCESSOR or words[4] == "0" for words in followed
    )
    sends_sets = any(frame.startswith("load without ") for frame in frames)
    return SentSet(
        int(frames[-1].split()[-1], 16),
        tuple(orders),
        followed=len(followed),
        real=sum(frame.startswith("load real ") for frame in frames),
        sought=sum(frame.startswith("load source ") for frame in frames),
        unseen_followed=unseen_followed,
        has_table=any(frame.startswith("load table ") for frame in frames),
        has_sets=sends_sets,
        lacks_failover=has_sets and not sends_sets,
    )


_WAITED = {
    "the other direction": "in the other direction",
    "another speed": "at another speed",
}


@dataclass(frozen=True)
class _Status:
    """Answer of the device to ``load status``."""

    state: str
    reason: str
    orders: tuple[int, ...]
    unjudged: tuple[int, ...]
    undecided: tuple[int, ...]
    refused: tuple[int, ...]
    crc: int | None
    waits_for: tuple[str, ...] = ()
    """Conditions at which the device has not yet captured a turn."""

    @classmethod
    def read(cls, console: Console) -> _Status:
        lines = [line.split() for line in console.command("load status")]

        def numbers(name: str) -> tuple[int, ...]:
            return tuple(int(words[1]) for words in lines if words[:1] == [name])

        states = [words for words in lines if words[:1] == ["load"] and len(words) > 1]
        if len(states) != 1:
            raise ConsoleError(
                f"{console.port}: the answer to 'load status' has {len(states)} lines that begin "
                "with 'load'; expected one: is another program using the device?"
            )
        said = states[0]
        crcs = [int(words[1], 16) for words in lines if words[:1] == ["loaded_crc"]]
        return cls(
            said[1],
            said[2] if len(said) > 2 else "",
            numbers("loaded_order"),
            numbers("unjudged_order"),
            numbers("undecided_order"),
            numbers("refused_order"),
            crcs[0] if crcs else None,
            tuple(
                words[1].replace("_", " ")
                for words in lines
                if words[:1] == ["waits_for"] and len(words) > 1
            ),
        )

    def holds(self, sent: SentSet) -> bool:
        """Tell whether the active set is the sent one; older firmware reports its orders but no
        CRC."""
        if sent.is_empty:
            return self.state == "none"
        same = self.orders == sent.orders if self.crc is None else self.crc == sent.crc
        return self.state == "active" and same


def wait_until_judged(console: Console, sent: SentSet, seconds: float) -> tuple[int, ...]:
    """Wait until captured turns have tested the sent set; return the orders that no turn has
    tested.

    Raises LoadRefusedError if a turn contradicts the set, or if the device has another set at the
    end; ConsoleError if no turn tests the set within ``seconds``.
    """
    end = time.monotonic() + seconds
    status = _Status.read(console)
    while time.monotonic() < end:
        if status.state == "refused":
            named = "".join(f" (order {order})" for order in status.refused)
            raise LoadRefusedError(explained(console, status.reason) + named)
        if status.holds(sent):
            return status.unjudged
        if status.state in ("active", "none"):
            raise LoadRefusedError(
                f"{console.port}: these coefficients are not active: the device says load "
                f"{status.state}{_listed(': it has the orders ', status.orders)}; was it given "
                "another set, re-armed or switched off meanwhile? Load them again"
            )
        time.sleep(0.2)
        status = _Status.read(console)
    console.command("load abort")
    if status.waits_for:
        raise ConsoleError(
            f"{console.port}: waiting for a turn "
            + " and one ".join(_WAITED[name] for name in status.waits_for)
            + f" for {seconds:g} s; nothing is loaded. Load again while the table turns like this, "
            "or load the lanes that follow a condition without a test (--force)"
        )
    if status.undecided:
        raise ConsoleError(
            f"{console.port}: within {seconds:g} s the turns did not show whether"
            f"{_listed(' the orders ', status.undecided)} are right: their noise is as large as "
            "the orders, or the samples of a turn cannot separate them; nothing is loaded. Wait "
            "longer "
            "(--timeout), leave them out, or load them without a test (--force)"
        )
    raise ConsoleError(
        f"{console.port}: no turn tested the coefficients within {seconds:g} s, nothing is loaded; "
        "does the table turn? The console's status shows why turns are refused"
    )


def _listed(before: str, orders: Sequence[int]) -> str:
    return before + ", ".join(map(str, orders)) if orders else ""
