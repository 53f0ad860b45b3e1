"""Tests the longest paths, and the rule that a path has at most one wide adder, with handwritten
netlists and small entities."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from scripts import cell_delays as delays
from scripts import timing
from scripts.cell_delays import timing_of, wire_ns
from scripts.netlist import synthesise, write_netlist
from scripts.tests.synth.test_netlist import needs_tools
from scripts.timing_paths import WIDE_CARRY4, Netlist, crowded_registers, longest_paths

TWO_ADDERS = """
library ieee;
  use ieee.std_logic_1164.all;
  use ieee.numeric_std.all;

entity two_adders is
  port (
    clock  : in  std_ulogic;
    a, b   : in  u_unsigned(23 downto 0);
    c      : out u_unsigned(23 downto 0)
  );
end entity two_adders;

architecture rtl of two_adders is
  signal a_1, b_1 : u_unsigned(23 downto 0);
begin
  process (clock) is
  begin
    if rising_edge(clock) then
      a_1 <= a;
      b_1 <= b;
      c   <= ((a_1 + b_1) xor a_1) + b_1;
    end if;
  end process;
end architecture rtl;
"""


def cell(
    kind: str, inputs: dict[str, Any], outputs: dict[str, Any], **given: str
) -> dict[str, Any]:
    return {
        "type": kind,
        "parameters": given,
        "port_directions": dict.fromkeys(inputs, "input") | dict.fromkeys(outputs, "output"),
        "connections": inputs | outputs,
    }


def flip_flop(data: int, output: int) -> dict[str, Any]:
    return cell("FDRE", {"C": [1], "CE": ["1"], "D": [data], "R": ["0"]}, {"Q": [output]})


def chain(first_bit: int, operand: int, length: int) -> list[dict[str, Any]]:
    """Return a carry chain whose lowest bit adds ``operand``; the net of its last sum is first_bit
    + 1."""
    cells = []
    carry: int | str = "0"
    for place in range(length):
        carry_out = first_bit + 2 + place
        last = place == length - 1
        cells.append(
            cell(
                "CARRY4",
                {
                    "CI": [carry],
                    "CYINIT": ["0"],
                    "DI": ["0"] * 4,
                    "S": [operand if place == 0 else "0", "0", "0", "0"],
                },
                {
                    "O": ["x", "x", "x", first_bit + 1 if last else "x"],
                    "CO": ["x", "x", "x", carry_out],
                },
            )
        )
        carry = carry_out
    return cells


def read(path: Path, cells: list[dict[str, Any]], names: dict[str, list[int]]) -> Netlist:
    module = {
        "cells": {f"c{number}": one for number, one in enumerate(cells)},
        "netnames": {name: {"bits": bits} for name, bits in names.items()},
    }
    file = path / "made.json"
    file.write_text(json.dumps({"modules": {"made": module}}), encoding="utf-8")
    return Netlist.read(file, "made")


def test_delay_of_a_path_is_the_sum_of_its_parts(tmp_path: Path) -> None:
    lut = cell("LUT2", {"I0": [10], "I1": [10]}, {"O": [11]})
    cells = [flip_flop(99, 10), lut, *chain(20, 11, WIDE_CARRY4), flip_flop(21, 50)]
    netlist = read(tmp_path, cells, {"given": [10], "n12_o": [10], "sum": [50]})
    (path,) = longest_paths(netlist, netlist.reached())
    assert (path.start, path.end) == ("given", "sum")
    assert (path.levels, path.carry4, path.wires) == (1, WIDE_CARRY4, 3)
    expected = (
        delays.FLIP_FLOP_OUT_NS
        + delays.LUT_NS
        + delays.CARRY_ENTER_NS
        + (WIDE_CARRY4 - 2) * delays.CARRY_THROUGH_NS
        + delays.CARRY_IN_TO_SUM_NS
        + 3 * wire_ns(1)
    )
    assert path.delay_ns == pytest.approx(expected)
    assert crowded_registers(netlist, netlist.reached()) == []


def test_no_wire_from_a_lut_to_the_multiplexer_next_to_it(tmp_path: Path) -> None:
    lut = cell("LUT1", {"I0": [10]}, {"O": [11]})
    multiplexer = cell("MUXF7", {"I0": [11], "I1": ["0"], "S": ["0"]}, {"O": [12]})
    netlist = read(tmp_path, [flip_flop(99, 10), lut, multiplexer, flip_flop(12, 50)], {})
    (path,) = longest_paths(netlist, netlist.reached())
    assert path.wires == 2
    expected = delays.FLIP_FLOP_OUT_NS + delays.LUT_NS + delays.MULTIPLEXER_NS + 2 * wire_ns(1)
    assert path.delay_ns == pytest.approx(expected)


@pytest.mark.parametrize(
    ("first", "second", "adders"),
    [(WIDE_CARRY4, WIDE_CARRY4, 2), (WIDE_CARRY4, WIDE_CARRY4 - 1, 1), (1, WIDE_CARRY4, 1)],
)
def test_only_wide_adders_in_a_row_are_counted(
    tmp_path: Path, first: int, second: int, adders: int
) -> None:
    cells = [
        flip_flop(99, 10),
        *chain(20, 10, first),
        cell("LUT1", {"I0": [21]}, {"O": [31]}),
        *chain(40, 31, second),
        flip_flop(41, 60),
    ]
    netlist = read(tmp_path, cells, {"given": [10], "sum": [60]})
    found = crowded_registers(netlist, netlist.reached())
    assert [(entry.start, entry.end, entry.adders) for entry in found] == (
        [("given", "sum", 2)] if adders == 2 else []
    )


def test_logic_that_feeds_itself_is_refused(tmp_path: Path) -> None:
    """The error names the loop of logic, but not the registers before and after the loop."""
    cells = [
        flip_flop(99, 10),
        cell("LUT2", {"I0": [10], "I1": [12]}, {"O": [11]}),
        cell("LUT1", {"I0": [11]}, {"O": [12]}),
        cell("LUT1", {"I0": [12]}, {"O": [13]}),
        flip_flop(13, 50),
    ]
    netlist = read(tmp_path, cells, {"asked": [11], "allowed": [12], "after": [13]})
    with pytest.raises(ValueError, match="feeds itself") as raised:
        netlist.reached()
    loop = str(raised.value).partition(": ")[2].split(" -> ")
    assert loop[0] == loop[-1]
    assert sorted(loop[1:]) == ["allowed", "asked"]


@pytest.mark.parametrize(("sum_register", "adders"), [("0", 2), ("1", 1)])
def test_the_register_after_an_adder_of_a_dsp_counts(
    tmp_path: Path, sum_register: str, adders: int
) -> None:
    def dsp(c: list[Any], p: list[Any], **given: str) -> dict[str, Any]:
        ports = {"A": [3, 4], "B": [5], "C": c, "CLK": [1]}
        return cell("DSP48E1", ports, {"P": p}, AREG="1", BREG="1", MREG="1", **given)

    cells = [dsp(["0"], [10], PREG=sum_register), dsp([10], [11], PREG="1")]
    cells += [flip_flop(90 + bit, bit) for bit in (3, 4, 5)]
    netlist = read(tmp_path, cells, {"low": [10], "middle": [11]})
    found = crowded_registers(netlist, netlist.reached())
    assert [entry.adders for entry in found] == ([2] if adders == 2 else [])


def test_an_unknown_cell_is_refused() -> None:
    with pytest.raises(ValueError, match=r"type GTXE2.*scripts/cell_delays\.py"):
        timing_of(cell("GTXE2", {}, {}))


def test_an_exception_needs_its_name() -> None:
    entry = timing.Crowded("a", "unit.slow_sum", 2)
    assert timing.split_exceptions([entry], ()) == ([entry], [])
    reason = ("slow_sum$", "It stands still while it is used.")
    assert timing.split_exceptions([entry], (reason,)) == ([], [(entry, reason[1])])
    assert timing.split_exceptions([entry], (("other", ""),)) == ([entry], [])


@pytest.mark.large
@needs_tools
def test_two_adders_in_a_row_are_reported(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "two_adders.vhd").write_text(TWO_ADDERS, encoding="utf-8")
    netlist = synthesise(
        write_netlist("two_adders", tmp_path / "made", folders=[tmp_path]), flatten=True
    )
    assert timing.main(["--entity", "two_adders", "--netlist", str(netlist)]) == 1
    printed = capsys.readouterr()
    assert "2 wide adders or DSPs on a path from" in printed.err
    assert "put a register between them" in printed.err
    assert (tmp_path / "made" / "timing.md").read_text(encoding="utf-8") in printed.out


@needs_tools
@pytest.mark.parametrize(
    "entity", [pytest.param("phase_lane", marks=pytest.mark.large), "position_compare"]
)
def test_a_unit_keeps_to_one_adder_and_to_200_mhz(
    entity: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    made = str(tmp_path / "made")
    assert timing.main(["--entity", entity, "--output", made, "--limit", "5"]) == 0
    assert "0 without a reason" in capsys.readouterr().out
    # Every path is longer than this limit, so the program must report it.
    netlist = str(tmp_path / "made" / f"{entity}.flat.json")
    assert timing.main(["--entity", entity, "--netlist", netlist, "--limit", "0.5"]) == 1
    assert "expected 0.5 ns at the most" in capsys.readouterr().err


@needs_tools
@pytest.mark.large
def test_no_core_feeds_itself(tmp_path: Path) -> None:
    """The core with every unit has no loop of logic: each register has a longest path."""
    built = dict.fromkeys(
        ("FAILOVER", "MODULATORS", "REAL_ORDERS", "LOCAL_TABLE", "EVENTS"), "true"
    )
    generics: dict[str, int | str] = {"LANES": 2, "CAPTURE_DEPTH": 16, "HEADS": 4, **built}
    written = write_netlist("arctrue_core", tmp_path / "made", generics=generics)
    netlist = Netlist.read(synthesise(written, flatten=True), "arctrue_core")
    assert longest_paths(netlist, netlist.reached())
