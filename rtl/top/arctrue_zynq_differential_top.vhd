-- SPDX-License-Identifier: Apache-2.0
--
-- # arctrue_zynq_differential_top
--
-- Connects the encoder signals of arctrue_zynq_top to differential pairs of pins (IBUFDS, OBUFDS). The chip's pairs are
-- LVDS_25 or TMDS_33, not RS-422: a board that uses them must convert the levels.
--
-- **Latency.** The latency equals that of arctrue_zynq_top.
--
-- **Number formats.** All ports are single bits. `_p` and `_n` mark the two wires of a pair.

library ieee;
  use ieee.std_logic_1164.all;

  use work.number_formats_pkg.all;

entity arctrue_zynq_differential_top is
  generic (
    LANES         : positive range 1 to LANES_MAX := LANES_DEFAULT;         -- number of harmonic lanes
    CAPTURE_DEPTH : positive range 2 to 16384     := CAPTURE_DEPTH_DEFAULT; -- number of samples per capture bank
    FOLD          : positive range 1 to 8         := 1;                     -- lanes that share a pipeline: 1, 2, 4 or 8
    MEAN          : boolean                       := false;                 -- correct the mean of both heads, not head 1 alone
    ROTATION      : string                        := "cordic";              -- or "table": method of computing the cosine
    MODULATORS    : boolean                       := false;                 -- amplitudes can follow motion or a processor word
    LOCAL_TABLE   : boolean                       := false;                 -- a table corrects errors that a sum of orders cannot represent
    REAL_ORDERS   : boolean                       := false;                 -- the order of a lane need not be an integer
    EVENTS        : boolean                       := false;                 -- edges of the probe and compare pulses are queued
    LED_HOLD_LOG2 : positive range 1 to 28        := 22;                    -- log2 of the shortest time for which an LED is lit, in clocks
    DNA_PORTS     : natural range 0 to 1          := 1                      -- 0: for tools without the primitive DNA_PORT
  );
  port (
    -- Reference head, asynchronous
    head1_a_p        : in    std_ulogic;
    head1_a_n        : in    std_ulogic;
    head1_b_p        : in    std_ulogic;
    head1_b_n        : in    std_ulogic;
    head1_z_p        : in    std_ulogic;
    head1_z_n        : in    std_ulogic;
    -- Calibration head, asynchronous
    head2_a_p        : in    std_ulogic;
    head2_a_n        : in    std_ulogic;
    head2_b_p        : in    std_ulogic;
    head2_b_n        : in    std_ulogic;
    head2_z_p        : in    std_ulogic;
    head2_z_n        : in    std_ulogic;
    -- Corrected encoder signal
    out_a_p          : out   std_ulogic;
    out_a_n          : out   std_ulogic;
    out_b_p          : out   std_ulogic;
    out_b_n          : out   std_ulogic;
    out_z_p          : out   std_ulogic;
    out_z_n          : out   std_ulogic;
    -- Single-ended pins: line drivers of A, B and Z; external instruments
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
end entity arctrue_zynq_differential_top;

architecture rtl of arctrue_zynq_differential_top is

  -- Primitives of the 7 series, named as the vendor's and the open tools' libraries name them.
  -- vsg_off
  component IBUFDS is
    port (
      O  : out   std_ulogic;
      I  : in    std_ulogic;
      IB : in    std_ulogic
    );
  end component IBUFDS;

  component OBUFDS is
    port (
      O  : out   std_ulogic;
      OB : out   std_ulogic;
      I  : in    std_ulogic
    );
  end component OBUFDS;
  -- vsg_on

  -- Bits, from the highest on: a, b, z of head 1, then of head 2
  signal heads_p : std_ulogic_vector(5 downto 0);
  signal heads_n : std_ulogic_vector(5 downto 0);
  signal heads   : std_ulogic_vector(5 downto 0);
  -- a, b, z
  signal corrected   : std_ulogic_vector(2 downto 0);
  signal corrected_p : std_ulogic_vector(2 downto 0);
  signal corrected_n : std_ulogic_vector(2 downto 0);

begin

  heads_p <= head1_a_p & head1_b_p & head1_z_p & head2_a_p & head2_b_p & head2_z_p;
  heads_n <= head1_a_n & head1_b_n & head1_z_n & head2_a_n & head2_b_n & head2_z_n;

  receivers : for place in heads'range generate

    -- vsg_off
    receiver : component IBUFDS
      port map (
        O  => heads(place),
        I  => heads_p(place),
        IB => heads_n(place)
      );
    -- vsg_on

  end generate receivers;

  drivers : for place in corrected'range generate

    -- vsg_off
    driver : component OBUFDS
      port map (
        O  => corrected_p(place),
        OB => corrected_n(place),
        I  => corrected(place)
      );
    -- vsg_on

  end generate drivers;

  (out_a_p, out_b_p, out_z_p) <= corrected_p;
  (out_a_n, out_b_n, out_z_n) <= corrected_n;

  single_ended : entity work.arctrue_zynq_top
    generic map (
      LANES         => LANES,
      CAPTURE_DEPTH => CAPTURE_DEPTH,
      FOLD          => FOLD,
      MEAN          => MEAN,
      ROTATION      => ROTATION,
      MODULATORS    => MODULATORS,
      LOCAL_TABLE   => LOCAL_TABLE,
      REAL_ORDERS   => REAL_ORDERS,
      EVENTS        => EVENTS,
      LED_HOLD_LOG2 => LED_HOLD_LOG2,
      DNA_PORTS     => DNA_PORTS
    )
    port map (
      head1_a          => heads(5),
      head1_b          => heads(4),
      head1_z          => heads(3),
      head2_a          => heads(2),
      head2_b          => heads(1),
      head2_z          => heads(0),
      out_a            => corrected(2),
      out_b            => corrected(1),
      out_z            => corrected(0),
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
