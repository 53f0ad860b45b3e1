-- SPDX-License-Identifier: Apache-2.0
--
-- # ps7
--
-- Models the ports of the primitive PS7 that zynq_processor connects, for simulation: the fabric's clock and reset, I2C
-- controller 0, general-purpose pins, and M_AXI_GP0, on which the test is the master. The test writes `fabric_clock`,
-- `fabric_resetn`, and the signals whose names begin with `master_` or end in `_value` or `_drives`; it reads the ports
-- and the signals whose names end in `_level`. `pin_level`, `scl_level` and `sda_level` show the inputs as '0' or '1':
-- a wire that only a pull-up holds ('H') is '1'.

library ieee;
  use ieee.std_logic_1164.all;

entity ps7 is
  port (
    emiogpioi      : in    std_ulogic_vector(63 downto 0);
    emiogpioo      : out   std_ulogic_vector(63 downto 0);
    emiogpiotn     : out   std_ulogic_vector(63 downto 0);
    emioi2c0scli   : in    std_ulogic;
    emioi2c0sclo   : out   std_ulogic;
    emioi2c0scltn  : out   std_ulogic;
    emioi2c0sdai   : in    std_ulogic;
    emioi2c0sdao   : out   std_ulogic;
    emioi2c0sdatn  : out   std_ulogic;
    fclkclk        : out   std_ulogic_vector(3 downto 0);
    fclkresetn     : out   std_ulogic_vector(3 downto 0);
    irqf2p         : in    std_ulogic_vector(19 downto 0);
    maxigp0aclk    : in    std_ulogic;
    maxigp0awvalid : out   std_ulogic;
    maxigp0awready : in    std_ulogic;
    maxigp0awid    : out   std_ulogic_vector(11 downto 0);
    maxigp0awaddr  : out   std_ulogic_vector(31 downto 0);
    maxigp0awlen   : out   std_ulogic_vector(3 downto 0);
    maxigp0awsize  : out   std_ulogic_vector(1 downto 0);
    maxigp0awburst : out   std_ulogic_vector(1 downto 0);
    maxigp0wvalid  : out   std_ulogic;
    maxigp0wready  : in    std_ulogic;
    maxigp0wdata   : out   std_ulogic_vector(31 downto 0);
    maxigp0wstrb   : out   std_ulogic_vector(3 downto 0);
    maxigp0wlast   : out   std_ulogic;
    maxigp0bvalid  : in    std_ulogic;
    maxigp0bready  : out   std_ulogic;
    maxigp0bid     : in    std_ulogic_vector(11 downto 0);
    maxigp0bresp   : in    std_ulogic_vector(1 downto 0);
    maxigp0arvalid : out   std_ulogic;
    maxigp0arready : in    std_ulogic;
    maxigp0arid    : out   std_ulogic_vector(11 downto 0);
    maxigp0araddr  : out   std_ulogic_vector(31 downto 0);
    maxigp0arlen   : out   std_ulogic_vector(3 downto 0);
    maxigp0arsize  : out   std_ulogic_vector(1 downto 0);
    maxigp0arburst : out   std_ulogic_vector(1 downto 0);
    maxigp0rvalid  : in    std_ulogic;
    maxigp0rready  : out   std_ulogic;
    maxigp0rid     : in    std_ulogic_vector(11 downto 0);
    maxigp0rdata   : in    std_ulogic_vector(31 downto 0);
    maxigp0rresp   : in    std_ulogic_vector(1 downto 0);
    maxigp0rlast   : in    std_ulogic
  );
end entity ps7;

architecture simulation of ps7 is

  signal fabric_clock  : std_ulogic := '0';
  signal fabric_resetn : std_ulogic := '0';

  signal pin_value  : std_ulogic_vector(63 downto 0) := (others => '0');
  signal pin_drives : std_ulogic_vector(63 downto 0) := (others => '0');
  signal pin_level  : std_ulogic_vector(63 downto 0);
  signal scl_value  : std_ulogic := '0';
  signal scl_drives : std_ulogic := '0';
  signal scl_level  : std_ulogic;
  signal sda_value  : std_ulogic := '0';
  signal sda_drives : std_ulogic := '0';
  signal sda_level  : std_ulogic;

  signal master_awvalid : std_ulogic := '0';
  signal master_awid    : std_ulogic_vector(11 downto 0) := (others => '0');
  signal master_awaddr  : std_ulogic_vector(31 downto 0) := (others => '0');
  signal master_awlen   : std_ulogic_vector(3 downto 0) := (others => '0');
  signal master_awsize  : std_ulogic_vector(1 downto 0) := (others => '0');
  signal master_awburst : std_ulogic_vector(1 downto 0) := (others => '0');
  signal master_wvalid  : std_ulogic := '0';
  signal master_wdata   : std_ulogic_vector(31 downto 0) := (others => '0');
  signal master_wstrb   : std_ulogic_vector(3 downto 0) := (others => '0');
  signal master_wlast   : std_ulogic := '0';
  signal master_bready  : std_ulogic := '0';
  signal master_arvalid : std_ulogic := '0';
  signal master_arid    : std_ulogic_vector(11 downto 0) := (others => '0');
  signal master_araddr  : std_ulogic_vector(31 downto 0) := (others => '0');
  signal master_arlen   : std_ulogic_vector(3 downto 0) := (others => '0');
  signal master_arsize  : std_ulogic_vector(1 downto 0) := (others => '0');
  signal master_arburst : std_ulogic_vector(1 downto 0) := (others => '0');
  signal master_rready  : std_ulogic := '0';

begin

  emiogpioo     <= pin_value;
  emiogpiotn    <= pin_drives;
  emioi2c0sclo  <= scl_value;
  emioi2c0scltn <= scl_drives;
  emioi2c0sdao  <= sda_value;
  emioi2c0sdatn <= sda_drives;

  pin_level <= to_x01(emiogpioi);
  scl_level <= to_x01(emioi2c0scli);
  sda_level <= to_x01(emioi2c0sdai);

  fclkclk    <= (0 => fabric_clock, others => '0');
  fclkresetn <= (0 => fabric_resetn, others => '0');

  maxigp0awvalid <= master_awvalid;
  maxigp0awid    <= master_awid;
  maxigp0awaddr  <= master_awaddr;
  maxigp0awlen   <= master_awlen;
  maxigp0awsize  <= master_awsize;
  maxigp0awburst <= master_awburst;
  maxigp0wvalid  <= master_wvalid;
  maxigp0wdata   <= master_wdata;
  maxigp0wstrb   <= master_wstrb;
  maxigp0wlast   <= master_wlast;
  maxigp0bready  <= master_bready;
  maxigp0arvalid <= master_arvalid;
  maxigp0arid    <= master_arid;
  maxigp0araddr  <= master_araddr;
  maxigp0arlen   <= master_arlen;
  maxigp0arsize  <= master_arsize;
  maxigp0arburst <= master_arburst;
  maxigp0rready  <= master_rready;

end architecture simulation;
