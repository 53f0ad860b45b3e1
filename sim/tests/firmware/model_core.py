"""Models the core's registers as the firmware reads them, and runs the firmware on this model."""

from __future__ import annotations

import json
from collections import deque
from typing import Any

import numpy as np
from numpy.typing import NDArray
from sim.tests.firmware.calibrator import BOTH_INDICES_SEEN
from sim.tests.firmware.library import firmware

from arctrue.gateware.register_access import register_named

COEFFICIENTS = 0x1000
INDEX_SEEN = 1
FAULTS = (
    "head1",
    "head2",
    "cannot_keep_up",
    "correction_limited",
    "processor_silent",
    "swallowed",
)
"""Names of the bits of the register ``alarm``, from the lowest one."""


def address(path: str) -> int:
    return register_named(path).address


def field_shift(path: str, field: str) -> int:
    (found,) = [f for f in register_named(path).fields if f.name == field]
    return found.shift


def bit(path: str, field: str) -> int:
    return 1 << field_shift(path, field)


class ModelCore:
    """The parts of the core that the tests need: identity, commands, one bank, the coefficient
    window."""

    def __init__(self, lanes: int = 32, depth: int = 12288) -> None:
        self.words: dict[int, int] = {}
        self.writes: list[tuple[int, int]] = []
        self.idle: dict[int, int] = {}
        self.active: dict[int, int] = {}
        self.bank: NDArray[np.int32] = np.zeros((0, 2), dtype=np.int32)
        self.broken_lane: int | None = None
        self.broken_word: int | None = None
        """Address of a register whose lowest bit reads inverted."""
        self.swaps_are_lost = False
        self.armed: list[tuple[int, int]] = []
        self.lasting_faults: set[str] = set()
        """Faults of ``FAULTS`` that no command can end."""
        self.release_causes = 0
        self.events: deque[tuple[int, int, int, int, int]] | None = None
        """Waiting events, each as (number, kind, time, position, angle); None for a core without
        EVENTS."""
        self.set("identification", 0x41524354)
        self.set("version", 0x000100)
        self.set("core_configuration", lanes | 18 << 8 | depth << 16)
        self.set("clock_hz", 100_000_000)
        self.set("counts_per_rev", 1 << 24)
        ffi, _library = firmware()
        self._read = ffi.callback("core_read_word", self.read)
        self._write = ffi.callback("core_write_word", self.write)
        self._capture = ffi.callback("core_capture_words", self.capture)
        self.access = ffi.new("struct core_access *", [self._read, self._write, self._capture])

    def set(self, path: str, word: int) -> None:
        self.words[address(path)] = word & 0xFFFF_FFFF

    def get(self, path: str) -> int:
        return self.words.get(address(path), 0)

    def read(self, _: Any, offset: int) -> int:
        if COEFFICIENTS <= offset < COEFFICIENTS + 1024:
            if self.broken_lane == (offset - COEFFICIENTS) // 16:
                return 0xDEAD
            return self.idle.get(offset, 0)
        if offset == address("events.state") and self.events is not None:
            self.show_event()
        if offset == address("status"):
            on = self.get("control") & bit("control", "compensate")
            applied = bool(on and self.get("head1.flags") & INDEX_SEEN)
            releasing = self.releasing_faults()
            return (
                self.get("status")
                | applied * bit("status", "compensating")
                | bool(self.release_causes) * bit("status", "released")
                | self.release_causes << field_shift("status", "release_causes")
                | releasing << field_shift("status", "release_present")
            )
        return self.words.get(offset, 0) ^ (offset == self.broken_word)

    def write(self, _: Any, offset: int, word: int) -> None:
        self.writes.append((offset, word))
        if offset == address("command"):
            self.command(word)
        elif COEFFICIENTS <= offset < COEFFICIENTS + 1024:
            self.idle[offset] = word
        else:
            self.words[offset] = word

    def command(self, word: int) -> None:
        if word & bit("command", "swap") and not self.swaps_are_lost:
            self.active = dict(self.idle)
            self.set("swap_count", self.get("swap_count") + 1)
        if word & bit("command", "capture_release"):
            self.set("status", self.get("status") & ~bit("status", "capture_ready"))
        for head in ("head1", "head2"):
            if word & bit("command", f"clear_{head}"):
                self.set(f"{head}.flags", self.get(f"{head}.flags") & INDEX_SEEN)
        if word & bit("command", "clear_output"):
            self.set("status", self.get("status") & ~bit("status", "cannot_keep_up"))
            self.release_causes = self.releasing_faults()
        if word & bit("command", "compare_arm"):
            self.armed.append((self.get("compare.first"), self.get("compare.interval")))
            self.set("status", self.get("status") | bit("status", "compare_armed"))
        if word & bit("command", "compare_disarm"):
            self.set("status", self.get("status") & ~bit("status", "compare_armed"))
        if word & bit("command", "next_event") and self.events:
            self.events.popleft()
            self.show_event()
        if word & bit("command", "rearm"):
            self.set("counts_per_rev_active", self.get("counts_per_rev"))

    def releasing_faults(self) -> int:
        """Return the bits of the present faults that disable the line drivers, and latch these bits
        as causes."""
        present = {name for name in ("head1", "head2") if self.get(f"{name}.flags") & 0b1110}
        if self.get("head1.flags") & bit("head1.flags", "swallowed"):
            present.add("swallowed")
        present |= self.lasting_faults
        if self.get("status") & bit("status", "cannot_keep_up"):
            present.add("cannot_keep_up")
        bits = sum(1 << place for place, name in enumerate(FAULTS) if name in present)
        bits &= self.get("alarm") >> field_shift("alarm", "released_by")
        self.release_causes |= bits
        return bits

    def capture(self, _: Any, number: int) -> Any:
        ffi, _library = firmware()
        assert self.get("status") & bit("status", "capture_ready"), "no bank is ready"
        assert number <= self.bank.size
        return ffi.cast("int32_t *", self.bank.ctypes.data)

    def build_events(self) -> None:
        """Make the model that of a core that was built with EVENTS; its event queue is empty."""
        self.events = deque()
        self.set("version", 0x000800)
        self.set("capability", 2 | bit("capability", "events"))

    def show_event(self) -> None:
        """Show the oldest event in the event registers."""
        assert self.events is not None
        number, kind, time, position, angle = self.events[0] if self.events else (0,) * 5
        self.set("events.state", number << 16 | len(self.events) << 8 | kind)
        self.set("events.time_low", time)
        self.set("events.time_high", time >> 32)
        self.set("events.position", position)
        self.set("events.angle", angle)

    def see_index(self) -> None:
        for head in ("head1", "head2"):
            self.set(f"{head}.flags", bit(f"{head}.flags", "index_seen"))

    def head1_slips(self, slip: int, travel: int = 1000) -> None:
        """Set the registers so that the angle of head 1 was ``slip`` at the last index of head
        1."""
        position = self.get("snapshot.head1_position")
        self.set("head1.index", position - travel)
        self.set("snapshot.head1_angle", (slip + travel) % self.get("counts_per_rev_active"))

    def moves_zero(self, slip: int) -> None:
        """Move the zero, as the core does when a mark proves that head 1 lost ``-slip`` counts."""
        self.set("zero", self.get("zero") + 1)
        self.set("zero_slip", slip)
        self.set("head1.flags", self.get("head1.flags") | 0b10)
        self.head1_slips(0)

    def head2_slips(self, slip: int, travel: int = 1000) -> None:
        """Set the registers so that the angle of head 2 was ``slip`` at the last index of head
        2."""
        index = 123_456_789
        self.set("head2.index", index)
        self.set("snapshot.head2_position", index + travel)
        angle = (slip + travel) % self.get("counts_per_rev_active")
        self.set("snapshot.head2_angle", angle)

    def stand_at(self, position: int, angle: int) -> None:
        """Set the corrected position and angle, and the position of head 1."""
        for head in ("head1", "corrected"):
            self.set(f"snapshot.{head}_position", position)
        self.set("snapshot.corrected_angle", angle)

    def hand_over(
        self, counts: NDArray[np.integer], flags: int = BOTH_INDICES_SEEN, travel: int = 0
    ) -> None:
        """Hand over a bank with counts (2, n). Head 1 has moved on by ``travel`` counts since the
        last sample when the firmware reads the registers."""
        words = counts.T.astype(np.int64).astype(np.uint32).view(np.int32)
        self.bank = np.ascontiguousarray(words)
        self.set("capture_header.sample_count", counts.shape[1])
        self.set("capture_header.flags", flags)
        number = self.get("capture_header.sequence_number") + 1
        self.set("capture_header.sequence_number", number)
        position = int(counts[0, -1]) + travel if counts.shape[1] else 0
        self.set("snapshot.head1_turn_position", position)
        self.set("snapshot.head1_position", position)
        self.set("snapshot.head1_angle", position % self.get("counts_per_rev_active"))
        self.set("status", self.get("status") | bit("status", "capture_ready"))


class Firmware:
    """Application and console that run on a core; ``said`` is the output of the console."""

    def __init__(self, core: Any) -> None:
        ffi, library = firmware()
        self.core = core
        self.library = library
        self.said = bytearray()
        self._put = ffi.callback("text_put", self._take)
        self.sink = ffi.new("struct text_sink *", [self._put, ffi.NULL])
        self.sensor: Any = None
        self.application = ffi.new("struct application *")
        self.console = ffi.new("struct console *")
        library.application_prepare(self.application, core.access)
        self.copy = ffi.new("struct capture_copy *")
        library.application_use_copy(self.application, self.copy)
        self.axis = ffi.new("struct axis_mean *")
        library.application_use_axis(self.application, self.axis)
        library.console_prepare(self.console, self.application, self.sink)

    def _take(self, _: Any, characters: Any, number: int) -> None:
        self.said += firmware()[0].buffer(characters, number)[:]

    def send(self, line: str | bytes) -> str:
        """Type a line and return the output that follows immediately."""
        self.said.clear()
        data = line if isinstance(line, bytes) else line.encode() + b"\r"
        for character in data:
            self.library.console_receive(self.console, character)
        return self.said.decode()

    def parameters(self) -> dict[str, str]:
        """Return the values that ``show parameters`` prints, by name."""
        return dict(line.split() for line in self.send("show parameters").splitlines()[:-1])

    def status(self, name: str) -> list[str]:
        """Return the lines of ``status`` that begin with a name, without the name."""
        lines = self.send("status").splitlines()
        return [line.split(" ", 1)[1] for line in lines if line.startswith(f"{name} ")]

    def step(self, times: int = 1) -> str:
        """Run the main loop this number of times and return the output of the firmware."""
        self.said.clear()
        for _ in range(times):
            self.library.application_step(self.application)
            self.library.console_step(self.console)
        return self.said.decode()

    @property
    def phase(self) -> str:
        name = self.library.application_phase_name(self.application.phase)
        return str(firmware()[0].string(name).decode())

    def turn(self, counts: NDArray[np.integer], flags: int = BOTH_INDICES_SEEN) -> dict[str, Any]:
        """Hand over a turn, let the firmware process it, and return the telemetry."""
        self.core.hand_over(counts, flags)
        self.send("telemetry on")
        telemetry: dict[str, Any] = json.loads(self.step(4))
        return telemetry
