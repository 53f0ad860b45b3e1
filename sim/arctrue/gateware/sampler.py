"""Models ``rtl/sampler/sampler.vhd`` with two heads bit by bit; the entity stores samples of the
positions of the heads, turn by turn."""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import ArrayLike, NDArray

from arctrue.gateware.sample_trigger import SampleTrigger, wrapped
from arctrue.generated import number_formats

FLAG_NAMES = (
    "index_seen1",
    "index_seen2",
    "index_error1",
    "index_error2",
    "illegal1",
    "illegal2",
    "overspeed1",
    "overspeed2",
    "overrun",
    "full_before_turn",
)
"""Names of the flags in a header; bit i of the flags is ``FLAG_NAMES[i]``."""

OVERRUN = 1 << FLAG_NAMES.index("overrun")
FULL_BEFORE_TURN = 1 << FLAG_NAMES.index("full_before_turn")
_INDEX_SEEN = 0b11


@dataclass(frozen=True)
class SamplerInputs:
    """Inputs of the sampler; each is one value per clock, or one value for all clocks."""

    turn_position1: ArrayLike
    """Position of head 1 from its index, counts, signed, 32 bits."""
    turn_position2: ArrayLike
    """Position of head 2 from its index in the same clock."""
    counts_per_rev: ArrayLike
    """Counts per turn."""
    reset: ArrayLike = False
    enable: ArrayLike = True
    mode: ArrayLike = 0
    """Sampling mode: 0 equal time, 1 equal angle."""
    sample_period: ArrayLike = 100_000
    """Time between two samples at equal time, clocks."""
    angle_step: ArrayLike = 0
    """Angle between two samples at equal angle, counts."""
    timestamp: ArrayLike | None = None
    """Present time, clocks; None: the clocks count from 0."""
    flags: ArrayLike = _INDEX_SEEN
    """Flags of the decoders: the first eight of FLAG_NAMES."""
    zero_moved1: ArrayLike = 0
    """Level that toggles in the clock in which ``turn_position1`` counts from a new zero for the
    first time."""
    release_bank: ArrayLike = False


@dataclass(frozen=True)
class SampledBank:
    """One bank that the sampler handed to the processor."""

    clock: int
    """First clock in which the bank is READY."""
    bank: int
    start_time: int
    """Time stamp of the first sample, clocks."""
    sequence: int
    sample_clocks: NDArray[np.int64]
    """Clock of every sample, shape (samples,)."""
    samples: NDArray[np.int32]
    """Positions of head 1 and head 2, counts, shape (samples, 2)."""
    flags: int


@dataclass(frozen=True)
class SamplerTrace:
    """The captures, and every output in every clock, shape (clocks + 1,).

    Element t is the output during clock t; the last element follows the last input.
    """

    captures: list[SampledBank]
    capture_ready: NDArray[np.bool_]
    capture_overrun: NDArray[np.bool_]
    capture_busy: NDArray[np.bool_]
    bank_ready: NDArray[np.bool_]
    ready_bank: NDArray[np.int64]
    overrun_count: NDArray[np.int64]
    fill_count: NDArray[np.int64]
    trigger: NDArray[np.bool_]


class _Filling:
    """Registers of the sampler: the bank that is being filled, the owner of each bank, and the
    delay of one clock after the trigger."""

    def __init__(self, depth: int) -> None:
        self.depth = depth
        self.captures: list[SampledBank] = []
        self.restart()

    def restart(self) -> None:
        """Set the registers to their state after a reset."""
        self.filling_bank = self.ready_bank = self.handed_over = self.overrun_count = 0
        self.owned = self.overrun = False
        self.handing_over: SampledBank | None = None
        self.ready_pulse = self.overrun_pulse = False
        self.drop()

    def drop(self) -> None:
        """Discard the samples of the present turn."""
        self.rows: list[tuple[int, int, int]] = []
        self.flags = 0
        self.start_time = 0

    def advance(self, release: bool) -> None:
        """Advance by one clock."""
        self.ready_pulse = self.handing_over is not None
        self.owned = (self.owned and not release) or self.ready_pulse
        if self.handing_over:
            self.captures.append(self.handing_over)
            self.handing_over = None
        self.overrun_pulse = False

    def sample(
        self, clock: int, position1: int, position2: int, timestamp: int, counts_per_rev: int
    ) -> None:
        """Store the pair of samples of ``clock``, and hand over a finished bank."""
        if not self.rows:
            self.start_time = timestamp
            self.turn = (
                wrapped(position1 + counts_per_rev),
                wrapped(position1 - counts_per_rev),
            )
        # Like the entity, the model checks for the end of the turn from two clocks after the first
        # sample on. No table moves by a turn in one clock.
        closed = (
            bool(self.rows)
            and clock > self.rows[0][0] + 1
            and (wrapped(position1 - self.turn[0]) >= 0 or wrapped(self.turn[1] - position1) >= 0)
        )
        self.rows.append((clock, position1, position2))
        if not closed and len(self.rows) < self.depth:
            return
        if self.owned:
            self.overrun = self.overrun_pulse = True
            self.overrun_count = (self.overrun_count + 1) % 2**16
        else:
            rows = np.array(self.rows, dtype=np.int64)
            self.handing_over = SampledBank(
                clock=clock + 3,
                bank=self.filling_bank,
                start_time=self.start_time,
                sequence=self.handed_over % 2**32,
                sample_clocks=rows[:, 0],
                samples=rows[:, 1:].astype(np.int32),
                flags=self.flags | OVERRUN * self.overrun | FULL_BEFORE_TURN * (not closed),
            )
            self.overrun = False
            self.ready_bank = self.filling_bank
            self.filling_bank = 1 - self.filling_bank
            self.handed_over += 1
        self.drop()


def sampler(
    inputs: SamplerInputs, depth: int = number_formats.CAPTURE_DEPTH_DEFAULT
) -> SamplerTrace:
    """Run the sampler with banks of ``depth`` sample pairs over all clocks of ``inputs``.

    Raises ValueError if the shapes of the inputs do not fit.
    """
    names = [field.name for field in fields(inputs)]
    values = [np.atleast_1d(getattr(inputs, name)) for name in names if name != "timestamp"]
    clocks = np.broadcast_shapes(*(value.shape for value in values))[0]
    timestamps = np.arange(clocks) if inputs.timestamp is None else inputs.timestamp
    columns = {
        name: np.broadcast_to(
            timestamps if name == "timestamp" else getattr(inputs, name), (clocks,)
        ).tolist()
        for name in names
    }

    trigger = SampleTrigger()
    filling = _Filling(depth)
    triggered = running = False
    outputs = np.zeros((clocks + 1, 8), dtype=np.int64)
    for clock in range(clocks):
        now = {name: column[clock] for name, column in columns.items()}
        # A sample that was triggered in the previous clock is stored in this clock.
        if now["reset"]:
            filling.restart()
        else:
            filling.advance(bool(now["release_bank"]))
            if triggered or filling.rows:
                filling.flags |= columns["flags"][clock - 1]
            if triggered:
                filling.sample(
                    clock - 1,
                    columns["turn_position1"][clock - 1],
                    columns["turn_position2"][clock - 1],
                    columns["timestamp"][clock - 1],
                    now["counts_per_rev"],
                )
            if not running:
                filling.drop()
        running = bool(
            now["enable"] and now["flags"] & _INDEX_SEEN == _INDEX_SEEN and not now["reset"]
        )
        triggered = trigger.clock(
            running,
            now["mode"],
            now["sample_period"],
            now["angle_step"],
            now["turn_position1"],
            now["zero_moved1"],
        )
        outputs[clock + 1] = (
            filling.ready_pulse,
            filling.overrun_pulse,
            bool(filling.rows),
            filling.owned,
            filling.ready_bank,
            filling.overrun_count,
            len(filling.rows),
            triggered,
        )
    flags = [outputs[:, column].astype(bool) for column in (0, 1, 2, 3, 7)]
    return SamplerTrace(
        captures=filling.captures,
        capture_ready=flags[0],
        capture_overrun=flags[1],
        capture_busy=flags[2],
        bank_ready=flags[3],
        ready_bank=outputs[:, 4],
        overrun_count=outputs[:, 5],
        fill_count=outputs[:, 6],
        trigger=flags[4],
    )
