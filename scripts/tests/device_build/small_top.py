"""Defines a small top level with the processor, and makes its netlist with the real GHDL and
Yosys."""

from __future__ import annotations

from pathlib import Path

from scripts.bitstream_job import Top
from scripts.netlist import (
    SOURCE_FOLDERS,
    synthesise,
    write_netlist,
)

LUT_RAMS = {"RAM32M": 3, "RAM64M": 2, "RAM128X1D": 2}
SMALL_TOP = Top(
    "small_zynq_top",
    100,
    {"PS7": 1, "BUFG": 1, "DSP48E1": 1, "RAMB18E1": 1, **LUT_RAMS},
    vivado="",  # this top level is built with the open flow only
    has_core=False,
)
# The VHDL contains the processor's wrapper and, on its bus, one cell of each kind. A write goes to
# a block RAM with contents and to memories of 16, 64 and 128 words in look-up tables. A DSP
# multiplies a word of the block RAM, and a shift register requests an interrupt.
VHDL = """
library ieee;
  use ieee.std_logic_1164.all;
  use ieee.numeric_std.all;
  use work.axi_lite_pkg.all;

entity small_zynq_top is
  port (led_alive, led_written : out std_ulogic; scl, sda : inout std_logic);
end entity small_zynq_top;

architecture rtl of small_zynq_top is
  constant WORDS : positive := 1024;
  type memory_type is array (0 to WORDS - 1) of std_ulogic_vector(17 downto 0);
  function squares return memory_type is
    variable contents : memory_type;
  begin
    for word in contents'range loop
      contents(word) := std_ulogic_vector(to_unsigned(word * word mod 2 ** 18, 18));
    end loop;
    return contents;
  end function squares;
  signal memory : memory_type := squares;
  type words_16 is array (0 to 15) of std_ulogic_vector(15 downto 0);
  type words_64 is array (0 to 63) of std_ulogic_vector(5 downto 0);
  type words_128 is array (0 to 127) of std_ulogic_vector(1 downto 0);
  signal memory_16 : words_16 := (others => (others => '0'));
  signal memory_64 : words_64 := (others => (others => '0'));
  signal memory_128 : words_128 := (others => (others => '0'));
  signal read_16 : std_ulogic_vector(15 downto 0);
  signal read_64 : std_ulogic_vector(5 downto 0);
  signal read_128, replaced_128 : std_ulogic_vector(1 downto 0);
  signal clock, reset, scl_low, sda_low : std_ulogic;
  signal request : axi_lite_request;
  signal response : axi_lite_response;
  signal word : std_ulogic_vector(31 downto 0);
  signal read : std_ulogic_vector(17 downto 0);
  signal factor1 : signed(24 downto 0) := (others => '0');
  signal factor2 : signed(17 downto 0) := (others => '0');
  signal product : signed(42 downto 0) := (others => '0');
  signal sum : signed(47 downto 0) := (others => '0');
  signal delayed : std_ulogic_vector(31 downto 0) := (others => '0');
begin
  scl <= '0' when scl_low = '1' else 'Z';
  sda <= '0' when sda_low = '1' else 'Z';
  processor : entity work.zynq_processor
    port map (
      scl => scl, scl_low => scl_low, sda => sda, sda_low => sda_low,
      clock => clock, reset => reset, interrupt => delayed(31),
      m_axil_request => request, m_axil_response => response);
  response.awready <= '1';
  response.wready <= '1';
  response.bresp <= "00";
  response.arready <= '1';
  response.rresp <= "00";
  process (clock) is
  begin
    if rising_edge(clock) then
      response.bvalid <= request.awvalid and request.wvalid;
      response.rvalid <= request.arvalid;
      read <= memory(to_integer(unsigned(request.araddr(11 downto 2))));
      read_16 <= memory_16(to_integer(unsigned(request.araddr(5 downto 2))));
      read_64 <= memory_64(to_integer(unsigned(request.araddr(7 downto 2))));
      read_128 <= memory_128(to_integer(unsigned(request.araddr(8 downto 2))));
      replaced_128 <= memory_128(to_integer(unsigned(request.awaddr(8 downto 2))));
      if request.wvalid = '1' then
        word <= request.wdata;
        memory(to_integer(unsigned(request.awaddr(11 downto 2)))) <= request.wdata(17 downto 0);
        memory_16(to_integer(unsigned(request.awaddr(5 downto 2)))) <= request.wdata(15 downto 0);
        memory_64(to_integer(unsigned(request.awaddr(7 downto 2)))) <= request.wdata(21 downto 16);
        memory_128(to_integer(unsigned(request.awaddr(8 downto 2)))) <= request.wdata(23 downto 22);
      end if;
      factor1 <= signed(word(24 downto 0));
      factor2 <= signed(read);
      product <= factor1 * factor2;
      sum <= resize(product, 48) + signed(word);
      delayed <= delayed(30 downto 0) & word(1);
      case request.araddr(13 downto 12) is
        when "00" => response.rdata <= std_ulogic_vector(sum(31 downto 0));
        when "01" => response.rdata <= word(15 downto 0) & std_ulogic_vector(sum(47 downto 32));
        when "10" => response.rdata <= std_ulogic_vector(resize(signed(read), 32));
        when others => response.rdata <= "000000" & replaced_128 & read_128 & read_64 & read_16;
      end case;
    end if;
  end process;
  leds : entity work.status_leds
    port map (
      clock => clock, reset => reset, capturing => word(0), fault => '0', compensating => '0',
      led_alive => led_alive, led_capture => led_written, led_fault => open,
      led_compensation => open);
end architecture rtl;
"""
PINS = "".join(
    f"set_property LOC {pin} [get_ports {port}]\n"
    f"set_property IOSTANDARD LVCMOS33 [get_ports {port}]\n"
    for port, pin in {
        "led_alive": "R14",
        "led_written": "P14",
        "scl": "P16",
        "sda": "P15",
    }.items()
)


def netlist_of_small_top(folder: Path) -> Path:
    """Return the path of the netlist of the small top level, mapped to the chip's cells."""
    source = folder / "source"
    source.mkdir()
    (source / f"{SMALL_TOP.name}.vhd").write_text(VHDL, encoding="utf-8")
    verilog = write_netlist(SMALL_TOP.name, folder / "made", folders=[*SOURCE_FOLDERS, source])
    return synthesise(verilog, flatten=True, for_nextpnr=True)
