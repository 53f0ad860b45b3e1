-- SPDX-License-Identifier: Apache-2.0
--
-- # zynq_processor
--
-- Wraps the processor of a Zynq-7000 for the fabric: provides clock and reset from FCLK 0 and the registers' bus from
-- M_AXI_GP0, and connects one interrupt line to the processor. The entity instantiates the primitive PS7 directly,
-- without a block design; the pins of PS7 (DDR, MIO, crystal) are wired inside the chip, and the firmware sets them up.
-- Source: Zynq-7000 technical reference manual (UG585), chapters 2, 5, 7, 20 and 25.
--
-- **Latency.** See axi3_to_axi_lite for the bus and reset_release for the reset.
--
-- **Number formats.** Addresses on the AXI4-Lite bus are in bytes, counted from 0x4000_0000.
--
-- **Clock.** The clock is FCLK 0 through one global buffer; the firmware sets it to 100 MHz. M_AXI_GP0 runs on this
-- clock too.
--
-- **Interrupt.** `interrupt` is level sensitive and goes to IRQF2P(0), which is interrupt 61 of the
-- generic interrupt controller. The other lines stay low.
--
-- **I2C.** The signals of the processor's I2C controller 0 go through the fabric (EMIO). While `scl_low` (`sda_low`) is
-- high, the top level must pull the wire SCL (SDA) low; it must never drive a wire high. PS7's outputs …TN are
-- active-low tri-state controls: while …TN is 1, the pin is driven with the level of …O. The general-purpose pins 54
-- (SCL) and 55 (SDA) of the processor are connected to the same wires: if a device holds SDA low, the firmware sends
-- clock pulses with these pins until the device releases SDA.
--
-- **Reset** is FCLKRESETN(0), which software sets (FPGA_RST_CTRL). Software must not begin the reset during an access
-- to the registers: the access would get no answer, and the processor would wait for ever. The output `reset` ends
-- RESET_CLOCKS + 3 clocks after FCLKRESETN(0) has risen (reset_release); an access that begins before this end waits
-- for it.
--
-- **Write data.** The entity assigns write data to write addresses in the order of the addresses, and ignores WID.

library ieee;
  use ieee.std_logic_1164.all;

  use work.axi_lite_pkg.all;

entity zynq_processor is
  generic (
    RESET_CLOCKS : positive range 1 to 65535 := 64 -- clocks of reset after the processor's reset, see reset_release
  );
  port (
    clock           : out   std_ulogic;
    reset           : out   std_ulogic;
    interrupt       : in    std_ulogic; -- level
    -- I2C bus, both wires with a pull-up
    scl             : in    std_ulogic;
    scl_low         : out   std_ulogic; -- 1 pulls low
    sda             : in    std_ulogic;
    sda_low         : out   std_ulogic; -- 1 pulls low
    -- AXI4-Lite master, see axi_lite_pkg
    m_axil_request  : out   axi_lite_request;
    m_axil_response : in    axi_lite_response
  );
end entity zynq_processor;

architecture rtl of zynq_processor is

  constant ID_WIDTH : positive := 12;

  -- Primitives of the 7 series, named as the vendor's and the open tools' libraries name them. Inputs that are not
  -- listed here stay open; the vendor's and the open tools tie them to 0.
  -- vsg_off
  component PS7 is
    port (
      EMIOGPIOI       : in    std_ulogic_vector(63 downto 0);
      EMIOGPIOO       : out   std_ulogic_vector(63 downto 0);
      EMIOGPIOTN      : out   std_ulogic_vector(63 downto 0);
      EMIOI2C0SCLI    : in    std_ulogic;
      EMIOI2C0SCLO    : out   std_ulogic;
      EMIOI2C0SCLTN   : out   std_ulogic;
      EMIOI2C0SDAI    : in    std_ulogic;
      EMIOI2C0SDAO    : out   std_ulogic;
      EMIOI2C0SDATN   : out   std_ulogic;
      FCLKCLK         : out   std_ulogic_vector(3 downto 0);
      FCLKRESETN      : out   std_ulogic_vector(3 downto 0);
      IRQF2P          : in    std_ulogic_vector(19 downto 0);
      MAXIGP0ACLK     : in    std_ulogic;
      MAXIGP0AWVALID  : out   std_ulogic;
      MAXIGP0AWREADY  : in    std_ulogic;
      MAXIGP0AWID     : out   std_ulogic_vector(11 downto 0);
      MAXIGP0AWADDR   : out   std_ulogic_vector(31 downto 0);
      MAXIGP0AWLEN    : out   std_ulogic_vector(3 downto 0);
      MAXIGP0AWSIZE   : out   std_ulogic_vector(1 downto 0);
      MAXIGP0AWBURST  : out   std_ulogic_vector(1 downto 0);
      MAXIGP0WVALID   : out   std_ulogic;
      MAXIGP0WREADY   : in    std_ulogic;
      MAXIGP0WDATA    : out   std_ulogic_vector(31 downto 0);
      MAXIGP0WSTRB    : out   std_ulogic_vector(3 downto 0);
      MAXIGP0WLAST    : out   std_ulogic;
      MAXIGP0BVALID   : in    std_ulogic;
      MAXIGP0BREADY   : out   std_ulogic;
      MAXIGP0BID      : in    std_ulogic_vector(11 downto 0);
      MAXIGP0BRESP    : in    std_ulogic_vector(1 downto 0);
      MAXIGP0ARVALID  : out   std_ulogic;
      MAXIGP0ARREADY  : in    std_ulogic;
      MAXIGP0ARID     : out   std_ulogic_vector(11 downto 0);
      MAXIGP0ARADDR   : out   std_ulogic_vector(31 downto 0);
      MAXIGP0ARLEN    : out   std_ulogic_vector(3 downto 0);
      MAXIGP0ARSIZE   : out   std_ulogic_vector(1 downto 0);
      MAXIGP0ARBURST  : out   std_ulogic_vector(1 downto 0);
      MAXIGP0RVALID   : in    std_ulogic;
      MAXIGP0RREADY   : out   std_ulogic;
      MAXIGP0RID      : in    std_ulogic_vector(11 downto 0);
      MAXIGP0RDATA    : in    std_ulogic_vector(31 downto 0);
      MAXIGP0RRESP    : in    std_ulogic_vector(1 downto 0);
      MAXIGP0RLAST    : in    std_ulogic
    );
  end component PS7;

  component BUFG is
    port (
      I : in    std_ulogic;
      O : out   std_ulogic
    );
  end component BUFG;
  -- vsg_on

  signal fabric_clock   : std_ulogic;
  signal fabric_clocks  : std_ulogic_vector(3 downto 0);
  signal fabric_resetn  : std_ulogic_vector(3 downto 0);
  signal fabric_reset   : std_ulogic;
  signal interrupt_line : std_ulogic_vector(19 downto 0);
  signal pin_levels     : std_ulogic_vector(63 downto 0);
  signal pin_values     : std_ulogic_vector(63 downto 0);
  signal pin_drives     : std_ulogic_vector(63 downto 0);
  signal scl_value      : std_ulogic;
  signal scl_drives     : std_ulogic;
  signal sda_value      : std_ulogic;
  signal sda_drives     : std_ulogic;

  signal awvalid : std_ulogic;
  signal awready : std_ulogic;
  signal awid    : std_ulogic_vector(ID_WIDTH - 1 downto 0);
  signal awaddr  : std_ulogic_vector(31 downto 0);
  signal awlen   : std_ulogic_vector(3 downto 0);
  signal awsize  : std_ulogic_vector(2 downto 0);
  signal awburst : std_ulogic_vector(1 downto 0);
  signal wvalid  : std_ulogic;
  signal wready  : std_ulogic;
  signal wdata   : std_ulogic_vector(31 downto 0);
  signal wstrb   : std_ulogic_vector(3 downto 0);
  signal wlast   : std_ulogic;
  signal bvalid  : std_ulogic;
  signal bready  : std_ulogic;
  signal bid     : std_ulogic_vector(ID_WIDTH - 1 downto 0);
  signal bresp   : std_ulogic_vector(1 downto 0);
  signal arvalid : std_ulogic;
  signal arready : std_ulogic;
  signal arid    : std_ulogic_vector(ID_WIDTH - 1 downto 0);
  signal araddr  : std_ulogic_vector(31 downto 0);
  signal arlen   : std_ulogic_vector(3 downto 0);
  signal arsize  : std_ulogic_vector(2 downto 0);
  signal arburst : std_ulogic_vector(1 downto 0);
  signal rvalid  : std_ulogic;
  signal rready  : std_ulogic;
  signal rid     : std_ulogic_vector(ID_WIDTH - 1 downto 0);
  signal rdata   : std_ulogic_vector(31 downto 0);
  signal rresp   : std_ulogic_vector(1 downto 0);
  signal rlast   : std_ulogic;

begin

  clock          <= fabric_clock;
  reset          <= fabric_reset;
  interrupt_line <= (0 => interrupt, others => '0');
  awsize(2)      <= '0';
  arsize(2)      <= '0';
  pin_levels     <= (0 => scl, 1 => sda, others => '0');
  scl_low        <= (scl_drives and not scl_value) or (pin_drives(0) and not pin_values(0));
  sda_low        <= (sda_drives and not sda_value) or (pin_drives(1) and not pin_values(1));

  -- vsg_off
  ps7_primitive : component PS7
    port map (
      EMIOGPIOI       => pin_levels,
      EMIOGPIOO       => pin_values,
      EMIOGPIOTN      => pin_drives,
      EMIOI2C0SCLI    => scl,
      EMIOI2C0SCLO    => scl_value,
      EMIOI2C0SCLTN   => scl_drives,
      EMIOI2C0SDAI    => sda,
      EMIOI2C0SDAO    => sda_value,
      EMIOI2C0SDATN   => sda_drives,
      FCLKCLK         => fabric_clocks,
      FCLKRESETN      => fabric_resetn,
      IRQF2P          => interrupt_line,
      MAXIGP0ACLK     => fabric_clock,
      MAXIGP0AWVALID  => awvalid,
      MAXIGP0AWREADY  => awready,
      MAXIGP0AWID     => awid,
      MAXIGP0AWADDR   => awaddr,
      MAXIGP0AWLEN    => awlen,
      MAXIGP0AWSIZE   => awsize(1 downto 0),
      MAXIGP0AWBURST  => awburst,
      MAXIGP0WVALID   => wvalid,
      MAXIGP0WREADY   => wready,
      MAXIGP0WDATA    => wdata,
      MAXIGP0WSTRB    => wstrb,
      MAXIGP0WLAST    => wlast,
      MAXIGP0BVALID   => bvalid,
      MAXIGP0BREADY   => bready,
      MAXIGP0BID      => bid,
      MAXIGP0BRESP    => bresp,
      MAXIGP0ARVALID  => arvalid,
      MAXIGP0ARREADY  => arready,
      MAXIGP0ARID     => arid,
      MAXIGP0ARADDR   => araddr,
      MAXIGP0ARLEN    => arlen,
      MAXIGP0ARSIZE   => arsize(1 downto 0),
      MAXIGP0ARBURST  => arburst,
      MAXIGP0RVALID   => rvalid,
      MAXIGP0RREADY   => rready,
      MAXIGP0RID      => rid,
      MAXIGP0RDATA    => rdata,
      MAXIGP0RRESP    => rresp,
      MAXIGP0RLAST    => rlast
    );

  clock_buffer : component BUFG
    port map (
      I => fabric_clocks(0),
      O => fabric_clock
    );
  -- vsg_on

  reset_hold : entity work.reset_release
    generic map (
      CLOCKS => RESET_CLOCKS
    )
    port map (
      clock                => fabric_clock,
      asynchronous_reset_n => fabric_resetn(0),
      reset                => fabric_reset
    );

  bridge : entity work.axi3_to_axi_lite
    generic map (
      ID_WIDTH => ID_WIDTH
    )
    port map (
      clock           => fabric_clock,
      reset           => fabric_reset,
      s_axi_awvalid   => awvalid,
      s_axi_awready   => awready,
      s_axi_awid      => awid,
      s_axi_awaddr    => awaddr,
      s_axi_awlen     => awlen,
      s_axi_awsize    => awsize,
      s_axi_awburst   => awburst,
      s_axi_wvalid    => wvalid,
      s_axi_wready    => wready,
      s_axi_wdata     => wdata,
      s_axi_wstrb     => wstrb,
      s_axi_wlast     => wlast,
      s_axi_bvalid    => bvalid,
      s_axi_bready    => bready,
      s_axi_bid       => bid,
      s_axi_bresp     => bresp,
      s_axi_arvalid   => arvalid,
      s_axi_arready   => arready,
      s_axi_arid      => arid,
      s_axi_araddr    => araddr,
      s_axi_arlen     => arlen,
      s_axi_arsize    => arsize,
      s_axi_arburst   => arburst,
      s_axi_rvalid    => rvalid,
      s_axi_rready    => rready,
      s_axi_rid       => rid,
      s_axi_rdata     => rdata,
      s_axi_rresp     => rresp,
      s_axi_rlast     => rlast,
      m_axil_request  => m_axil_request,
      m_axil_response => m_axil_response
    );

end architecture rtl;
