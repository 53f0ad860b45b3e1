"""Tests the conversion of FASM to frames with a handmade database of one tile."""

from __future__ import annotations

from pathlib import Path

import pytest

from scripts.bitstream_database import Chip
from scripts.fasm_frames import frames_of, main
from scripts.netlist import ToolError
from scripts.tests.device_build.fake_tools import PART, add_database


def words(folder: Path, fasm: str) -> dict[int, dict[int, int]]:
    """Return the words that are not 0, by the frame's address and the word's index in the frame."""
    file = folder / "made.fasm"
    file.write_text(fasm, encoding="ascii")
    family = folder / "prjxray-db" / "zynq7"
    chip = Chip(family if family.exists() else add_database(folder), PART)
    frames = frames_of(file, chip)
    assert {len(frame) for frame in frames.words.values()} == {101}
    return {
        address: {place: word for place, word in enumerate(frame) if word}
        for address, frame in frames.words.items()
    }


@pytest.mark.parametrize(
    ("fasm", "first"),
    [
        ("PSS2_X1.PS7.USED[0]", {1: 1 << 5}),
        ("PSS2_X1.PS7.USED[2:0] = 3'b101", {1: 1 << 5 | 1 << 8}),
        ("PSS2_X1.PS7.USED[2:1] = 2'h1", {1: 1 << 6}),
        ("PSS2_X1.PS7.USED[2:0] = 3'b000", {}),
        ("PSS2_X1.PS7.USED[0] = 0", {}),
        ("PSS2_X1.PS7.WIRE", {}),
        ("# nothing\n\n", {}),
    ],
)
def test_a_feature_sets_its_bits_in_the_words_of_its_tile(
    tmp_path: Path, fasm: str, first: dict[int, int]
) -> None:
    assert words(tmp_path, fasm) == {0x100: first, 0x101: {}}


def test_bits_beyond_a_word_and_a_second_frame(tmp_path: Path) -> None:
    assert words(tmp_path, "PSS2_X1.PS7.ALONE") == {0x100: {}, 0x101: {2: 1 << 1}}


def test_what_the_part_asks_for_is_added(tmp_path: Path) -> None:
    required = add_database(tmp_path) / PART / "required_features.fasm"
    required.write_text("PSS2_X1.PS7.USED[1]\n", encoding="ascii")
    assert words(tmp_path, "PSS2_X1.PS7.USED[0]")[0x100] == {1: 1 << 5 | 1 << 6}


@pytest.mark.parametrize(
    ("fasm", "message"),
    [
        ("PSS2_X1.PS7.OTHER", "1 features are not in .*made.fasm:1: PSS2_X1.PS7.OTHER"),
        ("PSS2_X9.PS7.ALONE", "made.fasm:1: PSS2_X9"),
        ("PSS2_X1.PS7.USED[7]", r"made.fasm:1: PSS2_X1.PS7.USED\[7\]"),
        ("\nPSS2 X1", "made.fasm:2: expected a feature of FASM, found 'PSS2 X1'"),
        ("PSS2_X1.PS7.USED[2]\nPSS2_X1.PS7.ALONE", "is set by 'PSS2_X1.PS7.ALONE' and cleared by"),
        ("PSS2_X1.PS7.STEPDOWN", "FASM2FRAMES=/path/to/fasm2frames"),
    ],
)
def test_what_has_no_exact_form_is_refused(tmp_path: Path, fasm: str, message: str) -> None:
    with pytest.raises(ToolError, match=f"(?s){message}"):
        words(tmp_path, fasm)


def test_another_part_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    family = add_database(tmp_path)
    arguments = ["--part", "xc7a35tcsg324-1", "--db-root", str(family)]
    assert main([*arguments, str(tmp_path / "none.fasm"), str(tmp_path / "made.frames")]) == 2
    assert "has no tilegrid.json for the part xc7a35tcsg324-1" in capsys.readouterr().err
