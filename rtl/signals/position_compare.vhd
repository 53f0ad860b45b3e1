-- SPDX-License-Identifier: Apache-2.0
--
-- # position_compare
--
-- Tells with a strobe when the corrected position reaches a given count, and each multiple of an interval from there: the
-- signal that fires a camera or a laser at even angles.
--
-- **Latency.** 2 clocks from `position` to `strobe`.
--
-- **Number formats.** position, first s31.0 counts; interval u24.0 counts, 0: `first` alone. Differences hold across the
-- wrap of the position as long as it is within 2**31 counts.
--
-- **Arming.** `arm` (pulse) begins anew with `first` and `interval`. `first` is reached when the position comes to it, or passes it,
-- from the side on which it was at the arming, or leaves it where it stood there. From then on the place reached last is
-- left when the position is a whole interval away from it, in either direction: the next place is then reached. So a
-- position that trembles on a place gives one strobe. A position that jumps further gives a strobe a clock until it has
-- caught up.
--
-- **Reset** disarms.

library ieee;
  use ieee.std_logic_1164.all;
  use ieee.numeric_std.all;

  use work.number_formats_pkg.all;

entity position_compare is
  port (
    clock    : in    std_ulogic;
    reset    : in    std_ulogic;
    arm      : in    std_ulogic;                              -- pulse
    position : in    u_signed(POSITION_WIDTH - 1 downto 0);   -- counts
    first    : in    u_signed(POSITION_WIDTH - 1 downto 0);   -- counts
    interval : in    u_unsigned(ANGLE_WIDTH - 1 downto 0);    -- counts, 0: once
    armed    : out   std_ulogic := '0';                       -- level: it waits for a place
    strobe   : out   std_ulogic := '0'
  );
end entity position_compare;

architecture rtl of position_compare is

  type compare_state is (IDLE, MEASURE, WAIT_FIRST, TRACK);

begin

  compare : process (clock) is

    variable state    : compare_state                         := IDLE;
    variable place    : u_signed(POSITION_WIDTH - 1 downto 0) := (others => '0');
    variable step     : u_signed(POSITION_WIDTH - 1 downto 0) := (others => '0');
    variable distance : u_signed(POSITION_WIDTH - 1 downto 0) := (others => '0');
    variable below    : std_ulogic                            := '0'; -- the side of the arming

  begin

    if rising_edge(clock) then
      strobe <= '0';

      case state is

        when IDLE =>
          null;

        when MEASURE =>
          below := distance(distance'high);
          state := WAIT_FIRST;

        when WAIT_FIRST =>
          if (below = '1' and distance(distance'high) = '0') or (below = '0' and distance <= 0) then
            strobe <= '1';
            state  := TRACK;
            if step = 0 then
              state := IDLE;
            end if;
          end if;

        when TRACK =>
          if distance >= step then
            strobe   <= '1';
            place    := place + step;
          elsif distance <= -step then
            strobe   <= '1';
            place    := place - step;
          end if;

      end case;

      distance := position - place;

      if arm = '1' then
        state    := MEASURE;
        place    := first;
        step     := signed(resize(interval, POSITION_WIDTH));
        distance := position - first;
      end if;

      if reset = '1' then
        state  := IDLE;
        strobe <= '0';
      end if;

      armed <= '1';
      if state = IDLE then
        armed <= '0';
      end if;
    end if;

  end process compare;

end architecture rtl;
