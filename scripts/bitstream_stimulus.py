"""Lists bus accesses for the comparison of a bitstream with its VHDL; checks their coverage.

Random levels at the bus rarely form a legal access. Therefore this module lists accesses, most of
them legal and a few illegal. First, the accesses fill and read banks of the capture. Then each
round writes new settings; writes, reads and swaps every word of coefficients; and reads snapshots
and captured samples and gives commands in random order. Each round draws the counts per turn anew,
so that the angles after a backward pass through zero have other upper bits. From the answers,
``shortfalls`` lists the parts that the accesses did not reach.
"""

from __future__ import annotations

import random
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Final

from arctrue.generated import number_formats, registers
from scripts.bitstream_accesses import WORD, Access, Answer, Burst, Response

BASE: Final = 0x4000_0000
"""Base address of the core on the processor's bus, as in rtl/top/axi3_to_axi_lite.vhd."""
BUS_BEYOND: Final = 0x4004_0000
WORDS_A_LANE: Final = 4
SETTLED_CLOCKS: Final = 300
"""Number of clocks to wait after a re-arm, which takes 128 clocks (``command.rearm``)."""
CLOCKS_A_ROUND: Final = 20_000
"""Approximate number of clocks in a round; the number of rounds is the number of all clocks divided
by this number, rounded up."""
MIXED: Final = 220
"""Number of accesses of random kinds in a round."""
COUNTS_A_TURN: Final = 96
"""Counts per turn of the encoders of bench.cpp."""
FILLINGS: Final = 8
"""Number of times that a bank is filled; after so many fillings, positions of both signs have
reached every part of both banks."""
FEWEST_CORRECTIONS: Final = 50
"""Smallest number of different corrections that must be read; every lane contributes to some of
these."""
FEWEST_SAMPLES: Final = 100
"""Smallest number of captured words that must be read from each bank."""

SNAPSHOT: Final = range(
    registers.SNAPSHOT_TIME_ADDRESS, registers.SNAPSHOT_FOLLOWING_ERROR_ADDRESS + 4, 4
)
LAST_REGISTER: Final = registers.COMPARE_INTERVAL_ADDRESS
CAPTURING: Final = registers.CONTROL_CAPTURE_ENABLE_MASK
CORRECTING: Final = registers.CONTROL_COMPENSATE_MASK | registers.CONTROL_OUTPUT_ENABLE_MASK


@dataclass(frozen=True)
class Core:
    """Generics of the core under test."""

    lanes: int
    depth: int
    """Number of samples in a bank."""
    fold: int

    @property
    def coefficients(self) -> list[int]:
        """Return the addresses of all words of coefficients; the address of the offset is the
        last."""
        first = registers.COEFFICIENTS_ADDRESS
        words = range(first, first + 4 * WORDS_A_LANE * self.lanes, 4)
        return [*words, registers.COEFFICIENT_OFFSET_ADDRESS]


def questions() -> list[Access]:
    """Return accesses that read the generics of the core."""
    places = (registers.CORE_CONFIGURATION_ADDRESS, registers.PIPELINE_ADDRESS)
    return [Access("n", data=SETTLED_CLOCKS), *(Access("r", BASE + place) for place in places)]


def core_of(answers: Sequence[Answer]) -> Core:
    """Read the generics from the answers to ``questions``."""
    configuration, pipeline = (answer.data for answer in answers)

    def field(word: int, name: str) -> int:
        mask, shift = (getattr(registers, f"{name}_{part}") for part in ("MASK", "SHIFT"))
        return int((word & mask) >> shift)

    return Core(
        lanes=field(configuration, "CORE_CONFIGURATION_LANES"),
        depth=field(configuration, "CORE_CONFIGURATION_CAPTURE_DEPTH"),
        fold=field(pipeline, "PIPELINE_FOLD"),
    )


def stored(address: int, value: int) -> int:
    """Return the value that the register map states for a coefficient word after a write of
    ``value``."""
    word = (address - registers.COEFFICIENTS_ADDRESS) // 4 % WORDS_A_LANE
    if address == registers.COEFFICIENT_OFFSET_ADDRESS or word == 3:
        sign = 1 << (number_formats.AMPLITUDE_WIDTH - 1)
        return (((value & (2 * sign - 1)) ^ sign) - sign) & WORD
    bits = (32, number_formats.PHASE_STEP_WIDTH - 32, number_formats.PHASE_WIDTH)[word]
    return value & ((1 << bits) - 1)


class Stimulus:
    """Makes the rounds of accesses; the same seed always gives the same rounds."""

    def __init__(self, core: Core, seed: int) -> None:
        """Store the generics of the core; ``seed`` starts the random numbers."""
        self.core = core
        self._random = random.Random(seed)

    def accesses(self, rounds: int) -> list[Access]:
        """Return the accesses that fill and read whole banks, followed by the accesses of
        ``rounds`` rounds."""
        made = list(self._full_banks())
        for place in range(rounds):
            made += self._settings()
            # Only every second round has large corrections, because the output can follow only
            # small corrections.
            made += self._all_coefficients(number_formats.AMPLITUDE_WIDTH if place % 2 else 13)
            for _ in range(MIXED):
                made += self._mixed()
            if self._one_in(2):
                made.append(Access("z", data=20 + self._random.randrange(100)))
                made.append(Access("n", data=SETTLED_CLOCKS))
        return made

    def _one_in(self, count: int) -> bool:
        return self._random.randrange(count) == 0

    def _of_any_size(self, bits: int) -> int:
        """Draw a number of at most ``bits`` bits; every number of bits is equally likely."""
        return self._random.getrandbits(self._random.randint(1, bits))

    def _amplitude(self, bits: int) -> int:
        value = self._of_any_size(bits - 1)
        return (-value if self._one_in(2) else value) & WORD

    def _write(self, address: int, value: int) -> Access:
        return Access("w", BASE + address, value & WORD)

    def _read(self, address: int, beats: int = 1) -> Access:
        return Access("r", BASE + address, beats=beats, together=self._one_in(2))

    def _full_banks(self) -> Iterator[Access]:
        """Yield accesses that fill the banks several times, one sample per clock, and read random
        words of each filled bank."""
        yield self._write(registers.COUNTS_PER_REV_ADDRESS, 1 << 24)
        yield self._write(registers.FILTER_LENGTH_ADDRESS, 2)
        yield self._write(registers.SAMPLE_PERIOD_ADDRESS, 1)
        yield self._write(registers.COMMAND_ADDRESS, registers.COMMAND_REARM_MASK)
        yield self._write(registers.CONTROL_ADDRESS, CAPTURING)
        # Before the first bank, the core also waits for the index of both heads.
        yield Access("n", data=80 * COUNTS_A_TURN)
        for _ in range(FILLINGS):
            yield Access("n", data=self.core.depth)
            for _ in range(3 * FEWEST_SAMPLES):
                yield self._read(self._captured())
            yield from self._release()

    def _captured(self) -> int:
        return registers.CAPTURE_ADDRESS + 4 * self._random.randrange(2 * self.core.depth)

    def _release(self) -> Iterator[Access]:
        yield Access("r", BASE + registers.CAPTURE_HEADER_SEQUENCE_NUMBER_ADDRESS)
        yield self._write(registers.COMMAND_ADDRESS, registers.COMMAND_CAPTURE_RELEASE_MASK)

    def _turn(self) -> int:
        if self._one_in(3):
            return COUNTS_A_TURN
        return max(4, self._of_any_size(24))

    def _setting(self) -> dict[int, int]:
        """Return, for every setting, a random value with which the core still counts correctly."""
        draw = self._random
        pins = [draw.getrandbits(4) if self._one_in(2) else 0 for _ in range(3)]
        filters = [self._random.randrange(8) << 8 if self._one_in(3) else 0 for _ in range(2)]
        mode = draw.choice((0, 0, 1, 2)) << registers.CONTROL_CAPTURE_MODE_SHIFT
        return {
            registers.SCRATCH_ADDRESS: draw.getrandbits(32),
            registers.COUNTS_PER_REV_ADDRESS: self._turn(),
            registers.FILTER_LENGTH_ADDRESS: draw.randrange(9),
            registers.MINIMUM_EDGE_SPACING_ADDRESS: draw.choice((0, 8, 14, 20)),
            registers.SAMPLE_PERIOD_ADDRESS: draw.choice((1, 2, 3, draw.randint(1, 60))),
            registers.ANGLE_STEP_ADDRESS: draw.randint(1, 20),
            registers.RAMP_RATE_ADDRESS: self._of_any_size(32),
            registers.OUTPUT_SPACING_ADDRESS: draw.randrange(12),
            registers.FOLLOWING_LIMIT_ADDRESS: draw.choice((3, 100, 0xFFFF)),
            registers.INDEX_TOLERANCE_ADDRESS: draw.randrange(5),
            registers.OUTPUT_INDEX_ADDRESS: draw.getrandbits(10),
            registers.LOST_COUNTS_ADDRESS: draw.getrandbits(2),
            registers.PROCESSOR_LIMIT_ADDRESS: draw.choice((0, 300, 5000)),
            registers.RAMP_ACCELERATION_ADDRESS: draw.choice((0, self._of_any_size(32))),
            registers.HEAD1_INPUT_PINS_ADDRESS: pins[0] | filters[0],
            registers.HEAD2_INPUT_PINS_ADDRESS: pins[1] | filters[1],
            registers.OUTPUT_PINS_ADDRESS: pins[2],
            registers.ALARM_ADDRESS: draw.getrandbits(13),
            registers.PULSE_WIDTHS_ADDRESS: draw.randrange(60) << 16 | draw.randrange(60),
            registers.PULSE_INPUTS_ADDRESS: draw.randrange(12) << 8 | draw.getrandbits(2),
            registers.INTERRUPT_ENABLE_ADDRESS: draw.getrandbits(11),
            registers.COMPARE_FIRST_ADDRESS: draw.randint(-60, 60) & WORD,
            registers.COMPARE_INTERVAL_ADDRESS: draw.randrange(30),
            registers.CONTROL_ADDRESS: mode | CAPTURING | CORRECTING,
        }

    def _settings(self) -> Iterator[Access]:
        for address, value in self._setting().items():
            yield self._write(address, value)
        command = registers.COMMAND_REARM_MASK | registers.COMMAND_COMPARE_ARM_MASK
        command |= registers.COMMAND_CLEAR_HEAD1_MASK | registers.COMMAND_CLEAR_HEAD2_MASK
        yield self._write(registers.COMMAND_ADDRESS, command | registers.COMMAND_CLEAR_OUTPUT_MASK)
        yield Access("n", data=SETTLED_CLOCKS)

    def _coefficient(self, address: int, bits: int) -> int:
        word = (address - registers.COEFFICIENTS_ADDRESS) // 4 % WORDS_A_LANE
        is_amplitude = address == registers.COEFFICIENT_OFFSET_ADDRESS or word == 3
        return self._amplitude(bits) if is_amplitude else self._random.getrandbits(32)

    def _all_coefficients(self, bits: int) -> Iterator[Access]:
        """Yield accesses that write all coefficients in random order (some lanes in one burst),
        read them in another order, and swap the banks."""
        addresses = self.core.coefficients
        for address in self._random.sample(addresses, len(addresses)):
            if address % 16 == 0 and self._one_in(3):
                data = self._random.getrandbits(32)
                yield Access("w", BASE + address, data, beats=WORDS_A_LANE)
        for address in self._random.sample(addresses, len(addresses)):
            yield self._write(address, self._coefficient(address, bits))
        yield from self._coefficients_read()
        yield self._write(registers.COMMAND_ADDRESS, registers.COMMAND_SWAP_MASK)

    def _coefficients_read(self) -> Iterator[Access]:
        addresses = self.core.coefficients
        for address in self._random.sample(addresses, len(addresses)):
            yield Access("r", BASE + address)

    def _mixed(self) -> Iterator[Access]:
        steps = (
            (self._snapshot, 34),
            (self._registers, 16),
            (self._samples, 14),
            (self._command, 12),
            (self._word, 12),
            (self._one_setting, 6),
            (self._odd, 6),
        )
        (step,) = self._random.choices([one for one, _ in steps], [weight for _, weight in steps])
        yield from step()

    def _snapshot(self) -> Iterator[Access]:
        yield Access("r", BASE + registers.SNAPSHOT_TIME_ADDRESS)
        yield self._read(registers.SNAPSHOT_CORRECTION_ADDRESS)
        for _ in range(self._random.randrange(4)):
            yield self._read(self._random.choice(SNAPSHOT))
        if self._one_in(8):
            yield self._read(SNAPSHOT[0], len(SNAPSHOT))

    def _registers(self) -> Iterator[Access]:
        yield self._read(4 * self._random.randrange(LAST_REGISTER // 4 + 2))

    def _samples(self) -> Iterator[Access]:
        for _ in range(4):
            yield self._read(self._captured())
        if self._one_in(2):
            yield self._read(registers.CAPTURE_ADDRESS, beats=self._random.randint(2, 16))
        if self._one_in(4):
            yield from self._release()

    def _command(self) -> Iterator[Access]:
        bit = self._random.choice(
            (
                registers.COMMAND_SWAP_MASK,
                registers.COMMAND_SWAP_MASK,
                registers.COMMAND_CLEAR_HEAD1_MASK,
                registers.COMMAND_CLEAR_HEAD2_MASK,
                registers.COMMAND_CLEAR_OUTPUT_MASK,
                registers.COMMAND_ALIVE_MASK,
                registers.COMMAND_COMPARE_ARM_MASK,
                registers.COMMAND_COMPARE_DISARM_MASK,
            )
        )
        yield self._write(registers.COMMAND_ADDRESS, bit)
        yield self._write(registers.INTERRUPT_STATUS_ADDRESS, self._random.getrandbits(11))
        if self._one_in(12):
            yield self._write(registers.COUNTS_PER_REV_ADDRESS, self._turn())
            yield self._write(registers.COMMAND_ADDRESS, registers.COMMAND_REARM_MASK)

    def _word(self) -> Iterator[Access]:
        address = self._random.choice(self.core.coefficients)
        bits = self._random.choice((13, number_formats.AMPLITUDE_WIDTH))
        yield self._write(address, self._coefficient(address, bits))
        yield Access("r", BASE + address)
        if self._one_in(2):
            yield self._write(registers.COMMAND_ADDRESS, registers.COMMAND_SWAP_MASK)

    def _one_setting(self) -> Iterator[Access]:
        address, value = self._random.choice(list(self._setting().items()))
        yield self._write(address, value)

    def _odd(self) -> Iterator[Access]:
        """Yield accesses that the bridge or the core refuses, and bursts of other kinds and
        sizes."""
        draw = self._random
        anywhere = BASE + 4 * draw.randrange(1 << 16)
        scratch = BASE + registers.SCRATCH_ADDRESS
        word = BASE + draw.choice(self.core.coefficients)
        burst, size = Burst(draw.randrange(4)), draw.randrange(4)
        beats = draw.choice((1, 2, 4, 8, 16, draw.randint(1, 16)))
        data, strobe = draw.getrandbits(32), draw.randrange(15)
        yield draw.choice(
            (
                Access("r", anywhere, beats=beats, burst=burst, size=size),
                Access("r", anywhere),
                Access("r", draw.choice((BUS_BEYOND, BASE - 4, draw.getrandbits(32) & ~3))),
                Access("w", draw.choice((BUS_BEYOND, BASE - 4)), data),
                Access("w", BASE + registers.IDENTIFICATION_ADDRESS, data),
                Access("w", BASE + self._captured(), data),
                Access("w", word, data, strobe=strobe),
                Access("w", scratch, data, strobe=strobe),
                Access("w", scratch, data, beats=beats, burst=Burst.FIXED, last=draw.randrange(16)),
                Access("w", scratch, data, burst=burst, size=size),
            )
        )


def accesses_of(core: Core, clocks: int, seed: int) -> list[Access]:
    """Return accesses that take about this number of clocks."""
    return Stimulus(core, seed).accesses(-(-clocks // CLOCKS_A_ROUND))


def shortfalls(core: Core, accesses: Sequence[Access], answers: Sequence[Answer]) -> list[str]:
    """Return a sentence for each part of the core that the accesses did not reach, and for each
    answer that contradicts the register map."""
    asked = {BASE + address: address for address in core.coefficients}
    held = dict.fromkeys(core.coefficients, 0)
    written: set[int] = set()
    read: set[int] = set()
    faults = []
    corrections: set[int] = set()
    samples = [0, 0]
    waiting = 0
    beats: dict[int, int] = {}
    for answer in answers:
        access = accesses[answer.place]
        place = beats[answer.place] = beats.get(answer.place, -1) + 1
        is_full = access.burst is Burst.INCREASING and access.size == 2
        if answer.response is not Response.OKAY or not is_full:
            continue
        if access.kind == "w" and access.strobe == 0xF:
            for beat in range(access.beats):
                address = asked.get(access.address + 4 * beat)
                if address is not None:
                    held[address] = stored(address, access.beat(beat))
                    written.add(address)
        if access.kind != "r":
            continue
        where = access.address + 4 * place
        if where in asked:
            address = asked[where]
            if answer.data != held[address]:
                faults.append(
                    f"coefficient word 0x{address:05x} read 0x{answer.data:08x}, "
                    f"expected 0x{held[address]:08x}"
                )
            if address in written:
                read.add(address)
        elif where == BASE + registers.SNAPSHOT_CORRECTION_ADDRESS:
            corrections.add(answer.data)
        elif where >= BASE + registers.CAPTURE_ADDRESS:
            waiting += 1
        elif where == BASE + registers.CAPTURE_HEADER_SEQUENCE_NUMBER_ADDRESS and place == 0:
            # From a reset on, the two banks alternate.
            samples[answer.data % 2] += waiting
            waiting = 0
    lacking = [address for address in core.coefficients if address not in written & read]
    if lacking:
        faults.append(
            f"{len(lacking)} words of coefficients were not written and read, the first at "
            f"0x{lacking[0]:05x}"
        )
    if len(corrections) < FEWEST_CORRECTIONS:
        faults.append(
            f"the correction was read with {len(corrections)} values, expected "
            f"{FEWEST_CORRECTIONS} or more"
        )
    faults += [
        f"{count} captured words were read from bank {bank}, expected {FEWEST_SAMPLES} or more"
        for bank, count in enumerate(samples)
        if count < FEWEST_SAMPLES
    ]
    return faults
