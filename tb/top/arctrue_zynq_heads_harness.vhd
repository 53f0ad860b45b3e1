-- SPDX-License-Identifier: Apache-2.0
--
-- # arctrue_zynq_heads_harness
--
-- Connects arctrue_zynq_heads_top to models of the chip's primitives, for simulation. The use clauses name the models;
-- each model is bound to the component of the same name.

library ieee;
  use ieee.std_logic_1164.all;

  use work.bufg;
  use work.dna_port;
  use work.ps7;

entity arctrue_zynq_heads_harness is
  generic (
    LANES         : positive;
    CAPTURE_DEPTH : positive;
    FOLD          : positive;
    HEADS         : positive;
    LED_HOLD_LOG2 : positive
  );
  port (
    head1_a          : in    std_ulogic;
    head1_b          : in    std_ulogic;
    head1_z          : in    std_ulogic;
    head2_a          : in    std_ulogic;
    head2_b          : in    std_ulogic;
    head2_z          : in    std_ulogic;
    head3_a          : in    std_ulogic;
    head3_b          : in    std_ulogic;
    head3_z          : in    std_ulogic;
    head4_a          : in    std_ulogic;
    head4_b          : in    std_ulogic;
    head4_z          : in    std_ulogic;
    out_a            : out   std_ulogic;
    out_b            : out   std_ulogic;
    out_z            : out   std_ulogic;
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
end entity arctrue_zynq_heads_harness;

architecture simulation of arctrue_zynq_heads_harness is

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

  device : entity work.arctrue_zynq_heads_top
    generic map (
      LANES         => LANES,
      CAPTURE_DEPTH => CAPTURE_DEPTH,
      FOLD          => FOLD,
      HEADS         => HEADS,
      LED_HOLD_LOG2 => LED_HOLD_LOG2
    )
    port map (
      head1_a          => head1_a,
      head1_b          => head1_b,
      head1_z          => head1_z,
      head2_a          => head2_a,
      head2_b          => head2_b,
      head2_z          => head2_z,
      head3_a          => head3_a,
      head3_b          => head3_b,
      head3_z          => head3_z,
      head4_a          => head4_a,
      head4_b          => head4_b,
      head4_z          => head4_z,
      out_a            => out_a,
      out_b            => out_b,
      out_z            => out_z,
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
