-- SPDX-License-Identifier: Apache-2.0
--
-- # sample_trigger
--
-- Generates the trigger of each sample. Mode 0, equal time: a trigger every `sample_period` clocks (100000 is the
-- paper's 1 kHz at 100 MHz). Mode 1, equal angle: a trigger each time the turn position of head 1 reaches the next
-- multiple of `angle_step` above or below the last multiple reached. Source: section 3.2 of the paper (sampling clock
-- of 1 kHz); the Fourier transform D21[n] of its equation (7) assumes equal angle steps.
--
-- **Latency.** `trigger` is high one clock after the clock that it belongs to: a unit that delays its values by one
-- clock and latches them with `trigger` gets the values of the crossing itself.
--
-- **Number formats.** turn_position s31.0 counts; angle_step u24.0 counts; sample_period u32.0
-- clocks.
--
-- **Equal time.** The first trigger belongs to the clock `sample_period` - 1 clocks after the
-- first enabled one. A change of `sample_period` applies to the present interval: an
-- interval already longer than the new period ends at once. A period of 0 acts as 1.
--
-- **Equal angle.** The multiples are m * angle_step from the zero of the index, computed exactly:
-- no error accumulates. A multiple is reached at the same count from below and from above,
-- so samples of both directions lie on the same grid. The multiple that was reached last gives no trigger again before
-- one of its neighbours was reached: a table that vibrates at a multiple gives one sample, and after a reversal the
-- table passes that multiple without a sample. The first multiple after the start is reached from either side; a table
-- that stands on a multiple at the start has to reach a neighbour first. A division finds the grid, even while the
-- table moves: there is no trigger in the first 36 enabled clocks, and in at most the 38 clocks after a change of
-- angle_step. An angle_step of 0 gives no trigger. turn_position wraps modulo 2**32; the grid continues evenly across
-- the wrap.
--
-- From the start on the entity counts the movement modulo angle_step; the division only gives the value
-- of that counter at the multiples. So turn_position may move by at most one count per clock, as the decoder's
-- turn_position does. If it jumps because its zero moves, `zero_moved` toggles with the first position from the new
-- zero, and the grid is computed again as after a change of angle_step: no trigger in that clock and the next 38.
--
-- **External**, mode 2: a strobe of `external` is a trigger that belongs to the strobe's clock. Mode 3 gives no trigger.
--
-- **Reset and enable.** `reset` and a low `enable` have the same effect: no trigger, and every counter starts again.
-- Without a change of `zero_moved`, turn_position may jump (as at the first index) only while `enable` is low.

library ieee;
  use ieee.std_logic_1164.all;
  use ieee.numeric_std.all;

  use work.number_formats_pkg.all;

entity sample_trigger is
  port (
    clock         : in    std_ulogic;
    reset         : in    std_ulogic;
    enable        : in    std_ulogic;
    mode          : in    u_unsigned(1 downto 0);                    -- 0 equal time, 1 equal angle, 2 external
    external      : in    std_ulogic := '0';                         -- strobe: a sample is requested from outside
    sample_period : in    u_unsigned(31 downto 0);                   -- clocks
    angle_step    : in    u_unsigned(ANGLE_WIDTH - 1 downto 0);      -- counts
    turn_position : in    u_signed(POSITION_WIDTH - 1 downto 0);     -- counts from the index, head 1
    zero_moved    : in    std_ulogic := '0';                         -- toggles with the first position from another zero
    trigger       : out   std_ulogic                                 -- strobe: one clock per sample
  );
end entity sample_trigger;

architecture rtl of sample_trigger is

  type grid_state is (IDLE, DIVIDE, SET_BELOW, SET_MULTIPLE, SET_ABOVE, START, TRACK);

  subtype count is u_unsigned(ANGLE_WIDTH - 1 downto 0);

  -- Returns the count plus 1, modulo last + 1.
  function one_up (place, last : count) return count is
  begin

    if place = last then
      return (count'range => '0');
    end if;
    return place + 1;

  end function one_up;

  signal time_trigger  : std_ulogic := '0';
  signal angle_trigger : std_ulogic := '0';

  signal external_trigger : std_ulogic := '0';

begin

  -- Only the selected mode triggers.
  trigger <= time_trigger or angle_trigger or external_trigger;

  from_outside : process (clock) is
  begin

    if rising_edge(clock) then
      external_trigger <= external and enable and not reset;
      if mode /= 2 then
        external_trigger <= '0';
      end if;
    end if;

  end process from_outside;

  equal_time : process (clock) is

    -- Number of clocks of the interval, including the present clock. At the start of an interval is_first is set in
    -- place of `elapsed`, that is 1 bit in place of 32.
    variable elapsed  : u_unsigned(31 downto 0) := to_unsigned(1, 32);
    variable is_first : std_ulogic              := '1';
    variable ends     : std_ulogic;

  begin

    if rising_edge(clock) then
      ends := elapsed ?>= sample_period;
      if is_first = '1' then
        ends := not (or sample_period(31 downto 1));
      end if;
      if is_first = '1' then
        elapsed := to_unsigned(1, 32);
      end if;
      elapsed := elapsed + 1;

      time_trigger <= ends;
      is_first     := ends;
      if reset = '1' or enable = '0' or mode /= 0 then
        time_trigger <= '0';
        is_first     := '1';
      end if;
    end if;

  end process equal_time;

  equal_angle : process (clock) is

    -- is_idle repeats the state in a register, because the bits of `moved` depend on it.
    variable state       : grid_state := IDLE;
    variable is_idle     : std_ulogic := '1';
    variable step        : count      := (others => '0');
    variable changes     : std_ulogic;
    variable zero_before : std_ulogic := '0';
    variable jumps       : std_ulogic;
    variable last        : count      := (others => '0'); -- step - 1
    variable before_last : count      := (others => '0'); -- step - 2
    variable is_single   : std_ulogic := '0';             -- step is 1
    -- turn_position modulo step, by long division
    variable dividend    : u_signed(POSITION_WIDTH - 1 downto 0)   := (others => '0');
    variable bits_left   : natural range 0 to POSITION_WIDTH - 2   := 0;
    variable remainder   : count                                   := (others => '0');
    variable shifted     : u_unsigned(ANGLE_WIDTH downto 0);
    variable reduced     : u_unsigned(ANGLE_WIDTH + 1 downto 0);
    -- Counts moved since the start, modulo step; the value of this counter one count below a multiple, at the multiple
    -- and one count above
    variable moved       : count := (others => '0');
    -- Flags: the counter is 0, or `last`; they are registered, so that its wrap needs no comparison
    variable is_zero     : std_ulogic := '1';
    variable is_last     : std_ulogic := '0';
    variable rises       : std_ulogic;
    variable falls       : std_ulogic;
    variable wraps_down  : std_ulogic;
    variable below       : count := (others => '0');
    variable multiple    : count := (others => '0');
    variable above       : count := (others => '0');
    -- The lowest bits of turn_position one clock ago give the direction of its step.
    variable before      : u_signed(1 downto 0) := "00";
    variable move        : u_signed(1 downto 0);
    variable up          : std_ulogic;
    variable down        : std_ulogic;
    variable stood       : std_ulogic;
    variable arrives     : std_ulogic;
    -- High if the table stands on a multiple; the direction in which it left the last multiple; high if it has not
    -- reached a multiple yet.
    variable on_multiple : std_ulogic := '0';
    variable left_up     : std_ulogic := '0';
    variable fresh       : std_ulogic := '1';

  begin

    if rising_edge(clock) then
      angle_trigger <= '0';
      changes       := angle_step ?/= step;
      jumps         := zero_moved xor zero_before;
      zero_before   := zero_moved;
      move          := turn_position(1 downto 0) - before;
      before        := turn_position(1 downto 0);
      up            := move ?= 1;
      down          := move ?= -1;
      stood         := moved ?= multiple;
      arrives       := (up and (moved ?= below)) or (down and (moved ?= above));

      -- The cases exclude each other: a bit needs one look-up table after the carry chains.
      rises      := up and not is_last;
      falls      := down and not is_zero;
      wraps_down := down and is_zero;
      if (up or down) = '1' then
        is_zero := (up and is_last) or (falls and (moved ?= 1)) or is_single;
        is_last := wraps_down or (rises and (moved ?= before_last)) or is_single;
        -- not (not x + 1) = x - 1, on the same carry chain as x + 1.
        moved   := ((moved + 1) and (moved'range => rises))
                   or ((not (not moved + 1)) and (moved'range => falls))
                   or (last and (moved'range => wraps_down));
      end if;

      if is_idle = '1' then
        moved   := (others => '0');
        is_zero := '1';
        is_last := angle_step ?= 1;
      end if;

      case state is

        when IDLE =>

          dividend  := turn_position;
          bits_left := POSITION_WIDTH - 2;
          step      := angle_step;
          last      := angle_step - 1;
          is_single := angle_step ?= 1;
          before_last := angle_step - 2;
          -- The sign bit has the weight -2**31: the long division starts with the remainder of -1.
          remainder := (others => '0');
          if turn_position(POSITION_WIDTH - 1) = '1' then
            remainder := last;
          end if;
          if angle_step /= 0 then
            state   := DIVIDE;
            is_idle := '0';
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
            state := SET_BELOW;
          else
            bits_left := bits_left - 1;
          end if;

        when SET_BELOW =>

          below := last - remainder;
          above := below;
          state := SET_MULTIPLE;

        when SET_MULTIPLE =>

          above := one_up(above, last);
          state := SET_ABOVE;

        when SET_ABOVE =>

          multiple := above;
          above    := one_up(above, last);
          state    := START;

        when START | TRACK =>

          if state = START then
            on_multiple := stood;
            fresh       := not stood;
          elsif arrives = '1' and (fresh = '1' or on_multiple = '1' or left_up = up) then
            angle_trigger <= '1';
          end if;
          if (up or down) = '1' and on_multiple = '1' then
            left_up := up;
          end if;
          fresh := fresh and not arrives;
          state := TRACK;

      end case;

      -- The step 0 differs from angle_step, so the division restarts a clock later, as after a change of angle_step.
      if jumps = '1' then
        step          := (others => '0');
        angle_trigger <= '0';
      end if;

      -- This runs in every state, which saves a case; START sets the initial value.
      on_multiple := arrives or (on_multiple and not (up or down));

      if reset = '1' or enable = '0' or mode /= 1 or changes = '1' then
        state         := IDLE;
        is_idle       := '1';
        angle_trigger <= '0';
      end if;
    end if;

  end process equal_angle;

end architecture rtl;
