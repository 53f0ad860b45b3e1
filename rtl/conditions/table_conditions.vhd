-- SPDX-License-Identifier: Apache-2.0
--
-- # table_conditions
--
-- Computes the conditions, that is the factors by which amplitude_sweep multiplies the amplitudes of lanes, and serves
-- the registers that set them: direction h (stop_operator), speed over nominal speed (table_speed) and two words of the
-- processor (slewed_word). It also counts `sweep_step`, the steps of amplitude_sweep. One divider serves direction and
-- speed, each in its part of the sweep.
--
-- **Unknown direction.** After a reset h is 0; when a change of `width` makes the direction unknown, h moves to 0 by
-- `slew` per sweep. Once the direction is known, h moves towards it by `slew` per sweep, so that the output makes no
-- step; after h has reached the direction, it follows the direction without this limit.
--
-- **Two banks.** Width, dead zone and nominal speed belong to the coefficients: the processor writes the words of the
-- idle bank, and `swap_comes` makes them active together with the lanes. `idle_speed` is the speed over the nominal
-- speed of the idle bank, so that amplitude_sweep prepares the amplitudes of that bank for its own nominal speed.
-- `settled` is low from a write of these words until the idle bank's amplitudes are ready, for at most
-- 3 · AMPLITUDE_SWEEP_CLOCKS + 1 clocks; a swap must wait for it. A write of these words waits while `hold_writes` is
-- high, that is while a swap waits, so that a swap takes over exactly the acknowledged writes.
--
-- **Speed.** Each sweep divides the last travel of table_speed anew, once for each bank. A bound from table_speed
-- replaces this travel only if the bound is not above the present speed and the present travel is not 0.
--
-- **Words of the window**, by `address`: 0 width, 1 dead_zone, 2 nominal_speed, 3 word_a, 4 word_b (limited to ±1), 5
-- slew; read-only: 6 direction, with bit 31 high while it is known, 7 speed, 8 speed squared. Signed words are read
-- sign-extended.
--
-- **Latency.** 1 to 2 sweeps and 8 clocks (at most 3 µs at 100 MHz) from a motion of the table to the sweep that uses
-- the new h; 1 clock from an access to `read_data` and `done`, 2 clocks for a write of a word of the idle bank.
--
-- **Number formats.** position s31.0 counts; correction s19.11 counts; modulators s1.16, with a magnitude of at most 1;
-- table_speed and stop_operator state the other formats.
--
-- **Reset.** Slew is 2⁻¹⁶, so that a word moves from 0 to 1 in 94 ms at 100 MHz; word_a and word_b are 0. The words of
-- both banks keep their values, as the banks of the lanes do; at power-up they are 0. A pending write is dropped.

library ieee;
  use ieee.std_logic_1164.all;
  use ieee.numeric_std.all;

  use work.conditions_pkg.all;
  use work.number_formats_pkg.all;

entity table_conditions is
  generic (
    WINDOW     : positive range 4 to 20 := SPEED_WINDOW_BITS; -- see table_speed
    LONGEST    : positive range 6 to 24 := SPEED_LONGEST_BITS -- see table_speed
  );
  port (
    clock              : in    std_ulogic;
    reset              : in    std_ulogic;
    -- The reading: its position before and after the correction, and the correction
    position           : in    u_signed(POSITION_WIDTH - 1 downto 0);   -- counts
    put_back           : in    u_signed(15 downto 0);                   -- counts put back for lost counts
    corrected_position : in    u_signed(POSITION_WIDTH - 1 downto 0);   -- counts
    correction         : in    u_signed(CORRECTION_WIDTH - 1 downto 0); -- counts, s19.11
    -- Access to the window of the register map
    read_enable        : in    std_ulogic;                              -- pulse: read the word
    write_enable       : in    std_ulogic;                              -- pulse: write the word
    address            : in    u_unsigned(3 downto 0);                  -- number of the word
    write_data         : in    std_ulogic_vector(31 downto 0);
    done               : out   std_ulogic := '0';                       -- pulse: the word is read or written
    read_data          : out   std_ulogic_vector(31 downto 0);
    -- Swap of the banks
    hold_writes        : in    std_ulogic;                              -- a swap is requested, waits or takes effect
    swap_comes         : in    std_ulogic;                              -- the idle words are active from the next clock on
    settled            : out   std_ulogic := '1';                       -- level: a swap may take effect
    -- To amplitude_sweep
    sweep_step         : out   u_unsigned(7 downto 0);                  -- 0 to AMPLITUDE_SWEEP_CLOCKS - 1
    direction          : out   modulator;
    speed              : out   modulator;
    idle_speed         : out   modulator;                               -- speed for the nominal speed of the idle bank
    word_a             : out   modulator;
    word_b             : out   modulator;
    speed_squared      : in    modulator                                -- as amplitude_sweep uses it
  );
end entity table_conditions;

architecture rtl of table_conditions is

  subtype bus_word is std_ulogic_vector(31 downto 0);

  constant SLEW_AT_RESET : bus_word := x"00010000";

  -- Limits a value to the range -1 to 1, because the formats of the lanes cannot hold larger products.
  function limited (value : bus_word) return modulator is

    variable whole : u_signed(31 downto 0);

  begin

    whole := u_signed(value);
    if whole > MODULATOR_ONE then
      return MODULATOR_ONE;
    elsif whole < -MODULATOR_ONE then
      return -MODULATOR_ONE;
    end if;
    return resize(whole, MODULATOR_WIDTH);

  end function limited;

  function with_sign (size : u_unsigned; negative : std_ulogic) return modulator is

    variable straight : modulator;

  begin

    straight := resize(u_signed('0' & size), MODULATOR_WIDTH);
    if negative = '1' then
      return -straight;
    end if;
    return straight;

  end function with_sign;

  signal width          : u_unsigned(STOP_WIDTH - 1 downto 0)      := (others => '0');
  signal dead_zone      : u_unsigned(DEAD_ZONE_WIDTH - 1 downto 0) := (others => '0');
  signal nominal        : u_unsigned(31 downto 0)                  := (others => '0');
  signal idle_width     : u_unsigned(STOP_WIDTH - 1 downto 0)      := (others => '0');
  signal idle_dead_zone : u_unsigned(DEAD_ZONE_WIDTH - 1 downto 0) := (others => '0');
  signal idle_nominal   : u_unsigned(31 downto 0)                  := (others => '0');
  signal is_banked      : std_ulogic;
  signal pending        : std_ulogic                               := '0';
  signal write_now      : std_ulogic;

  signal target_a      : modulator                                := (others => '0');
  signal target_b      : modulator                                := (others => '0');
  signal slew          : u_unsigned(31 downto 0)                  := u_unsigned(SLEW_AT_RESET);

  signal step          : u_unsigned(7 downto 0) := (others => '0');
  signal sweep_begins  : std_ulogic;

  signal place         : u_signed(STOP_WIDTH downto 0);
  signal known         : std_ulogic;
  signal is_known      : std_ulogic := '0';
  signal has_caught_up : std_ulogic := '0';
  signal led_direction : modulator;
  signal reached       : std_ulogic;
  signal real_direction : modulator := (others => '0');
  signal goal_direction : modulator;

  signal measured       : std_ulogic;
  signal travel         : u_unsigned(TRAVEL_WIDTH - 1 downto 0);
  signal is_down        : std_ulogic;
  signal is_bound       : std_ulogic;
  signal elapsed        : u_unsigned(ELAPSED_WIDTH - 1 downto 0);

  signal start         : std_ulogic := '0';
  signal dividend      : u_unsigned(NOMINAL_WIDTH - 1 downto 0) := (others => '0');
  signal divisor       : u_unsigned(NOMINAL_WIDTH - 1 downto 0) := (others => '0');
  signal divided       : std_ulogic;
  signal ratio         : u_unsigned(MODULATOR_FRACTION downto 0);
  signal speed_size    : u_unsigned(MODULATOR_FRACTION downto 0) := (others => '0');
  signal idle_size     : u_unsigned(MODULATOR_FRACTION downto 0) := (others => '0');
  signal speed_is_down : std_ulogic := '0';

begin

  sweep_step   <= step;
  sweep_begins <= step ?= 0;

  stop : entity work.stop_operator
    port map (
      clock     => clock,
      reset     => reset,
      position  => position,
      put_back  => put_back,
      width     => width,
      dead_zone => dead_zone,
      place     => place,
      known     => known
    );

  speed_of_table : entity work.table_speed
    generic map (
      WINDOW  => WINDOW,
      LONGEST => LONGEST
    )
    port map (
      clock          => clock,
      reset          => reset,
      position       => corrected_position,
      correction     => correction,
      measured       => measured,
      travel         => travel,
      is_down        => is_down,
      is_bound       => is_bound,
      elapsed        => elapsed
    );

  divider : entity work.unit_divider
    port map (
      clock    => clock,
      reset    => reset,
      start    => start,
      dividend => dividend,
      divisor  => divisor,
      done     => divided,
      quotient => ratio
    );

  goal_direction <= real_direction when is_known = '1' else
                    (others => '0');

  lead_direction : entity work.slewed_word
    port map (
      clock   => clock,
      reset   => reset,
      step    => sweep_begins,
      slew    => slew,
      target  => goal_direction,
      word    => led_direction,
      reached => reached
    );

  lead_word_a : entity work.slewed_word
    port map (
      clock   => clock,
      reset   => reset,
      step    => sweep_begins,
      slew    => slew,
      target  => target_a,
      word    => word_a,
      reached => open
    );

  lead_word_b : entity work.slewed_word
    port map (
      clock   => clock,
      reset   => reset,
      step    => sweep_begins,
      slew    => slew,
      target  => target_b,
      word    => word_b,
      reached => open
    );

  direction <= real_direction when has_caught_up = '1' else
               led_direction;
  speed      <= with_sign(speed_size, speed_is_down);
  idle_speed <= with_sign(idle_size, speed_is_down);

  divide_in_turn : process (clock) is

    type condition is (OF_DIRECTION, OF_SPEED, OF_IDLE_SPEED);

    variable is_measured      : std_ulogic := '0';
    variable place_was_down   : std_ulogic := '0';
    variable place_was_known  : std_ulogic := '0';
    variable serves           : condition  := OF_DIRECTION;
    -- Travel and clocks to which the speed belongs, and the travel and clocks from which the next speed is being
    -- computed
    variable travel_taken     : u_unsigned(TRAVEL_WIDTH - 1 downto 0)  := (others => '0');
    variable elapsed_taken    : u_unsigned(ELAPSED_WIDTH - 1 downto 0) := (others => '0');
    variable travel_judged    : u_unsigned(TRAVEL_WIDTH - 1 downto 0)  := (others => '0');
    variable elapsed_judged   : u_unsigned(ELAPSED_WIDTH - 1 downto 0) := (others => '0');
    variable judged_is_bound  : std_ulogic                             := '0';
    variable judged_is_down   : std_ulogic                             := '0';
    -- Travel at the nominal speed in elapsed_judged clocks: a product to which each clock adds one bit of `factor`
    variable factor           : u_unsigned(ELAPSED_WIDTH - 1 downto 0) := (others => '0');
    variable of_idle          : std_ulogic                             := '0';
    variable nominal_travel   : u_unsigned(NOMINAL_WIDTH - 1 downto 0) := (others => '0');
    variable left             : natural range 0 to ELAPSED_WIDTH       := 0;
    variable addend           : u_unsigned(31 downto 0);
    -- High until the end of a sweep in which the nominal speed has changed
    variable is_stale         : std_ulogic := '0';
    -- High if the direction was already known when the sweep began, so that `reached` refers to the known direction.
    variable was_known        : std_ulogic := '0';
    variable size             : u_signed(STOP_WIDTH downto 0);

  begin

    if rising_edge(clock) then
      start <= '0';

      if step = DIRECTION_STEP then
        size            := place;
        if place < 0 then
          size := -place;
        end if;
        start           <= '1';
        dividend        <= resize(u_unsigned(size(STOP_WIDTH - 1 downto 0)), NOMINAL_WIDTH);
        divisor         <= resize(width, NOMINAL_WIDTH);
        place_was_down  := place(place'high);
        place_was_known := known;
        serves          := OF_DIRECTION;
      elsif step = SPEED_STEP or step = IDLE_SPEED_STEP then
        start    <= '1';
        -- Dividend and divisor are in units of 2⁻³² count.
        dividend <= shift_left(resize(travel_judged, NOMINAL_WIDTH), 32 - CORRECTION_FRACTION);
        divisor  <= nominal_travel;
        serves   := OF_IDLE_SPEED when of_idle = '1' else OF_SPEED;
      end if;

      if left > 0 then
        addend         := idle_nominal when of_idle = '1' else nominal;
        addend         := addend and (addend'range => factor(factor'high));
        nominal_travel := shift_left(nominal_travel, 1) + addend;
        factor := shift_left(factor, 1);
        left   := left - 1;
      end if;

      if step = SPEED_STEP - PRODUCT_CLOCKS then
        is_stale := '0';
        if is_measured = '1' then
          travel_judged   := travel;
          elapsed_judged  := elapsed;
          judged_is_bound := is_bound;
          judged_is_down  := is_down;
          is_measured     := '0';
        end if;
      end if;
      if step = SPEED_STEP - PRODUCT_CLOCKS or step = IDLE_SPEED_STEP - PRODUCT_CLOCKS then
        of_idle        := '0' when step = SPEED_STEP - PRODUCT_CLOCKS else '1';
        factor         := elapsed_judged;
        nominal_travel := (others => '0');
        left           := ELAPSED_WIDTH;
      end if;
      is_measured := is_measured or measured;

      if divided = '1' and serves = OF_DIRECTION then
        real_direction <= with_sign(ratio, place_was_down);
        is_known       <= place_was_known;
      elsif divided = '1' and is_stale = '0' and serves = OF_SPEED then
        if judged_is_bound = '0' or (ratio <= speed_size and (or travel_taken) = '1') then
          speed_size    <= ratio;
          speed_is_down <= judged_is_down;
          travel_taken  := travel_judged;
          elapsed_taken := elapsed_judged;
        end if;
        travel_judged   := travel_taken;
        elapsed_judged  := elapsed_taken;
        judged_is_bound := '0';
      elsif divided = '1' and is_stale = '0' then
        idle_size <= ratio;
      end if;

      if swap_comes = '1' then
        speed_size <= idle_size;
        is_stale   := '1';
      end if;

      if step = AMPLITUDE_SWEEP_CLOCKS - 1 then
        step          <= (others => '0');
        has_caught_up <= is_known and (has_caught_up or (reached and was_known));
        was_known     := is_known;
      else
        step <= step + 1;
      end if;

      if reset = '1' then
        step           <= (others => '0');
        start          <= '0';
        is_measured    := '0';
        travel_taken   := (others => '0');
        travel_judged  := (others => '0');
        left           := 0;
        is_known       <= '0';
        was_known      := '0';
        has_caught_up  <= '0';
        speed_size     <= (others => '0');
        idle_size      <= (others => '0');
        real_direction <= (others => '0');
      end if;
    end if;

  end process divide_in_turn;

  is_banked <= address ?< 3;
  write_now <= pending and not hold_writes and not reset;

  -- Counts the ends of sweeps since the last write. The sweep after the first end computes the speed for the new words,
  -- the sweep after the second end multiplies the amplitudes by it.
  settle : process (clock) is

    variable ends : natural range 0 to 3 := 3;

  begin

    if rising_edge(clock) then
      if step = AMPLITUDE_SWEEP_CLOCKS - 1 and ends < 3 then
        ends := ends + 1;
      end if;
      if write_now = '1' then
        ends := 0;
      end if;
      settled <= '1' when ends = 3 else '0';
    end if;

  end process settle;

  registers : process (clock) is

    function extended (word : modulator) return bus_word is
    begin

      return bus_word(resize(word, 32));

    end function extended;

  begin

    if rising_edge(clock) then
      done      <= read_enable or (write_enable and not is_banked) or write_now;
      pending   <= ((write_enable and is_banked) or (pending and not write_now)) and not reset;
      if swap_comes = '1' then
        width     <= idle_width;
        dead_zone <= idle_dead_zone;
        nominal   <= idle_nominal;
      end if;
      read_data <= (others => '0');

      case to_integer(address) is

        when 0 =>
          read_data <= bus_word(resize(idle_width, 32));
          if write_now = '1' then
            idle_width <= u_unsigned(write_data(width'range));
          end if;

        when 1 =>
          read_data <= bus_word(resize(idle_dead_zone, 32));
          if write_now = '1' then
            idle_dead_zone <= u_unsigned(write_data(dead_zone'range));
          end if;

        when 2 =>
          read_data <= bus_word(idle_nominal);
          if write_now = '1' then
            idle_nominal <= u_unsigned(write_data);
          end if;

        when 3 =>
          read_data <= extended(target_a);
          if write_enable = '1' then
            target_a <= limited(write_data);
          end if;

        when 4 =>
          read_data <= extended(target_b);
          if write_enable = '1' then
            target_b <= limited(write_data);
          end if;

        when 5 =>
          read_data <= bus_word(slew);
          if write_enable = '1' then
            slew <= u_unsigned(write_data);
          end if;

        when 6 =>
          read_data     <= extended(direction);
          read_data(31) <= is_known;

        when 7 =>
          read_data <= extended(speed);

        when others =>
          read_data <= extended(speed_squared);

      end case;

      if reset = '1' then
        target_a  <= (others => '0');
        target_b  <= (others => '0');
        slew      <= u_unsigned(SLEW_AT_RESET);
        done      <= '0';
      end if;
    end if;

  end process registers;

end architecture rtl;
