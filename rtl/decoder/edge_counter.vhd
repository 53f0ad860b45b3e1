-- SPDX-License-Identifier: Apache-2.0
--
-- # edge_counter
--
-- Compares the filtered levels of A and B with the levels one clock before, and counts their edges (x4) into a
-- multi-turn position. Source: section 3.1 and figure 4 of the paper: A leads B counter-clockwise, (A, B) = 00, 10, 11,
-- 01 counts up.
--
-- **Latency.** 2 clocks from a change of `a` or `b` to `position`. `edge.comes` belongs to the clock of the levels, the
-- other fields of `edge` to the clock after it. position, direction, step, step_up and last_edge_time change in the
-- same clock.
--
-- **Number formats.** position s31.0 counts; timestamp and last_edge_time u64.0 clocks.
--
-- **Position** starts at RESET_POSITION on reset; only edges change it. It wraps modulo 2³²: readers use
-- differences, which are correct as long as they lie within +-2³¹ counts.
--
-- **Phase.** `phase_of_zero` is the index of (A, B) in the sequence 00, 10, 11, 01 at the positions that are multiples
-- of 4. It follows the levels by 3 clocks, one clock after the position. After the reset only illegal transitions
-- change it.
--
-- **Order.** If A and B change in the same clock, the direction is unknown: `edge.breaks_order` is high and the
-- position does not change.
--
-- **Reset.** While `preload` is high, changes of the levels do not count as edges; counting starts from the levels in
-- the last clock of `preload`.
--
-- **last_edge_time** is the timestamp of the clock that counted the edge, one clock before the position changes.

library ieee;
  use ieee.std_logic_1164.all;
  use ieee.numeric_std.all;

  use work.decoder_pkg.all;
  use work.number_formats_pkg.all;

entity edge_counter is
  generic (
    RESET_POSITION : integer := 0 -- counts
  );
  port (
    clock          : in    std_ulogic;
    reset          : in    std_ulogic;
    preload        : in    std_ulogic;                              -- level: counting starts from the present levels
    a              : in    std_ulogic;                              -- filtered
    b              : in    std_ulogic;                              -- filtered
    timestamp      : in    u_unsigned(TIMESTAMP_WIDTH - 1 downto 0); -- clocks
    edge           : out   counted_edge;
    position       : out   u_signed(POSITION_WIDTH - 1 downto 0);   -- counts, multi-turn
    phase_of_zero  : out   u_unsigned(1 downto 0);                  -- index of (A, B) in 00, 10, 11, 01 at position 0 modulo 4
    direction      : out   std_ulogic;                              -- '1': the last step was up
    step           : out   std_ulogic;                              -- strobe: position changed
    step_up        : out   std_ulogic;                              -- strobe: position rose
    last_edge_time : out   u_unsigned(TIMESTAMP_WIDTH - 1 downto 0) -- clocks
  );
end entity edge_counter;

architecture rtl of edge_counter is

  -- The levels of A and B one clock ago, and for each level whether it has changed in this clock
  signal a_before  : std_ulogic := '0';
  signal b_before  : std_ulogic := '0';
  signal a_changes : std_ulogic;
  signal b_changes : std_ulogic;
  signal comes     : std_ulogic;

  signal moves        : std_ulogic := '0';
  signal stands       : std_ulogic := '1';
  signal up           : std_ulogic := '1';
  signal down         : std_ulogic := '0';
  signal breaks_order : std_ulogic := '0';

begin

  a_changes <= a xor a_before;
  b_changes <= b xor b_before;
  comes     <= (a_changes xor b_changes) and not preload;

  edge <=
  (
    comes        => comes,
    moves        => moves,
    stands       => stands,
    up           => up,
    down         => down,
    breaks_order => breaks_order
  );

  count : process (clock) is

    -- Index in 00, 10, 11, 01 of the levels (A, B) that belong to the position of the same clock
    variable place : u_unsigned(1 downto 0) := "00";

  begin

    if rising_edge(clock) then
      phase_of_zero <= place - u_unsigned(position(1 downto 0));

      -- Stage 2: count the step.
      place := b_before & (a_before xor b_before);
      if (preload = '1') then
        phase_of_zero <= "00";
        place         := b & (a xor b);
      end if;
      direction <= up;
      step      <= moves;
      step_up   <= moves and up;
      if (moves = '1') then
        if (up = '1') then
          position <= position + 1;
        else
          -- not (not x + 1) = x - 1, on the same carry chain as x + 1.
          position <= not (not position + 1);
        end if;
        last_edge_time <= timestamp;
      end if;

      -- Stage 1: compare the levels with the levels one clock before.
      breaks_order <= a_changes and b_changes and not preload;
      moves        <= comes;
      stands       <= not comes;
      if (comes = '1') then
        up   <= a xor b_before;
        down <= a xnor b_before;
      end if;
      a_before <= a;
      b_before <= b;

      if (reset = '1') then
        moves          <= '0';
        stands         <= '1';
        up             <= '1';
        down           <= '0';
        breaks_order   <= '0';
        position       <= to_signed(RESET_POSITION, POSITION_WIDTH);
        direction      <= '1';
        phase_of_zero  <= "00";
        step           <= '0';
        step_up        <= '0';
        last_edge_time <= (others => '0');
      end if;
    end if;

  end process count;

end architecture rtl;
