-- SPDX-License-Identifier: Apache-2.0
--
-- # index_detector
--
-- Detects the index mark in Z: assigns each change of Z to a step of A or B and states when, in which direction and at
-- which side of the step the position passes the mark. Source: section 3.1 and figure 5 of the paper.
--
-- **Latency.** `meets` is high INDEX_SKEW clocks after the `edge.moves` of the step of the mark or, if the next step
-- comes earlier, in the clock of the next step's `edge.moves`. The other outputs belong to this clock and keep their
-- value until Z has been sampled for another step.
--
-- **Number formats.** The inputs and outputs are single bits.
--
-- **Mark.** The mark is one edge of Z: the rising edge while counting up, which is the falling edge while counting down.
-- Each change of Z is assigned to the step of A or B that is at most INDEX_SKEW clocks before or after it: the level of
-- Z is sampled INDEX_SKEW clocks after the step, or just before the next step, and compared with the level sampled for
-- the step before. While counting up, the mark lies at the position after the step; while counting down, it lies at the
-- position before the step. So both directions give the same count. If Z changes within a count, more than INDEX_SKEW
-- clocks from both edges of the count, the mark lies at this count (`is_inside` is high), and its direction is that of
-- the step that leaves the count. So a reversal within the count has no effect, and the direction is always that of the
-- present motion. Even with skewed pins or a vibration at one edge of the mark, the entity distinguishes the two edges of
-- the mark if the time between two opposite steps is longer than the time between a change of Z and its step. A
-- `filter_length` above INDEX_SKEW ensures this. If Z normally changes within a count, but at one speed changes near an
-- edge of that count, the index is one count off at that speed.
--
-- **Fastest index.** With pins skewed by up to s clocks, 1 to INDEX_SKEW, a count must last at least s + INDEX_SKEW + 1
-- clocks for this detection, that is 5, 6 or 7 clocks; 7 clocks are 14 million counts per second at 100 MHz. If Z
-- changes half a count from its step, the limit is twice 7 clocks. At higher speeds a change of Z before a step cannot
-- be distinguished from a change after the previous step, and the entity may take the other edge of a mark. With pins
-- that change in the same clock each mark is placed correctly at any speed. A Z edge before the first step after reset
-- belongs to that step.
--
-- **Reset** drops a step for which Z has not been sampled. While `preload` is high, a change of Z does not count as a
-- mark; detection starts from the level that Z has in the last clock of `preload`.

library ieee;
  use ieee.std_logic_1164.all;
  use ieee.numeric_std.all;

  use work.decoder_pkg.all;
  use work.number_formats_pkg.all;

entity index_detector is
  port (
    clock         : in    std_ulogic;
    reset         : in    std_ulogic;
    preload       : in    std_ulogic;        -- level: detection starts from the present level of Z
    z             : in    std_ulogic;        -- index, filtered
    edge          : in    counted_edge;
    meets         : out   std_ulogic := '0'; -- strobe: a mark that belongs to the previous step is detected
    is_up         : out   std_ulogic := '1'; -- '1': the mark is passed upwards
    is_inside     : out   std_ulogic := '0'; -- high if Z changed within a count, which the step left
    leaves_inside : out   std_ulogic := '0'  -- is_inside and is_up
  );
end entity index_detector;

architecture rtl of index_detector is

begin

  detect : process (clock) is

    -- Level of Z one clock ago
    variable before         : std_ulogic                             := '0';
    -- index_level is the level of Z that is assigned to the last step, or to the count before it. until_settled is the
    -- number of clocks until Z is sampled for the present step, since_settled the number of clocks since then
    variable index_level    : std_ulogic                             := '0';
    variable until_settled  : natural range 0 to INDEX_SKEW          := 0;
    variable since_settled  : natural range 0 to INDEX_SKEW + 1      := 0;
    variable settled_level  : std_ulogic;
    variable settles        : std_ulogic;
    -- Levels of Z in the clocks before, the latest in the low bit
    variable earlier_levels : std_ulogic_vector(INDEX_SKEW downto 0) := (others => '0');
    -- was_inside is high if Z changed within the count that the present step left; may_be_inside is high if Z may have
    -- changed there
    variable may_be_inside  : std_ulogic;
    variable was_inside     : std_ulogic                             := '0';
    variable meets_inside   : std_ulogic;

  begin

    if rising_edge(clock) then
      -- Assign a level of Z to the previous step. It is sampled after the pins have settled, or is the last level before
      -- the present step.
      settled_level := z;
      settles       := '0';
      -- may_be_inside is high if Z has had time to change again within the count that the present step leaves.
      may_be_inside := '0';
      if (until_settled = 0 and since_settled >= INDEX_SKEW) then
        may_be_inside := '1';
      end if;

      if (until_settled /= 0) then
        if (edge.comes = '1') then
          settled_level := before;
          settles       := '1';
        elsif (until_settled = 1) then
          settles := '1';
        end if;
        until_settled := until_settled - 1;
      end if;

      if (since_settled <= INDEX_SKEW) then
        since_settled := since_settled + 1;
      end if;

      meets <= '0';
      if (settles = '1') then
        meets_inside  := was_inside and (index_level xnor edge.up);
        meets         <= meets_inside or ((settled_level xor index_level) and (settled_level xnor edge.up));
        is_up         <= edge.up;
        is_inside     <= meets_inside;
        leaves_inside <= edge.up and meets_inside;
        index_level   := settled_level;
        until_settled := 0;
        since_settled := 0;
      end if;

      if (preload = '1') then
        meets         <= '0';
        until_settled := 0;
        since_settled := 0;
        index_level   := z;
      end if;

      if (edge.comes = '1') then
        until_settled := INDEX_SKEW;
        was_inside    := '0';
        if (may_be_inside = '1') then
          was_inside  := earlier_levels(INDEX_SKEW) xor index_level;
          index_level := earlier_levels(INDEX_SKEW);
        end if;
      end if;
      earlier_levels := earlier_levels(INDEX_SKEW - 1 downto 0) & z;
      before         := z;

      if (reset = '1') then
        until_settled := 0;
        meets         <= '0';
      end if;
    end if;

  end process detect;

end architecture rtl;
