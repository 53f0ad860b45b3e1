"""Tests ``make bitstream FLOW=open`` with fake programs in place of the tools, and tests the real
netlist."""

from __future__ import annotations

import json
import re
import subprocess
from pathlib import Path

import pytest

from scripts import bitstream
from scripts.bitstream_job import TOPS, Top
from scripts.bitstream_open import check_contents, check_primitives
from scripts.netlist import ROOT, ToolError, find_ghdl, find_yosys, write_netlist
from scripts.resources import Design
from scripts.tests.device_build.fake_tools import FASM2FRAMES, NEXTPNR, PART, FakeTools
from scripts.tests.device_build.small_top import SMALL_TOP, netlist_of_small_top
from scripts.tests.synth.tools import tools_missing

MISSING = tools_missing(find_ghdl, find_yosys)
SHORTEST_TOPS = ("encoder_source_top",)


@pytest.fixture
def fakes(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> FakeTools:
    return FakeTools(tmp_path, monkeypatch)


def run(fakes: FakeTools, *more: str) -> int:
    output = str(fakes.folder / "made")
    return bitstream.main(["--flow", "open", "--output", output, *more])


def test_every_tool_is_called_with_what_the_one_before_made(
    fakes: FakeTools, capsys: pytest.CaptureFixture[str]
) -> None:
    fakes.add_open_tools()
    assert run(fakes, "--lanes", "4", "--board", "arty_z7_20") == 0
    printed = capsys.readouterr().out
    assert "clock 143.45 MHz" in printed
    assert "estimate" in printed
    assert f"for {PART}" in printed
    made = fakes.folder / "made"
    (synthesis,) = (call for call in fakes.calls("ghdl") if "--synth" in call)
    assert {"-gLANES=4", "-gFOLD=1"} <= set(synthesis)
    assert synthesis[-1] == "arctrue_zynq_top"
    (mapping,) = (call[1] for call in fakes.calls("yosys") if call[0] == "-p")
    assert mapping.split("; ")[-2] == "delete t:$scopeinfo"
    assert "-flatten" in mapping
    (placing,) = fakes.calls("nextpnr-himbaechel")
    assert any(word.endswith("constraints/arty_z7_20.xdc") for word in placing)
    assert len(fakes.calls("xc7frames2bit")) == 1
    assert (made / "arctrue.bit").stat().st_size > 4 * 1_010_808
    for log in ("nextpnr.log", "xc7frames2bit.log"):
        assert (made / "reports" / log).exists()


@pytest.mark.large
def test_the_frames_are_the_same_by_a_program_that_is_named(fakes: FakeTools) -> None:
    fakes.add_open_tools()
    assert run(fakes) == 0
    frames = fakes.folder / "made" / "arctrue.frames"
    own = frames.read_text(encoding="ascii").splitlines()[0]
    fakes.monkeypatch.setenv("FASM2FRAMES", str(fakes.add("fasm2frames", FASM2FRAMES)))
    assert run(fakes) == 0
    assert len(fakes.calls("fasm2frames")) == 1
    named = frames.read_text(encoding="ascii")
    assert [int(word, 16) for word in re.split("[ ,]", own)] == [
        int(word, 16) for word in re.split("[ ,]", named)
    ]


def test_lanes_are_folded_no_more_than_the_tools_need() -> None:
    assert [bitstream.fold_of("open", lanes) for lanes in (1, 6, 20, 32, 64)] == [1, 1, 2, 2, 4]
    assert bitstream.fold_of("open", 33) == 1
    assert bitstream.fold_of("vivado", 32) == 1


@pytest.mark.parametrize(
    ("asked", "printed"),
    [
        (["--lanes", "65"], "expected 1 to 64, found 65"),
        (["--lanes", "0"], "expected 1 to 64, found 0"),
        (["--lanes", "12", "--fold", "8"], "8 lanes a pipeline do not divide 12 lanes"),
        # Depending on its version, Python writes 3 or "3" in the message.
        (["--fold", "3"], "argument --fold: invalid choice"),
    ],
)
def test_numbers_that_cannot_be_built_are_refused(
    fakes: FakeTools, capsys: pytest.CaptureFixture[str], asked: list[str], printed: str
) -> None:
    fakes.add_open_tools()
    with pytest.raises(SystemExit) as ended:
        run(fakes, *asked)
    assert ended.value.code == 2
    assert printed in capsys.readouterr().err
    assert not fakes.calls_file.exists()


def test_nextpnr_xilinx_gets_its_own_options(fakes: FakeTools) -> None:
    fakes.add_open_tools()
    other = fakes.add("nextpnr-xilinx", NEXTPNR)
    chipdb = fakes.folder / "xc7z020.bin"
    chipdb.write_text("chip", encoding="utf-8")
    fakes.monkeypatch.setenv("NEXTPNR", str(other))
    fakes.monkeypatch.setenv("CHIPDB", str(chipdb))
    assert run(fakes) == 0
    assert fakes.calls("nextpnr-himbaechel") == []
    (call,) = fakes.calls("nextpnr-xilinx")
    assert call[call.index("--chipdb") + 1] == str(chipdb)


def test_the_encoder_source_is_no_core(fakes: FakeTools) -> None:
    fakes.add_open_tools()
    fakes.monkeypatch.setenv("FAKE_CELLS", "BUFG LUT2")
    fakes.monkeypatch.setenv("FAKE_ASKED_MHZ", "125")
    assert run(fakes, "--top", "encoder_source_top", "--board", "encoder_source") == 0
    (synthesis,) = (call for call in fakes.calls("ghdl") if "--synth" in call)
    assert synthesis[-1] == "encoder_source_top"
    assert not [word for word in synthesis if word.startswith("-g")]
    (placing,) = fakes.calls("nextpnr-himbaechel")
    assert placing[placing.index("--freq") + 1] == "125"
    assert "--seed" not in placing
    assert "--placer-heap-timingweight" not in placing


def test_another_placement_is_that_of_another_seed(fakes: FakeTools) -> None:
    fakes.add_open_tools()
    assert run(fakes, "--seed", "7") == 0
    (placing,) = fakes.calls("nextpnr-himbaechel")
    assert placing[placing.index("--seed") + 1] == "7"
    assert placing[placing.index("--placer-heap-timingweight") + 1] == "50"
    assert "--tmg-ripup" in placing


def test_a_slow_clock_fails(fakes: FakeTools, capsys: pytest.CaptureFixture[str]) -> None:
    fakes.add_open_tools()
    fakes.monkeypatch.setenv("FAKE_MHZ", "99.99")
    # nextpnr then ends with an error, or without an error if an option permits this; the flow must
    # fail in both cases.
    for code in ("1", "0"):
        fakes.monkeypatch.setenv("FAKE_NEXTPNR_CODE", code)
        assert run(fakes) == 1
        error = capsys.readouterr().err
        assert "the timing is not met" in error
        assert "99.99 MHz" in error
        assert not (fakes.folder / "made" / "arctrue.bit").exists()
    assert fakes.calls("xc7frames2bit") == []


def test_data_that_change_too_early_fail(
    fakes: FakeTools, capsys: pytest.CaptureFixture[str]
) -> None:
    """The flow fails if nextpnr reports a hold violation, although nextpnr ends without an
    error."""
    fakes.add_open_tools()
    fakes.monkeypatch.setenv("FAKE_HOLD", "-0.02 -0.05")
    assert run(fakes) == 1
    error = capsys.readouterr().err
    assert "2 hold violations, the worst -0.05 ns at core.memory-0.05.DIADI13" in error
    assert "make bitstream FLOW=open SEED=N" in error
    assert fakes.calls("xc7frames2bit") == []


def test_a_placement_that_is_too_slow_is_followed_by_another(
    fakes: FakeTools, capsys: pytest.CaptureFixture[str]
) -> None:
    fakes.add_open_tools()
    fakes.monkeypatch.setenv("FAKE_SLOW_SEEDS", "none 2")
    assert run(fakes) == 0
    seeds = [call[call.index("--seed") + 1] for call in fakes.calls("nextpnr-himbaechel")[1:]]
    assert seeds == ["2", "3"]
    said = capsys.readouterr().out
    assert said.count("below 100 MHz") == 2
    assert "The next placement is that of seed 3." in said


def test_a_seed_that_was_asked_for_is_the_only_one(fakes: FakeTools) -> None:
    fakes.add_open_tools()
    fakes.monkeypatch.setenv("FAKE_SLOW_SEEDS", "7")
    assert run(fakes, "--seed", "7") == 1
    assert len(fakes.calls("nextpnr-himbaechel")) == 1


def test_a_tool_that_fails_is_named_with_the_end_of_its_log(
    fakes: FakeTools, capsys: pytest.CaptureFixture[str]
) -> None:
    fakes.add_open_tools()
    fakes.monkeypatch.setenv("FAKE_NEXTPNR_CODE", "3")
    assert run(fakes) == 2
    assert "nextpnr-himbaechel failed. The end of" in capsys.readouterr().err
    fakes.monkeypatch.setenv("FAKE_NEXTPNR_CODE", "0")
    fakes.add("xc7frames2bit", "print('no such part'); sys.exit(1)")
    assert run(fakes) == 2
    assert "no such part" in capsys.readouterr().err
    fakes.monkeypatch.setenv("FAKE_FASM", "PSS2_X1.PS7.OTHER")
    assert run(fakes) == 2
    error = capsys.readouterr().err
    assert "1 features are not in" in error
    assert "arctrue.tied.fasm:2: PSS2_X1.PS7.OTHER" in error


def test_a_placement_without_timing_is_refused(
    fakes: FakeTools, capsys: pytest.CaptureFixture[str]
) -> None:
    fakes.add_open_tools()
    fakes.add("nextpnr-himbaechel", "open(arguments[arguments.index('-o') + 3][5:], 'w')")
    assert run(fakes) == 2
    assert "timed no clock" in capsys.readouterr().err


def test_a_netlist_without_the_processor_is_refused(
    fakes: FakeTools, capsys: pytest.CaptureFixture[str]
) -> None:
    fakes.add_open_tools()
    fakes.monkeypatch.setenv("FAKE_CELLS", "BUFG LUT2")
    assert run(fakes) == 2
    assert "expected 1 PS7, found 0" in capsys.readouterr().err
    assert fakes.calls("nextpnr-himbaechel") == []


@pytest.mark.parametrize(
    ("variable", "value", "printed"),
    [
        # The code belongs to an XC7Z010.
        ("FAKE_IDCODE", "03722093", "expected the code 0x03727093"),
        ("FAKE_WORDS", "520352", "expected 1,010,808 words of frames"),
        ("FAKE_WORDS_THERE", "1010807", "cut off: 1,010,807 of 1,010,808 words"),
    ],
)
def test_a_bitstream_of_another_chip_is_refused(
    fakes: FakeTools, capsys: pytest.CaptureFixture[str], variable: str, value: str, printed: str
) -> None:
    fakes.add_open_tools()
    fakes.monkeypatch.setenv(variable, value)
    assert run(fakes) == 2
    assert printed in capsys.readouterr().err


def test_all_that_is_missing_is_named_at_once(
    fakes: FakeTools, capsys: pytest.CaptureFixture[str]
) -> None:
    fakes.monkeypatch.setenv("GHDL_NETLIST", "no-such-ghdl")
    fakes.monkeypatch.setenv("YOSYS", "no-such-yosys")
    fakes.monkeypatch.setenv("XC7FRAMES2BIT", "no-such-program")
    fakes.monkeypatch.delenv("PRJXRAY_DB_DIR", raising=False)
    assert run(fakes) == 2
    error = capsys.readouterr().err
    for printed in (
        "nextpnr-himbaechel or nextpnr-himbaechel-xilinx or nextpnr-xilinx is not on PATH",
        "Run scripts/install_place_and_route.sh",
        "NEXTPNR=/path/to/nextpnr",
        "XC7FRAMES2BIT=no-such-program is not a program that can be started",
        "scripts/install_ghdl_netlist.sh",
        "Yosys is missing",
        "PRJXRAY_DB_DIR is not set",
    ):
        assert printed in error, printed


def test_missing_databases_are_named(fakes: FakeTools, capsys: pytest.CaptureFixture[str]) -> None:
    fakes.add_open_tools()
    fakes.monkeypatch.setenv("NEXTPNR", str(fakes.add("nextpnr-xilinx", NEXTPNR)))
    fakes.monkeypatch.setenv("PRJXRAY_DB_DIR", str(fakes.folder))
    assert run(fakes) == 2
    error = capsys.readouterr().err
    assert "CHIPDB is not set: nextpnr-xilinx needs the chip's database" in error
    assert f"does not know the part {PART}" in error
    fakes.monkeypatch.setenv("CHIPDB", "no.bin")
    assert run(fakes) == 2
    assert "CHIPDB=no.bin: there is no such file" in capsys.readouterr().err


def test_bad_pins_stop_before_any_tool(
    fakes: FakeTools, capsys: pytest.CaptureFixture[str]
) -> None:
    fakes.add_open_tools()
    assert run(fakes, "--board", "none") == 2
    assert "there is no pin file for the board none; there are arty" in capsys.readouterr().err
    pins = fakes.folder / "pins.xdc"
    pins.write_text("set_property LOC Y18 [get_ports head1_a]\n", encoding="utf-8")
    assert run(fakes, "--pins", str(pins)) == 2
    assert "port head1_a has no IOSTANDARD" in capsys.readouterr().err
    assert not fakes.calls_file.exists()


def test_the_makefile_hands_its_variables_on() -> None:
    asked = [
        "FLOW=open",
        "BOARD=arty_z7_20",
        "LANES=4",
        "FOLD=2",
        "PINS=my.xdc",
        "PART=xc7z020clg484-1",
        "HEADS=4",
        "MEAN=true",
    ]
    done = subprocess.run(
        ["make", "--no-print-directory", "--dry-run", "bitstream", *asked],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=True,
    )
    command = done.stdout.splitlines()[-1].split()
    assert command[command.index("-m") + 1] == "scripts.bitstream"
    given = dict(zip(command[3::2], command[4::2], strict=True))
    assert given == {
        "--flow": "open",
        "--board": "arty_z7_20",
        "--lanes": "4",
        "--fold": "2",
        "--pins": "my.xdc",
        "--part": "xc7z020clg484-1",
        "--heads": "4",
        "--mean": "true",
    }


@pytest.mark.large
@pytest.mark.skipif(bool(MISSING), reason=MISSING)
def test_the_real_netlist_holds_the_processor(tmp_path: Path) -> None:
    """The netlist contains PS7 and one BUFG, with the primitives' ports, and pads; it contains no
    latch."""
    netlist = netlist_of_small_top(tmp_path)
    check_primitives(netlist, SMALL_TOP)
    check_contents(netlist, SMALL_TOP)
    empty = tmp_path / "empty.json"
    empty.write_text('{"modules": {"small_zynq_top": {"cells": {}}}}', encoding="utf-8")
    with pytest.raises(ToolError, match="expected 1 PS7, found 0"):
        check_primitives(empty, SMALL_TOP)
    total = Design.read(netlist).total("small_zynq_top")
    assert total.latches == 0
    cells = json.loads(netlist.read_text(encoding="utf-8"))["modules"]["small_zynq_top"]["cells"]
    kinds = [cell["type"] for cell in cells.values()]
    assert kinds.count("OBUF") == 2
    assert kinds.count("IOBUF") == 2
    assert [kind for kind in kinds if kind.startswith("$")] == []
    (ps7,) = (cell["connections"] for cell in cells.values() if cell["type"] == "PS7")
    (buffer,) = (cell["connections"] for cell in cells.values() if cell["type"] == "BUFG")
    assert buffer["I"] == [ps7["FCLKCLK"][0]]
    assert buffer["O"] == ps7["MAXIGP0ACLK"]
    # Interrupt 61 is the lowest line; the 19 others are tied low.
    assert isinstance(ps7["IRQF2P"][0], int)
    assert ps7["IRQF2P"][1:] == ["0"] * 19
    # Every register runs on the buffered clock.
    clocks = {cell["connections"]["C"][0] for cell in cells.values() if cell["type"][:2] == "FD"}
    assert clocks == set(buffer["O"])
    assert ps7["MAXIGP0BVALID"][0] not in ("0", "1", "x")


@pytest.mark.skipif(bool(MISSING), reason=MISSING)
@pytest.mark.parametrize(
    "top",
    [
        pytest.param(top, id=name, marks=[pytest.mark.large] * (name not in SHORTEST_TOPS))
        for name, top in TOPS.items()
    ],
)
def test_yosys_reads_the_netlist_of_every_top(tmp_path: Path, top: Top) -> None:
    """Yosys reads the netlist of every top; it once rejected the netlist of one top, because the
    name of an instance was a keyword of Verilog."""
    generics = {"LANES": 1, "CAPTURE_DEPTH": 64} if top.has_core else {}
    netlist = write_netlist(top.name, tmp_path / "made", generics=generics)
    script = f"read_verilog {netlist.name}; hierarchy -top {top.name}; select -assert-any c:*"
    subprocess.run([find_yosys()[0], "-q", "-p", script], cwd=netlist.parent, check=True)


@pytest.mark.parametrize("kind", ["RAM32M", "RAM64M"])
def test_contents_that_nextpnr_would_lose_are_refused(tmp_path: Path, kind: str) -> None:
    netlist = tmp_path / "netlist.json"
    cell = {"type": kind, "parameters": {"INIT_A": "0" * 64, "INIT_C": "0" * 62 + "1x"}}
    modules = {SMALL_TOP.name: {"cells": {"slots": cell}}}
    netlist.write_text(json.dumps({"modules": modules}), encoding="utf-8")
    with pytest.raises(ToolError, match=f"the {kind} slots holds ones at power-up"):
        check_contents(netlist, SMALL_TOP)
