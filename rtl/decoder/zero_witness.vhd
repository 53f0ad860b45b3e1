-- SPDX-License-Identifier: Apache-2.0
--
-- # zero_witness
--
-- Says whether an index mark of one head is true, from what the other head counted since the last mark that
-- was trusted. Both heads read one disc: between two passages of the true mark the other head counts a turn
-- exactly, whatever this head lost. At a false mark it counts something else. A head that stands still or lost
-- counts itself never agrees.
--
-- **Latency.** `agrees` comes 2 clocks after `index_strobe` and belongs to that mark until the next one. The other head's
-- counts are those of 2 clocks before `index_strobe`.
--
-- **Number formats.** other_position s31.0 counts, of the other head; it may wrap. counts_per_rev u25.0 counts;
-- tolerance u16.0 counts: `agrees` is high where the other head counted one turn, up or down, within it.
--
-- **Trust.** `trusted` makes the last mark the one from which the other head's counts are taken. Until the first
-- one after a reset or `rearm` nothing agrees.
--
-- **Reset** forgets the trusted mark, as `rearm` does.

library ieee;
  use ieee.std_logic_1164.all;
  use ieee.numeric_std.all;

  use work.number_formats_pkg.all;
  use work.tolerance_pkg.all;

entity zero_witness is
  port (
    clock          : in    std_ulogic;
    reset          : in    std_ulogic;
    rearm          : in    std_ulogic;                                    -- level: forgets the trusted mark
    index_strobe   : in    std_ulogic;                                    -- a mark was told
    trusted        : in    std_ulogic;                                    -- strobe: it lies where the zero says
    other_position : in    u_signed(POSITION_WIDTH - 1 downto 0);         -- counts, of the other head
    counts_per_rev : in    u_unsigned(COUNTS_PER_REV_WIDTH - 1 downto 0); -- counts
    tolerance      : in    u_unsigned(15 downto 0);                       -- counts
    agrees         : out   std_ulogic := '0'                              -- 2 clocks after index_strobe
  );
end entity zero_witness;

architecture rtl of zero_witness is

  subtype count is u_signed(POSITION_WIDTH - 1 downto 0);

begin

  watch : process (clock) is

    variable is_known     : std_ulogic := '0';
    variable at_trusted   : count      := (others => '0');
    variable at_mark      : count      := (others => '0');
    -- other_position, a clock before and two
    variable position     : count      := (others => '0');
    variable position_then : count     := (others => '0');
    variable since        : count      := (others => '0');
    -- What lies between that and a turn up, and down
    variable off_up       : count      := (others => '0');
    variable off_down     : count      := (others => '0');
    -- From the trusted mark it counted a turn up, or down.
    variable is_turn_up   : std_ulogic := '0';
    variable is_turn_down : std_ulogic := '0';
    variable strobe_then  : std_ulogic := '0';

  begin

    if rising_edge(clock) then
      if strobe_then = '1' then
        agrees <= is_known and (is_turn_up or is_turn_down);
      end if;
      strobe_then := index_strobe;

      if index_strobe = '1' then
        at_mark := position_then;
      end if;
      is_turn_up    := is_within(off_up, tolerance);
      is_turn_down  := is_within(off_down, tolerance);
      off_up   := since - signed(resize(counts_per_rev, POSITION_WIDTH));
      off_down := since + signed(resize(counts_per_rev, POSITION_WIDTH));
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
