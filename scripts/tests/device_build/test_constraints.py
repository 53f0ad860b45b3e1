"""Tests that the pin files fit the ports of the top level and the pins of the package."""

from __future__ import annotations

import re
import shutil
import subprocess
from fnmatch import fnmatchcase
from pathlib import Path

import pytest

from arctrue.generated import number_formats
from scripts.bitstream import boards, pins_of_all_heads
from scripts.bitstream_constraints import ConstraintError, check_pins, ports_of, read_pins
from scripts.bitstream_job import CONSTRAINTS, TOPS
from scripts.netlist import ROOT
from scripts.tests.device_build.package_pins import (
    BANKS,
    FIRST_PMOD,
    FURTHER_HEADS,
    HEADER_PAIRS,
    I2C_PINS,
    LEDS,
    OSCILLATOR,
    SECOND_PMOD,
    SUPPLY_VOLTS,
)

TOP = "arctrue_zynq_top"
PAIRS = "arctrue_zynq_differential_top"
HEADS = "arctrue_zynq_heads_top"
TEMPLATE = CONSTRAINTS / "own_board.template.xdc"
SOURCE = "encoder_source"
PMODS = (FIRST_PMOD, SECOND_PMOD)


def vivado_files(top: str) -> list[Path]:
    """Return the files that only Vivado reads for a top level, in the order in which it reads
    them."""
    names = (*TOPS[top].scoped, TOPS[top].vivado)
    return [CONSTRAINTS / "vivado" / f"{name}.xdc" for name in names]


DEVICE_BOARDS = [board for board in boards() if board != SOURCE]


def test_a_second_board_gives_what_the_first_takes() -> None:
    """The second board drives the signals of the heads at the pins at which the first board reads
    them."""
    pins = check_pins(CONSTRAINTS / f"{SOURCE}.xdc", ports_of(f"{SOURCE}_top"))
    assert pins.pop("oscillator") == OSCILLATOR
    for board in DEVICE_BOARDS:
        device = check_pins(CONSTRAINTS / f"{board}.xdc", ports_of(TOP))
        assert pins == {port: device[port] for port in pins}
    (path,) = vivado_files(f"{SOURCE}_top")
    text = path.read_text(encoding="utf-8")
    period = re.search(r"create_clock -name \w+ -period ([\d.]+) \[get_ports oscillator\]", text)
    assert period
    assert float(period[1]) == 1e3 / TOPS[f"{SOURCE}_top"].clock_mhz


def test_ports_are_read_from_the_vhdl() -> None:
    text = (ROOT / "rtl" / "top" / f"{TOP}.vhd").read_text(encoding="utf-8")
    clause = text[text.index("  port (") : text.index(f"end entity {TOP}")]
    assert ports_of(TOP) == re.findall(r"^ +(\w+) +: +(?:in|out|inout) ", clause, re.MULTILINE)
    assert len(ports_of(TOP)) == 6 + 3 + 6 + 2 + 4
    assert len(ports_of(PAIRS)) == 2 * (6 + 3) + 6 + 2 + 4


@pytest.mark.parametrize("board", DEVICE_BOARDS)
def test_every_port_has_a_pin_of_the_package(board: str) -> None:
    path = CONSTRAINTS / f"{board}.xdc"
    pins = check_pins(path, ports_of(TOP))
    assert list(pins) == ports_of(TOP)
    assert len(set(pins.values())) == len(pins)
    assert set(pins.values()) <= set(BANKS)
    standards = {port: given["IOSTANDARD"][0] for port, given in read_pins(path).items()}
    for port, pin in pins.items():
        assert SUPPLY_VOLTS[BANKS[pin]] == 3.3
        assert standards[port] == "LVCMOS33"


@pytest.mark.parametrize(
    "path", [*(CONSTRAINTS / f"{name}.xdc" for name in DEVICE_BOARDS), TEMPLATE]
)
def test_an_open_input_is_pulled_low_and_the_bus_high(path: Path) -> None:
    """The pin file, which both flows read, pulls only the inputs of two heads and ``sync_in`` and
    ``probe_in`` low, and pulls only the I2C bus high."""
    pulled = {
        port: given["PULLTYPE"][0] for port, given in read_pins(path).items() if "PULLTYPE" in given
    }
    inputs = [*ports_of(TOP)[:6], "sync_in", "probe_in"]
    bus = dict.fromkeys(("i2c_scl", "i2c_sda"), "PULLUP")
    assert pulled == dict.fromkeys(inputs, "PULLDOWN") | bus


@pytest.mark.parametrize("board", DEVICE_BOARDS)
def test_signals_are_where_the_page_says(board: str) -> None:
    pins = check_pins(CONSTRAINTS / f"{board}.xdc", ports_of(TOP))
    for place, line in ((1, "a"), (3, "b"), (4, "z")):
        assert pins[f"head1_{line}"] == FIRST_PMOD[place]
        assert pins[f"head2_{line}"] == FIRST_PMOD[6 + place]
        assert pins[f"out_{line}"] == SECOND_PMOD[place]
    coupled = [{pmod[place], pmod[place + 1]} for pmod in PMODS for place in (1, 3, 7, 9)]
    for signal in ("head1", "head2", "out"):
        assert {pins[f"{signal}_a"], pins[f"{signal}_b"]} not in coupled
    leds = [pins[f"led_{name}"] for name in ("alive", "capture", "fault", "compensation")]
    assert tuple(leds) == LEDS
    assert {port: pins[port] for port in I2C_PINS} == I2C_PINS
    page = (ROOT / "docs" / "device.md").read_text(encoding="utf-8")
    for port, pin in pins.items():
        assert re.search(rf"^\| `{port}` \|.*\| {pin} \|", page, re.MULTILINE), (port, pin)


def test_heads_3_and_4_are_on_the_header() -> None:
    """Heads 3 and 4 use the pins of the header on each board. The second board (the encoder source)
    drives these signals at the same pins of its header."""
    for board in DEVICE_BOARDS:
        pins = check_pins(pins_of_all_heads(CONSTRAINTS / f"{board}.xdc"), ports_of(HEADS))
        assert list(pins)[6:12] == [f"head{head}_{line}" for head in (3, 4) for line in "abz"]
        for head, expected in FURTHER_HEADS.items():
            assert tuple(pins[f"{head}_{line}"] for line in "abz") == expected
        assert "U13" not in pins.values()
        assert not [pair for pair in HEADER_PAIRS if pair <= set(pins.values())]
        pulled = read_pins(CONSTRAINTS / "heads" / f"{board}.xdc").values()
        assert {(given["PULLTYPE"][0], given["IOSTANDARD"][0]) for given in pulled} == {
            ("PULLDOWN", "LVCMOS33")
        }
        source = check_pins(
            pins_of_all_heads(CONSTRAINTS / f"{SOURCE}.xdc"), ports_of(f"{SOURCE}_heads_top")
        )
        assert source.pop("oscillator") == OSCILLATOR
        assert source == {port: pins[port] for port in source}
        page = (ROOT / "docs" / "device.md").read_text(encoding="utf-8")
        for port, pin in pins.items():
            assert re.search(rf"^\| `{port}` \|.*\| {pin} \|", page, re.MULTILINE), (port, pin)


def test_a_board_without_pins_for_further_heads_is_named(tmp_path: Path) -> None:
    pins = tmp_path / "my_board.xdc"
    pins.write_text("", encoding="utf-8")
    with pytest.raises(ConstraintError, match="this board has no pins for heads 3 and 4"):
        pins_of_all_heads(pins)


def test_the_template_names_every_port_and_is_refused_as_it_is(tmp_path: Path) -> None:
    with pytest.raises(ConstraintError, match="expected a pin such as Y18, found 'PIN'"):
        check_pins(TEMPLATE, ports_of(TOP))
    filled = iter(BANKS)
    text = re.sub(r"\bPIN(?= \[)", lambda _: next(filled), TEMPLATE.read_text(encoding="utf-8"))
    own = tmp_path / "own.xdc"
    own.write_text(re.sub(r"\bSTANDARD(?= \[)", "LVCMOS33", text), encoding="utf-8")
    assert list(check_pins(own, ports_of(TOP))) == ports_of(TOP)


FAULTS = {
    "another command": (
        "set_false_path -from [get_ports head1_a]",
        r":2: expected set_property .*found 'set_false_path",
    ),
    "a property that open tools do not take": (
        "set_property DRIVE 16 [get_ports head1_a]",
        r":2: expected set_property LOC\|IOSTANDARD\|PULLTYPE",
    ),
    "a pin of another port": (
        "set_property LOC Y18 [get_ports head1_b]",
        r":2: Y18 is already the pin of head1_a",
    ),
    "a second pin": (
        "set_property LOC Y19 [get_ports head1_a]",
        r":2: LOC of head1_a is given again, first in line 1",
    ),
    "a port that is not there": (
        "set_property LOC Y19 [get_ports head3_a]",
        r":2: the top level has no port head3_a",
    ),
    "an unknown standard": (
        "set_property IOSTANDARD RS422 [get_ports head1_a]",
        r":2: 'RS422' is not an accepted I/O standard; expected one of LVCMOS12",
    ),
    "an unknown pull": (
        "set_property PULLTYPE DOWN [get_ports head1_a]",
        r":2: 'DOWN' is not a PULLTYPE; expected one of NONE, PULLDOWN",
    ),
    "a port without a standard": ("", r"port head1_a has no IOSTANDARD"),
    "a port without a pin": ("", r"port head1_b has no LOC"),
}


@pytest.mark.parametrize("fault", FAULTS)
def test_faults_are_named_with_their_line(fault: str, tmp_path: Path) -> None:
    line, message = FAULTS[fault]
    path = tmp_path / "pins.xdc"
    path.write_text(f"set_property LOC Y18 [get_ports head1_a] # first\n{line}\n", encoding="utf-8")
    with pytest.raises(ConstraintError, match=message):
        check_pins(path, ["head1_a", "head1_b"])


def test_a_pin_file_that_is_not_utf_8_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "board.xdc"
    path.write_bytes("set_property LOC W14 [get_ports Kopf_\u00e4]".encode("latin-1"))
    with pytest.raises(ConstraintError, match=r"board\.xdc: expected text in UTF-8"):
        read_pins(path)


def vivado_text() -> str:
    """Return the text of all files of the device that only Vivado reads, without comments."""
    text = "".join(path.read_text(encoding="utf-8") for path in vivado_files(TOP))
    return re.sub(r"^#.*$", "", text, flags=re.MULTILINE)


def test_vivado_names_ports_of_the_top_and_its_clock() -> None:
    """Every pattern of port names in Vivado's files matches a port; otherwise a path would be
    untimed. test_scoped_constraints tests the patterns of cells."""
    text = vivado_text()
    ports = set(ports_of(TOP))
    patterns = " ".join(re.findall(r"get_ports \{?([\w* ]+)\}?\]", text)).split()
    assert patterns
    for pattern in patterns:
        assert any(fnmatchcase(port, pattern) for port in ports), pattern
    period = re.search(r"create_clock -name fabric_clock -period ([\d.]+)", text)
    assert period
    assert float(period[1]) == 1e3 / TOPS[TOP].clock_mhz == 1e9 / number_formats.CLOCK_HZ


def test_inputs_are_timed_and_their_skew_is_bounded() -> None:
    """Every timed input has an input delay, because Vivado times a path from a pin only then.
    test_scoped_constraints tests the bound of the skew."""
    text = vivado_text()
    for port in ("head*", "sync_in", "probe_in"):
        assert f"set_input_delay -clock fabric_clock 0.000 [get_ports {port}]" in text
    # Check that no timing exception cancels the bound of the skew.
    assert not re.search(r"^set_false_path -from \[get_ports head", text, re.MULTILINE)
    assert not re.search(r"^set_false_path -to \[get_ports (out|trig|comp)", text, re.MULTILINE)
    jitter = re.search(r"^set_input_jitter fabric_clock ([\d.]+)$", text, re.MULTILINE)
    assert jitter
    assert float(jitter[1]) == 0.03 * 1e9 / number_formats.CLOCK_HZ


def test_asynchronous_pins_meet_synchronisers_that_are_marked() -> None:
    source = (ROOT / "rtl" / "decoder" / "input_synchroniser.vhd").read_text(encoding="utf-8")
    assert re.search(r'attribute async_reg of stage_registers : signal is "true"', source)


@pytest.mark.parametrize(
    ("top", "expected"),
    [
        (
            TOP,
            {
                "create_clock",
                "create_generated_clock",
                "get_cells",
                "get_clocks",
                "get_pins",
                "get_ports",
                "set_false_path",
                "set_input_delay",
                "set_input_jitter",
                "set_max_delay",
                "set_property",
            },
        ),
        (
            f"{SOURCE}_top",
            {"create_clock", "set_max_delay", "get_ports", "get_clocks"},
        ),
    ],
)
def test_vivado_constraints_are_whole_tcl(top: str, expected: set[str]) -> None:
    """A real Tcl interpreter parses Vivado's files without an error; stand-ins for Vivado's
    commands record which commands the files call."""
    tcl = shutil.which("tclsh")
    assert tcl, "tclsh is missing: apt-get install tcl"
    files = " ".join(str(path) for path in vivado_files(top))
    script = """
    set called {}
    foreach name {create_clock create_generated_clock set_false_path set_max_delay set_property
                  get_pins get_cells set_input_delay set_input_jitter get_ports get_clocks} {
        proc $name args "lappend ::called $name; return $name"
    }
    foreach file $argv { source $file }
    puts [lsort -unique $called]
    """
    done = subprocess.run(
        [tcl],
        input=f"set argv [list {files}]\n{script}",
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.stderr == ""
    assert set(done.stdout.split()) == expected


def test_the_clock_of_the_identifier_is_the_one_that_the_entity_makes() -> None:
    """Vivado's file states the same divided clock as the entity's generic, and the limit of each
    path is at most a quarter of a period of this clock."""
    entity = (ROOT / "rtl" / "top" / "chip_dna.vhd").read_text(encoding="utf-8")
    found = re.search(r"CLOCKS_PER_HALF\s*: positive[^:]*:= (\d+)", entity)
    assert found is not None
    half = int(found.group(1))
    constraints = (CONSTRAINTS / "vivado" / "chip_dna.xdc").read_text(encoding="utf-8")
    assert f"-divide_by {2 * half} " in constraints
    bounds = [float(ns) for ns in re.findall(r"^set_max_delay .* (\d+\.\d+)$", constraints, re.M)]
    half_ns = half * 1e9 / number_formats.CLOCK_HZ
    assert len(bounds) == 2
    assert all(bound <= 0.5 * half_ns for bound in bounds)
    assert "port_clock" in re.findall(r"signal (\w+)", entity)
