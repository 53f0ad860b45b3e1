"""The open tools themselves, where they are there: VHDL to a bitstream, and back to its bits."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import pytest
from scripts import bitstream_open
from scripts.bitstream_database import Chip
from scripts.bitstream_features import bits_of_bitstream
from scripts.bitstream_file import check_bitstream
from scripts.bitstream_job import Job
from scripts.bitstream_open import OpenTools, Routed, place_and_route, write_frames
from scripts.fasm_frames import frames_of
from scripts.netlist import ToolError
from sim.tests.device_build.fake_tools import PART
from sim.tests.device_build.small_top import (
    PINS,
    SMALL_TOP,
    netlist_of_small_top,
    tools_missing,
)

MISSING = tools_missing() or (
    "" if bitstream_open.UNPACKED.exists() else "needs scripts/install_place_and_route.sh"
)
pytestmark = pytest.mark.skipif(bool(MISSING), reason=MISSING)
OPEN_PINS = ("ALUMODE2", "ALUMODE3", "OPMODE6", *(f"INMODE{place}" for place in range(5)))


@dataclass(frozen=True)
class Made:
    """The small design, routed."""

    job: Job
    tools: OpenTools
    routed: Routed


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Made:
    folder = tmp_path_factory.mktemp("small")
    pins = folder / "pins.xdc"
    pins.write_text(PINS, encoding="utf-8")
    netlist = netlist_of_small_top(folder)
    job = Job(SMALL_TOP, PART, {}, pins, folder / "job")
    job.reports.mkdir(parents=True)
    tools = bitstream_open.find_open_tools(PART)
    routed = place_and_route(job, tools.nextpnr, tools.chipdb, netlist)
    bitstream_open.write_bitstream_of(job, tools, routed)
    return Made(job, tools, routed)


def test_every_bit_of_the_bitstream_is_one_that_was_asked_for(made: Made) -> None:
    """Read back by Project X-Ray's reader: the same bits in the same frames, and no other."""
    assert f"for {PART}" in check_bitstream(made.job.bitstream, PART)
    frames = frames_of(made.job.folder / "arctrue.tied.fasm", Chip(made.tools.family, PART))
    asked = {
        (address, place * 32 + bit)
        for address, words in frames.words.items()
        for place, word in enumerate(words)
        for bit in range(32)
        if word >> bit & 1
    }
    reader = bitstream_open.UNPACKED / "bin" / "bitread"
    part_file = made.tools.family / PART / "part.yaml"
    read = bits_of_bitstream(made.job.bitstream, str(reader), part_file)
    assert len(asked) > 1000, "the processor side alone is more"
    assert {(address, bit) for address, bits in read.items() for bit in bits} == asked


def test_a_dsp_without_tie_offs_is_refused(made: Made, tmp_path: Path) -> None:
    """As nextpnr leaves it: its FASM, and a netlist that names no constant."""
    untied = tmp_path / "untied.json"
    untied.write_text('{"modules": {}}', encoding="utf-8")
    job = replace(made.job, folder=tmp_path)
    with pytest.raises(ToolError, match="8 pins of DSPs or block RAMs are not driven") as refused:
        write_frames(job, made.tools, replace(made.routed, netlist=untied))
    for pin in OPEN_PINS:
        assert f": {pin} has no route, no tie-off and no default" in str(refused.value)
