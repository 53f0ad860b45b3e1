-- SPDX-License-Identifier: Apache-2.0
--
-- # arctrue_zynq_heads_top
--
-- Connects arctrue_device, the whole device, to the pins of a Zynq-7000, for three or four heads. The device corrects
-- the weighted mean of the heads. The encoder pins are single-ended, for external RS-422 receivers and drivers.
--
-- **Latency.** The latency equals that of arctrue_core; there is no register between arctrue_core and the pins of
-- encoders and instruments; the LEDs follow their states with the delay that status_leds states.
--
-- **Number formats.** All ports are single bits. The register map describes the registers, which start at 0x4000_0000
-- for the processor.

library ieee;
  use ieee.std_logic_1164.all;

  use work.number_formats_pkg.all;

entity arctrue_zynq_heads_top is
  generic (
    LANES         : positive range 1 to LANES_MAX := LANES_DEFAULT;         -- number of harmonic lanes
    CAPTURE_DEPTH : positive range 2 to 16384     := CAPTURE_DEPTH_DEFAULT; -- number of samples per capture bank
    FOLD          : positive range 1 to 8         := 1;                     -- lanes that share a pipeline: 1, 2, 4 or 8
    HEADS         : positive range 3 to HEADS_MAX := HEADS_MAX;
    ROTATION      : string                        := "cordic";              -- or "table": method of computing the cosine
    MODULATORS    : boolean                       := false;                 -- amplitudes can follow motion or a processor word
    FAILOVER      : boolean                       := false;                 -- a failed head of three or four is left out of the mean
    LOCAL_TABLE   : boolean                       := false;                 -- a table corrects errors that a sum of orders cannot represent
    REAL_ORDERS   : boolean                       := false;                 -- the order of a lane need not be an integer
    EVENTS        : boolean                       := false;                 -- edges of the probe and compare pulses are queued
    LED_HOLD_LOG2 : positive range 1 to 28        := 22;                    -- log2 of the shortest time for which an LED is lit, in clocks
    DNA_PORTS     : natural range 0 to 1          := 1                      -- 0: for tools without the primitive DNA_PORT
  );
  port (
    -- Head 1, asynchronous
    head1_a          : in    std_ulogic;
    head1_b          : in    std_ulogic;
    head1_z          : in    std_ulogic;
    -- Head 2, asynchronous
    head2_a          : in    std_ulogic;
    head2_b          : in    std_ulogic;
    head2_z          : in    std_ulogic;
    -- Further heads, asynchronous; with HEADS = 3 the pins of head 4 have no effect
    head3_a          : in    std_ulogic;
    head3_b          : in    std_ulogic;
    head3_z          : in    std_ulogic;
    head4_a          : in    std_ulogic;
    head4_b          : in    std_ulogic;
    head4_z          : in    std_ulogic;
    -- Corrected encoder signal
    out_a            : out   std_ulogic;
    out_b            : out   std_ulogic;
    out_z            : out   std_ulogic;
    -- Line drivers of A, B and Z; external instruments
    driver_enable    : out   std_ulogic;
    alarm            : out   std_ulogic;
    sync_in          : in    std_ulogic; -- asynchronous
    trigger_out      : out   std_ulogic;
    probe_in         : in    std_ulogic; -- asynchronous
    compare_out      : out   std_ulogic;
    -- I2C bus of the table's thermometer, open drain; the board has a pull-up on each wire
    i2c_scl          : inout std_logic;
    i2c_sda          : inout std_logic;
    -- An LED is lit while its output is high
    led_alive        : out   std_ulogic;
    led_capture      : out   std_ulogic;
    led_fault        : out   std_ulogic;
    led_compensation : out   std_ulogic
  );
end entity arctrue_zynq_heads_top;

architecture rtl of arctrue_zynq_heads_top is

begin

  device : entity work.arctrue_device
    generic map (
      LANES         => LANES,
      CAPTURE_DEPTH => CAPTURE_DEPTH,
      FOLD          => FOLD,
      HEADS         => HEADS,
      ROTATION      => ROTATION,
      MODULATORS    => MODULATORS,
      FAILOVER      => FAILOVER,
      LOCAL_TABLE   => LOCAL_TABLE,
      REAL_ORDERS   => REAL_ORDERS,
      EVENTS        => EVENTS,
      LED_HOLD_LOG2 => LED_HOLD_LOG2,
      DNA_PORTS     => DNA_PORTS
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
      i2c_scl          => i2c_scl,
      i2c_sda          => i2c_sda,
      led_alive        => led_alive,
      led_capture      => led_capture,
      led_fault        => led_fault,
      led_compensation => led_compensation
    );

end architecture rtl;
