"""Models the entity ``coefficient_memory``: two banks; a swap makes the idle bank active."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from arctrue.gateware.coefficients import Coefficients
from arctrue.generated.number_formats import (
    AMPLITUDE_WIDTH,
    LANES_DEFAULT,
    LANES_MAX,
    PHASE_WIDTH,
)

WORDS_A_LANE = 4
WORD_STEP_LOW, WORD_STEP_HIGH, WORD_PHASE_OFFSET, WORD_AMPLITUDE = range(WORDS_A_LANE)
WORD_MASK = 2**32 - 1


def bank_words(coefficients: Coefficients) -> Iterator[tuple[int, int]]:
    """Return the writes that load a bank, as addresses (lane * 4 + word) with 32-bit data.

    The writes do not include the offset, which has a register of its own.
    """
    for lane in range(coefficients.lanes):
        step = int(coefficients.phase_steps[lane])
        first = lane * WORDS_A_LANE
        yield first + WORD_STEP_LOW, step & WORD_MASK
        yield first + WORD_STEP_HIGH, step >> 32 | int(coefficients.modulator_numbers[lane]) << 16
        yield first + WORD_PHASE_OFFSET, int(coefficients.phase_offsets[lane])
        yield first + WORD_AMPLITUDE, int(coefficients.amplitudes[lane]) & WORD_MASK


def turn_step_words(coefficients: Coefficients) -> Iterator[tuple[int, int]]:
    """Return the writes of the turn steps, as addresses (lane * 2 + word) with 32-bit data."""
    for lane, step in enumerate(coefficients.turn_steps.tolist()):
        yield 2 * lane, step & WORD_MASK
        yield 2 * lane + 1, step >> 32


class CoefficientMemory:
    """Both banks of ``lanes`` lanes; each write, read-back and swap takes effect at once.

    ``compensation_pipeline`` models the clock of a swap: it corrects each angle with a single bank.
    """

    def __init__(self, counts_per_rev: int, lanes: int = LANES_DEFAULT) -> None:
        """Fill both banks with zeros, as at power-up."""
        self._counts_per_rev = counts_per_rev
        self._words = [0] * (WORDS_A_LANE * lanes)
        self._offset = 0
        self._active = Coefficients.zero(counts_per_rev, lanes)

    @property
    def active(self) -> Coefficients:
        """Return the bank that the pipeline reads."""
        return self._active

    def write(self, address: int, data: int) -> None:
        """Write a word of the idle bank; a write to a lane that the gateware lacks is ignored.

        Raises ValueError for an address or a word that the bus cannot carry.
        """
        _check_address(address)
        if not 0 <= data <= WORD_MASK:
            raise ValueError(f"data: {data}, expected a 32-bit word")
        if address < len(self._words):
            self._words[address] = _stored(address % WORDS_A_LANE, data)

    def write_offset(self, data: int) -> None:
        """Write the offset of the idle bank; the memory stores the low bits of the 32-bit word, in
        the format s13.11."""
        self._offset = _signed(data, AMPLITUDE_WIDTH)

    def read(self, address: int) -> int:
        """Return a word of the idle bank; 0 for a lane that the gateware lacks."""
        _check_address(address)
        return self._words[address] if address < len(self._words) else 0

    def swap(self) -> None:
        """Make the idle bank active; the new idle bank then contains the same words, as in the
        gateware."""
        words = np.array(self._words, dtype=np.int64).reshape(-1, WORDS_A_LANE)
        self._active = Coefficients(
            words[:, WORD_STEP_LOW] | words[:, WORD_STEP_HIGH] << 32,  # type: ignore[arg-type]
            words[:, WORD_PHASE_OFFSET],  # type: ignore[arg-type]
            np.array(
                [_signed(word, AMPLITUDE_WIDTH) for word in words[:, WORD_AMPLITUDE].tolist()]
            ),
            self._offset,
            self._counts_per_rev,
        )

    def load(self, coefficients: Coefficients) -> None:
        """Write a whole bank with its offset, and swap the banks."""
        for address, data in bank_words(coefficients):
            self.write(address, data)
        self.write_offset(coefficients.offset & WORD_MASK)
        self.swap()


def _check_address(address: int) -> None:
    if not 0 <= address < WORDS_A_LANE * LANES_MAX:
        raise ValueError(f"address: {address}, expected 0 to {WORDS_A_LANE * LANES_MAX - 1}")


def _signed(data: int, width: int) -> int:
    low = data & ((1 << width) - 1)
    return low - (1 << width) if low >> (width - 1) else low


def _stored(word: int, data: int) -> int:
    if word == WORD_STEP_HIGH:
        return data & 0xFFFF
    if word == WORD_PHASE_OFFSET:
        return data & (2**PHASE_WIDTH - 1)
    if word == WORD_AMPLITUDE:
        return _signed(data, AMPLITUDE_WIDTH) & WORD_MASK
    return data
