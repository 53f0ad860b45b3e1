-- SPDX-License-Identifier: Apache-2.0
--
-- # encoder_heads
--
-- Converts the pins of all encoder heads to their positions. Each head has an input_selection, which mends exchanged or
-- inverted pins, and a quadrature_decoder. Source: section 3.1 of the paper.
--
-- **Latency.** As quadrature_decoder; the selection of the pins has no register. A new filter length takes one clock.
--
-- **Number formats.** `pin_settings` has 16 bits per head, in the layout of the registers `pins`, and `delays` has 8
-- bits per head, in clocks; head 1 is in the low bits. decoder_pkg states the formats of `decoded`.
--
-- **Lost counts.** With `zero_again` and `heal`, a head finds its zero again after it has lost counts; the next head is
-- the witness of its marks (zero_witness). Without MEAN only head 1 does so: head 2 keeps its zero, because the
-- processor derives the separation of the heads from this zero.
--
-- **Delay.** With MEAN, the levels of each head can be delayed (level_delay).
--
-- **Reset** and `rearm` act as in quadrature_decoder.

library ieee;
  use ieee.std_logic_1164.all;
  use ieee.numeric_std.all;

  use work.decoder_pkg.all;
  use work.number_formats_pkg.all;

entity encoder_heads is
  generic (
    HEADS : positive range 2 to HEADS_MAX := 2;
    MEAN  : boolean                       := false -- the mean of the heads is corrected
  );
  port (
    clock                : in    std_ulogic;
    reset                : in    std_ulogic;
    pins                 : in    std_ulogic_vector(1 to 3 * HEADS);                  -- A, B and Z of head 1, of head 2, ...; asynchronous
    timestamp            : in    u_unsigned(TIMESTAMP_WIDTH - 1 downto 0);           -- clocks
    -- Settings
    counts_per_rev       : in    u_unsigned(COUNTS_PER_REV_WIDTH - 1 downto 0);      -- counts
    pin_settings         : in    std_ulogic_vector(16 * HEADS - 1 downto 0);         -- polarity, exchange and filter length of each head
    filter_length        : in    std_ulogic_vector(7 downto 0);                      -- clocks, of the heads whose own length is 0
    delays               : in    std_ulogic_vector(8 * HEADS - 1 downto 0);          -- clocks
    minimum_edge_spacing : in    u_unsigned(15 downto 0);                            -- clocks
    index_tolerance      : in    u_unsigned(15 downto 0);                            -- counts
    zero_again           : in    std_ulogic;                                         -- level: find the zero again after lost counts
    heal                 : in    std_ulogic;                                         -- level: put lost counts back
    -- Commands, for each head
    clear                : in    std_ulogic_vector(1 to HEADS);                      -- pulse: clear the faults
    rearm                : in    std_ulogic_vector(1 to HEADS);                      -- level: hold the head at angle zero
    -- Results
    decoded              : out   decoded_heads(1 to HEADS)                           -- positions, indices and faults
  );
end entity encoder_heads;

architecture rtl of encoder_heads is

  -- Returns the filter length of a head: its own length or, if that is 0, the length that all heads share.
  function filter_of (own, both : std_ulogic_vector(7 downto 0)) return u_unsigned is
  begin

    if (or own) = '0' then
      return u_unsigned(both);
    end if;
    return u_unsigned(own);

  end function filter_of;

begin

  every_head : for number in 1 to HEADS generate

    alias settings : std_ulogic_vector(15 downto 0) is pin_settings(16 * number - 1 downto 16 * number - 16);

    signal a                 : std_ulogic;
    signal b                 : std_ulogic;
    signal z                 : std_ulogic;
    signal own_filter_length : u_unsigned(7 downto 0) := (others => '0');
    signal finds_again       : std_ulogic;
    signal heals             : std_ulogic;
    signal agrees            : std_ulogic;

  begin

    selection : entity work.input_selection
      port map (
        pin_a    => pins(3 * number - 2),
        pin_b    => pins(3 * number - 1),
        pin_z    => pins(3 * number),
        invert_a => settings(0),
        invert_b => settings(1),
        invert_z => settings(2),
        swap_ab  => settings(3),
        a        => a,
        b        => b,
        z        => z
      );

    -- The filter length is selected one clock before the filter uses it.
    choose_filter : process (clock) is
    begin

      if rising_edge(clock) then
        own_filter_length <= filter_of(settings(15 downto 8), filter_length);
      end if;

    end process choose_filter;

    decoder : entity work.quadrature_decoder
      generic map (
        DELAYED => MEAN
      )
      port map (
        clock                => clock,
        reset                => reset,
        a                    => a,
        b                    => b,
        z                    => z,
        counts_per_rev       => counts_per_rev,
        delay                => u_unsigned(delays(8 * number - 1 downto 8 * number - 8)),
        filter_length        => own_filter_length,
        minimum_edge_spacing => minimum_edge_spacing,
        index_tolerance      => index_tolerance,
        timestamp            => timestamp,
        clear                => clear(number),
        rearm                => rearm(number),
        zero_again           => finds_again,
        heal                 => heals,
        other_head_agrees    => agrees,
        decoded              => decoded(number)
      );

    counts_again : if number = 1 or MEAN generate

      finds_again <= zero_again;
      heals       <= heal;

      next_head_as_witness : entity work.zero_witness
        port map (
          clock          => clock,
          reset          => reset,
          rearm          => rearm(number),
          index_strobe   => decoded(number).index_strobe,
          trusted        => decoded(number).index_trusted,
          other_position => decoded(number mod HEADS + 1).position,
          counts_per_rev => counts_per_rev,
          tolerance      => index_tolerance,
          agrees         => agrees
        );

    else generate
      finds_again <= '0';
      heals       <= '0';
      agrees      <= '0';
    end generate counts_again;

  end generate every_head;

end architecture rtl;
