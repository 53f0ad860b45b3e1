"""The open tools themselves, where they are there: VHDL to a bitstream, and back to its bits."""

from __future__ import annotations

import subprocess
from pathlib import Path

import pytest
from scripts import bitstream_open
from scripts.bitstream_file import check_bitstream
from scripts.bitstream_job import Job
from scripts.fasm_frames import frames_of
from sim.tests.device_build.fake_tools import PART
from sim.tests.device_build.small_top import SMALL_TOP, netlist_of_small_top, tools_missing

MISSING = tools_missing() or (
    "" if bitstream_open.UNPACKED.exists() else "needs scripts/install_place_and_route.sh"
)
PINS = "".join(
    f"set_property LOC {pin} [get_ports {port}]\n"
    f"set_property IOSTANDARD LVCMOS33 [get_ports {port}]\n"
    for port, pin in {"led_alive": "R14", "led_written": "P14"}.items()
)


@pytest.mark.skipif(bool(MISSING), reason=MISSING)
def test_every_bit_of_the_bitstream_is_one_that_nextpnr_asked_for(tmp_path: Path) -> None:
    """Read back by Project X-Ray's reader: the same bits in the same frames, and no other."""
    pins = tmp_path / "pins.xdc"
    pins.write_text(PINS, encoding="utf-8")
    netlist = netlist_of_small_top(tmp_path)
    job = Job(SMALL_TOP, PART, {}, pins, tmp_path / "job")
    job.reports.mkdir(parents=True)
    tools = bitstream_open.find_open_tools(PART)
    bitstream_open.write_bitstream(job, tools, netlist)
    assert f"for {PART}" in check_bitstream(job.bitstream, PART)

    part_file = tools.family / PART / "part.yaml"
    frames = frames_of(job.folder / "arctrue.fasm", tools.family, PART)
    asked = {
        (address, place, bit)
        for address, words in frames.words.items()
        for place, word in enumerate(words)
        for bit in range(32)
        if word >> bit & 1
    }
    bits = tmp_path / "bits"
    reader = bitstream_open.UNPACKED / "bin" / "bitread"
    command = [reader, "-part_file", part_file, "-y", "-z", "-o", bits]
    subprocess.run([*command, job.bitstream], check=True, capture_output=True)
    lines = bits.read_text(encoding="ascii").split()
    read = {
        (int(address, 16), int(place), int(bit))
        for _, address, place, bit in (line.split("_") for line in lines)
    }
    assert len(asked) > 1000, "the processor side alone is more"
    assert read == asked
