"""``make bitstream FLOW=open`` with stand-ins for the tools, and its netlist with the real ones."""

from __future__ import annotations

import json
import subprocess
from pathlib import Path

import pytest
from scripts import bitstream
from scripts.bitstream_job import Top
from scripts.bitstream_open import check_primitives
from scripts.netlist import (
    ROOT,
    SOURCE_FOLDERS,
    ToolError,
    find_ghdl,
    find_yosys,
    synthesise,
    write_netlist,
)
from scripts.resources import Design
from sim.tests.device_build.fake_tools import NEXTPNR, PART, Bench


@pytest.fixture
def bench(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Bench:
    return Bench(tmp_path, monkeypatch)


def run(bench: Bench, *more: str) -> int:
    output = str(bench.folder / "made")
    return bitstream.main(["--flow", "open", "--output", output, *more])


def test_every_tool_is_called_with_what_the_one_before_made(
    bench: Bench, capsys: pytest.CaptureFixture[str]
) -> None:
    bench.add_open_tools()
    assert run(bench, "--lanes", "4", "--board", "arty_z7_20") == 0
    told = capsys.readouterr().out
    assert "clock 143.45 MHz" in told
    assert "estimate" in told
    assert f"for {PART}" in told
    made = bench.folder / "made"
    (synthesis,) = (call for call in bench.calls("ghdl") if "--synth" in call)
    assert {"-gLANES=4", "-gFOLD=4"} <= set(synthesis)
    assert synthesis[-1] == "arctrue_zynq_top"
    (mapping,) = (call[1] for call in bench.calls("yosys") if call[0] == "-p")
    assert mapping.split("; ")[-2] == "delete t:$scopeinfo"
    assert "-flatten" in mapping
    (placing,) = bench.calls("nextpnr-himbaechel")
    assert any(word.endswith("constraints/arty_z7_20.xdc") for word in placing)
    assert len(bench.calls("fasm2frames")) == len(bench.calls("xc7frames2bit")) == 1
    assert (made / "arctrue.bit").stat().st_size > 4_045_564
    for log in ("nextpnr.log", "fasm2frames.log", "xc7frames2bit.log"):
        assert (made / "reports" / log).exists()


def test_lanes_are_folded_as_far_as_they_divide() -> None:
    assert [bitstream.fold_of("open", lanes) for lanes in (1, 6, 20, 32, 64)] == [1, 2, 4, 8, 8]
    assert bitstream.fold_of("vivado", 32) == 1


@pytest.mark.parametrize(
    ("asked", "told"),
    [
        (["--lanes", "65"], "expected 1 to 64, found 65"),
        (["--lanes", "0"], "expected 1 to 64, found 0"),
        (["--lanes", "12", "--fold", "8"], "8 lanes a pipeline do not divide 12 lanes"),
        (["--fold", "3"], "invalid choice: 3"),
    ],
)
def test_numbers_that_cannot_be_built_are_refused(
    bench: Bench, capsys: pytest.CaptureFixture[str], asked: list[str], told: str
) -> None:
    bench.add_open_tools()
    with pytest.raises(SystemExit) as ended:
        run(bench, *asked)
    assert ended.value.code == 2
    assert told in capsys.readouterr().err
    assert not bench.calls_file.exists()


def test_nextpnr_xilinx_gets_its_own_options(bench: Bench) -> None:
    bench.add_open_tools()
    other = bench.add("nextpnr-xilinx", NEXTPNR)
    chipdb = bench.folder / "xc7z020.bin"
    chipdb.write_text("chip", encoding="utf-8")
    bench.monkeypatch.setenv("NEXTPNR", str(other))
    bench.monkeypatch.setenv("CHIPDB", str(chipdb))
    assert run(bench) == 0
    assert bench.calls("nextpnr-himbaechel") == []
    (call,) = bench.calls("nextpnr-xilinx")
    assert call[call.index("--chipdb") + 1] == str(chipdb)


def test_the_encoder_source_is_no_core(bench: Bench) -> None:
    bench.add_open_tools()
    bench.monkeypatch.setenv("FAKE_CELLS", "BUFG LUT2")
    bench.monkeypatch.setenv("FAKE_ASKED_MHZ", "125")
    assert run(bench, "--top", "encoder_source_top", "--board", "encoder_source") == 0
    (synthesis,) = (call for call in bench.calls("ghdl") if "--synth" in call)
    assert synthesis[-1] == "encoder_source_top"
    assert not [word for word in synthesis if word.startswith("-g")]
    (placing,) = bench.calls("nextpnr-himbaechel")
    assert placing[placing.index("--freq") + 1] == "125"


def test_a_slow_clock_fails(bench: Bench, capsys: pytest.CaptureFixture[str]) -> None:
    bench.add_open_tools()
    bench.monkeypatch.setenv("FAKE_MHZ", "99.99")
    # nextpnr ends with an error then, and without one when it is told to allow it: both must fail.
    for code in ("1", "0"):
        bench.monkeypatch.setenv("FAKE_NEXTPNR_CODE", code)
        assert run(bench) == 1
        error = capsys.readouterr().err
        assert "the timing is not met" in error
        assert "99.99 MHz" in error
        assert not (bench.folder / "made" / "arctrue.bit").exists()
    assert bench.calls("fasm2frames") == []


def test_a_tool_that_fails_is_named_with_the_end_of_its_log(
    bench: Bench, capsys: pytest.CaptureFixture[str]
) -> None:
    bench.add_open_tools()
    bench.monkeypatch.setenv("FAKE_NEXTPNR_CODE", "3")
    assert run(bench) == 2
    assert "nextpnr-himbaechel failed. The end of" in capsys.readouterr().err
    bench.monkeypatch.setenv("FAKE_NEXTPNR_CODE", "0")
    bench.add("fasm2frames", "print('no such feature'); sys.exit(1)")
    assert run(bench) == 2
    assert "no such feature" in capsys.readouterr().err


def test_a_placement_without_timing_is_refused(
    bench: Bench, capsys: pytest.CaptureFixture[str]
) -> None:
    bench.add_open_tools()
    bench.add("nextpnr-himbaechel", "open(arguments[arguments.index('-o') + 3][5:], 'w')")
    assert run(bench) == 2
    assert "timed no clock" in capsys.readouterr().err


def test_a_netlist_without_the_processor_is_refused(
    bench: Bench, capsys: pytest.CaptureFixture[str]
) -> None:
    bench.add_open_tools()
    bench.monkeypatch.setenv("FAKE_CELLS", "BUFG LUT2")
    assert run(bench) == 2
    assert "expected 1 PS7, found 0" in capsys.readouterr().err
    assert bench.calls("nextpnr-himbaechel") == []


@pytest.mark.parametrize(
    ("variable", "value", "told"),
    [
        ("FAKE_IDCODE", "03722093", "expected the code 0x03727093"),  # an XC7Z010
        ("FAKE_FRAMES", "2083740", "expected 4,045,564"),
    ],
)
def test_a_bitstream_of_another_chip_is_refused(
    bench: Bench, capsys: pytest.CaptureFixture[str], variable: str, value: str, told: str
) -> None:
    bench.add_open_tools()
    bench.monkeypatch.setenv(variable, value)
    assert run(bench) == 2
    assert told in capsys.readouterr().err


def test_all_that_is_missing_is_named_at_once(
    bench: Bench, capsys: pytest.CaptureFixture[str]
) -> None:
    bench.monkeypatch.setenv("GHDL_NETLIST", "no-such-ghdl")
    bench.monkeypatch.setenv("YOSYS", "no-such-yosys")
    bench.monkeypatch.setenv("XC7FRAMES2BIT", "no-such-program")
    bench.monkeypatch.delenv("PRJXRAY_DB_DIR", raising=False)
    assert run(bench) == 2
    error = capsys.readouterr().err
    for told in (
        "nextpnr-himbaechel or nextpnr-xilinx is not on PATH",
        "NEXTPNR=/path/to/nextpnr",
        "fasm2frames or fasm2frames.py is not on PATH",
        "XC7FRAMES2BIT=no-such-program is no program that can be started",
        "scripts/install_ghdl_netlist.sh",
        "Yosys is missing",
        "PRJXRAY_DB_DIR is not set",
    ):
        assert told in error, told


def test_missing_databases_are_named(bench: Bench, capsys: pytest.CaptureFixture[str]) -> None:
    bench.add_open_tools()
    bench.monkeypatch.setenv("NEXTPNR", str(bench.add("nextpnr-xilinx", NEXTPNR)))
    bench.monkeypatch.setenv("PRJXRAY_DB_DIR", str(bench.folder))
    assert run(bench) == 2
    error = capsys.readouterr().err
    assert "CHIPDB is not set: nextpnr-xilinx needs the chip's database" in error
    assert f"does not know the part {PART}" in error
    bench.monkeypatch.setenv("CHIPDB", "no.bin")
    assert run(bench) == 2
    assert "CHIPDB=no.bin: there is no such file" in capsys.readouterr().err


def test_bad_pins_stop_before_any_tool(bench: Bench, capsys: pytest.CaptureFixture[str]) -> None:
    bench.add_open_tools()
    assert run(bench, "--board", "none") == 2
    assert "there is no pin file for the board none; there are arty" in capsys.readouterr().err
    pins = bench.folder / "pins.xdc"
    pins.write_text("set_property LOC Y18 [get_ports head1_a]\n", encoding="utf-8")
    assert run(bench, "--pins", str(pins)) == 2
    assert "port head1_a has no IOSTANDARD" in capsys.readouterr().err
    assert not bench.calls_file.exists()


def test_the_makefile_hands_its_variables_on() -> None:
    asked = [
        "FLOW=open",
        "BOARD=arty_z7_20",
        "LANES=4",
        "FOLD=2",
        "PINS=my.xdc",
        "PART=xc7z020clg484-1",
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
    }


def tools_missing() -> str:
    try:
        find_ghdl()
        find_yosys()
    except ToolError as error:
        return str(error)
    return ""


# The processor side with something behind it that is small: what is written is read back.
SMALL_TOP = """
library ieee;
  use ieee.std_logic_1164.all;

entity small_zynq_top is
  port (led_alive, led_written : out std_ulogic);
end entity small_zynq_top;

architecture rtl of small_zynq_top is
  signal clock, reset : std_ulogic;
  signal awvalid, wvalid, bvalid, arvalid, rvalid : std_ulogic;
  signal wdata, word : std_ulogic_vector(31 downto 0);
begin
  processor : entity work.zynq_processor
    port map (
      clock => clock, reset => reset, interrupt => word(1),
      m_axil_awvalid => awvalid, m_axil_awready => '1', m_axil_awaddr => open,
      m_axil_wvalid => wvalid, m_axil_wready => '1', m_axil_wdata => wdata, m_axil_wstrb => open,
      m_axil_bvalid => bvalid, m_axil_bready => open, m_axil_bresp => "00",
      m_axil_arvalid => arvalid, m_axil_arready => '1', m_axil_araddr => open,
      m_axil_rvalid => rvalid, m_axil_rready => open, m_axil_rdata => word, m_axil_rresp => "00");
  process (clock) is
  begin
    if rising_edge(clock) then
      bvalid <= awvalid and wvalid;
      rvalid <= arvalid;
      if wvalid = '1' then
        word <= wdata;
      end if;
    end if;
  end process;
  leds : entity work.status_leds
    port map (
      clock => clock, reset => reset, capturing => word(0), fault => '0', compensating => '0',
      led_alive => led_alive, led_capture => led_written, led_fault => open,
      led_compensation => open);
end architecture rtl;
"""


@pytest.mark.skipif(bool(tools_missing()), reason=tools_missing())
def test_the_real_netlist_holds_the_processor(tmp_path: Path) -> None:
    """PS7 and one BUFG with the ports of the primitives, pads, no latch, nothing unplaceable."""
    source = tmp_path / "source"
    source.mkdir()
    (source / "small_zynq_top.vhd").write_text(SMALL_TOP, encoding="utf-8")
    verilog = write_netlist("small_zynq_top", tmp_path / "made", folders=[*SOURCE_FOLDERS, source])
    netlist = synthesise(verilog, flatten=True)
    small_top = Top("small_zynq_top", 100, {"PS7": 1, "BUFG": 1})
    check_primitives(netlist, small_top)
    empty = tmp_path / "empty.json"
    empty.write_text('{"modules": {"small_zynq_top": {"cells": {}}}}', encoding="utf-8")
    with pytest.raises(ToolError, match="expected 1 PS7, found 0"):
        check_primitives(empty, small_top)
    total = Design.read(netlist).total("small_zynq_top")
    assert total.latches == 0
    cells = json.loads(netlist.read_text(encoding="utf-8"))["modules"]["small_zynq_top"]["cells"]
    kinds = [cell["type"] for cell in cells.values()]
    assert kinds.count("OBUF") == 2
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
