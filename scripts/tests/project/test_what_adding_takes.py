"""Tests that the files that CONTRIBUTING names are enough to add a register or a board; the tests
edit copies of these files.

The tests for a cause and an effect are in ``sim/tests/table/test_registry.py`` and
``test_effect_check.py``.
"""

from __future__ import annotations

import re
import shutil
import subprocess
from pathlib import Path

import pytest

from scripts import bitstream
from scripts.bitstream_constraints import check_pins, ports_of
from scripts.generate_python import python_registers
from scripts.netlist import SOURCE_FOLDERS, write_netlist
from scripts.register_block import write_register_block
from scripts.register_map import REGISTERS, compile_registers
from scripts.register_words import ENTITY, register_words

ROOT = Path(__file__).resolve().parents[3]
CORE = Path("rtl/core/arctrue_core.vhd")
TABLE = re.compile(r"^\| (?P<kind>an? \w+) \| (?P<number>\d) \| (?P<files>.+?) \|", re.MULTILINE)

NEW_REGISTER = """
    reg {
        name = "Added";
        desc = "A register of the test.";
        field {sw=r; hw=w; desc="Lanes.";} value[6:0];
    } added_by_test @ 0x0FC;
"""
CONNECTION = """  hwif_in.added_by_test.value.next_q <= std_ulogic_vector(to_unsigned(LANES, 7));
"""
BEFORE_REGISTER = "    regfile head {\n"
BEFORE_CONNECTION = "  status_capturing    <= capture_busy;\n"


def documented(kind: str) -> set[str]:
    """Return the files that CONTRIBUTING names for ``kind``; their number must equal the number in
    the row of CONTRIBUTING's table."""
    text = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")
    (row,) = (found for found in TABLE.finditer(text) if found["kind"] == kind)
    files = set(re.findall(r"`([^`]+)`", row["files"]))
    assert len(files) == int(row["number"]), f"CONTRIBUTING: {kind}"
    return files


def edited(folder: Path, path: Path, before: str, added: str) -> Path:
    """Copy a file of the tree; insert ``added`` before the text ``before``, which must occur
    once."""
    text = (ROOT / path).read_text(encoding="utf-8")
    assert text.count(before) == 1, f"{path}: expected once: {before}"
    copy = folder / path.name
    copy.write_text(text.replace(before, added + before), encoding="utf-8")
    return copy


@pytest.mark.large
def test_a_register_takes_two_files(tmp_path: Path) -> None:
    """A new register needs two edited files, from which the build makes block, Python names, bench
    and core."""
    sources, made = tmp_path / "sources", tmp_path / "made"
    sources.mkdir()
    made.mkdir()
    register_map = edited(sources, REGISTERS, BEFORE_REGISTER, NEW_REGISTER)
    core = edited(sources, CORE, BEFORE_CONNECTION, CONNECTION)
    assert {str(REGISTERS), str(CORE)} == documented("a register")

    block = compile_registers(register_map, block_only=True)
    write_register_block(block, made)
    (made / f"{ENTITY}.vhd").write_text(register_words(block), encoding="utf-8")
    names = python_registers(compile_registers(register_map))
    assert "ADDED_BY_TEST_ADDRESS: Final = 0x000FC" in names
    # The last folder takes precedence, so its copies replace the files of the tree.
    folders = (*SOURCE_FOLDERS, ROOT / "tb", made, sources)
    generics = {"LANES": 2, "CAPTURE_DEPTH": 2}
    built = write_netlist(core.stem, tmp_path / "core", generics=generics, folders=folders)
    assert "added_by_test" in built.read_text(encoding="utf-8")
    bench = write_netlist(ENTITY, tmp_path / "bench", folders=folders)
    assert re.search(r"input\s+\[31:0\] added_by_test\b", bench.read_text(encoding="utf-8"))


@pytest.mark.parametrize("own_processor_side", [False, True])
def test_a_board_takes_one_file(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, own_processor_side: bool
) -> None:
    """A new board needs one pin file, whose name is the board's name; it needs a second file only
    for another processor side."""
    constraints, firmware = tmp_path / "constraints", tmp_path / "firmware"
    shutil.copytree(ROOT / "constraints", constraints)
    shutil.copytree(ROOT / "firmware", firmware)
    shutil.copy(ROOT / "pyproject.toml", tmp_path)
    assert {"constraints/<board>.xdc"} == documented("a board")
    pins = constraints / "added.xdc"
    shutil.copy(ROOT / "constraints" / "pynq_z2.xdc", pins)
    processor_side = firmware / "board" / "processor_side.h"
    if own_processor_side:
        own = firmware / "board" / "boards" / "added.h"
        own.parent.mkdir()
        own.write_text(processor_side.read_text().replace("50000000U", "33333333U"))
        processor_side = own

    monkeypatch.setattr(bitstream, "CONSTRAINTS", constraints)
    assert "added" in bitstream.boards()
    check_pins(pins, ports_of("arctrue_zynq_top"))
    out = tmp_path / "out"
    command = ["make", "-C", str(firmware), "BOARD=added", f"OUT={out}", f"{out}/board_settings.h"]
    subprocess.run(command, check=True, capture_output=True, timeout=60)
    header = (out / "board_settings.h").read_text(encoding="utf-8")
    assert header.startswith(processor_side.read_text(encoding="utf-8"))
    assert '#define BOARD_NAME "added"' in header
    wrong = subprocess.run(
        [word.replace("added", "adddde") for word in command],
        check=False, capture_output=True, text=True, timeout=60,
    )  # fmt: skip
    assert wrong.returncode
    assert "constraints/adddde.xdc" in wrong.stderr


@pytest.mark.parametrize("kind", ["a cause", "an effect"])
def test_a_cause_and_an_effect_are_one_file(kind: str) -> None:
    """A cause or an effect needs one file: the folder that CONTRIBUTING names contains only such
    files and the package's ``__init__.py``."""
    (pattern,) = documented(kind)
    folder = (ROOT / pattern).parent
    assert len(list(folder.glob("*.py"))) > 10
    assert not [path for path in folder.iterdir() if path.is_dir() and path.name != "__pycache__"]
