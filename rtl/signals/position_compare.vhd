-- SPDX-License-Identifier: Apache-2.0
--
-- # position_compare
--
-- Gives a strobe when the corrected position reaches a given count, and then at every interval from this count. The
-- strobe triggers, for example, a camera or a laser at evenly spaced angles. A place is a count at which a strobe
-- comes.
--
-- **Latency.** 2 clocks from `position` to `strobe`.
--
-- **Number formats.** position, first s31.0 counts; interval u24.0 counts; with an interval of 0 only `first` gives a
-- strobe. The comparison is correct across the wrap of the position if the distance between position and place is below
-- 2**31 counts.
--
-- **Arming.** A pulse of `arm` starts the comparison with new values of `first` and `interval`. The place `first` is
-- reached when the position comes to it, or passes it, from the side on which the position was in the clock of `arm`.
-- If the position was at `first`, this place is reached when the position leaves it in either direction. After that,
-- the next place is reached when the position is a whole interval away from the last place reached, in either
-- direction. So a position that vibrates at a place gives one strobe. If the position jumps by several intervals, a
-- strobe comes every third clock until all places passed have had their strobe. A pulse of `disarm` ends the
-- comparison, even in the clock of an `arm`.
--
-- **Reset** ends the comparison.

library ieee;
  use ieee.std_logic_1164.all;
  use ieee.numeric_std.all;

  use work.carry_save_pkg.all;
  use work.number_formats_pkg.all;

entity position_compare is
  port (
    clock    : in    std_ulogic;
    reset    : in    std_ulogic;
    arm      : in    std_ulogic;                              -- pulse
    disarm   : in    std_ulogic;                              -- pulse
    position : in    u_signed(POSITION_WIDTH - 1 downto 0);   -- counts
    first    : in    u_signed(POSITION_WIDTH - 1 downto 0);   -- counts
    interval : in    u_unsigned(ANGLE_WIDTH - 1 downto 0);    -- counts; 0: one strobe only
    armed    : out   std_ulogic := '0';                       -- level: the comparison waits for a place
    strobe   : out   std_ulogic := '0'
  );
end entity position_compare;

architecture rtl of position_compare is

  type compare_state is (IDLE, MEASURE, WAIT_FIRST, TRACK);

  subtype count is u_signed(POSITION_WIDTH - 1 downto 0);

begin

  compare : process (clock) is

    variable state    : compare_state := IDLE;
    variable place    : count         := (others => '0'); -- the first place, `first` of the last `arm`
    variable step     : count         := (others => '0');
    variable distance : count         := (others => '0');
    variable below    : std_ulogic    := '0';             -- when armed, the position was below `place`
    variable stood    : std_ulogic    := '0';             -- when armed, the position was at `place`
    variable is_there : std_ulogic;
    -- The next places upwards and downwards, and the position minus these places; from_lower is one count less, so that
    -- it is negative at the place too
    variable upper      : count       := (others => '0');
    variable lower      : count       := (others => '0');
    variable upper_then : count;
    variable lower_then : count;
    variable from_upper : count       := (others => '0');
    variable from_lower : count       := (others => '0');
    -- rose, fell: a place was reached one clock ago, upwards or downwards. is_stale: for two clocks after that,
    -- from_upper and from_lower still belong to the previous places.
    variable rose      : std_ulogic   := '0';
    variable fell      : std_ulogic   := '0';
    variable goes_up   : std_ulogic;
    variable goes_down : std_ulogic;
    variable is_stale  : std_ulogic_vector(1 downto 0) := "00";

  begin

    if rising_edge(clock) then
      strobe    <= '0';
      goes_up   := '0';
      goes_down := '0';

      upper_then := upper;
      lower_then := lower;
      if rose = '1' or fell = '1' or state = MEASURE then
        upper := less_or_more(upper, step, not fell);
        lower := less_or_more(lower, step, rose);
      end if;

      case state is

        when IDLE =>
          null;

        when MEASURE =>
          below := distance(distance'high);
          stood := distance ?= 0;
          state := WAIT_FIRST;

        when WAIT_FIRST =>
          is_there := distance ?= 0;
          if (stood xor is_there) = '1' or (stood = '0' and distance(distance'high) /= below) then
            strobe <= '1';
            state  := TRACK;
            if step = 0 then
              state := IDLE;
            end if;
          end if;

        when TRACK =>
          goes_up   := not from_upper(from_upper'high) and not (or is_stale);
          goes_down := from_lower(from_lower'high) and not (or is_stale);
          strobe    <= goes_up or goes_down;

      end case;

      is_stale := is_stale(0) & '0';
      if goes_up = '1' or goes_down = '1' then
        is_stale := "11";
      end if;
      rose := goes_up;
      fell := goes_down;

      distance   := position - place;
      from_upper := position - upper_then;
      from_lower := add_with_carry(position, not lower_then, '0');

      if arm = '1' then
        state    := MEASURE;
        place    := first;
        upper    := first;
        lower    := first;
        step     := signed(resize(interval, POSITION_WIDTH));
        distance := position - first;
        rose     := '0';
        fell     := '0';
        is_stale := "00";
      end if;

      if reset = '1' or disarm = '1' then
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
