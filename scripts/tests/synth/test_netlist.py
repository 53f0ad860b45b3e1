"""Tests that GHDL and Yosys accept small entities, and refuse faulty entities."""

from __future__ import annotations

from pathlib import Path

import pytest

from scripts import synth
from scripts.netlist import (
    ROOT,
    ToolError,
    find_ghdl,
    find_yosys,
    sources_of,
    synthesise,
    write_netlist,
)
from scripts.resources import Design
from scripts.tests.synth.tools import tools_missing

MISSING = tools_missing(find_ghdl, find_yosys)
needs_tools = pytest.mark.skipif(bool(MISSING), reason=MISSING)

LATCH = """
library ieee;
  use ieee.std_logic_1164.all;

entity latch is
  port (a, enable : in std_ulogic; b : out std_ulogic);
end entity latch;

architecture rtl of latch is
begin
  process (all) is
  begin
    if enable = '1' then
      b <= a;
    end if;
  end process;
end architecture rtl;
"""

# GHDL names the output of an instance <label>_<port>; here this name equals the name of a port of
# the outer entity.
INNER = """
library ieee;
  use ieee.std_logic_1164.all;

entity inner is
  port (clock, a : in std_ulogic; busy : out std_ulogic);
end entity inner;

architecture rtl of inner is
begin
  busy <= a when rising_edge(clock);
end architecture rtl;
"""
CLASH = """
library ieee;
  use ieee.std_logic_1164.all;

entity clash is
  port (clock, a : in std_ulogic; ramp_busy : out std_ulogic);
end entity clash;

architecture rtl of clash is
  signal busy : std_ulogic;
begin
  ramp : entity work.inner port map (clock => clock, a => a, busy => busy);
  ramp_busy <= busy when rising_edge(clock);
end architecture rtl;
"""


@pytest.mark.large
@needs_tools
def test_phase_lane_takes_three_multipliers(tmp_path: Path) -> None:
    netlist = write_netlist("phase_lane", tmp_path / "made")
    lane = Design.read(synthesise(netlist, flatten=True)).total("phase_lane")
    assert lane.dsp == 3  # 24 x 48 bits in 3 DSP48E1: K split into 17 + 17 + 14
    assert lane.ff > 0
    assert lane.latches == 0


@pytest.mark.large
@needs_tools
def test_folded_lanes_share_their_multipliers(tmp_path: Path) -> None:
    netlist = write_netlist(
        "compensation_pipeline", tmp_path / "made", generics={"LANES": 2, "FOLD": 2}
    )
    assert Design.read(synthesise(netlist, flatten=True)).total("compensation_pipeline").dsp == 4


@pytest.mark.large
@needs_tools
def test_report_of_a_small_entity(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    folder = tmp_path / "made"
    assert synth.main(["--entity", "glitch_filter", "-g", "width=2", "--output", str(folder)]) == 0
    text = capsys.readouterr().out
    assert "glitch_filter (WIDTH = 2), GHDL" in text
    assert "all budgets kept" in text
    assert (folder / "resources.json").exists()
    assert (folder / "resources.md").read_text(encoding="utf-8") in text


@needs_tools
def test_a_latch_is_refused(tmp_path: Path) -> None:
    (tmp_path / "latch.vhd").write_text(LATCH, encoding="utf-8")
    # Either GHDL or Yosys warns of the fault or refuses the design.
    with pytest.raises(ToolError, match=r"(?i)latch"):
        synthesise(write_netlist("latch", tmp_path / "made", folders=[tmp_path]), flatten=True)


@pytest.mark.large
@needs_tools
def test_two_drivers_of_one_net_are_refused(tmp_path: Path) -> None:
    for name, text in (("inner", INNER), ("clash", CLASH)):
        (tmp_path / f"{name}.vhd").write_text(text, encoding="utf-8")
    with pytest.raises(ToolError, match="conflicting drivers"):
        synthesise(write_netlist("clash", tmp_path / "made", folders=[tmp_path]), flatten=False)


def test_sources_of_the_core() -> None:
    names = {path.stem for path in sources_of("arctrue_core")}
    assert {"arctrue_core", "arctrue_registers", "cordic_pkg", "number_formats_pkg"} <= names
    with pytest.raises(ToolError, match=r"no missing\.vhd"):
        sources_of("missing")


@pytest.mark.parametrize("version", ["2.0.0", "4.1.0"])
def test_an_old_ghdl_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, version: str
) -> None:
    old = tmp_path / "ghdl"
    old.write_text(f"#!/bin/sh\necho 'GHDL {version} (Debian)'\n", encoding="utf-8")
    old.chmod(0o755)
    monkeypatch.setenv("GHDL_NETLIST", str(old))
    with pytest.raises(ToolError, match=rf"5\.0 or newer; found .*GHDL {version}.*install_ghdl"):
        find_ghdl()


def test_without_yosys_the_command_says_what_to_do(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("YOSYS", "no-such-yosys")
    monkeypatch.setattr(synth, "find_ghdl", lambda: ("ghdl", "GHDL 5"))
    assert synth.main(["--entity", "glitch_filter", "--output", str(ROOT / "build/none")]) == 2
    assert "Yosys is missing" in capsys.readouterr().err
