-- SPDX-License-Identifier: Apache-2.0
--
-- # local_table
--
-- Computes a correction that a sum of orders cannot describe, from 4,096 points over the turn, or over one, two or four
-- windows of 1/2 to 1/64 of the turn, with straight lines between the points. Outside of every window the value is 0.
-- Two banks store the points and the place of the windows; `bank` travels with the angle, so that all stages use the
-- same bank for an angle. The register map fixes the formats.
--
-- **Latency.** LOCAL_TABLE_LATENCY = 17 clocks from `angle` and `bank` to `value`, one angle per clock: 4 to the window, 5 to the
-- place in it (phase_lane), 3 for the points, 5 for the line.
--
-- **Number formats.** angle and starts u24.0 counts, below counts_per_rev; step u0.48 window a count,
-- round(2⁴⁸·2^width / counts_per_rev); a point s(17 − F).F counts; value s13.22 counts, exact for the place at which
-- the line is read.
--
-- **Windows.** The first enabled window that contains the angle gives the value; windows should not overlap. The points
-- of window j are the j-th half or quarter of all points. After the last point of a window the line leads to its first
-- point.
--
-- **Error.** The place is rounded to 2⁻²⁴ window, its step is off by 2⁻⁴⁹ window a count, and 12 bits of the place between two
-- points are used. The value differs from the exact line by at most the largest difference of two neighbouring points
-- times (2⁻¹³ + 2⁻¹³) with one window; with two or four windows this factor is larger by 2⁻¹².
--
-- **Size.** 893 LUT, 507 FF, 4 DSP48E1 and 4 RAMB36 for both banks (Yosys).
--
-- **Access.** `write_bank` and `write_address` choose a point of either bank: `write_enable` writes this point, and
-- `read_word` shows it one clock later, while bank and address do not change. A point that is written while an angle
-- reads it may give the old or the new value.
--
-- There is no reset: it would only affect angles in the pipeline.

library ieee;
  use ieee.std_logic_1164.all;
  use ieee.numeric_std.all;

  use work.local_table_pkg.all;
  use work.number_formats_pkg.all;

entity local_table is
  port (
    clock          : in    std_ulogic;
    angle          : in    u_unsigned(ANGLE_WIDTH - 1 downto 0);          -- counts, below counts_per_rev
    bank           : in    std_ulogic;                                    -- bank that applies to this angle
    counts_per_rev : in    u_unsigned(COUNTS_PER_REV_WIDTH - 1 downto 0); -- counts
    -- Place of the windows, by bank
    bank0_place    : in    local_place;
    bank1_place    : in    local_place;
    -- Points
    write_enable   : in    std_ulogic;                                    -- pulse: write a point
    write_bank     : in    std_ulogic;
    write_address  : in    u_unsigned(LOCAL_INDEX_WIDTH - 1 downto 0);    -- number of the point
    write_data     : in    u_signed(LOCAL_POINT_WIDTH - 1 downto 0);      -- counts, s(17 − F).F
    read_word      : out   u_signed(LOCAL_POINT_WIDTH - 1 downto 0);      -- counts, s(17 − F).F
    value          : out   u_signed(LOCAL_VALUE_WIDTH - 1 downto 0) := (others => '0') -- counts, s13.22
  );
end entity local_table;

architecture rtl of local_table is

  subtype point is u_signed(LOCAL_POINT_WIDTH - 1 downto 0);

  -- Each memory stores every second point of both banks, so that the two neighbours of a place come from different
  -- memories.
  type half_of_points is array (0 to 2 ** LOCAL_INDEX_WIDTH - 1) of point;

  subtype half_index is u_unsigned(LOCAL_INDEX_WIDTH - 1 downto 0);

  subtype angle_count is u_unsigned(ANGLE_WIDTH - 1 downto 0);

  type angles is array (1 to LOCAL_WINDOWS) of angle_count;

  type differences is array (1 to LOCAL_WINDOWS) of u_signed(ANGLE_WIDTH downto 0);

  type places is array (0 to 1) of local_place;

  type last_counts is array (0 to 1) of angle_count;

  constant LINE_WIDTH : positive := LOCAL_INDEX_WIDTH; -- bits of the place between two points

  function starts_of (place : local_place) return angles is
  begin

    return (place.start1, place.start2, place.start3, place.start4);

  end function starts_of;

  -- Returns the last count of a window of 2**-width turn: the largest offset with offset · 2**width < turn.
  function last_count (
    width : u_unsigned(2 downto 0);
    turn  : u_unsigned(COUNTS_PER_REV_WIDTH - 1 downto 0)
  ) return angle_count is
  begin

    return resize(shift_right(turn - 1, to_integer(width)), ANGLE_WIDTH);

  end function last_count;

  function number_of (bit : std_ulogic) return natural is
  begin

    if bit = '1' then
      return 1;
    end if;
    return 0;

  end function number_of;

  signal place_of_bank : places;
  signal offset        : angle_count := (others => '0');
  signal step          : u_unsigned(PHASE_STEP_WIDTH - 1 downto 0);
  signal in_window     : u_unsigned(PHASE_WIDTH - 1 downto 0);

  -- Last count of a window of each bank. It does not change while angles use it.
  signal last_of_bank  : last_counts := (others => (others => '0'));

  -- Points at `write_address`, a clock later
  signal half_place    : half_index;
  signal even_there    : point := (others => '0');
  signal odd_there     : point := (others => '0');

  -- Bank and window of the angles in the pipeline, by stage
  signal banks     : std_ulogic_vector(1 to LOCAL_TABLE_LATENCY - 1) := (others => '0');
  signal even_word : point                                          := (others => '0');
  signal odd_word  : point                                          := (others => '0');
  signal even_read : half_index                                     := (others => '0');
  signal odd_read  : half_index                                     := (others => '0');

begin

  place_of_bank <= (bank0_place, bank1_place);
  half_place    <= write_bank & write_address(LOCAL_INDEX_WIDTH - 1 downto 1);
  read_word     <= odd_there when write_address(0) = '1' else
                   even_there;
  step          <= place_of_bank(number_of(banks(4))).step;

  place_in_window : entity work.phase_lane
    port map (
      clock        => clock,
      angle        => offset,
      phase_step   => step,
      phase_offset => (others => '0'),
      phase        => in_window
    );

  even_points : process (clock) is

    -- This is a variable: as a signal it would be 73,728 signals for the simulator.
    variable memory : half_of_points := (others => (others => '0'));
    variable word   : point          := (others => '0');

  begin

    if rising_edge(clock) then
      even_word  <= word;
      word       := memory(to_integer(even_read));
      even_there <= memory(to_integer(half_place));
      if write_enable = '1' and write_address(0) = '0' then
        memory(to_integer(half_place)) := write_data;
      end if;
    end if;

  end process even_points;

  odd_points : process (clock) is

    variable memory : half_of_points := (others => (others => '0'));
    variable word   : point          := (others => '0');

  begin

    if rising_edge(clock) then
      odd_word  <= word;
      word      := memory(to_integer(odd_read));
      odd_there <= memory(to_integer(half_place));
      if write_enable = '1' and write_address(0) = '1' then
        memory(to_integer(half_place)) := write_data;
      end if;
    end if;

  end process odd_points;

  follow : process (clock) is

    -- Registers; the number in a name is the number of clocks from `angle` until the register is valid.
    variable difference1 : differences                                  := (others => (others => '0'));
    variable offset2     : angles                                       := (others => (others => '0'));
    variable offset3     : angles                                       := (others => (others => '0'));
    variable inside3     : std_ulogic_vector(1 to LOCAL_WINDOWS)        := (others => '0');
    variable starts      : angles;
    -- Window that contains the angle, and whether any window contains it, from clock 4 on
    variable window      : u_unsigned(1 downto 0);
    variable windows     : u_unsigned(2 * LOCAL_TABLE_LATENCY - 1 downto 0) := (others => '0');
    variable are_inside  : std_ulogic_vector(4 to LOCAL_TABLE_LATENCY - 1) := (others => '0');
    variable window9     : u_unsigned(1 downto 0);
    variable index       : u_unsigned(LOCAL_INDEX_WIDTH - 1 downto 0);
    variable following   : u_unsigned(LOCAL_INDEX_WIDTH - 1 downto 0);
    variable part        : u_unsigned(LINE_WIDTH - 1 downto 0);
    variable place       : local_place;
    -- Place between two points, and whether the first of them is odd
    variable part10      : u_unsigned(LINE_WIDTH - 1 downto 0)          := (others => '0');
    variable part11      : u_unsigned(LINE_WIDTH - 1 downto 0)          := (others => '0');
    variable part12      : u_unsigned(LINE_WIDTH - 1 downto 0)          := (others => '0');
    variable part13      : u_unsigned(LINE_WIDTH - 1 downto 0)          := (others => '0');
    variable odd         : std_ulogic_vector(10 to 12)                  := (others => '0');
    variable second      : point;
    variable first13     : point                                        := (others => '0');
    variable rise13      : u_signed(LOCAL_POINT_WIDTH downto 0)         := (others => '0');
    variable first14     : point                                        := (others => '0');
    variable rise14      : u_signed(LOCAL_POINT_WIDTH downto 0)         := (others => '0');
    variable part14      : u_unsigned(LINE_WIDTH - 1 downto 0)          := (others => '0');
    variable first15     : point                                        := (others => '0');
    variable product15   : u_signed(LOCAL_POINT_WIDTH + LINE_WIDTH + 1 downto 0) := (others => '0');
    variable sum16       : u_signed(LOCAL_POINT_WIDTH + LINE_WIDTH - 1 downto 0) := (others => '0');

  begin

    if rising_edge(clock) then
      -- 17: apply the fraction of the points; 0 outside of the windows.
      place := place_of_bank(number_of(banks(16)));
      value <= (others => '0');
      if are_inside(16) = '1' then
        value <= shift_left(resize(sum16, LOCAL_VALUE_WIDTH), 6 - 2 * to_integer(place.fraction));
      end if;

      -- 16 to 13: interpolate. The value lies between its two points, so the sum needs no more bits than they have.
      sum16     := resize(shift_left(resize(first15, product15'length), LINE_WIDTH) + product15, sum16'length);
      first15   := first14;
      product15 := rise14 * signed('0' & part14);
      first14   := first13;
      rise14    := rise13;
      part14    := part13;
      first13 := odd_word when odd(12) = '1' else
                 even_word;
      second  := even_word when odd(12) = '1' else
                 odd_word;
      rise13  := resize(second, LOCAL_POINT_WIDTH + 1) - first13;
      part13 := part12;

      -- 12 and 11: read the memories.
      part12 := part11;
      part11 := part10;
      odd(11 to 12) := odd(10 to 11);

      -- 10: select the points. With several windows, the number of the window is in the upper bits.
      place   := place_of_bank(number_of(banks(9)));
      window9 := windows(2 * 9 + 1 downto 2 * 9);

      case to_integer(place.windows) is

        when 0 =>
          index     := in_window(23 downto 12);
          part      := in_window(11 downto 0);
          following := index + 1;

        when 1 =>
          index     := window9(0) & in_window(23 downto 13);
          part      := in_window(12 downto 1);
          following := window9(0) & (in_window(23 downto 13) + 1);

        when others =>
          index     := window9 & in_window(23 downto 14);
          part      := in_window(13 downto 2);
          following := window9 & (in_window(23 downto 14) + 1);

      end case;

      part10  := part;
      odd(10) := index(0);
      if index(0) = '0' then
        even_read <= banks(9) & index(LOCAL_INDEX_WIDTH - 1 downto 1);
        odd_read  <= banks(9) & following(LOCAL_INDEX_WIDTH - 1 downto 1);
      else
        odd_read  <= banks(9) & index(LOCAL_INDEX_WIDTH - 1 downto 1);
        even_read <= banks(9) & following(LOCAL_INDEX_WIDTH - 1 downto 1);
      end if;

      -- 4: select the first window that contains the angle.
      windows    := shift_left(windows, 2);
      are_inside := (or inside3) & are_inside(4 to LOCAL_TABLE_LATENCY - 2);
      window     := "00";
      offset     <= offset3(1);

      for number in LOCAL_WINDOWS downto 1 loop
        if inside3(number) = '1' then
          window := to_unsigned(number - 1, 2);
          offset <= offset3(number);
        end if;
      end loop;

      windows(2 * 4 + 1 downto 2 * 4) := window;

      -- 3 to 1: distance of the angle from each start, and whether it is within the window.
      place := place_of_bank(number_of(banks(2)));

      for number in 1 to LOCAL_WINDOWS loop
        inside3(number) := place.enable(number - 1) and (offset2(number) ?<= last_of_bank(number_of(banks(2))));
        offset3(number) := offset2(number);
        -- The turn or 0 is added, which takes no look-up tables besides those of the carry chain.
        offset2(number) := u_unsigned(difference1(number)(ANGLE_WIDTH - 1 downto 0))
                           + (counts_per_rev(ANGLE_WIDTH - 1 downto 0) and (angle'range => difference1(number)(ANGLE_WIDTH)));
      end loop;

      starts := starts_of(place_of_bank(number_of(bank)));

      for number in 1 to LOCAL_WINDOWS loop
        difference1(number) := signed(resize(angle, ANGLE_WIDTH + 1)) - signed(resize(starts(number), ANGLE_WIDTH + 1));
      end loop;

      banks        <= bank & banks(1 to LOCAL_TABLE_LATENCY - 2);
      last_of_bank <= (last_count(bank0_place.width, counts_per_rev), last_count(bank1_place.width, counts_per_rev));
    end if;

  end process follow;

end architecture rtl;
