-- SPDX-License-Identifier: Apache-2.0
--
-- # plausibility_check
--
-- Stores and counts the faults of a head: misplaced index marks, illegal transitions of A and B, edges that follow
-- each other too fast, and edges that the filter suppressed. Source: section 3.1 of the paper.
--
-- **Latency.** illegal follows `edge.breaks_order`, and index_error follows `misplaced`, by 1 clock; overspeed follows
-- `edge.moves` by 2 clocks. `swallowed`, and `overspeed` for edges that the filter suppresses, come 3 clocks after the
-- levels before the filter.
--
-- **Number formats.** filter_length u8.0 and minimum_edge_spacing u16.0 clocks; counters u16.0.
--
-- **Faults.** `illegal`: A and B changed in the same clock. `overspeed`: a counted edge came less than
-- minimum_edge_spacing clocks after the previous edge (0 and 1 disable this check). This check ignores illegal
-- transitions. Edges that the filter suppresses also count as overspeed, and set `swallowed` too, because counts are
-- lost. To detect such edges the entity also decodes the levels before the filter. It sets and counts `overspeed` when
-- the count of these levels differs by a whole period of A and B (4 counts) from the count of the filtered levels, or
-- when these levels have made 4 illegal transitions that the filtered levels do not show. After the pins have been
-- quiet for filter_length clocks this comparison restarts. A pulse on one pin that is shorter than filter_length clocks
-- has no effect on this comparison, unless another pin changes during the pulse: then the pulse cannot be distinguished
-- from a lost period.
--
-- **Clear semantics.** index_error, illegal, overspeed and swallowed stay set, and their counters saturate at
-- 65,535, until `clear` or reset. A fault in the clock of a clear is kept: flag set, counter 1.
--
-- **Reset** clears all flags and counters. While `settling` is high, the entity ignores the levels before the filter.

library ieee;
  use ieee.std_logic_1164.all;
  use ieee.numeric_std.all;

  use work.decoder_pkg.all;
  use work.number_formats_pkg.all;

entity plausibility_check is
  port (
    clock                : in    std_ulogic;
    reset                : in    std_ulogic;
    settling             : in    std_ulogic;             -- level: the unfiltered levels are from before the end of the reset
    a                    : in    std_ulogic;             -- before the filter
    b                    : in    std_ulogic;             -- before the filter
    edge                 : in    counted_edge;           -- steps of the filtered levels
    misplaced            : in    std_ulogic;             -- strobe: an index mark lies outside the tolerance
    filter_length        : in    u_unsigned(7 downto 0); -- clocks, 1 is off
    minimum_edge_spacing : in    u_unsigned(15 downto 0); -- clocks, 0 is off
    clear                : in    std_ulogic;             -- pulse: clears the faults
    index_error          : out   std_ulogic;             -- sticky: an index mark was misplaced
    index_error_count    : out   u_unsigned(15 downto 0); -- number of these faults; saturates
    illegal              : out   std_ulogic;             -- sticky: A and B changed in the same clock
    illegal_count        : out   u_unsigned(15 downto 0); -- number of these faults; saturates
    overspeed            : out   std_ulogic;             -- sticky: edges came too fast
    overspeed_count      : out   u_unsigned(15 downto 0); -- number of these faults; saturates
    swallowed            : out   std_ulogic              -- sticky: the filter suppressed counts
  );
end entity plausibility_check;

architecture rtl of plausibility_check is

  constant LONGEST_FILTER : u_unsigned(7 downto 0) := (others => '1'); -- clocks

  -- A small number of counts. Its sums are a table, because they are too narrow for a carry chain.
  subtype few_counts is u_signed(3 downto 0);

  type tables is array (natural range <>) of few_counts;

  -- Returns the table of the counts by which the unfiltered levels are ahead of the filtered levels, after a step of
  -- one or both. Index: these counts before the step (bits 6 to 4); the unfiltered levels make a step (bit 3), the step
  -- is up (bit 2); the filtered levels make a step (bit 1), the step is up (bit 0). A period or more, up or down, is
  -- COUNTS_PER_PERIOD in the table.
  function ahead_after_steps return tables is

    variable table : tables(0 to 127);
    variable ahead : integer range -6 to 5;

  begin

    for bits in table'range loop
      ahead := to_integer(u_signed(to_unsigned(bits / 16, 3)));
      if (bits / 8 mod 2 = 1) then
        ahead := ahead + 2 * (bits / 4 mod 2) - 1;
      end if;
      if (bits / 2 mod 2 = 1) then
        ahead := ahead - 2 * (bits mod 2) + 1;
      end if;
      table(bits) := to_signed(COUNTS_PER_PERIOD, 4);
      if (abs ahead < COUNTS_PER_PERIOD) then
        table(bits) := to_signed(ahead, 4);
      end if;
    end loop;

    return table;

  end function ahead_after_steps;

  constant AHEAD_AFTER : tables := ahead_after_steps;

  function saturating_increment (count : u_unsigned(15 downto 0)) return u_unsigned is
  begin

    if (count = FAULT_COUNT_MAX) then
      return count;
    end if;
    return count + 1;

  end function saturating_increment;

begin

  check : process (clock) is

    -- A and B before the filter one clock ago, their changes, and their step of one clock ago
    variable raw_before    : std_ulogic_vector(1 downto 0)   := (others => '0');
    variable raw_changes   : std_ulogic_vector(1 downto 0);
    variable raw_moves     : std_ulogic                      := '0';
    variable raw_up        : std_ulogic                      := '0';
    variable raw_breaks    : std_ulogic                      := '0';
    -- Number of clocks since the last change of the levels before the filter, minus one
    variable still         : u_unsigned(7 downto 0)          := (others => '0');
    variable is_quiet      : std_ulogic                      := '0';
    -- Counts by which the levels before the filter are ahead of the filtered levels, and number of illegal transitions
    -- that the filter hides
    variable ahead         : u_signed(2 downto 0)            := "000";
    variable ahead_now     : few_counts;
    variable hidden_breaks : natural range 0 to COUNTS_PER_PERIOD - 1 := 0;
    variable edges_lost    : std_ulogic                      := '0';
    -- Clocks since the last counted edge. It is an integer, because a vector that counts in every clock makes an idle
    -- simulation 4 times slower.
    variable spacing       : natural range 0 to EDGE_SPACING_MAX := EDGE_SPACING_MAX;
    variable too_near      : std_ulogic                      := '0';
    variable too_fast      : std_ulogic;

  begin

    if rising_edge(clock) then
      -- Record the faults of the previous clock.
      too_fast := too_near or edges_lost;
      if (clear = '1') then
        index_error       <= misplaced;
        index_error_count <= (0 => misplaced, others => '0');
        illegal           <= edge.breaks_order;
        illegal_count     <= (0 => edge.breaks_order, others => '0');
        overspeed         <= too_fast;
        overspeed_count   <= (0 => too_fast, others => '0');
        swallowed         <= edges_lost;
      else
        if (edges_lost = '1') then
          swallowed <= '1';
        end if;
        if (misplaced = '1') then
          index_error       <= '1';
          index_error_count <= saturating_increment(index_error_count);
        end if;
        if (edge.breaks_order = '1') then
          illegal       <= '1';
          illegal_count <= saturating_increment(illegal_count);
        end if;
        if (too_fast = '1') then
          overspeed       <= '1';
          overspeed_count <= saturating_increment(overspeed_count);
        end if;
      end if;

      -- Check the spacing of the counted edges.
      too_near := '0';
      if (edge.moves = '1') then
        if (spacing < minimum_edge_spacing) then
          too_near := '1';
        end if;
        spacing := 1;
      elsif (spacing /= EDGE_SPACING_MAX) then
        spacing := spacing + 1;
      end if;

      -- Find the edges that the filter suppresses: compare the steps of the previous clock at its input and at its
      -- output.
      edges_lost := '0';
      if (settling = '1' or is_quiet = '1') then
        ahead         := "000";
        hidden_breaks := 0;
      else
        ahead_now  := AHEAD_AFTER(to_integer(u_unsigned(std_ulogic_vector(ahead) & raw_moves & raw_up
                                                        & not edge.stands & not edge.down)));
        ahead      := ahead_now(ahead'range);
        edges_lost := ahead_now ?= COUNTS_PER_PERIOD;
        if (edge.breaks_order = '1') then
          hidden_breaks := 0;
        elsif (raw_breaks = '1' and hidden_breaks = COUNTS_PER_PERIOD - 1) then
          edges_lost := '1';
        elsif (raw_breaks = '1') then
          hidden_breaks := hidden_breaks + 1;
        end if;
        if (edges_lost = '1') then
          ahead         := "000";
          hidden_breaks := 0;
        end if;
      end if;

      raw_changes := (a & b) xor raw_before;
      raw_moves   := raw_changes(1) xor raw_changes(0);
      raw_breaks  := raw_changes(1) and raw_changes(0);
      raw_up      := a xor raw_before(0);
      is_quiet    := '0';
      if (raw_changes /= "00") then
        still := (others => '0');
      else
        is_quiet := still ?>= filter_length;
        if (still /= LONGEST_FILTER) then
          still := still + 1;
        end if;
      end if;
      raw_before := a & b;

      if (reset = '1') then
        spacing           := EDGE_SPACING_MAX;
        too_near          := '0';
        edges_lost        := '0';
        index_error       <= '0';
        index_error_count <= (others => '0');
        illegal           <= '0';
        illegal_count     <= (others => '0');
        overspeed         <= '0';
        overspeed_count   <= (others => '0');
        swallowed         <= '0';
      end if;
    end if;

  end process check;

end architecture rtl;
