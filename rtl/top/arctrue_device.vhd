-- SPDX-License-Identifier: Apache-2.0
--
-- # arctrue_device
--
-- Connects the processor side of a Zynq-7000 (zynq_processor), the core (arctrue_core) and four LEDs (status_leds), for
-- two to four heads. The top levels connect the ports of this entity to pins: arctrue_zynq_top for two heads,
-- arctrue_zynq_heads_top for three and four heads, arctrue_zynq_differential_top for two heads at differential pairs of
-- pins. Of the processor's pins, only those of the I2C controller are ports of this entity; the other pins need no
-- port.
--
-- **Latency.** The latency equals that of arctrue_core; there is no register between arctrue_core and the pins of
-- encoders and instruments; the LEDs follow their states with the delay that status_leds states.
--
-- **Number formats.** All ports are single bits. The register map describes the registers, which start at 0x4000_0000
-- for the processor.
--
-- **Clock and reset** come from the processor, see zynq_processor. From power-up until the firmware releases the reset,
-- the outputs are low and the LEDs are off.
--
-- **LEDs.** The LED alive blinks; capture is lit while a turn is captured; compensation is lit while the output is
-- corrected. The LED fault is lit while one of the faults of the register `alarm` is present, for example an index
-- error that has not been cleared, or a clipped correction. Each LED shows the state with the delay and the shortest
-- time that status_leds states.

library ieee;
  use ieee.std_logic_1164.all;

  use work.axi_lite_pkg.all;
  use work.number_formats_pkg.all;

entity arctrue_device is
  generic (
    LANES         : positive range 1 to LANES_MAX := LANES_DEFAULT;         -- number of harmonic lanes
    CAPTURE_DEPTH : positive range 2 to 16384     := CAPTURE_DEPTH_DEFAULT; -- number of samples per capture bank
    FOLD          : positive range 1 to 8         := 1;                     -- lanes that share a pipeline: 1, 2, 4 or 8
    HEADS         : positive range 2 to HEADS_MAX := 2;
    MEAN          : boolean                       := false;                 -- true: correct the mean of two heads (more heads: always)
    ROTATION      : string                        := "cordic";              -- or "table": method of computing the cosine
    MODULATORS    : boolean                       := false;                 -- amplitudes can follow motion or a processor word
    FAILOVER      : boolean                       := false;                 -- true: a failed head of three or four is left out of the mean
    LOCAL_TABLE   : boolean                       := false;                 -- a table corrects errors that a sum of orders cannot represent
    REAL_ORDERS   : boolean                       := false;                 -- the order of a lane need not be an integer
    EVENTS        : boolean                       := false;                 -- edges of the probe and compare pulses are queued
    LED_HOLD_LOG2 : positive range 1 to 28        := 22;                    -- log2 of the shortest time for which an LED is lit, in clocks
    DNA_PORTS     : natural range 0 to 1          := 1                      -- 0: for tools without the primitive DNA_PORT
  );
  port (
    -- Reference head, asynchronous
    head1_a          : in    std_ulogic;
    head1_b          : in    std_ulogic;
    head1_z          : in    std_ulogic;
    -- Calibration head, asynchronous
    head2_a          : in    std_ulogic;
    head2_b          : in    std_ulogic;
    head2_z          : in    std_ulogic;
    -- Further heads, asynchronous
    head3_a          : in    std_ulogic := '0';
    head3_b          : in    std_ulogic := '0';
    head3_z          : in    std_ulogic := '0';
    head4_a          : in    std_ulogic := '0';
    head4_b          : in    std_ulogic := '0';
    head4_z          : in    std_ulogic := '0';
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
end entity arctrue_device;

architecture rtl of arctrue_device is

  signal clock     : std_ulogic;
  signal reset     : std_ulogic;
  signal interrupt : std_ulogic;
  signal scl_low   : std_ulogic;
  signal sda_low   : std_ulogic;

  signal axil_request  : axi_lite_request;
  signal axil_response : axi_lite_response;

  signal dna       : std_ulogic_vector(56 downto 0);
  signal dna_known : std_ulogic;

  signal capturing    : std_ulogic;
  signal fault        : std_ulogic;
  signal compensating : std_ulogic;

begin

  i2c_scl <= '0' when scl_low = '1' else
             'Z';
  i2c_sda <= '0' when sda_low = '1' else
             'Z';

  processor : entity work.zynq_processor
    port map (
      clock           => clock,
      reset           => reset,
      interrupt       => interrupt,
      scl             => i2c_scl,
      scl_low         => scl_low,
      sda             => i2c_sda,
      sda_low         => sda_low,
      m_axil_request  => axil_request,
      m_axil_response => axil_response
    );

  core : entity work.arctrue_core
    generic map (
      LANES         => LANES,
      CAPTURE_DEPTH => CAPTURE_DEPTH,
      FOLD          => FOLD,
      HEADS         => HEADS,
      MEAN          => MEAN,
      ROTATION      => ROTATION,
      MODULATORS    => MODULATORS,
      FAILOVER      => FAILOVER,
      LOCAL_TABLE   => LOCAL_TABLE,
      REAL_ORDERS   => REAL_ORDERS,
      EVENTS        => EVENTS
    )
    port map (
      clock               => clock,
      reset               => reset,
      s_axil_request      => axil_request,
      s_axil_response     => axil_response,
      interrupt           => interrupt,
      head1_a             => head1_a,
      head1_b             => head1_b,
      head1_z             => head1_z,
      head2_a             => head2_a,
      head2_b             => head2_b,
      head2_z             => head2_z,
      head3_a             => head3_a,
      head3_b             => head3_b,
      head3_z             => head3_z,
      head4_a             => head4_a,
      head4_b             => head4_b,
      head4_z             => head4_z,
      out_a               => out_a,
      out_b               => out_b,
      out_z               => out_z,
      driver_enable       => driver_enable,
      alarm               => alarm,
      sync_in             => sync_in,
      trigger_out         => trigger_out,
      probe_in            => probe_in,
      compare_out         => compare_out,
      chip_dna            => dna,
      chip_dna_known      => dna_known,
      status_capturing    => capturing,
      status_fault        => fault,
      status_compensating => compensating
    );

  identified : if DNA_PORTS = 1 generate

    identifier : entity work.chip_dna
      port map (
        clock => clock,
        reset => reset,
        dna   => dna,
        known => dna_known
      );

  else generate

    dna       <= (others => '0');
    dna_known <= '0';

  end generate identified;

  leds : entity work.status_leds
    generic map (
      HOLD_LOG2 => LED_HOLD_LOG2
    )
    port map (
      clock            => clock,
      reset            => reset,
      capturing        => capturing,
      fault            => fault,
      compensating     => compensating,
      led_alive        => led_alive,
      led_capture      => led_capture,
      led_fault        => led_fault,
      led_compensation => led_compensation
    );

end architecture rtl;
