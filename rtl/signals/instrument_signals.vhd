-- SPDX-License-Identifier: Apache-2.0
--
-- # instrument_signals
--
-- Connects external instruments to the core. In the external capture mode (mode 2 of sample_trigger) an edge at
-- `sync_in` triggers a sample. In every mode each sample gives a pulse at `trigger_out`. An edge at `probe_in` latches
-- the corrected position (position_latch). Chosen corrected positions give a pulse at `compare_out` (position_compare).
-- With EVENTS, edges of the probe and compare pulses wait in a queue for the processor (event_queue).
--
-- **Latency.** The strobe of a probe's edge waits CORE_LATENCY + 1 clocks, so that the latched position is the corrected
-- reading of the time of the edge (with FOLD > 1: of a time up to FOLD - 1 clocks before it). This requires that probe
-- and head have the same filter length, and that the levels of the head are not delayed (level_delay). pulse_input,
-- position_compare and pulse_output state the other latencies.
--
-- **Number formats.** signals_pkg states those of `latched` and `oldest_event`; position s31.0 counts; angle u24.0 counts;
-- widths and the filter length in clocks.
--
-- **Reset** stops the comparison, ends the pulses, empties the queue, drops edges of the probe that are still delayed,
-- and clears `latched.number`.

library ieee;
  use ieee.std_logic_1164.all;
  use ieee.numeric_std.all;

  use work.number_formats_pkg.all;
  use work.signals_pkg.all;

entity instrument_signals is
  generic (
    CORE_LATENCY : positive := PIPELINE_LATENCY; -- clocks from the angle of a head to the corrected angle
    EVENTS       : boolean  := false             -- edges of the probe and compare pulses are queued
  );
  port (
    clock          : in    std_ulogic;
    reset          : in    std_ulogic;
    timestamp      : in    u_unsigned(TIMESTAMP_WIDTH - 1 downto 0); -- clocks
    position       : in    u_signed(POSITION_WIDTH - 1 downto 0);    -- counts, corrected
    angle          : in    u_unsigned(ANGLE_WIDTH - 1 downto 0);     -- counts, corrected
    sampled        : in    std_ulogic;                               -- strobe: a sample was taken
    -- Pins
    sync_in        : in    std_ulogic;                               -- asynchronous
    trigger_out    : out   std_ulogic;                               -- a pulse with each sample
    probe_in       : in    std_ulogic;                               -- asynchronous
    compare_out    : out   std_ulogic;                               -- a pulse at chosen corrected positions
    -- Settings
    sync_falling   : in    std_ulogic;                               -- level: use the falling edge
    probe_falling  : in    std_ulogic;                               -- level: use the falling edge
    filter_length  : in    u_unsigned(7 downto 0);                   -- clocks
    trigger_width  : in    u_unsigned(15 downto 0);                  -- clocks
    compare_width  : in    u_unsigned(15 downto 0);                  -- clocks
    first          : in    u_signed(POSITION_WIDTH - 1 downto 0);    -- counts, first position of a compare pulse
    interval       : in    u_unsigned(ANGLE_WIDTH - 1 downto 0);     -- counts to the next pulse; 0: one pulse only
    recorded       : in    std_ulogic_vector(1 downto 0);            -- kinds of events that are queued: compare, probe
    -- Commands
    compare_arm    : in    std_ulogic;                               -- pulse
    compare_disarm : in    std_ulogic;                               -- pulse
    next_event     : in    std_ulogic;                               -- pulse: remove the oldest event
    -- Results
    sync_strobe    : out   std_ulogic;                               -- strobe: an edge at sync_in
    compare_armed  : out   std_ulogic;                               -- level
    probe_latched  : out   std_ulogic;                               -- strobe: `latched` is new
    latched        : out   probe_edge;
    oldest_event   : out   queued_event
  );
end entity instrument_signals;

architecture rtl of instrument_signals is

  -- Clocks from an edge at a pulse input to the strobe of this edge, and clocks from an edge of head 1 to the position
  -- that counts it, both with the filter off.
  constant PULSE_CLOCKS    : positive := SYNCHRONISER_STAGES_DEFAULT + 2;
  constant POSITION_CLOCKS : positive := SYNCHRONISER_STAGES_DEFAULT + 3;

  -- Clocks from the strobe of the probe to the corrected position that belongs to its edge.
  constant PROBE_DELAY : positive := POSITION_CLOCKS + CORE_LATENCY - PULSE_CLOCKS;

  signal probe_strobe   : std_ulogic;
  signal compare_strobe : std_ulogic;

begin

  sync_input : entity work.pulse_input
    port map (
      clock         => clock,
      reset         => reset,
      pin           => sync_in,
      falling_edge  => sync_falling,
      filter_length => filter_length,
      strobe        => sync_strobe
    );

  sample_pulse : entity work.pulse_output
    port map (
      clock  => clock,
      reset  => reset,
      strobe => sampled,
      width  => trigger_width,
      pulse  => trigger_out
    );

  probe_input : entity work.pulse_input
    port map (
      clock         => clock,
      reset         => reset,
      pin           => probe_in,
      falling_edge  => probe_falling,
      filter_length => filter_length,
      strobe        => probe_strobe
    );

  latch_of_probe : entity work.position_latch
    generic map (
      DELAY => PROBE_DELAY
    )
    port map (
      clock            => clock,
      reset            => reset,
      strobe           => probe_strobe,
      position         => position,
      angle            => angle,
      timestamp        => timestamp,
      latched          => probe_latched,
      latched_position => latched.position,
      latched_angle    => latched.angle,
      latched_time     => latched.time,
      count            => latched.number
    );

  comparison : entity work.position_compare
    port map (
      clock    => clock,
      reset    => reset,
      arm      => compare_arm,
      disarm   => compare_disarm,
      position => position,
      first    => first,
      interval => interval,
      armed    => compare_armed,
      strobe   => compare_strobe
    );

  compare_pulse : entity work.pulse_output
    port map (
      clock  => clock,
      reset  => reset,
      strobe => compare_strobe,
      width  => compare_width,
      pulse  => compare_out
    );

  queue_of_events : if EVENTS generate

    queue : entity work.event_queue
      generic map (
        DELAY         => PROBE_DELAY,
        COMPARE_DELAY => PROBE_DELAY + PULSE_CLOCKS + 1
      )
      port map (
        clock          => clock,
        reset          => reset,
        probe          => probe_strobe,
        compare        => compare_strobe,
        recorded       => recorded,
        position       => position,
        angle          => angle,
        timestamp      => timestamp,
        take           => next_event,
        kind           => oldest_event.kind,
        number         => oldest_event.number,
        event_time     => oldest_event.time,
        event_position => oldest_event.position,
        event_angle    => oldest_event.angle,
        waiting        => oldest_event.waiting,
        lost           => oldest_event.lost
      );

  else generate
    oldest_event.kind     <= (others => '0');
    oldest_event.number   <= (others => '0');
    oldest_event.time     <= (others => '0');
    oldest_event.position <= (others => '0');
    oldest_event.angle    <= (others => '0');
    oldest_event.waiting  <= (others => '0');
    oldest_event.lost     <= (others => '0');
  end generate queue_of_events;

end architecture rtl;
