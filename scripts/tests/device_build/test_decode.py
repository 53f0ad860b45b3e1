"""Tests how single cells are decoded from features; test_place_and_route.py decodes whole
designs."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from scripts import bitstream_verify
from scripts.bitstream_blocks import dsp, ram_half
from scripts.bitstream_database import Chip
from scripts.bitstream_equality import Compared, direct_tristates, ports_of, without_repeats
from scripts.bitstream_features import Features
from scripts.bitstream_routes import Routes, Source
from scripts.bitstream_slices import Slice, Text
from scripts.netlist import ToolError

PART = "xc7z020clg400-1"
NAME = "S"


def one_slice(features: set[str], pins: dict[str, str]) -> tuple[Slice, Text]:
    text = Text()
    return Slice(NAME, frozenset(features), lambda pin: pins.get(pin, pin), text), text


def init_features(letter: str, value: int) -> set[str]:
    return {f"{letter}LUT.INIT[{bit:02}]" for bit in range(64) if value >> bit & 1}


def test_a_table_gives_the_bit_that_its_inputs_name() -> None:
    """At every address of random tables, output O6 is the bit of INIT with the number A6 … A1, and
    O5 the bit with the number A5 … A1 (UG474)."""
    rng = np.random.default_rng(1)
    for _ in range(4):
        value = int.from_bytes(rng.bytes(8), "little")
        for address in range(64):
            pins = {f"A{place + 1}": f"1'b{address >> place & 1}" for place in range(6)}
            made, text = one_slice(init_features("A", value) | {"AOUTMUX.O5"}, pins)
            assert made.output("A") == f"{NAME}_Ao6"
            assert text.assignments[-1] == f"assign {NAME}_Ao6 = 1'b{value >> address & 1};"
            made.output("AMUX")
            assert text.assignments[-1] == f"assign {NAME}_Ao5 = 1'b{value >> address % 32 & 1};"


def test_an_input_that_changes_chooses_between_what_is_left() -> None:
    """With constant inputs the first table reduces to A3 xor A5, and the second passes B2 to its
    output."""
    value = sum(1 << place for place in range(64) if (place >> 2 ^ place >> 4) & 1)
    constant = {"A1": "1'b1", "A2": "1'b0", "A4": "1'b1", "A6": "1'b1"}
    made, text = one_slice(init_features("A", value), constant)
    made.output("A")
    assert text.assignments[-1] == f"assign {NAME}_Ao6 = 1'b1 & (4'h6 >> {{A5, A3}});"
    through = sum(1 << place for place in range(64) if place >> 1 & 1)
    pins = {f"B{place}": "1'b1" for place in (1, 3, 4, 5, 6)}
    made, text = one_slice(init_features("B", through), pins)
    made.output("B")
    assert text.assignments[-1] == f"assign {NAME}_Bo6 = B2;"


@pytest.mark.parametrize(
    ("features", "statement"),
    [
        ({"AFF.ZRST", "AFF.ZINI"}, "S_AFF <= AX;"),
        ({"CEUSEDMUX", "AFF.ZINI"}, "if (CE) S_AFF <= AX;"),
        (
            {"CEUSEDMUX", "SRUSEDMUX", "FFSYNC", "AFF.ZRST"},
            "if (SR) S_AFF <= 1'b0; else if (CE) S_AFF <= AX;",
        ),
        ({"SRUSEDMUX", "FFSYNC"}, "if (SR) S_AFF <= 1'b1; else S_AFF <= AX;"),
    ],
)
def test_a_register(features: set[str], statement: str) -> None:
    made, text = one_slice(features | {"AFFMUX.AX"}, {})
    assert made.output("AQ") == "S_AFF"
    assert text.clocked == {"posedge CLK": [statement]}
    assert text.declarations == [f"reg [0:0] S_AFF = 1'd{int('AFF.ZINI' not in features)};"]


@pytest.mark.parametrize(
    ("features", "pin", "message"),
    [
        ({"LATCH"}, "A", "latches are not decoded"),
        ({"SRUSEDMUX", "AFFMUX.AX"}, "AQ", "asynchronous resets are not decoded"),
        ({"ALUT.SRL", "ALUT.DI1MUX.AI", "ALUT.INIT[03]"}, "A", "begins with ones"),
        (set(), "AMUX", "AOUTMUX has 0 choices"),
    ],
)
def test_what_is_not_decoded_is_refused(features: set[str], pin: str, message: str) -> None:
    with pytest.raises(ToolError, match=message):
        one_slice(features, {})[0].output(pin)


def test_pins_of_blocks_are_after_their_inverters() -> None:
    """Pins of blocks are decoded after their inverters; a feature ``Z…`` is set if a pin is not
    inverted or a register is not used."""
    text = dsp("one", frozenset({"ZIS_INMODE_INVERTED[1]", "AREG_2", "ZMREG[0]"}), str.lower, "p")
    assert ".INMODE({~inmode4, ~inmode3, ~inmode2, inmode1, ~inmode0})" in text
    assert ".AREG(2), .BREG(1), .CREG(1), .MREG(0)" in text
    with pytest.raises(ToolError, match="USE_DPORT"):
        dsp("one", frozenset({"USE_DPORT[0]"}), str.lower, "p")
    features = {"READ_WIDTH_A_9", "WRITE_MODE_A_NO_CHANGE", "ZINV_ENARDEN", "INIT_01[002]"}
    text = ram_half("two", frozenset(features), str.lower, lambda _: True, "out")
    assert ".READ_WIDTH_A(9)" in text
    assert ".READ_WIDTH_B(1)" in text
    assert ".WRITE_MODE_A(2)" in text
    assert ".ENA(enarden), .ENB(~enbwren)" in text
    assert f".INIT(16384'h{1 << 258:x})" in text
    with pytest.raises(ToolError, match="FIFO_MODE"):
        ram_half("two", frozenset({"FIFO_MODE"}), str.lower, lambda _: True, "out")


def grid_of_two(folder: Path, bits: dict[int, frozenset[int]]) -> Routes:
    """Return the routes of two neighbouring tiles; a wire of the left tile is connected to one of
    the right tile."""
    family = folder / "zynq7"
    (family / "xc7z020").mkdir(parents=True)
    block = {"CLB_IO_CLK": {"baseaddr": "0x10", "frames": 1, "offset": 0, "words": 1}}
    grid = {
        "LEFT": {"type": "L", "grid_x": 0, "grid_y": 0, "bits": block},
        "RIGHT": {"type": "R", "grid_x": 1, "grid_y": 0, "bits": {}},
    }
    joints = [{"grid_deltas": [1, 0], "tile_types": ["L", "R"], "wire_pairs": [["END", "BEGIN"]]}]
    pip = {"is_directional": "1"}
    left = {
        "sites": [
            {
                "name": "X0Y0",
                "type": "TIEOFF",
                "prefix": "TIEOFF",
                "site_pins": {"HARD0": {"wire": "LOW"}, "HARD1": {"wire": "HIGH"}},
            }
        ],
        "pips": {
            name: {"dst_wire": name.split(".")[0], "src_wire": name.split(".")[1], **pip}
            for name in ("END.LOW", "END.ONE", "END.HIGH", "ONE.END")
        },
    }
    right = {"sites": [], "pips": {"PIN.BEGIN": {"dst_wire": "PIN", "src_wire": "BEGIN", **pip}}}
    directions = {"HARD0": {"direction": "OUT"}, "HARD1": {"direction": "OUT"}}
    for name, content in (
        ("xc7z020/tilegrid.json", json.dumps(grid)),
        ("xc7z020/tileconn.json", json.dumps(joints)),
        ("tile_type_L.json", json.dumps(left)),
        ("tile_type_R.json", json.dumps(right)),
        ("site_type_TIEOFF.json", json.dumps({"site_pins": directions})),
        ("segbits_l.db", "L.END.LOW 00_01 !00_02\nL.END.ONE 00_02 !00_01\nL.ONE.END 00_03\n"),
        ("ppips_l.db", "L.END.HIGH default\n"),
        ("ppips_r.db", "R.PIN.BEGIN always\n"),
    ):
        (family / name).write_text(content, encoding="ascii")
    return Routes(Features(Chip(family, PART), bits))


def test_a_wire_is_followed_through_tiles_to_what_drives_it(tmp_path: Path) -> None:
    """The feature that is set determines the driver of a wire; if none is set, it is the database's
    default."""
    driven = grid_of_two(tmp_path / "driven", {0x10: frozenset({1})})
    assert driven.source("RIGHT", "PIN") == Source(level=0)
    assert driven.features.unexplained() == []
    default = grid_of_two(tmp_path / "default", {})
    assert default.source("RIGHT", "PIN") == Source(level=1)
    assert default.source("LEFT", "ONE") is None


def test_bits_and_wires_that_cannot_be_are_reported(tmp_path: Path) -> None:
    strange = grid_of_two(tmp_path / "strange", {0x10: frozenset({1, 2})})
    assert strange.features.unexplained() == [
        f"frame 0x00000010 word 0 bit {bit}" for bit in (1, 2)
    ]
    circle = grid_of_two(tmp_path / "circle", {0x10: frozenset({2, 3})})
    with pytest.raises(ToolError, match="is driven by itself"):
        circle.source("RIGHT", "PIN")


@pytest.mark.parametrize("port", ["ARD", "BWR"])
def test_an_address_is_handed_on_where_the_cascade_is_active(tmp_path: Path, port: str) -> None:
    """A block RAM passes its address to its neighbour if Project X-Ray's feature
    ``CASCOUT_ARD_ACTIVE`` or ``CASCOUT_BWR_ACTIVE`` is set."""
    family = tmp_path / "zynq7"
    (family / "xc7z020").mkdir(parents=True)
    block = {"CLB_IO_CLK": {"baseaddr": "0x10", "frames": 1, "offset": 0, "words": 1}}
    grid = {"B": {"type": "B", "grid_x": 0, "grid_y": 0, "bits": block}}
    out = f"BRAM_CASCOUT_ADDR{port}ADDRU3"
    tile = {
        "sites": [
            {
                "name": "X0Y0",
                "type": "TIEOFF",
                "prefix": "TIEOFF",
                "site_pins": {"HARD1": {"wire": "HIGH"}},
            }
        ],
        "pips": {"one": {"dst_wire": out, "src_wire": "HIGH", "is_directional": "1"}},
    }
    for name, content in (
        ("xc7z020/tilegrid.json", json.dumps(grid)),
        ("xc7z020/tileconn.json", "[]"),
        ("tile_type_B.json", json.dumps(tile)),
        ("site_type_TIEOFF.json", json.dumps({"site_pins": {"HARD1": {"direction": "OUT"}}})),
        ("segbits_b.db", "B.CASCOUT_ARD_ACTIVE 00_01\nB.CASCOUT_BWR_ACTIVE 00_02\n"),
        ("ppips_b.db", f"B.{out}.HIGH always\n"),
    ):
        (family / name).write_text(content, encoding="ascii")
    bit = {"ARD": 1, "BWR": 2}[port]
    chip = Chip(family, PART)
    active = Routes(Features(chip, {0x10: frozenset({bit})}))
    assert active.source("B", out) == Source(level=1)
    other = Routes(Features(chip, {0x10: frozenset({3 - bit})}))
    assert other.source("B", out) is None


def test_an_assignment_of_a_signal_to_itself_is_dropped() -> None:
    """The assignment of a signal to itself is removed, because Verilator uses the first of two
    assignments."""
    written = (
        "module core\n"
        "  (input clock,\n"
        "   output armed);\n"
        "  wire armed;\n"
        "  wire strobe;\n"
        "  assign strobe = strobe; // (signal)\n"
        "  assign strobe = n1_o;\n"
        "  assign armed = strobe; //(module output)\n"
    )
    kept = without_repeats(written).splitlines()
    assert kept == [written.splitlines()[place] for place in (0, 1, 2, 4, 6, 7)]


def test_ports_of_the_processor_turn_round() -> None:
    """The ports of the PS7 change direction: an output of the PS7 is an input of the design."""
    module = {
        "ports": {
            "led": {"direction": "output", "bits": [2]},
            "sda": {"direction": "inout", "bits": [6]},
        },
        "cells": {
            "ps7": {
                "type": "PS7",
                "port_directions": {"FCLKCLK": "output", "MAXIGP0RVALID": "input"},
                "connections": {"FCLKCLK": [3, 4], "MAXIGP0RVALID": [5]},
            }
        },
    }
    lines = {(port.name, port.is_input): port.lines() for port in ports_of(module)}
    assert lines == {
        ("FCLKCLK", True): ["FCLKCLK0", "FCLKCLK1"],
        ("led", False): ["led"],
        ("sda", True): ["sda"],
        ("sda", False): ["sda"],
        ("MAXIGP0RVALID", False): ["MAXIGP0RVALID"],
    }


def test_what_was_not_tested_is_a_fault() -> None:
    figures = {"clocks": 1, "different": 0, "outputs": 2, "moved_outputs": 1}
    assert bitstream_verify.faults_of(Compared([], [], figures)) == []
    still = Compared(["clock 3: a is 1, expected 0"], ["DSP_R"], {**figures, "different": 4})
    assert [fault.split(":")[0] for fault in bitstream_verify.faults_of(still)] == [
        "4 words of outputs differ",
        "never moved, so not tested",
    ]
    constant = Compared([], ["CLBLM_R_X63Y71_0_Ao6"], figures)
    assert len(bitstream_verify.faults_of(constant)) == 1
    assert bitstream_verify.faults_of(constant, are_rams_written=False) == []
    assert len(bitstream_verify.faults_of(still, are_rams_written=False)) == 2
    assert bitstream_verify.faults_of(Compared([], [], {**figures, "moved_outputs": 0})) == [
        "no output ever moved, so nothing was tested"
    ]


def test_a_bitstream_that_is_not_there_is_reported(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert bitstream_verify.main(["--folder", str(tmp_path)]) == 2
    assert "arctrue.bit is missing: make bitstream FLOW=open" in capsys.readouterr().err


def test_a_wire_is_left_or_pulled_low_at_the_port_itself() -> None:
    """GHDL puts wires between the inout port and its driver; only the first assignment is replaced
    by the driver's expression, all other lines stay."""
    written = (
        "  assign scl = n2_oport; //(module output)\n"
        "  assign n2_oport = n103_o; // (inout - port)\n"
        "  assign n2_o = scl; // (inout - read)\n"
        "  assign n103_o = scl_low ? 1'b0 : 1'bz;\n"
        "  assign led = n1_o; //(module output)\n"
    )
    lines = direct_tristates(written).splitlines()
    assert lines[0] == "  assign scl = scl_low ? 1'b0 : 1'bz; //(module output)"
    assert lines[1:] == written.splitlines()[1:]
