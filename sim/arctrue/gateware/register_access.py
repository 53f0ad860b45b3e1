"""Accesses the registers of the core by name, over any bus that reads and writes words.

The testbenches use an AXI4-Lite master in the simulator; a host uses the bus that it has. Addresses
and fields come from the generated description of the register map.
"""

from __future__ import annotations

import math
from collections.abc import Awaitable, Callable, Sequence
from dataclasses import dataclass
from typing import Final, Protocol

import numpy as np
from numpy.typing import NDArray

from arctrue.gateware.extension import Conditions
from arctrue.gateware.local_table import LocalTable
from arctrue.gateware.mean_set import MeanSet
from arctrue.gateware.register_types import Register
from arctrue.gateware.table_conditions import condition_registers
from arctrue.generated import registers
from arctrue.generated.number_formats import CLOCK_HZ, CORRECTION_FRACTION, HEADS_MAX

ReadWords = Callable[[int, int], Awaitable[Sequence[int]]]
"""Type of ``await read_words(address, count)``, which returns ``count`` words of 32 bits from the
byte address on."""

WriteWords = Callable[[int, Sequence[int]], Awaitable[None]]
"""Type of ``await write_words(address, words)``. This function and ``read_words`` raise an
exception if the bus responds with an error."""

IDENTIFICATION: Final = 0x41524354

SET_BYTES: Final = 0x1000
"""Size of the window of one prepared set; the window has the layout of the register map from 0x1000
on."""
SET_MEAN: Final = 0x800
SET_OFFSET: Final = 0x83C

_BY_PATH: Final = {register.path: register for register in registers.REGISTERS}
_WORD: Final = 0xFFFF_FFFF


class CoefficientSet(Protocol):
    """Coefficients that :meth:`RegisterMap.write_coefficients` writes, one per lane."""

    @property
    def phase_steps(self) -> NDArray[np.uint64]:
        """Phase steps, (lanes,), u0.48 turn per count."""

    @property
    def phase_offsets(self) -> NDArray[np.uint32]:
        """Phase offsets, (lanes,), u0.24 turn."""

    @property
    def amplitudes(self) -> NDArray[np.int32]:
        """Amplitudes, (lanes,), 2^-11 count."""

    @property
    def offset(self) -> int:
        """Offset, 2^-11 count."""

    @property
    def modulator_numbers(self) -> NDArray[np.int64]:
        """Numbers of the amplitudes' modulators, (lanes,); 0: no modulator."""

    @property
    def turn_steps(self) -> NDArray[np.uint64]:
        """Turn steps, (lanes,), u0.48 turn per turn; 0 for integer orders."""


@dataclass(frozen=True, slots=True)
class Snapshot:
    """State of the core in one clock. Times are in clocks, the correction is in 2^-11 count, all
    other values are in counts."""

    time: int
    head1_edge_time: int
    head2_edge_time: int
    head1_position: int
    head2_position: int
    head1_turn_position: int
    head2_turn_position: int
    head1_angle: int
    head2_angle: int
    corrected_position: int
    corrected_angle: int
    correction: int
    following_error: int

    @property
    def exact_position_counts(self) -> float:
        """Corrected position before its rounding to whole counts, with a resolution of 2⁻¹¹ count.

        The gateware subtracts the correction rounded to whole counts, floor(correction + ½).
        """
        counts = self.correction / 2**CORRECTION_FRACTION
        return self.corrected_position + math.floor(counts + 0.5) - counts


@dataclass(frozen=True, slots=True)
class CaptureBank:
    """A capture bank: ``samples`` (n, heads) are positions of the heads from their index, counts,
    int32."""

    start_time: int
    sequence_number: int
    flags: dict[str, bool]
    samples: NDArray[np.int32]


def register_named(path: str) -> Register:
    """Return the register ``path``, for example ``head1.flags``. Raises KeyError, which lists
    similar names."""
    if path in _BY_PATH:
        return _BY_PATH[path]
    parts = path.split(".")
    near = [known for known in _BY_PATH if any(part in known for part in parts)]
    raise KeyError(f"no register {path!r}; there are: {', '.join(near or sorted(_BY_PATH))}")


class RegisterMap:
    """Accesses registers by name, through two callables that transfer 32-bit words.

    If the core refuses an address, the callable raises its exception.
    """

    def __init__(self, read_words: ReadWords, write_words: WriteWords, *, base: int = 0) -> None:
        """Store the callables and ``base``, the byte address of the core on the bus."""
        self._read_words = read_words
        self._write_words = write_words
        self._base = base
        self._has_turn_steps = False

    async def read_raw(self, path: str) -> int:
        """Read a whole register. Of a 64-bit register the low word is read first, so that both
        words are from the same clock."""
        register = register_named(path)
        value = 0
        for word in range(register.words):
            read = await self._read_words(self._base + register.address + 4 * word, 1)
            value |= read[0] << (32 * word)
        return value

    async def read_fields(self, path: str) -> dict[str, int]:
        """Read every field of a register; a signed field gives a signed number."""
        word = await self.read_raw(path)
        return {field.name: field.get(word) for field in register_named(path).fields}

    async def read(self, path: str) -> int:
        """Read one value: a register with a single field, or ``register.field``."""
        if path in _BY_PATH:
            values = await self.read_fields(path)
            if len(values) != 1:
                raise KeyError(f"{path} has several fields, name one: {', '.join(values)}")
            return next(iter(values.values()))
        register, _, field = path.rpartition(".")
        # The error names the whole path if the register does not exist.
        known = register_named(register if register in _BY_PATH else path)
        return known.field(field).get(await self.read_raw(register))

    async def write_raw(self, path: str, value: int) -> None:
        """Write a whole 32-bit register."""
        address = self._base + register_named(path).address
        await self._write_words(address, [value & _WORD])

    async def write(self, path: str, value: int) -> None:
        """Write the only field of a register. Raises ValueError for a value that does not fit the
        field."""
        register = register_named(path)
        if len(register.fields) != 1:
            names = ", ".join(field.name for field in register.fields)
            raise KeyError(f"{path} has several fields, use update(): {names}")
        await self.write_raw(path, register.fields[0].put(value))

    async def update(self, path: str, **values: int) -> None:
        """Change the named fields of a register and keep all others (read, modify, write)."""
        register = register_named(path)
        word = await self.read_raw(path)
        for name, value in values.items():
            field = register.field(name)
            word = (word & ~field.mask) | field.put(value)
        await self.write_raw(path, word)

    async def command(self, *names: str) -> None:
        """Set each named bit of ``command`` for one clock, all in the same clock."""
        register = register_named("command")
        await self.write_raw("command", sum(register.field(name).mask for name in set(names)))

    async def clear_interrupts(self, *names: str) -> None:
        """Clear the named bits of ``interrupt_status``; without names, clear all bits."""
        register = register_named("interrupt_status")
        masks = [field.mask for field in register.fields if not names or field.name in names]
        await self.write_raw("interrupt_status", sum(masks))

    async def check_identity(self) -> dict[str, int]:
        """Read the fields of ``core_configuration``. Raises ValueError if the bus does not reach an
        ArcTrue core."""
        found = await self.read("identification")
        if found != IDENTIFICATION:
            raise ValueError(
                f"identification: expected 0x{IDENTIFICATION:08X} (ARCT), found 0x{found:08X}: "
                f"no ArcTrue core at 0x{self._base:08X}"
            )
        return await self.read_fields("core_configuration")

    async def snapshot(self) -> Snapshot:
        """Read the positions of both heads and of the corrected output in one clock."""
        values = {}
        for register in registers.REGISTERS:
            group, _, name = register.path.partition(".")
            if group == "snapshot":  # in address order: reading time latches all other values
                values[name] = await self.read(register.path)
        return Snapshot(**values)

    async def read_capture(self, heads: int = 2) -> CaptureBank:
        """Read the capture bank that is ready, from a core with ``heads`` heads.

        The caller releases the bank with ``command("capture_release")``.
        """
        count = await self.read("capture_header.sample_count")
        flags = await self.read_fields("capture_header.flags")
        words = await self._read_words(self._base + registers.CAPTURE_ADDRESS, 2 * count)
        samples = np.array(words, dtype=np.uint32).view(np.int32).reshape(count, 2)
        for head in range(3, heads + 1):
            # The words are read one by one, because a core with three heads refuses the words of
            # head 4.
            first = self._base + registers.FURTHER_CAPTURE_ADDRESS + 4 * (head - 3)
            column = [(await self._read_words(first + 8 * row, 1))[0] for row in range(count)]
            further = np.array(column, dtype=np.uint32).view(np.int32)
            samples = np.column_stack([samples, further])
        return CaptureBank(
            start_time=await self.read("capture_header.start_time"),
            sequence_number=await self.read("capture_header.sequence_number"),
            flags={name: bool(value) for name, value in flags.items()},
            samples=samples,
        )

    async def write_coefficients(self, coefficients: CoefficientSet) -> None:
        """Write all lanes and the offset to the idle bank.

        The bank becomes active with ``command("swap")``. A core without REAL_ORDERS refuses turn
        steps. The function therefore writes them only if a lane has one, and from then on with
        every bank.
        """
        await self._write_words(
            self._base + registers.COEFFICIENTS_ADDRESS, coefficient_words(coefficients)
        )
        self._has_turn_steps = self._has_turn_steps or bool(coefficients.turn_steps.any())
        if self._has_turn_steps:
            await self.write_turn_steps(coefficients)
        await self.write("coefficient_offset", coefficients.offset)

    async def write_turn_steps(self, coefficients: CoefficientSet) -> None:
        """Write the turn step of every lane to the idle bank; a lane of an integer order has the
        turn step 0."""
        steps = coefficients.turn_steps.tolist()
        words = [word for step in steps for word in (step & _WORD, step >> 32)]
        await self._write_words(self._base + registers.TURN_STEPS_ADDRESS, words)

    async def write_conditions(
        self, conditions: Conditions, counts_per_rev: int, clock_hz: float = CLOCK_HZ
    ) -> None:
        """Write the settings for direction and speed to the idle bank; they become active with
        ``command("swap")``."""
        for path, word in condition_registers(conditions, counts_per_rev, clock_hz).items():
            await self.write(path, word)

    async def write_mean(self, mean: MeanSet) -> None:
        """Write weights, offsets and carrier of the mean to the idle bank; they become active with
        ``command("swap")``."""
        for number, word in enumerate(mean.words()):
            if number >= 2 * HEADS_MAX or number % HEADS_MAX < mean.heads:
                address = self._base + registers.MEAN_ADDRESS + 4 * number
                await self._write_words(address, [word])

    async def write_local_table(self, table: LocalTable) -> None:
        """Write the local table to its idle bank; it becomes active with ``command("swap")``.

        ``local_place.choice`` is written last, because writing it makes the next swap include the
        table.
        """
        points = [point & _WORD for point in table.points.tolist()]
        await self._write_words(self._base + registers.LOCAL_POINTS_ADDRESS, points)
        choice, *others = table.place_words()
        first = register_named("local_place.choice").address
        await self._write_words(self._base + first + 4, others)
        await self._write_words(self._base + first, [choice])

    async def write_set(self, number: int, coefficients: CoefficientSet, mean: MeanSet) -> None:
        """Write the prepared set ``number``, which the core can load without the processor: 0 for
        all heads, otherwise for the case that head ``number`` is missing.

        Raises ValueError for a lane whose order is not an integer, because a prepared set has no
        turn steps.
        """
        if coefficients.turn_steps.any():
            raise ValueError("a prepared set holds no turn steps: leave its real orders out")
        first = self._base + registers.PREPARED_SETS_ADDRESS + SET_BYTES * number
        await self._write_words(first, coefficient_words(coefficients))
        for place, word in enumerate(mean.words()):
            if place >= 2 * HEADS_MAX or place % HEADS_MAX < mean.heads:
                await self._write_words(first + SET_MEAN + 4 * place, [word])
        await self._write_words(first + SET_OFFSET, [coefficients.offset & _WORD])

    async def write_parity_weights(self, weights: Sequence[int]) -> None:
        """Write the weights of the parity, one per head; they take effect at once."""
        for head, weight in enumerate(weights, start=1):
            await self.write(f"parity.weight{head}", int(weight))


def coefficient_words(coefficients: CoefficientSet) -> list[int]:
    """Return the words of the coefficient window, four per lane, in the format that the register
    map states."""
    words: list[int] = []
    lanes = zip(
        coefficients.phase_steps.tolist(),
        coefficients.phase_offsets.tolist(),
        coefficients.amplitudes.tolist(),
        coefficients.modulator_numbers.tolist(),
        strict=True,
    )
    for step, phase, amplitude, modulator in lanes:
        words += [step & _WORD, step >> 32 | modulator << 16, phase, amplitude & _WORD]
    return words
