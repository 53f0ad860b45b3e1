-- SPDX-License-Identifier: Apache-2.0
--
-- # sample_trigger
--
-- Says when a sample is taken. Mode '0', equal time: every `sample_period` clocks (100000 is the
-- paper's 1 kHz at 100 MHz). Mode '1', equal angle: each time the turn position of head 1 reaches
-- the next multiple of `angle_step` above or below the multiple that was reached last. Source:
-- section 3.2 of the paper (sampling clock of 1 kHz); equal angle steps are what the Fourier
-- transform D21[n] of its equation (7) supposes.
--
-- **Latency.** `trigger` is high one clock after the clock that it belongs to: whoever latches
-- with it latches values delayed by one clock and so gets those of the crossing itself.
--
-- **Number formats.** turn_position s31.0 counts; angle_step u24.0 counts; sample_period u32.0
-- clocks.
--
-- **Equal time.** The first trigger belongs to the clock `sample_period` - 1 clocks after the
-- first enabled one. A change of `sample_period` holds from the interval under way on: an
-- interval already longer than the new period ends at once. 0 acts as 1.
--
-- **Equal angle.** The multiples are m * angle_step from the zero of the index, worked out exactly:
-- nothing accumulates an error. A multiple is reached at the same count from below and from above,
-- so readings taken while turning up and down lie on the same grid. The multiple reached last is
-- not reached again before a neighbour was: a table that trembles on a step gives one sample, and
-- a reversal shows as a step that is passed without a sample. The first multiple after the start is
-- reached from either side; a table that stands on a multiple at the start has to reach a
-- neighbour first. After the start, and after a change of angle_step, the grid is found by a
-- division of 31 clocks, together at most 35 clocks and one clock for each step passed meanwhile;
-- there is no trigger in that time. 0 gives no trigger. turn_position wraps modulo 2**32; the grid
-- goes on evenly across the wrap.
--
-- **Reset and enable.** `reset` and a low `enable` do the same: no trigger, and everything starts
-- afresh. turn_position may jump (first index) only while `enable` is low.

library ieee;
  use ieee.std_logic_1164.all;
  use ieee.numeric_std.all;

  use work.number_formats_pkg.all;

entity sample_trigger is
  port (
    clock         : in    std_ulogic;
    reset         : in    std_ulogic;
    enable        : in    std_ulogic;
    mode          : in    std_ulogic;                                -- '0' equal time, '1' equal angle
    sample_period : in    u_unsigned(31 downto 0);                   -- clocks
    angle_step    : in    u_unsigned(ANGLE_WIDTH - 1 downto 0);      -- counts
    turn_position : in    u_signed(POSITION_WIDTH - 1 downto 0);     -- counts from the index, head 1
    trigger       : out   std_ulogic                                 -- one clock a sample
  );
end entity sample_trigger;

architecture rtl of sample_trigger is

  type grid_state is (IDLE, DIVIDE, SET_LOWER, SET_UPPER, WALK, TRACK);

  signal time_trigger  : std_ulogic := '0';
  signal angle_trigger : std_ulogic := '0';

begin

  -- Only the selected mode triggers.
  trigger <= time_trigger or angle_trigger;

  equal_time : process (clock) is

    variable elapsed : u_unsigned(31 downto 0) := to_unsigned(1, 32); -- clocks, this one included

  begin

    if rising_edge(clock) then
      if elapsed >= sample_period then
        time_trigger <= '1';
        elapsed      := to_unsigned(1, 32);
      else
        time_trigger <= '0';
        elapsed      := elapsed + 1;
      end if;
      if reset = '1' or enable = '0' or mode = '1' then
        time_trigger <= '0';
        elapsed      := to_unsigned(1, 32);
      end if;
    end if;

  end process equal_time;

  equal_angle : process (clock) is

    variable state     : grid_state                           := IDLE;
    variable step      : u_unsigned(ANGLE_WIDTH - 1 downto 0) := (others => '0');
    variable dividend  : u_signed(POSITION_WIDTH - 1 downto 0) := (others => '0');
    variable origin    : u_signed(POSITION_WIDTH - 1 downto 0) := (others => '0');
    variable bits_left : natural range 0 to POSITION_WIDTH - 2 := 0;
    variable remainder : u_unsigned(ANGLE_WIDTH - 1 downto 0) := (others => '0');
    variable shifted   : u_unsigned(ANGLE_WIDTH downto 0);
    variable reduced   : u_unsigned(ANGLE_WIDTH + 1 downto 0);
    -- The multiples that trigger next, and the one reached last (unless none was: fresh).
    variable upper     : u_signed(POSITION_WIDTH - 1 downto 0) := (others => '0');
    variable lower     : u_signed(POSITION_WIDTH - 1 downto 0) := (others => '0');
    variable middle    : u_signed(POSITION_WIDTH - 1 downto 0) := (others => '0');
    variable fresh     : std_ulogic := '1';
    variable above     : u_signed(POSITION_WIDTH - 1 downto 0);
    variable below     : u_signed(POSITION_WIDTH - 1 downto 0);
    variable next_up   : u_signed(POSITION_WIDTH - 1 downto 0);
    variable next_down : u_signed(POSITION_WIDTH - 1 downto 0);
    variable on_lower  : boolean;

  begin

    if rising_edge(clock) then
      angle_trigger <= '0';
      -- Differences, not comparisons: they hold across the wrap of turn_position.
      above     := turn_position - upper;
      below     := lower - turn_position;
      on_lower  := turn_position = lower;
      next_up   := upper + signed(resize(step, POSITION_WIDTH));
      next_down := lower - signed(resize(step, POSITION_WIDTH));

      case state is

        when IDLE =>

          dividend  := turn_position;
          origin    := turn_position;
          bits_left := POSITION_WIDTH - 2;
          step      := angle_step;
          -- The sign bit weighs -2**31: the remainder of -1 starts the long division.
          remainder := (others => '0');
          if turn_position(POSITION_WIDTH - 1) = '1' then
            remainder := angle_step - 1;
          end if;
          if angle_step /= 0 then
            state := DIVIDE;
          end if;

        when DIVIDE =>

          shifted  := remainder & dividend(POSITION_WIDTH - 2);
          reduced  := ('0' & shifted) - step;
          dividend := shift_left(dividend, 1);
          if reduced(reduced'high) = '1' then
            remainder := shifted(ANGLE_WIDTH - 1 downto 0);
          else
            remainder := reduced(ANGLE_WIDTH - 1 downto 0);
          end if;
          if bits_left = 0 then
            state := SET_LOWER;
          else
            bits_left := bits_left - 1;
          end if;

        when SET_LOWER =>

          lower := origin - signed(resize(remainder, POSITION_WIDTH));
          upper := lower;
          state := SET_UPPER;

        when SET_UPPER =>

          upper := next_up;
          state := WALK;

        -- Follow what has moved during the division, until lower <= turn_position < upper.
        when WALK =>

          fresh := '1';
          if above(above'high) = '0' then
            lower := upper;
            upper := next_up;
          elsif on_lower then
            middle := lower;
            lower  := next_down;
            fresh  := '0';
            state  := TRACK;
          elsif below(below'high) = '0' then
            upper := lower;
            lower := next_down;
          else
            state := TRACK;
          end if;

        when TRACK =>

          if above(above'high) = '0' then
            angle_trigger <= '1';
            if fresh = '0' then
              lower := middle;
            end if;
            middle := upper;
            upper  := next_up;
            fresh  := '0';
          elsif below(below'high) = '0' then
            angle_trigger <= '1';
            if fresh = '0' then
              upper := middle;
            end if;
            middle := lower;
            lower  := next_down;
            fresh  := '0';
          end if;

      end case;

      if reset = '1' or enable = '0' or mode = '0' or (state /= IDLE and angle_step /= step) then
        state         := IDLE;
        angle_trigger <= '0';
      end if;
    end if;

  end process equal_angle;

end architecture rtl;
