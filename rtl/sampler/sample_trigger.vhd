-- SPDX-License-Identifier: Apache-2.0
--
-- # sample_trigger
--
-- Generates the trigger of each sample. Mode 0, equal time, gives a trigger every `sample_period` clocks (100000 clocks
-- at 100 MHz are the paper's 1 kHz). Mode 1, equal angle, gives a trigger each time the turn position of head 1 reaches
-- the next multiple of `angle_step` above or below the multiple that it reached last. Mode 2 takes each strobe of
-- `external` as a trigger. Mode 3 gives no trigger. Source: section 3.2 of the paper (sampling clock of 1 kHz); the
-- Fourier transform D21[n] of its equation (7) assumes equal angle steps.
--
-- **Latency.** `trigger` is high one clock after the clock to which it belongs. So a unit that delays its values by one
-- clock and latches them with `trigger` gets the values of the clock in which the multiple was reached.
--
-- **Number formats.** turn_position s31.0 counts; angle_step u24.0 counts; sample_period u32.0
-- clocks.
--
-- **Equal time.** The first trigger belongs to the clock that comes `sample_period` - 1 clocks after the first clock in
-- which `enable` is high. A change of `sample_period` applies to the present interval: if this interval is already as
-- long as the new period or longer, it ends at once. A period of 0 acts as 1.
--
-- **Equal angle.** The multiples lie exactly m * angle_step counts from the zero of turn_position, m being any integer,
-- so no error accumulates. A multiple is reached at the same count from below and from above, so the samples of both
-- directions lie on the same grid. The multiple that was reached last gives no trigger again before one of its
-- neighbours has been reached: a table that vibrates at a multiple gives one sample, and after a reversal the table
-- passes this multiple without a sample. The first multiple after the start is reached from either side; a table that
-- stands on a multiple at the start has to reach a neighbour first. The entity finds the grid by a division, even while
-- the table moves. So there is no trigger in the first 36 clocks in which `enable` is high, nor in up to 38 clocks
-- after a change of angle_step. An angle_step of 0 gives no trigger. turn_position wraps modulo 2**32; the grid
-- continues evenly across the wrap.
--
-- From the start on the entity counts the movement modulo angle_step; the division only yields the value that this
-- counter has at the multiples. So turn_position may move by at most one count per clock, as the decoder's
-- turn_position does. If it jumps because its zero moves, `zero_moved` toggles with the first position from the new
-- zero, and the grid is computed again as after a change of angle_step: no trigger in that clock and the next 38.
--
-- **External.** A trigger belongs to the clock of its strobe.
--
-- **Reset and enable.** `reset` and a low `enable` have the same effect: there is no trigger, and every counter starts
-- anew. Without a change of `zero_moved`, turn_position may jump (as at the first index) only while `enable` is low.

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
    external      : in    std_ulogic := '0';                         -- strobe: an external sample request
    sample_period : in    u_unsigned(31 downto 0);                   -- clocks
    angle_step    : in    u_unsigned(ANGLE_WIDTH - 1 downto 0);      -- counts
    turn_position : in    u_signed(POSITION_WIDTH - 1 downto 0);     -- counts from the zero, head 1
    zero_moved    : in    std_ulogic := '0';                         -- toggles with the first position from another zero
    trigger       : out   std_ulogic                                 -- strobe: one clock per sample
  );
end entity sample_trigger;

architecture rtl of sample_trigger is

  type grid_state is (IDLE, DIVIDE, SET_BELOW, SET_MULTIPLE, SET_ABOVE, START, TRACK);

  subtype count is u_unsigned(ANGLE_WIDTH - 1 downto 0);

  -- Returns place plus 1, modulo last + 1.
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

  -- Only the trigger of the selected mode can be high.
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

    -- `elapsed` is the number of clocks of the interval, including the present clock. At the start of an interval
    -- is_first, 1 bit, is set instead of the 32 bits of `elapsed`.
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

    -- is_idle is high in the state IDLE; it is a register of its own, because every bit of `moved` depends on it.
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
    -- `moved` is the number of counts moved since the start, modulo step. `below`, `multiple` and `above` are its
    -- values one count below a multiple, at the multiple and one count above.
    variable moved       : count := (others => '0');
    -- Flags: `moved` is 0, or `last`. They are registers, so that the wrap of `moved` needs no comparison.
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
    -- on_multiple is high if the table stands on a multiple, left_up if it left the last multiple upwards, fresh if it
    -- has not reached a multiple yet.
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

      -- Only one of these cases holds at a time, so a bit of `moved` needs one look-up table after the carry chains.
      rises      := up and not is_last;
      falls      := down and not is_zero;
      wraps_down := down and is_zero;
      if (up or down) = '1' then
        is_zero := (up and is_last) or (falls and (moved ?= 1)) or is_single;
        is_last := wraps_down or (rises and (moved ?= before_last)) or is_single;
        -- not (not x + 1) equals x - 1; its carry chain has the form of that of x + 1.
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
          -- The sign bit has the weight -2**31. So for a negative position the long division starts with the remainder
          -- of -1, that is step - 1.
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

      -- A `step` of 0 differs from angle_step, so the division restarts one clock later, as after a change of
      -- angle_step.
      if jumps = '1' then
        step          := (others => '0');
        angle_trigger <= '0';
      end if;

      -- This statement is executed in every state; START sets the initial value.
      on_multiple := arrives or (on_multiple and not (up or down));

      if reset = '1' or enable = '0' or mode /= 1 or changes = '1' then
        state         := IDLE;
        is_idle       := '1';
        angle_trigger <= '0';
      end if;
    end if;

  end process equal_angle;

end architecture rtl;
