-- SPDX-License-Identifier: Apache-2.0
--
-- # local_table
--
-- Computes a correction that a sum of orders cannot describe: it interpolates linearly between 4,096 points. The points
-- cover the whole turn, or one, two or four windows of 1/2 to 1/64 of the turn; outside of every window the value is 0.
-- Two banks store the points and the places of the windows. `bank` is delayed with the angle, so that all stages use
-- the same bank for an angle. The register map specifies the formats.
--
-- **Latency.** LOCAL_TABLE_LATENCY = 17 clocks from `angle` and `bank` to `value`: 4 clocks to find the window, 5 for
-- the place in the window (phase_lane), 3 to read the points, 5 to interpolate. The entity accepts one angle per clock.
--
-- **Number formats.** angle and starts u24.0 counts, below counts_per_rev; step u0.48 windows per count,
-- round(2⁴⁸·2^width / counts_per_rev); points s(17 − F).F counts; value s13.22 counts: the interpolation itself is not
-- rounded.
--
-- **Windows.** The first enabled window that contains the angle gives the value; windows should not overlap. With two
-- (four) windows, the j-th half (quarter) of all points belongs to window j. From the last point of a window on, the
-- value is interpolated towards the window's first point.
--
-- **Error.** The place in the window is rounded to 2⁻²⁴ window, the error of `step` is at most 2⁻⁴⁹ window per count,
-- and the interpolation uses 12 bits of the place between two points. With one window, the value differs from the exact
-- interpolation by at most (2⁻¹³ + 2⁻¹³) times the largest difference of two neighbouring points; with two or four
-- windows, whose lowest bits of the place are truncated, this factor is larger by 2⁻¹².
--
-- **Size.** Yosys reports 893 LUT, 507 FF, 4 DSP48E1 and 4 RAMB36 for both banks.
--
-- **Access.** `write_bank` and `write_address` choose a point of either bank: `write_enable` writes this point, and
-- `read_word` shows it one clock later, as long as bank and address do not change. If a point is written while an angle
-- reads it, the angle may get the old or the new value.
--
-- There is no reset: no register keeps a state beyond the angles in the pipeline.

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
    -- Places of the windows, one record per bank
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

  -- Last count of a window, for each bank. It does not change while the bank's angles use it.
  signal last_of_bank  : last_counts := (others => (others => '0'));

  -- Address in the memories for `write_address`, and the points there, one clock later
  signal half_place    : half_index;
  signal even_there    : point := (others => '0');
  signal odd_there     : point := (others => '0');

  -- Bank of the angle in each stage; the two points that were read, and their addresses
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

    -- The memory is a variable, because a simulator would treat it as 73,728 signals if it were a signal.
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
    -- Number of the window that contains the angle, and whether any window contains it; from stage 4 on
    variable window      : u_unsigned(1 downto 0);
    variable windows     : u_unsigned(2 * LOCAL_TABLE_LATENCY - 1 downto 0) := (others => '0');
    variable are_inside  : std_ulogic_vector(4 to LOCAL_TABLE_LATENCY - 1) := (others => '0');
    variable window9     : u_unsigned(1 downto 0);
    variable index       : u_unsigned(LOCAL_INDEX_WIDTH - 1 downto 0);
    variable following   : u_unsigned(LOCAL_INDEX_WIDTH - 1 downto 0);
    variable part        : u_unsigned(LINE_WIDTH - 1 downto 0);
    variable place       : local_place;
    -- Place between two points, and whether the number of the first point is odd
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
      -- 17: align the value by the points' number of fraction bits; the value is 0 outside of the windows.
      place := place_of_bank(number_of(banks(16)));
      value <= (others => '0');
      if are_inside(16) = '1' then
        value <= shift_left(resize(sum16, LOCAL_VALUE_WIDTH), 6 - 2 * to_integer(place.fraction));
      end if;

      -- 16 to 13: interpolate. The value lies between its two points, so the sum needs no more integer bits than a
      -- point.
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

      -- 10: select the points. With several windows, the upper bits of the point's number are the number of the window.
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
        -- Adding either the turn or 0 takes only the look-up tables of the carry chain.
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
