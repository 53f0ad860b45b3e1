-- SPDX-License-Identifier: Apache-2.0
--
-- # zero_witness
--
-- Checks an index mark of one head against the counts of the other head since the last trusted mark. Both heads read
-- the same disc: from one passage of the true mark to the next in the same direction, the other head counts exactly one
-- turn, even if this head has lost counts. At a false mark the other head has counted more or less than a turn. If the
-- other head stands still or has lost more counts than the tolerance, `agrees` is low.
--
-- **Latency.** `agrees` is valid from 2 clocks after the `index_strobe` of a mark until the next mark. The other head's
-- counts are read 2 clocks before `index_strobe`.
--
-- **Number formats.** other_position s31.0 counts; it may wrap. counts_per_rev u25.0 counts; tolerance u16.0 counts:
-- `agrees` is high if the other head counted one turn, up or down, within the tolerance.
--
-- **Trust.** `trusted` makes the last mark the reference for the other head's counts. Before the first
-- trusted mark after a reset or `rearm`, `agrees` is low.
--
-- **Reset** clears the trusted mark; `rearm` also clears it.

library ieee;
  use ieee.std_logic_1164.all;
  use ieee.numeric_std.all;

  use work.carry_save_pkg.all;
  use work.number_formats_pkg.all;
  use work.tolerance_pkg.all;

entity zero_witness is
  port (
    clock          : in    std_ulogic;
    reset          : in    std_ulogic;
    rearm          : in    std_ulogic;                                    -- level: clears the trusted mark
    index_strobe   : in    std_ulogic;                                    -- strobe: a mark was detected
    trusted        : in    std_ulogic;                                    -- strobe: the mark lies at the zero
    other_position : in    u_signed(POSITION_WIDTH - 1 downto 0);         -- counts, of the other head
    counts_per_rev : in    u_unsigned(COUNTS_PER_REV_WIDTH - 1 downto 0); -- counts
    tolerance      : in    u_unsigned(15 downto 0);                       -- counts
    agrees         : out   std_ulogic := '0'                              -- level: the other head confirms the mark, see Latency
  );
end entity zero_witness;

architecture rtl of zero_witness is

  subtype count is u_signed(POSITION_WIDTH - 1 downto 0);

begin

  watch : process (clock) is

    variable is_known     : std_ulogic := '0';
    variable at_trusted   : count      := (others => '0');
    variable at_mark      : count      := (others => '0');
    -- other_position one clock ago and two clocks ago
    variable position     : count      := (others => '0');
    variable position_then : count     := (others => '0');
    variable since        : count      := (others => '0');
    -- Deviation of the other head's counts from a turn in their direction
    variable off          : count      := (others => '0');
    -- High if the other head has counted a turn since the trusted mark.
    variable is_turn      : std_ulogic := '0';
    variable strobe_then  : std_ulogic := '0';

  begin

    if rising_edge(clock) then
      if strobe_then = '1' then
        agrees <= is_known and is_turn;
      end if;
      strobe_then := index_strobe;

      if index_strobe = '1' then
        at_mark := position_then;
      end if;
      is_turn  := is_within(off, tolerance);
      off      := less_or_more(since, signed(resize(counts_per_rev, POSITION_WIDTH)), since(since'high));
      since    := other_position - at_trusted;
      position_then := position;
      position      := other_position;

      if trusted = '1' then
        at_trusted := at_mark;
        is_known   := '1';
      end if;

      if reset = '1' or rearm = '1' then
        is_known  := '0';
        agrees    <= '0';
      end if;
    end if;

  end process watch;

end architecture rtl;
