"""A top level with the processor that is small, and its netlist by the real GHDL and Yosys."""

from __future__ import annotations

from pathlib import Path

from scripts.bitstream_job import Top
from scripts.netlist import (
    SOURCE_FOLDERS,
    ToolError,
    find_ghdl,
    find_yosys,
    synthesise,
    write_netlist,
)

SMALL_TOP = Top("small_zynq_top", 100, {"PS7": 1, "BUFG": 1})
# The processor side with something behind it that is small: what is written is read back.
VHDL = """
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


def netlist_of_small_top(folder: Path) -> Path:
    """Mapped to the chip's cells."""
    source = folder / "source"
    source.mkdir()
    (source / f"{SMALL_TOP.name}.vhd").write_text(VHDL, encoding="utf-8")
    verilog = write_netlist(SMALL_TOP.name, folder / "made", folders=[*SOURCE_FOLDERS, source])
    return synthesise(verilog, flatten=True)


def tools_missing() -> str:
    try:
        find_ghdl()
        find_yosys()
    except ToolError as error:
        return str(error)
    return ""
