-- SPDX-License-Identifier: Apache-2.0
--
-- # arctrue_zynq_differential_harness
--
-- Connects arctrue_zynq_differential_top to models of the chip's primitives, for simulation. The use clauses name the
-- models; each model is bound to the component of the same name.

library ieee;
  use ieee.std_logic_1164.all;

  use work.bufg;
  use work.dna_port;
  use work.ibufds;
  use work.obufds;
  use work.ps7;

entity arctrue_zynq_differential_harness is
  generic (
    LANES         : positive;
    CAPTURE_DEPTH : positive;
    FOLD          : positive;
    LED_HOLD_LOG2 : positive
  );
  port (
    head1_a_p        : in    std_ulogic;
    head1_a_n        : in    std_ulogic;
    head1_b_p        : in    std_ulogic;
    head1_b_n        : in    std_ulogic;
    head1_z_p        : in    std_ulogic;
    head1_z_n        : in    std_ulogic;
    head2_a_p        : in    std_ulogic;
    head2_a_n        : in    std_ulogic;
    head2_b_p        : in    std_ulogic;
    head2_b_n        : in    std_ulogic;
    head2_z_p        : in    std_ulogic;
    head2_z_n        : in    std_ulogic;
    out_a_p          : out   std_ulogic;
    out_a_n          : out   std_ulogic;
    out_b_p          : out   std_ulogic;
    out_b_n          : out   std_ulogic;
    out_z_p          : out   std_ulogic;
    out_z_n          : out   std_ulogic;
    driver_enable    : out   std_ulogic;
    alarm            : out   std_ulogic;
    sync_in          : in    std_ulogic := '0';
    trigger_out      : out   std_ulogic;
    probe_in         : in    std_ulogic := '0';
    compare_out      : out   std_ulogic;
    -- I2C bus with its pull-ups: requests of the thermometer to pull a wire low, and the levels of the wires
    thermometer_scl  : in    std_ulogic := '0'; -- 1 pulls low
    thermometer_sda  : in    std_ulogic := '0'; -- 1 pulls low
    scl              : out   std_ulogic;
    sda              : out   std_ulogic;
    led_alive        : out   std_ulogic;
    led_capture      : out   std_ulogic;
    led_fault        : out   std_ulogic;
    led_compensation : out   std_ulogic
  );
end entity arctrue_zynq_differential_harness;

architecture simulation of arctrue_zynq_differential_harness is

  signal scl_wire : std_logic;
  signal sda_wire : std_logic;

begin

  scl_wire <= 'H';
  sda_wire <= 'H';
  scl_wire <= '0' when thermometer_scl = '1' else
              'Z';
  sda_wire <= '0' when thermometer_sda = '1' else
              'Z';
  scl      <= to_x01(scl_wire);
  sda      <= to_x01(sda_wire);

  device : entity work.arctrue_zynq_differential_top
    generic map (
      LANES         => LANES,
      CAPTURE_DEPTH => CAPTURE_DEPTH,
      FOLD          => FOLD,
      LED_HOLD_LOG2 => LED_HOLD_LOG2
    )
    port map (
      head1_a_p        => head1_a_p,
      head1_a_n        => head1_a_n,
      head1_b_p        => head1_b_p,
      head1_b_n        => head1_b_n,
      head1_z_p        => head1_z_p,
      head1_z_n        => head1_z_n,
      head2_a_p        => head2_a_p,
      head2_a_n        => head2_a_n,
      head2_b_p        => head2_b_p,
      head2_b_n        => head2_b_n,
      head2_z_p        => head2_z_p,
      head2_z_n        => head2_z_n,
      out_a_p          => out_a_p,
      out_a_n          => out_a_n,
      out_b_p          => out_b_p,
      out_b_n          => out_b_n,
      out_z_p          => out_z_p,
      out_z_n          => out_z_n,
      driver_enable    => driver_enable,
      alarm            => alarm,
      sync_in          => sync_in,
      trigger_out      => trigger_out,
      probe_in         => probe_in,
      compare_out      => compare_out,
      i2c_scl          => scl_wire,
      i2c_sda          => sda_wire,
      led_alive        => led_alive,
      led_capture      => led_capture,
      led_fault        => led_fault,
      led_compensation => led_compensation
    );

end architecture simulation;
