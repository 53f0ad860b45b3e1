"""Tests the accesses that the simulated processor makes while a bitstream runs, and the report of
parts that the accesses do not reach."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from arctrue.generated import registers
from scripts.bitstream_accesses import Access, Answer, Burst, Response, read_answers
from scripts.bitstream_stimulus import (
    BASE,
    FEWEST_CORRECTIONS,
    FEWEST_SAMPLES,
    Core,
    accesses_of,
    core_of,
    shortfalls,
    stored,
)

CORE = Core(lanes=4, depth=64, fold=2)
CLOCKS = 40_000


def answered(accesses: list[Access]) -> list[Answer]:
    """Return answers that a correct core could give: the stored coefficients, and for every other
    word the number of the access, except the sequence number of a capture."""
    held = dict.fromkeys(CORE.coefficients, 0)
    sequence = 0
    answers = []
    for place, access in enumerate(accesses):
        if access.kind not in "rw":
            continue
        is_write = access.kind == "w"
        is_legal = access.burst is Burst.INCREASING and access.size == 2
        is_legal &= not is_write or access.strobe == 0xF
        if is_write and is_legal:
            for beat in range(access.beats):
                address = access.address - BASE + 4 * beat
                if address in held:
                    held[address] = stored(address, access.beat(beat))
            command = access.address == BASE + registers.COMMAND_ADDRESS
            sequence += command and bool(access.data & registers.COMMAND_CAPTURE_RELEASE_MASK)
        response = Response.OKAY if is_legal else Response.SLAVE_ERROR
        for beat in range(1 if is_write else access.beats):
            address = access.address - BASE + 4 * beat
            data = held.get(address, place)
            if address == registers.CAPTURE_HEADER_SEQUENCE_NUMBER_ADDRESS:
                data = sequence
            answers.append(Answer(place, response, data))
    return answers


def test_every_word_is_reached_and_the_rounds_are_the_same_for_the_same_seed() -> None:
    accesses = accesses_of(CORE, CLOCKS, 1)
    assert accesses == accesses_of(CORE, CLOCKS, 1)
    assert accesses != accesses_of(CORE, CLOCKS, 2)
    assert len(CORE.coefficients) == 4 * 4 + 1
    assert shortfalls(CORE, accesses, answered(accesses)) == []


def test_a_word_that_was_not_written_and_what_else_is_lacking_is_reported() -> None:
    accesses = accesses_of(CORE, CLOCKS, 1)
    answers = answered(accesses)
    word = BASE + CORE.coefficients[5]
    kept = [
        answer
        for answer in answers
        if not (accesses[answer.place].kind == "w" and answer_reaches(accesses, answer, word))
    ]
    missing = shortfalls(CORE, accesses, kept)
    assert missing[-1] == "1 words of coefficients were not written and read, the first at 0x01014"
    assert missing[0].startswith("coefficient word 0x01014 read 0x")
    refused = [replace(answer, response=Response.SLAVE_ERROR) for answer in answers]
    assert shortfalls(CORE, accesses, refused) == [
        "17 words of coefficients were not written and read, the first at 0x01000",
        f"the correction was read with 0 values, expected {FEWEST_CORRECTIONS} or more",
        f"0 captured words were read from bank 0, expected {FEWEST_SAMPLES} or more",
        f"0 captured words were read from bank 1, expected {FEWEST_SAMPLES} or more",
    ]


def answer_reaches(accesses: list[Access], answer: Answer, address: int) -> bool:
    access = accesses[answer.place]
    return 0 <= address - access.address < 4 * access.beats


@pytest.mark.parametrize(
    ("word", "written", "reads"),
    [
        (0, 0xFFFF_FFFF, 0xFFFF_FFFF),
        (1, 0xFFFF_FFFF, 0x0000_FFFF),
        (2, 0xFFFF_FFFF, 0x00FF_FFFF),
        (3, 0x0100_0001, 0xFF00_0001),
        (3, 0xFEFF_FFFF, 0x00FF_FFFF),
    ],
)
def test_a_word_reads_as_the_register_map_says(word: int, written: int, reads: int) -> None:
    """A coefficient word keeps as many bits as its format has: K has 48 bits, the phase 24, the
    amplitude 25 with its sign."""
    assert stored(registers.COEFFICIENTS_ADDRESS + 16 * 3 + 4 * word, written) == reads


def test_the_core_is_asked_what_it_is() -> None:
    words = [12288 << 16 | 18 << 8 | 32, 36 << 8 | 8]
    answers = [Answer(place, Response.OKAY, word) for place, word in enumerate(words)]
    assert core_of(answers) == Core(lanes=32, depth=12288, fold=8)


def test_lines_that_the_bench_reads_and_writes(tmp_path: Path) -> None:
    access = Access("w", 0x4000_1000, 0xFF, beats=4, strobe=3, together=True)
    assert access.line() == "w 40001000 ff 4 2 1 3 3 1"
    assert replace(access, last=1).line() == "w 40001000 ff 4 2 1 3 1 1"
    assert access.beat(2) == 0xFF + 2 * 0x0100_0193
    answers = tmp_path / "answers.txt"
    answers.write_text("0 0 ff\n2 3 0\n", encoding="ascii")
    assert read_answers(answers) == [
        Answer(0, Response.OKAY, 0xFF),
        Answer(2, Response.DECODE_ERROR, 0),
    ]
