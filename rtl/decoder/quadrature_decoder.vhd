-- SPDX-License-Identifier: Apache-2.0
--
-- # quadrature_decoder
--
-- Decodes one head: counts every edge of an incremental encoder's A and B (x4) into a multi-turn position and, in
-- parallel, into an angle modulo `counts_per_rev` whose zero the first index defines. It checks the distance of the
-- index marks, the order of the edges and their spacing. input_synchroniser and glitch_filter condition the pins,
-- edge_counter counts, index_zero detects the index and holds the zero, plausibility_check stores the faults. Source:
-- section 3.1 and figures 4 and 5 of the paper: A leads B counter-clockwise, (A, B) = 00, 10, 11, 01 counts up.
--
-- **Latency.** SYNCHRONISER_STAGES + filter_length + 2 clocks from a change of a pin to `position`: 5 with the filter
-- off. With DELAYED, `delay` adds to this and to the other latencies from the pins. position, angle, turn_position,
-- direction, step, step_up, last_edge_time, illegal and illegal_count belong to one clock; overspeed and
-- overspeed_count follow 1 clock after this clock. At the first index, index_seen rises, and the angle counts from the
-- new zero, INDEX_SKEW clocks after the step of the index, or with the next step if that step comes earlier.
-- index_strobe, index_position, index_direction and index_interval follow 1 clock after index_seen would rise,
-- index_error and index_error_count 4 clocks after. Edges that the filter suppresses are reported SYNCHRONISER_STAGES +
-- 3 clocks after the pins. last_edge_time is SYNCHRONISER_STAGES + filter_length + 1 clocks later than the timestamp at
-- which the pin changed. position and last_edge_time, read in the same clock, give the velocity.
--
-- **Number formats.** decoder_pkg states the formats of the outputs. counts_per_rev u25.0 counts; filter_length u8.0
-- and minimum_edge_spacing u16.0 clocks; index_tolerance u16.0 counts; timestamp u64.0 clocks.
--
-- **Settings.** filter_length, minimum_edge_spacing and index_tolerance may change at any time. counts_per_rev is
-- sampled while rearm or reset is high, and for SYNCHRONISER_STAGES + 1 clocks after reset; at other times a change has
-- no effect. A `filter_length` above INDEX_SKEW makes the time between two opposite steps longer than the time between
-- a change of Z and its step, as index_zero requires.
--
-- **Clear and rearm.** `clear` affects only the faults; `rearm` affects only angle, turn_position and index.
--
-- **Reset** may be as short as one clock. Counting starts from the levels that the pins have in the last clock of the
-- reset (with DELAYED: `delay` clocks before it): these levels cause no edge, and every later change is counted.

library ieee;
  use ieee.std_logic_1164.all;
  use ieee.numeric_std.all;

  use work.decoder_pkg.all;
  use work.number_formats_pkg.all;

entity quadrature_decoder is
  generic (
    SYNCHRONISER_STAGES : positive range 2 to 4 := SYNCHRONISER_STAGES_DEFAULT; -- number of registers per pin
    RESET_POSITION      : integer               := 0; -- counts; a test of the wrap sets it near +-2**31
    DELAYED             : boolean               := false -- the levels of the head may be delayed
  );
  port (
    clock                : in    std_ulogic;
    reset                : in    std_ulogic;
    -- Pins, asynchronous
    a                    : in    std_ulogic;
    b                    : in    std_ulogic;
    z                    : in    std_ulogic;                                    -- index
    -- Settings
    counts_per_rev       : in    u_unsigned(COUNTS_PER_REV_WIDTH - 1 downto 0); -- counts, 4 to 2**24
    delay                : in    u_unsigned(7 downto 0) := (others => '0');           -- clocks; has an effect only with DELAYED
    filter_length        : in    u_unsigned(7 downto 0);                        -- clocks, 1 is off
    minimum_edge_spacing : in    u_unsigned(15 downto 0);                       -- clocks, 0 is off
    index_tolerance      : in    u_unsigned(15 downto 0) := (others => '0');    -- counts
    timestamp            : in    u_unsigned(TIMESTAMP_WIDTH - 1 downto 0);      -- clocks
    clear                : in    std_ulogic;                                    -- pulse: clears the faults
    rearm                : in    std_ulogic;                                    -- level: clears the index
    zero_again           : in    std_ulogic := '0';                             -- level: the zero moves if a mark proves it wrong
    heal                 : in    std_ulogic := '0';                             -- level: lost counts are added to put_back
    other_head_agrees    : in    std_ulogic := '0';                             -- the other head confirms the mark, see zero_witness
    -- Position, index, faults
    decoded              : out   decoded_head
  );
end entity quadrature_decoder;

architecture rtl of quadrature_decoder is

  signal pins     : std_ulogic_vector(2 downto 0);
  signal levels_in : std_ulogic_vector(2 downto 0);
  signal levels   : std_ulogic_vector(2 downto 0);
  signal filtered : std_ulogic_vector(2 downto 0);

  -- High during the reset and in the clocks after it in which the synchroniser still outputs levels from before its
  -- end.
  signal settling : std_ulogic_vector(SYNCHRONISER_STAGES downto 0) := (others => '1');
  signal preload  : std_ulogic;

  signal edge      : counted_edge;
  signal position  : u_signed(POSITION_WIDTH - 1 downto 0);
  signal misplaced : std_ulogic;

begin

  pins    <= a & b & z;
  preload <= settling(settling'high);

  settle : process (clock) is
  begin

    if rising_edge(clock) then
      settling <= settling(settling'high - 1 downto 0) & '0';
      if (reset = '1') then
        settling <= (others => '1');
      end if;
    end if;

  end process settle;

  synchroniser : entity work.input_synchroniser
    generic map (
      WIDTH  => 3,
      STAGES => SYNCHRONISER_STAGES
    )
    port map (
      clock        => clock,
      asynchronous => pins,
      synchronised => levels_in
    );

  delays : if DELAYED generate

    takes_out_skew : entity work.level_delay
      port map (
        clock   => clock,
        delay   => delay,
        levels  => levels_in,
        delayed => levels
      );

  else generate
    levels <= levels_in;
  end generate delays;

  -- The filter is held in reset until all levels from before the end of this entity's reset have left the synchroniser.
  filter : entity work.glitch_filter
    generic map (
      WIDTH => 3
    )
    port map (
      clock         => clock,
      reset         => settling(settling'high - 1),
      filter_length => filter_length,
      unfiltered    => levels,
      filtered      => filtered
    );

  counter : entity work.edge_counter
    generic map (
      RESET_POSITION => RESET_POSITION
    )
    port map (
      clock          => clock,
      reset          => reset,
      preload        => preload,
      a              => filtered(2),
      b              => filtered(1),
      timestamp      => timestamp,
      edge           => edge,
      position       => position,
      phase_of_zero  => decoded.phase_of_zero,
      direction      => decoded.direction,
      step           => decoded.step,
      step_up        => decoded.step_up,
      last_edge_time => decoded.last_edge_time
    );

  decoded.position <= position;

  index : entity work.index_zero
    port map (
      clock             => clock,
      reset             => reset,
      preload           => preload,
      z                 => filtered(0),
      edge              => edge,
      position          => position,
      counts_per_rev    => counts_per_rev,
      index_tolerance   => index_tolerance,
      rearm             => rearm,
      zero_again        => zero_again,
      heal              => heal,
      other_head_agrees => other_head_agrees,
      angle             => decoded.angle,
      turn_position     => decoded.turn_position,
      index_seen        => decoded.index_seen,
      index_strobe      => decoded.index_strobe,
      index_position    => decoded.index_position,
      index_direction   => decoded.index_direction,
      index_interval    => decoded.index_interval,
      index_trusted     => decoded.index_trusted,
      zero_moved        => decoded.zero_moved,
      zero_moves        => decoded.zero_moves,
      zero_slip         => decoded.zero_slip,
      put_back          => decoded.put_back,
      misplaced         => misplaced
    );

  plausibility : entity work.plausibility_check
    port map (
      clock                => clock,
      reset                => reset,
      settling             => settling(settling'high - 1),
      a                    => levels(2),
      b                    => levels(1),
      edge                 => edge,
      misplaced            => misplaced,
      filter_length        => filter_length,
      minimum_edge_spacing => minimum_edge_spacing,
      clear                => clear,
      index_error          => decoded.index_error,
      index_error_count    => decoded.index_error_count,
      illegal              => decoded.illegal,
      illegal_count        => decoded.illegal_count,
      overspeed            => decoded.overspeed,
      overspeed_count      => decoded.overspeed_count,
      swallowed            => decoded.swallowed
    );

end architecture rtl;
