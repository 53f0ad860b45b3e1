-- SPDX-License-Identifier: Apache-2.0
--
-- # table_speed
--
-- Measures the travel of the table in a window of time, and the clocks of the window. table_conditions divides the
-- travel by the travel at the nominal speed; the ratio is the modulator `speed` of the lanes. The travel is measured in
-- the corrected angle with its fraction. A window begins and ends where the reading passes from one period of A and B
-- to the next, so that unequal distances of the four edges of a period do not matter.
--
-- **Window.** A window ends with the first such passage after 2**WINDOW = 16,384 clocks (164 µs at 100 MHz). The mean
-- over the window is the only filter. If a period of A and B takes longer, a window is one period.
--
-- **Slowing down.** If no passage comes for 2**WINDOW clocks, the table moves at most 4 counts in that time. The entity
-- then reports a bound, with `is_bound` high: |speed| is at most 8 counts / (time since the window began). The first
-- bound comes when the window is twice 2**WINDOW clocks old, and a new one every 2**WINDOW clocks. If the window
-- contains earlier passages, its mean belongs to a faster motion: it is not reported, and the next passage begins a new
-- window.
--
-- **Standstill.** If no window ends for 2**LONGEST - 1 = 2²⁴ - 1 clocks (168 ms at 100 MHz), the entity reports the
-- speed 0. A vibration across one passage moves less than 2 counts and gives speed 0, so that the speed does not
-- chatter.
--
-- **Error.** In steady motion each end of a window lies within a clock of its passage, so the relative error of the
-- ratio is at most 1 / 2¹⁴ = 6·10⁻⁵; the rounding of the quotient adds at most 2⁻¹⁷ to the ratio.
--
-- **Feedback.** Lanes that follow the speed move the corrected angle, in which the speed is measured. If the correction
-- changes by g times the change of the travel in a window, a measured speed is wrong by g times the difference of the
-- two speeds measured before it. Lanes that correct a latency τ have g = τ / (2**WINDOW clocks). In general |g| is at
-- most the sum of the amplitudes of these lanes, doubled for the squared speed, divided by the travel in a window at the
-- nominal speed. The speed settles for -1/2 < g < 1; export and firmware refuse lanes with |g| above SPEED_FEEDBACK_EIGHTHS / 8.
--
-- **Lag.** The mean of a window is half a window old when the window ends, and one and a half windows old when the next
-- window ends: 0.08 to 0.25 ms at 100 MHz, plus a period of A and B; the division adds 3 µs at the most.
--
-- **In a servo's loop.** Lanes that correct a latency τ add τ times the measured speed to the output. For a vibration of
-- frequency f up to 1 / (8 windows), 760 Hz at 100 MHz, the amplitude of the output is at most 1 + 2πfτ times that of
-- the table, and its phase leads by at most asin(2πfτ): for τ = 20 µs and 500 Hz 1.06 times and 3.6°.
--
-- **Range.** The entity measures speeds from one period of A and B in 168 ms up to one count per clock.
--
-- **Latency.** 3 clocks from `position` and `correction` to the outputs, which keep their values until the next
-- `measured`.
--
-- **Number formats.** position s31.0 counts; correction s19.11 counts; travel u20.11 counts; elapsed u24.0 clocks.
--
-- **Reset** ends the window; until the next window ends, the entity reports only bounds (0 at a standstill).

library ieee;
  use ieee.std_logic_1164.all;
  use ieee.numeric_std.all;

  use work.conditions_pkg.all;
  use work.number_formats_pkg.all;

entity table_speed is
  generic (
    WINDOW         : positive range 4 to 20 := SPEED_WINDOW_BITS; -- log2 of the clocks of a window
    LONGEST        : positive range 6 to 24 := SPEED_LONGEST_BITS -- log2 of the clocks after which the speed is 0 if no window has ended
  );
  port (
    clock          : in    std_ulogic;
    reset          : in    std_ulogic;
    position       : in    u_signed(POSITION_WIDTH - 1 downto 0);             -- counts, corrected
    correction     : in    u_signed(CORRECTION_WIDTH - 1 downto 0);           -- counts, s19.11, already subtracted from position
    measured       : out   std_ulogic                                := '0';  -- strobe: the other outputs are new
    travel         : out   u_unsigned(TRAVEL_WIDTH - 1 downto 0);             -- counts, u20.11; one unit too small if the angle fell
    is_down        : out   std_ulogic                                := '0';  -- high if the angle fell in the window
    is_bound       : out   std_ulogic                                := '0';  -- high if the ratio is an upper bound of the speed
    elapsed        : out   u_unsigned(ELAPSED_WIDTH - 1 downto 0)             -- clocks of the travel
  );
end entity table_speed;

architecture rtl of table_speed is

  constant FINE_WIDTH : positive := TRAVEL_WIDTH + 1;
  -- SPEED_TREMBLE_COUNTS and SPEED_BOUND_COUNTS in units of 2⁻¹¹ count
  constant TREMBLE    : positive := SPEED_TREMBLE_COUNTS * 2 ** CORRECTION_FRACTION;
  constant MOST_QUIET : positive := SPEED_BOUND_COUNTS * 2 ** CORRECTION_FRACTION;

  subtype fine_count is u_signed(FINE_WIDTH - 1 downto 0);

begin

  assert WINDOW < LONGEST
    report "table_speed: a window of 2**WINDOW clocks must be shorter than the time after which the speed is 0"
    severity failure;

  measure : process (clock) is

    -- Registers; the number in a name is the number of clocks from the position until the register is valid.
    variable fine_1       : fine_count                               := (others => '0');
    variable period_1     : u_unsigned(3 downto 0)                   := (others => '0');
    variable period_2     : u_unsigned(3 downto 0)                   := (others => '0');
    variable fine_2       : fine_count                               := (others => '0');
    variable way_2        : fine_count                               := (others => '0');
    variable passes_2     : std_ulogic                               := '0';
    -- The window: angle at its beginning, and clocks since then
    variable base         : fine_count                               := (others => '0');
    variable age          : u_unsigned(LONGEST - 1 downto 0)         := (others => '0');
    -- is_anchored: the window began with a passage. has_passed: the window contained further passages
    variable is_anchored  : std_ulogic                               := '0';
    variable has_passed   : std_ulogic                               := '0';
    variable was_over     : std_ulogic                               := '0';

    variable raw          : u_unsigned(5 downto 0);
    variable is_full      : std_ulogic;
    variable is_tick      : std_ulogic;
    variable is_over      : std_ulogic;
    variable size         : fine_count;
    variable begins       : std_ulogic;

  begin

    if rising_edge(clock) then
      -- Third clock: decide whether the window ends.
      is_full := or age(LONGEST - 1 downto WINDOW);
      is_tick := is_full and not (or age(WINDOW - 1 downto 0)) and (or age(LONGEST - 1 downto WINDOW + 1));
      is_over := and age;
      size    := way_2 xor (way_2'range => way_2(way_2'high));
      begins  := '0';

      measured <= '0';
      if passes_2 = '1' and is_full = '1' and is_anchored = '1' and is_over = '0' then
        measured       <= '1';
        is_bound       <= '0';
        is_down        <= way_2(way_2'high);
        elapsed  <= resize(age, ELAPSED_WIDTH);
        travel         <= u_unsigned(size(travel'range));
        if size < TREMBLE then
          travel <= (others => '0');
        end if;
        begins := '1';
      elsif passes_2 = '1' and is_anchored = '0' then
        begins := '1';
      elsif (is_over = '1' and was_over = '0') or is_tick = '1' then
        measured       <= '1';
        is_bound       <= '1';
        elapsed  <= resize(age, ELAPSED_WIDTH);
        travel         <= to_unsigned(MOST_QUIET, TRAVEL_WIDTH);
        if is_over = '1' then
          travel      <= (others => '0');
          is_anchored := '0';
        elsif has_passed = '1' then
          is_anchored := '0';
        end if;
      end if;

      was_over := is_over;

      if begins = '1' then
        base        := fine_2;
        is_anchored := '1';
        has_passed  := '0';
        age         := to_unsigned(1, LONGEST);
      elsif is_over = '0' then
        has_passed  := has_passed or passes_2;
        age         := age + 1;
      end if;

      -- Second clock: compute the travel, and find a passage to another period of A and B.
      way_2    := fine_1 - base;
      fine_2   := fine_1;
      passes_2 := period_1 ?/= period_2;
      period_2 := period_1;

      -- First clock: compute the reading and the corrected position with its fraction. The reading is the corrected
      -- position plus the rounded correction.
      raw      := u_unsigned(position(5 downto 0)) + u_unsigned(correction(CORRECTION_FRACTION + 5 downto CORRECTION_FRACTION))
                  + ("" & correction(CORRECTION_FRACTION - 1));
      period_1 := raw(5 downto 2);
      fine_1   := (position(FINE_WIDTH - CORRECTION_FRACTION - 1 downto 0) & (CORRECTION_FRACTION - 1 downto 0 => '0'))
                  - correction(CORRECTION_FRACTION - 1 downto 0);

      if reset = '1' then
        measured    <= '0';
        is_anchored := '0';
        has_passed  := '0';
        was_over    := '0';
        age         := (others => '0');
        passes_2    := '0';
      end if;
    end if;

  end process measure;

end architecture rtl;
