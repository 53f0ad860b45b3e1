"""Models the register map as a processor sees it, with tables written by hand from its description.

No value comes from the SystemRDL source or from files generated from that source.
"""

from __future__ import annotations

from dataclasses import dataclass, field

WORD = 0xFFFF_FFFF

CONSTANTS = {0x000: 0x41524354, 0x004: 0x000800}
"""Values of the constant registers by address."""

READ_WRITE = {
    0x010: (WORD, 0, None),
    0x020: (0x1F, 0, "control"),
    0x028: (WORD, 1 << 24, "counts_per_rev"),
    0x030: (0xFF, 1, "filter_length"),
    0x034: (0xFFFF, 0, "minimum_edge_spacing"),
    0x038: (WORD, 100_000, "sample_period"),
    0x03C: (0xFFFFFF, 1398, "angle_step"),
    0x040: (WORD, 652_835, "ramp_rate"),
    0x044: (0xFFFF, 10, "output_spacing"),
    0x048: (0xFFFF, 100, "following_limit"),
    0x050: (0xFFFF, 2, "index_tolerance"),
    0x054: (0x331, 0x20, "output_index"),
    0x058: (0x3, 0, "lost_counts"),
    0x05C: (WORD, 0, "processor_limit"),
    0x060: (WORD, 1_095_275, "ramp_acceleration"),
    0x064: (0xFF0F, 0, "head1_input_pins"),
    0x068: (0xFF0F, 0, "head2_input_pins"),
    0x06C: (0xF, 0, "output_pins"),
    0x070: (0xFFFF, 0x3F, "alarm"),
    0x074: (WORD, 100 << 16 | 100, "pulse_widths"),
    0x078: (0xFF03, 0x100, "pulse_inputs"),
    0x0A0: (0xFFFF, 0, None),
    0x180: (WORD, 0, "compare_first"),
    0x184: (0xFFFFFF, 0, "compare_interval"),
    0x1B8: (0x3, 1, "events_recorded"),
}
"""Registers that can be written, by address: existing bits, value after reset, and the port that
shows the value."""

COMMAND = 0x024
OFFSET = 0x04C
INTERRUPT_STATUS = 0x0A4
INTERRUPT_MASK = 0xFFFF

READ_ONLY = {
    0x008: (0x7FFF1F7F, "core_configuration"),
    0x00C: (WORD, "clock_hz"),
    0x014: (0xFF0F, "pipeline"),
    0x018: (WORD, "chip_dna_low"),
    0x01C: (0x81FF_FFFF, "chip_dna_high"),
    0x02C: (0x1FFFFFF, "counts_per_rev_active"),
    0x080: (0xFFFF_01FF, "status"),
    0x084: (0xFFFF, "swap_count"),
    0x088: (0xFFFF, "overrun_count"),
    0x08C: (0xFFFF, "capture_fill"),
    0x090: (0xFFFF, "zero"),
    0x094: (WORD, "zero_slip"),
    0x098: (WORD, "put_back"),
    0x0A8: (0x3FF, "capability"),
    0x0C0: (0x7F, "head1_flags"),
    0x0C4: (WORD, "head1_faults"),
    0x0C8: (0xFFFF, "head1_overspeeds"),
    0x0E0: (0x7F, "head2_flags"),
    0x0E4: (WORD, "head2_faults"),
    0x0E8: (0xFFFF, "head2_overspeeds"),
    0x148: (WORD, "capture_header_sequence_number"),
    0x14C: (0xFFFF, "capture_header_sample_count"),
    0x150: (0x3FFFF, "capture_header_flags"),
    0x1A0: (0xFFFF_7F03, "events_state"),
    0x1A4: (WORD, "events_time_low"),
    0x1A8: (WORD, "events_time_high"),
    0x1AC: (WORD, "events_position"),
    0x1B0: (0xFFFFFF, "events_angle"),
    0x1B4: (0xFFFF, "events_lost"),
}
"""Read-only registers by address: existing bits and the port that drives them."""

WIDE = {
    0x0D0: "head1_index",
    0x0F0: "head2_index",
    0x140: "capture_header_start_time",
}
"""Ports of 64 bits by the address of the low word; a read of the low word latches the high word."""

SNAPSHOT = {
    0x100: (WORD, "snapshot_time", 0),
    0x104: (WORD, "snapshot_time", 32),
    0x108: (WORD, "snapshot_head1_edge_time", 0),
    0x10C: (WORD, "snapshot_head1_edge_time", 32),
    0x110: (WORD, "snapshot_head2_edge_time", 0),
    0x114: (WORD, "snapshot_head2_edge_time", 32),
    0x118: (WORD, "snapshot_head1_position", 0),
    0x11C: (WORD, "snapshot_head2_position", 0),
    0x120: (WORD, "snapshot_head1_turn_position", 0),
    0x124: (WORD, "snapshot_head2_turn_position", 0),
    0x128: (0xFFFFFF, "snapshot_head1_angle", 0),
    0x12C: (0xFFFFFF, "snapshot_head2_angle", 0),
    0x130: (WORD, "snapshot_corrected_position", 0),
    0x134: (0xFFFFFF, "snapshot_corrected_angle", 0),
    0x138: (WORD, "snapshot_correction", 0),
    0x13C: (WORD, "snapshot_following_error", 0),
}
"""Words of the snapshot, by address: existing bits, port, and the port's bit that is bit 0 of the
word; a read of 0x100 latches them."""

PROBE = {
    0x160: (WORD, "probe_time", 0),
    0x164: (WORD, "probe_time", 32),
    0x168: (WORD, "probe_position", 0),
    0x16C: (0xFFFFFF, "probe_angle", 0),
    0x170: (0xFFFF, "probe_edges", 0),
}
"""Words of the probe, by address: existing bits, port, and the port's bit that is bit 0 of the
word; a read of 0x160 latches them."""

GROUPS = {0x100: SNAPSHOT, 0x160: PROBE}

COEFFICIENTS = 0x01000
COEFFICIENT_WORDS = 256
MEAN = 0x01800
CAPTURE = 0x20000
FURTHER_CAPTURE = 0x40000
HEADS = 0x02000
CONDITIONS = 0x02100
FURTHER_HEAD_READ = {*range(9), 10, 11}
"""Numbers of the words of head 3 or 4 that may be read; only word 0 may be written."""
DELAYS, HEADS_COMMAND, HEADS_STATUS = 32, 33, 34
"""Numbers of words in the window of the heads."""
FAILOVER = {35, 36, *range(40, 47)}
PARITY_VALUE = 44
"""Number of the word with the parity's value. The words in FAILOVER exist only in a core with
failover; words 40 to 43, the parity weights, exist only for heads that are built."""
LOCAL_PLACE = 0x01840
LOCAL_PLACE_WORDS = 7
LOCAL_POINTS = 0x10000
LOCAL_POINT_WORDS = 4096
TURN_STEPS = 0x01400
TURN_NUMBER = 0x01600
PREPARED_SETS = 0x08000
SET_BYTES = 0x1000
CAPTURE_WORDS = 32_768

CAPTURE_READY = 1 << 2
"""Bit of the register ``status`` that is high while a captured bank is ready."""


def driven_ports() -> dict[str, int]:
    """Return every port that drives read-only registers, with its width in bits."""
    ports = {port: 32 for _, port in READ_ONLY.values()}
    ports |= dict.fromkeys(WIDE.values(), 64)
    for _, port, low in (*SNAPSHOT.values(), *PROBE.values()):
        ports[port] = max(ports.get(port, 0), low + 32)
    return ports


@dataclass
class RegisterModel:
    """Answers reads and writes as the description of the map states. The answer to a read is a pair
    (accepted, word); the answer to a write is True if it is accepted."""

    lanes: int
    capture_depth: int
    inputs: dict[str, int]
    heads: int = 2
    has_mean: bool = False
    has_failover: bool = False
    has_local_table: bool = False
    has_real_orders: bool = False
    values: dict[int, int] = field(
        default_factory=lambda: {address: reset for address, (_, reset, _) in READ_WRITE.items()}
    )
    latched: dict[int, int] = field(default_factory=dict)
    coefficients: dict[int, int] = field(default_factory=dict)
    mean: dict[int, int] = field(default_factory=dict)
    of_heads: dict[int, int] = field(default_factory=dict)
    sets: dict[int, int] = field(default_factory=dict)
    local: dict[int, int] = field(default_factory=dict)
    turns: dict[int, int] = field(default_factory=dict)
    offset: int = 0
    interrupts: int = 0

    def read(self, address: int) -> tuple[bool, int]:
        """Return the answer to a read of the word that contains ``address``."""
        address &= ~3
        if address in CONSTANTS:
            return True, CONSTANTS[address]
        if address in self.values:
            return True, self.values[address]
        if address in READ_ONLY:
            mask, port = READ_ONLY[address]
            return True, self.inputs[port] & mask
        if address in WIDE:
            value = self.inputs[WIDE[address]]
            self.latched[address + 4] = value >> 32
            return True, value & WORD
        if address in GROUPS:
            for place, (mask, port, low) in GROUPS[address].items():
                self.latched[place] = self.inputs[port] >> low & mask
        if any(address in group for group in GROUPS.values()):
            return True, self.latched.get(address, 0)
        if address - 4 in WIDE:
            return True, self.latched.get(address, 0)
        if address == OFFSET:
            return True, self.offset
        if address == INTERRUPT_STATUS:
            return True, self.interrupts
        if self.coefficient_exists(address):
            return True, self.coefficients.get(address, 0)
        if self.mean_exists(address):
            return True, self.mean.get(address, 0)
        if address in self.heads_words(write=False):
            return True, self.of_heads.get(address, 0)
        if self.set_word_exists(address):
            return True, self.sets.get(address, 0)
        if self.local_word_exists(address):
            return True, self.local.get(address, 0)
        if self.turn_step_exists(address) or (self.has_real_orders and address == TURN_NUMBER):
            return True, self.turns.get(address, 0)
        word = (address & 0x1FFFF) // 4
        windows = (CAPTURE,) if self.heads == 2 else (CAPTURE, FURTHER_CAPTURE)
        if address & ~0x1FFFF in windows and word < 2 * self.capture_depth:
            if self.heads == 3 and address >= FURTHER_CAPTURE and word % 2:
                return False, 0
            if self.inputs["status"] & CAPTURE_READY:
                return True, (~word & 0xFFFF) << 16 | word
        return False, 0

    def coefficient_exists(self, address: int) -> bool:
        """Tell whether ``address`` is a coefficient word of a built lane."""
        return COEFFICIENTS <= address < COEFFICIENTS + 16 * self.lanes

    def heads_words(self, *, write: bool) -> set[int]:
        """Return the addresses in the window of the heads that may be read (or written, with
        ``write``)."""
        if not self.has_mean:
            return set()
        words = {DELAYS, *([HEADS_COMMAND] * (self.heads > 2) if write else [HEADS_STATUS])}
        for head in range(3, self.heads + 1):
            words |= {16 * (head - 3) + word for word in ({0} if write else FURTHER_HEAD_READ)}
        if self.has_failover:
            words |= FAILOVER - {40 + head for head in range(self.heads, 4)}
            words -= {PARITY_VALUE} if write else set()
        return {HEADS + 4 * word for word in words}

    def set_word_exists(self, address: int) -> bool:
        """Tell whether ``address`` is a word of a prepared set for lanes and heads that are
        built."""
        number, place = divmod(address - PREPARED_SETS, SET_BYTES)
        mean_word = (place - 0x800) // 4
        return (
            self.has_failover
            and 0 <= number <= self.heads
            and (
                place < 16 * self.lanes or mean_word == 15 or self.mean_exists(MEAN + 4 * mean_word)
            )
        )

    def local_word_exists(self, address: int) -> bool:
        """Tell whether ``address`` is a point of the local table or a word of the window
        ``local_place``."""
        place = 0 <= address - LOCAL_PLACE < 4 * LOCAL_PLACE_WORDS
        point = 0 <= address - LOCAL_POINTS < 4 * LOCAL_POINT_WORDS
        return self.has_local_table and (place or point)

    def turn_step_exists(self, address: int) -> bool:
        """Tell whether ``address`` is a word of the turn step of a lane that is built."""
        return self.has_real_orders and 0 <= address - TURN_STEPS < 8 * self.lanes

    def mean_exists(self, address: int) -> bool:
        """Tell whether ``address`` is a word of the mean for a built head, or the word that chooses
        carrier and heads."""
        word = (address - MEAN) // 4
        built = 0 <= word < 8 and word % 4 < self.heads
        return self.has_mean and (built or word == 8)

    def write(self, address: int, word: int, strobes: int) -> bool:
        """Write the bytes selected by ``strobes``; tell whether the write is accepted."""
        address &= ~3
        bits = sum(0xFF << (8 * byte) for byte in range(4) if strobes >> byte & 1)
        if address in READ_WRITE:
            mask = READ_WRITE[address][0]
            self.values[address] = (self.values[address] & ~bits | word & bits) & mask
            return True
        if address == COMMAND:
            return True
        if address == INTERRUPT_STATUS:
            self.interrupts &= ~(word & bits)
            return True
        if strobes != 0b1111:
            return False
        if address == OFFSET:
            self.offset = word
            return True
        if self.coefficient_exists(address):
            self.coefficients[address] = word
            return True
        if self.mean_exists(address):
            self.mean[address] = word
            return True
        if address in self.heads_words(write=True):
            self.of_heads[address] = word
            return True
        if self.set_word_exists(address):
            self.sets[address] = word
            return True
        if self.local_word_exists(address):
            self.local[address] = word
            return True
        if self.turn_step_exists(address):
            self.turns[address] = word
            return True
        return False
