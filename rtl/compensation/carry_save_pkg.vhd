-- SPDX-License-Identifier: Apache-2.0
--
-- Declares functions for carry-save addition: they reduce three numbers to two with the same sum, without a carry
-- chain, so that several numbers can be added in one clock at the cost of one chain.
-- a + b + c + carry_in = saved_sum(a, b, c) + saved_carry(a, b, c, carry_in) modulo 2**length.

library ieee;
  use ieee.std_logic_1164.all;
  use ieee.numeric_std.all;

package carry_save_pkg is

  function saved_sum (
    a, b, c : u_signed
  ) return u_signed;

  function saved_carry (
    a, b, c  : u_signed;
    carry_in : std_ulogic := '0'
  ) return u_signed;

  -- Returns a + b + carry_in, computed on one carry chain.
  function add_with_carry (
    a, b     : u_signed;
    carry_in : std_ulogic
  ) return u_signed;

  -- Returns a + b if `more` is high, otherwise a - b, on one carry chain. The function computes a difference in both
  -- cases, because Yosys may swap the operands of a sum; in a difference a enters the carry chain without a LUT.
  function less_or_more (
    a, b : u_signed;
    more : std_ulogic
  ) return u_signed;

  -- Returns whether a < b, for numbers of the same width, from the sign of a - b. The carry chain of this difference
  -- takes one bit of each number per LUT. For "<" Yosys builds a chain with two or three bits in two LUTs, and nextpnr
  -- places these LUTs apart from the chain.
  function is_less (
    a, b : u_signed
  ) return std_ulogic;

  -- Reduces numbers of `width` bits, which lie side by side in one vector, to `left` numbers with the same sum modulo
  -- 2**width. If there are fewer than `left` numbers, the remaining ones are 0. One level of logic reduces up to 6
  -- numbers to 3; 2 levels reduce up to 12 numbers, 3 levels up to 24, 4 levels up to 48. A reduction to 2 numbers
  -- takes one more level.
  function carry_saved (
    numbers     : u_signed;
    width, left : positive
  ) return u_signed;

  -- Returns the sum of numbers that lie side by side in one vector: carry-save levels reduce them to 2 numbers, which
  -- one carry chain adds.
  function sum_of_all (
    numbers : u_signed;
    width   : positive
  ) return u_signed;

end package carry_save_pkg;

package body carry_save_pkg is

  function saved_sum (
    a, b, c : u_signed
  ) return u_signed is
  begin

    return a xor b xor c;

  end function saved_sum;

  function saved_carry (
    a, b, c  : u_signed;
    carry_in : std_ulogic := '0'
  ) return u_signed is

    variable majority : u_signed(a'length - 1 downto 0);

  begin

    majority := (a and b) or (c and (a or b));
    return majority(a'length - 2 downto 0) & carry_in;

  end function saved_carry;

  function add_with_carry (
    a, b     : u_signed;
    carry_in : std_ulogic
  ) return u_signed is

    variable sum : u_signed(a'length downto 0);

  begin

    sum := (a & '1') + (b & carry_in);
    return sum(a'length downto 1);

  end function add_with_carry;

  function less_or_more (
    a, b : u_signed;
    more : std_ulogic
  ) return u_signed is

    variable difference : u_signed(a'length downto 0);

  begin

    -- The lowest bit generates the borrow: a - (not b) - 1 is a + b.
    difference := (a & '0') - ((b xor (b'range => more)) & more);
    return difference(a'length downto 1);

  end function less_or_more;

  function is_less (
    a, b : u_signed
  ) return std_ulogic is

    variable difference : u_signed(a'length downto 0);

  begin

    difference := resize(a, a'length + 1) - resize(b, a'length + 1);
    return difference(a'length);

  end function is_less;

  -- Returns number `place` of `count` numbers of `width` bits side by side, 0 beyond the last.
  function number_at (
    numbers             : u_signed;
    width, place, count : natural
  ) return u_signed is
  begin

    if place >= count then
      return (width - 1 downto 0 => '0');
    end if;
    return numbers((place + 1) * width - 1 downto place * width);

  end function number_at;

  type counts_of_six is array (0 to 63) of u_unsigned(2 downto 0);

  -- Returns a table: for every value of six bits, the number of bits that are high.
  function high_bits return counts_of_six is

    variable table : counts_of_six;
    variable count : natural range 0 to 6;

  begin

    for bits in table'range loop
      count := 0;

      for place in 0 to 5 loop
        count := count + bits / 2 ** place mod 2;
      end loop;

      table(bits) := to_unsigned(count, 3);
    end loop;

    return table;

  end function high_bits;

  constant HIGH_BITS_OF : counts_of_six := high_bits;

  -- Reduces six numbers to three with the same sum: each bit of a result is a function of the six bits at one bit
  -- position.
  function three_of_six (
    six   : u_signed;
    width : positive
  ) return u_signed is

    variable bits  : u_signed(6 * width - 1 downto 0);
    variable place : u_unsigned(5 downto 0);
    variable count : u_unsigned(2 downto 0);
    variable ones  : u_signed(width - 1 downto 0);
    variable twos  : u_signed(width - 1 downto 0);
    variable fours : u_signed(width - 1 downto 0);

  begin

    bits := six;

    for bit_number in 0 to width - 1 loop
      for number in place'range loop
        place(number) := bits(number * width + bit_number);
      end loop;

      count             := HIGH_BITS_OF(to_integer(place));
      ones(bit_number)  := count(0);
      twos(bit_number)  := count(1);
      fours(bit_number) := count(2);
    end loop;

    return ones & shift_left(twos, 1) & shift_left(fours, 2);

  end function three_of_six;

  function carry_saved (
    numbers     : u_signed;
    width, left : positive
  ) return u_signed is

    subtype number is u_signed(width - 1 downto 0);

    -- The vector has room for the numbers or the result, whichever is longer, and for two more numbers, because a group
    -- may write three.
    variable left_over : u_signed(maximum(numbers'length, left * width) + 2 * width - 1 downto 0);
    variable count     : natural;
    variable a         : number;
    variable b         : number;
    variable c         : number;

  begin

    left_over                              := (others => '0');
    left_over(numbers'length - 1 downto 0) := numbers;
    count                                  := numbers'length / width;

    while count > left loop
      -- Each group has up to six numbers; it overwrites only numbers that have been read.
      for part in 0 to (count - 1) / 6 loop
        a := number_at(left_over, width, 6 * part, count);
        b := number_at(left_over, width, 6 * part + 1, count);
        c := number_at(left_over, width, 6 * part + 2, count);
        if count - 6 * part > 3 then
          left_over((3 * part + 3) * width - 1 downto 3 * part * width) := three_of_six(
            number_at(left_over, width, 6 * part + 5, count) & number_at(left_over, width, 6 * part + 4, count)
            & number_at(left_over, width, 6 * part + 3, count) & c & b & a, width
          );
        elsif count - 6 * part = 3 then
          left_over((3 * part + 2) * width - 1 downto 3 * part * width) := saved_carry(a, b, c) & saved_sum(a, b, c);
        else
          left_over((3 * part + 2) * width - 1 downto 3 * part * width) := b & a;
        end if;
      end loop;

      count := count / 6 * 3 + minimum(count mod 6, 3) - boolean'pos(count mod 6 = 3);
    end loop;

    left_over(left_over'high downto count * width) := (others => '0');
    return left_over(left * width - 1 downto 0);

  end function carry_saved;

  function sum_of_all (
    numbers : u_signed;
    width   : positive
  ) return u_signed is

    variable two : u_signed(2 * width - 1 downto 0);

  begin

    if numbers'length = width then
      return numbers;
    end if;
    two := carry_saved(numbers, width, 2);
    return two(2 * width - 1 downto width) + two(width - 1 downto 0);

  end function sum_of_all;

end package body carry_save_pkg;
