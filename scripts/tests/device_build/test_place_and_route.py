"""Tests the open tools, if they are installed, from VHDL to a bitstream and back to the bitstream's
bits."""

from __future__ import annotations

import random
import shutil
from dataclasses import dataclass, replace
from pathlib import Path

import pytest

from scripts import bitstream_open
from scripts.bitstream_accesses import Access, Response
from scripts.bitstream_constraints import check_pins
from scripts.bitstream_database import Chip
from scripts.bitstream_equality import Compared, build, run
from scripts.bitstream_features import Bits, bits_of_bitstream, bits_of_frames
from scripts.bitstream_file import check_bitstream
from scripts.bitstream_job import CONSTRAINTS, TOPS, Job
from scripts.bitstream_open import (
    OpenTools,
    Routed,
    place_and_route,
    place_until_timed,
    write_frames,
)
from scripts.bitstream_stimulus import BASE
from scripts.bitstream_tristates import add_straight_enables
from scripts.bitstream_verify import BITREAD, Design, decode, faults_of
from scripts.fasm_frames import frames_of
from scripts.netlist import ToolError, find_ghdl, find_yosys, synthesise, write_netlist
from scripts.tests.device_build.fake_tools import PART
from scripts.tests.device_build.small_top import (
    PINS,
    SMALL_TOP,
    netlist_of_small_top,
)
from scripts.tests.synth.tools import tools_missing

MISSING = tools_missing(find_ghdl, find_yosys) or (
    "" if bitstream_open.UNPACKED.exists() else "needs scripts/install_place_and_route.sh"
)
pytestmark = pytest.mark.skipif(bool(MISSING), reason=MISSING)
OPEN_PINS = ("ALUMODE2", "ALUMODE3", "OPMODE6", *(f"INMODE{place}" for place in range(5)))


CLOCKS = 100_000


@dataclass(frozen=True)
class Made:
    """Small design after place and route."""

    job: Job
    tools: OpenTools
    routed: Routed
    netlist: Path

    @property
    def chip(self) -> Chip:
        return Chip(self.tools.family, PART)

    def bits(self) -> Bits:
        """Return the bits of the bitstream, as Project X-Ray's reader finds them."""
        reader = BITREAD.find()
        assert reader
        part_file = self.tools.family / PART / "part.yaml"
        return bits_of_bitstream(self.job.bitstream, reader, part_file)

    def bench(self, bits: Bits, folder: Path) -> Path:
        """Build the program that runs the VHDL and the design in ``bits`` in parallel."""
        design = Design.read(self.netlist.parent, SMALL_TOP.name)
        pins = check_pins(self.job.pins, design.pads)
        decoded, _ = decode(self.chip, bits, design, pins)
        return build(design.netlist, design.top, design.ports, decoded, folder)

    def compared(self, bits: Bits, folder: Path) -> Compared:
        """Return the comparison of the VHDL with the design in ``bits``, with random levels at the
        inputs."""
        return run(self.bench(bits, folder), CLOCKS, 1)


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
    return Made(job, tools, routed, netlist)


def test_every_bit_of_the_bitstream_is_one_that_was_asked_for(made: Made) -> None:
    """Project X-Ray's reader finds in the bitstream exactly the bits that the frames contain."""
    assert f"for {PART}" in check_bitstream(made.job.bitstream, PART)
    frames = frames_of(made.job.folder / "arctrue.tied.fasm", made.chip)
    asked = {
        (address, place * 32 + bit)
        for address, words in frames.words.items()
        for place, word in enumerate(words)
        for bit in range(32)
        if word >> bit & 1
    }
    read = made.bits()
    assert len(asked) > 1000, "the processor side alone has more bits"
    assert {(address, bit) for address, bits in read.items() for bit in bits} == asked


def test_the_encoder_source_is_placed_and_routed(tmp_path: Path) -> None:
    """The encoder source can be placed and routed; Yosys makes carry chains from its constant
    settings, which the core does not have."""
    name = "encoder_source_top"
    job = Job(TOPS[name], PART, {}, CONSTRAINTS / "encoder_source.xdc", tmp_path / "job")
    job.reports.mkdir(parents=True)
    tools = bitstream_open.find_open_tools(PART)
    verilog = write_netlist(name, tmp_path / "netlist")
    netlist = synthesise(verilog, flatten=True, for_nextpnr=True)
    # A TimingError is raised if the design is slower than its clock.
    routed = place_until_timed(job, tools.nextpnr, tools.chipdb, netlist)
    assert "MHz" in routed.timing


def test_a_dsp_without_tie_offs_is_refused(made: Made, tmp_path: Path) -> None:
    """A DSP without tie-offs is refused; nextpnr's FASM contains none, and this netlist names no
    constants for which the script would add them."""
    untied = tmp_path / "untied.json"
    untied.write_text('{"modules": {}}', encoding="utf-8")
    job = replace(made.job, folder=tmp_path)
    with pytest.raises(ToolError, match="8 pins of DSPs or RAMs are not driven") as refused:
        write_frames(job, made.tools, replace(made.routed, netlist=untied))
    for pin in OPEN_PINS:
        assert f": {pin} has no route, no tie-off and no default" in str(refused.value)


@pytest.mark.skipif(not shutil.which("verilator"), reason="needs verilator")
def test_what_is_in_the_bitstream_computes_what_the_vhdl_says(made: Made, tmp_path: Path) -> None:
    """The design in the bitstream computes the same outputs as the VHDL; the comparison covers DSP,
    RAMs, shift register and carry chains."""
    bench = made.bench(made.bits(), tmp_path)
    compared = run(bench, CLOCKS, 1)
    assert faults_of(compared) == []
    assert compared.figures["clocks"] == CLOCKS
    # Blocks: 2 (a DSP, half a block RAM), and the used outputs of look-up tables as RAM.
    blocks = 2 + 16 + 6 + 2 * 2 * 2
    assert compared.figures["blocks"] == compared.figures["moved_blocks"] == blocks
    # The outputs that change are 32 bits of read data, the identifiers of both answers, five
    # signals of the bus, interrupt, clock and LEDs, and the two wires of I2C with their levels; the
    # other inputs of the PS7 are constant.
    assert compared.figures["moved_outputs"] >= 32 + 2 * 12 + 5 + 2 + 4
    words_come_back(bench)


def words_come_back(bench: Path) -> None:
    """Write and read single words and bursts with the bench's bus master, with a reset in between.

    At 0x2000 the design reads its memory of 18 bits, with sign. At 0x3000 the design reads the
    memories of 16, 64 and 128 words, each of which holds the last word written to any address with
    the same low bits.
    """
    rng = random.Random(1)
    words = {4 * place: rng.getrandbits(32) for place in rng.sample(range(16, 1024), 200)}
    writes = [Access("w", BASE + address, word) for address, word in words.items()]
    burst = Access("w", BASE, 0x12345, beats=16)
    words = {4 * beat: burst.beat(beat) for beat in range(16)} | words
    order = rng.sample(list(words), len(words))
    reads = [Access("r", BASE + 0x2000 + address, together=True) for address in order]
    reads += [Access("r", BASE + 0x3000 + address, together=True) for address in order]
    accesses = [burst, *writes, Access("z", data=30), *reads, Access("r", BASE + 0x2000, beats=16)]
    accesses.append(Access("r", BASE - 4))
    compared = run(bench, 1, 1, accesses)
    assert compared.is_equal
    answers = compared.answers
    assert [answer.place for answer in answers[: len(writes) + 1]] == list(range(len(writes) + 1))
    assert {answer.response for answer in answers[:-1]} == {Response.OKAY}
    assert answers[-1].response is Response.DECODE_ERROR
    read = [answer.data for answer in answers[len(writes) + 1 : -1]]
    signed = {address: (word & 0x3FFFF ^ 1 << 17) - (1 << 17) for address, word in words.items()}
    in_order = [signed[address] for address in [*order, *range(0, 64, 4)]]
    count = len(order)
    assert read[:count] + read[2 * count :] == [word & 0xFFFF_FFFF for word in in_order]
    # The bits above bit 23 show the former content of the last written address.
    in_look_up_tables = [word & 0xFF_FFFF for word in read[count : 2 * count]]
    assert in_look_up_tables == [last_written(words, address) for address in order]


def last_written(words: dict[int, int], address: int) -> int:
    """Return the content of the memories of 16, 64 and 128 words at an address; ``words`` are in
    the order of writing."""
    found = 0
    for depth, first, bits in ((16, 0, 16), (64, 16, 6), (128, 22, 2)):
        mask = (1 << bits) - 1 << first
        same = [word for place, word in words.items() if (place - address) // 4 % depth == 0]
        found |= same[-1] & mask
    return found


@pytest.mark.skipif(not shutil.which("verilator"), reason="needs verilator")
def test_without_tie_offs_it_computes_something_else(made: Made, tmp_path: Path) -> None:
    fasm = tmp_path / "untied.fasm"
    shutil.copyfile(made.routed.fasm, fasm)
    add_straight_enables(fasm)
    frames = tmp_path / "untied.frames"
    frames_of(fasm, made.chip).write(frames)
    compared = made.compared(bits_of_frames(frames), tmp_path)
    assert not compared.is_equal
    assert any("MAXIGP0RDATA" in line for line in compared.differences)


@pytest.mark.skipif(not shutil.which("verilator"), reason="needs verilator")
def test_as_nextpnr_leaves_it_a_wire_is_pulled_where_it_must_not(
    made: Made, tmp_path: Path
) -> None:
    """The comparison finds a wrong enable of the tri-state pads: the first differences are at the
    two wires, before the design multiplies any word."""
    frames = tmp_path / "inverted.frames"
    frames_of(made.routed.fasm, made.chip).write(frames)
    compared = made.compared(bits_of_frames(frames), tmp_path)
    wires = ("scl", "sda", "EMIOI2C0SCLI", "EMIOI2C0SDAI")
    assert {line.split(": ", 1)[1].split()[0] for line in compared.differences[:4]} <= set(wires)
