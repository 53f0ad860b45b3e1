-- SPDX-License-Identifier: Apache-2.0
--
-- # table_rotation
--
-- Computes the cosine of an angle of the first quadrant from a table of straight lines. It can replace cordic_rotation
-- (the method of the paper) for the cosine of equation (9): with the same output format and latency, a lane needs only
-- 45 % as many look-up tables, and the error is less than half as large. It uses no multiplier and no block memory.
--
-- **Latency.** 15 clocks, as in cordic_rotation: in the first 7 the angle is only delayed, in the last 8 the cosine is
-- computed. The entity accepts one angle per clock.
--
-- **Number formats.** The port `folded` has 22 bits in units of 2⁻²⁴ turn; the table's value is s1.20 and its slope
-- u3.8 per turn (see Table); the port `cosine` is s1.18.
--
-- **Table.** The quadrant has 128 intervals of 2¹⁵ units. In an interval with the middle m and the half width h (rad),
-- the cosine is approximated by the line (1 − h²/4)·cos m − z·sin m; z is the angle from the middle, |z| ≤ h. The line
-- lies halfway between tangent and chord. For each interval the table holds the slope of the line and its value at the
-- beginning of the interval.
--
-- **Product.** Five rows of adders multiply the slope by the 10 upper bits of the 15-bit place in the interval: each
-- row takes two of these bits and adds 0, 1, 2 or 3 slopes to a quarter of the previous row's sum, truncated.
-- Truncation makes the product too small on average. The product is subtracted from the table's value; so the stored
-- value is reduced by the average error. This is half of the lowest of the 10 bits times the slope, plus half of the
-- last row's lowest bit.
--
-- **Error.** The bounds of the errors of the cosine add up to 2.7·10⁻⁵. A sweep over all 2²⁴ phases shows at most
-- 2.1·10⁻⁵. The bounds are:
--
-- - the line in place of the cosine: h²/4 = 9.4·10⁻⁶
-- - the angle z in place of its sine: h³/6 = 4·10⁻⁸
-- - rounding of the slope, over half an interval: 2⁻⁹·2⁻¹⁰ = 1.9·10⁻⁶
-- - truncation of the 5 lower bits of the place: 2π·2⁻²⁰ = 6.0·10⁻⁶
-- - rounding of the value: 2⁻²¹ = 4.8·10⁻⁷
-- - truncation in the rows: 2⁻²⁰ = 9.5·10⁻⁷
-- - mirroring of the phase into the first quadrant by the complement (quadrant_fold): 2π·2⁻²⁴ = 3.7·10⁻⁷
-- - rounding of the result to s1.16 in harmonic_lane: 2⁻¹⁷ = 7.6·10⁻⁶
--
-- There is no reset, because no register holds state.

library ieee;
  use ieee.std_logic_1164.all;
  use ieee.numeric_std.all;
  use ieee.math_real.all;

  use work.number_formats_pkg.all;

entity table_rotation is
  port (
    clock  : in    std_ulogic;
    folded : in    u_unsigned(PHASE_WIDTH - 3 downto 0);                                -- 2⁻²⁴ turn
    cosine : out   u_signed(COSINE_WIDTH + GUARD_WIDTH - 1 downto 0) := (others => '0') -- s1.18
  );
end entity table_rotation;

architecture rtl of table_rotation is

  constant OFFSET_WIDTH : positive := folded'length - COSINE_ADDRESS_WIDTH; -- bits of the place in an interval
  constant DIGITS_WIDTH : positive := 2 * COSINE_ROWS;                      -- bits of the place that the rows multiply
  constant SLOPE_WIDTH  : positive := COSINE_SLOPE_FRACTION + 3;
  constant VALUE_WIDTH  : positive := COSINE_VALUE_FRACTION + 2;
  -- Number of fraction bits of the last row: every row except the first drops two fraction bits of the product.
  constant ROW_FRACTION : positive := COSINE_SLOPE_FRACTION + PHASE_WIDTH - OFFSET_WIDTH + DIGITS_WIDTH - 2 * (COSINE_ROWS - 1);
  -- The last row is below 4 slopes.
  constant ROW_WIDTH    : positive := SLOPE_WIDTH + 2;

  constant WORKING : positive := COSINE_ROWS + 3;
  constant WAITING : positive := CORDIC_ITERATIONS - 1 - WORKING;

  subtype table_address is natural range 0 to 2 ** COSINE_ADDRESS_WIDTH - 1;

  subtype slope_count is u_unsigned(SLOPE_WIDTH - 1 downto 0);

  subtype row_count is u_unsigned(ROW_WIDTH - 1 downto 0);

  subtype value_count is u_signed(VALUE_WIDTH - 1 downto 0);

  subtype place is u_unsigned(COSINE_ADDRESS_WIDTH + DIGITS_WIDTH - 1 downto 0);

  type slope_table is array (table_address) of slope_count;

  type value_table is array (table_address) of value_count;

  type slope_line is array (natural range <>) of slope_count;

  type row_line is array (natural range <>) of row_count;

  type digits_line is array (natural range <>) of u_unsigned(DIGITS_WIDTH - 1 downto 0);

  type address_line is array (natural range <>) of u_unsigned(COSINE_ADDRESS_WIDTH - 1 downto 0);

  type place_line is array (natural range <>) of place;

  -- Returns the angle of the middle of an interval, rad.
  function middle_of (address : table_address) return real is
  begin

    return (real(address) + 0.5) * MATH_PI_OVER_2 / 2.0 ** COSINE_ADDRESS_WIDTH;

  end function middle_of;

  -- Returns the slope of the cosine without its sign, in 2**-COSINE_SLOPE_FRACTION per turn.
  function slope_of (address : table_address) return real is
  begin

    return round(MATH_2_PI * sin(middle_of(address)) * 2.0 ** COSINE_SLOPE_FRACTION);

  end function slope_of;

  function slopes_of_all return slope_table is

    variable table : slope_table;

  begin

    for address in table'range loop
      table(address) := to_unsigned(natural(slope_of(address)), SLOPE_WIDTH);
    end loop;

    return table;

  end function slopes_of_all;

  -- Returns the values of the lines at the beginnings of their intervals.
  function values_of_all return value_table is

    -- REACH is half an interval; UNIT is half of the lowest bit of the place that the rows multiply. Both are in turns.
    constant REACH : real := 2.0 ** (OFFSET_WIDTH - 1 - PHASE_WIDTH);
    constant UNIT  : real := 2.0 ** (OFFSET_WIDTH - DIGITS_WIDTH - 1 - PHASE_WIDTH);
    constant SCALE : real := 1.0 - (MATH_2_PI * REACH) ** 2 / 4.0;

    variable table  : value_table;
    variable begins : real;

  begin

    for address in table'range loop
      begins         := SCALE * cos(middle_of(address)) + slope_of(address) / 2.0 ** COSINE_SLOPE_FRACTION * (REACH - UNIT);
      begins         := begins - 2.0 ** (-ROW_FRACTION - 1);
      table(address) := to_signed(integer(round(begins * 2.0 ** COSINE_VALUE_FRACTION)), VALUE_WIDTH);
    end loop;

    return table;

  end function values_of_all;

  constant SLOPES : slope_table := slopes_of_all;
  constant VALUES : value_table := values_of_all;

begin

  -- harmonic_lane receives the amplitude a fixed number of clocks after the phase, so no other width or latency is
  -- possible.
  assert COSINE_WIDTH = 18 and WAITING >= 1
    report "table_rotation: needs a cosine of 18 bits and at least 10 CORDIC_ITERATIONS; choose ROTATION = cordic"
    severity failure;

  look_up : process (clock) is

    -- Registers in the order of the data path
    variable waits        : place_line(1 to WAITING)           := (others => (others => '0'));
    variable first_slope  : slope_count                        := (others => '0');
    variable first_digits : u_unsigned(DIGITS_WIDTH - 1 downto 0) := (others => '0');
    variable first_address : u_unsigned(COSINE_ADDRESS_WIDTH - 1 downto 0) := (others => '0');
    variable slope        : slope_line(0 to COSINE_ROWS - 1)   := (others => (others => '0'));
    variable triple       : row_line(0 to COSINE_ROWS - 1)     := (others => (others => '0'));
    variable digits       : digits_line(0 to COSINE_ROWS - 1)  := (others => (others => '0'));
    variable address      : address_line(0 to COSINE_ROWS - 1) := (others => (others => '0'));
    variable row          : row_line(1 to COSINE_ROWS)         := (others => (others => '0'));
    variable value        : value_count                        := (others => '0');

    variable before     : row_count;
    variable multiple   : row_count;
    variable product    : value_count;
    variable difference : value_count;

  begin

    if rising_edge(clock) then
      -- The code begins with the last register, so that each variable is read before it takes its new value.
      product    := signed(shift_left(resize(row(COSINE_ROWS), VALUE_WIDTH), COSINE_VALUE_FRACTION - ROW_FRACTION));
      difference := value - product;
      cosine     <= difference(difference'high downto COSINE_VALUE_FRACTION - (COSINE_WIDTH - 2 + GUARD_WIDTH));

      value := VALUES(to_integer(address(COSINE_ROWS - 1)));

      for i in COSINE_ROWS - 1 downto 0 loop
        before := (others => '0');
        if i > 0 then
          before := shift_right(row(i), 2);
        end if;

        case digits(i)(1 downto 0) is

          when "00" =>
            multiple := (others => '0');

          when "01" =>
            multiple := resize(slope(i), ROW_WIDTH);

          when "10" =>
            multiple := shift_left(resize(slope(i), ROW_WIDTH), 1);

          when others =>
            multiple := triple(i);

        end case;

        row(i + 1) := before + multiple;

        if i < COSINE_ROWS - 1 then
          slope(i + 1)   := slope(i);
          triple(i + 1)  := triple(i);
          digits(i + 1)  := shift_right(digits(i), 2);
          address(i + 1) := address(i);
        end if;
      end loop;

      slope(0)   := first_slope;
      triple(0)  := resize(first_slope, ROW_WIDTH) + shift_left(resize(first_slope, ROW_WIDTH), 1);
      digits(0)  := first_digits;
      address(0) := first_address;

      first_slope   := SLOPES(to_integer(waits(WAITING)(place'high downto DIGITS_WIDTH)));
      first_address := waits(WAITING)(place'high downto DIGITS_WIDTH);
      first_digits  := waits(WAITING)(DIGITS_WIDTH - 1 downto 0);

      waits(2 to WAITING) := waits(1 to WAITING - 1);
      waits(1)            := folded(folded'high downto folded'length - place'length);
    end if;

  end process look_up;

end architecture rtl;
