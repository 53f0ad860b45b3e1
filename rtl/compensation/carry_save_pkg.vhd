-- SPDX-License-Identifier: Apache-2.0
--
-- Carry-save addition: three numbers become two with the same sum, without a carry chain, so that
-- several numbers can be added in one clock at the cost of one chain.
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

  -- a + b + carry_in on one carry chain.
  function add_with_carry (
    a, b     : u_signed;
    carry_in : std_ulogic
  ) return u_signed;

  -- a - b, or a + b, on one carry chain. Written as a difference, since Yosys may swap the operands of
  -- a sum; a enters the carry chain without a LUT.
  function less_or_more (
    a, b : u_signed;
    more : std_ulogic
  ) return u_signed;

  -- Sum of numbers of `width` bits side by side, modulo 2**width, on one carry chain. Three
  -- numbers of each level become two: 3 numbers take 1 level of logic before the chain, 4 take 2, up to 6
  -- take 3, up to 9 take 4.
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

    -- The lowest bit makes the borrow: a - (not b) - 1 is a + b.
    difference := (a & '0') - ((b xor (b'range => more)) & more);
    return difference(a'length downto 1);

  end function less_or_more;

  function sum_of_all (
    numbers : u_signed;
    width   : positive
  ) return u_signed is

    subtype number is u_signed(width - 1 downto 0);

    variable left_over : u_signed(numbers'length - 1 downto 0);
    variable count     : natural;
    variable a         : number;
    variable b         : number;
    variable c         : number;

  begin

    left_over := numbers;
    count     := numbers'length / width;

    while count > 2 loop
      for triple in 0 to count / 3 - 1 loop
        a := left_over((3 * triple + 1) * width - 1 downto 3 * triple * width);
        b := left_over((3 * triple + 2) * width - 1 downto (3 * triple + 1) * width);
        c := left_over((3 * triple + 3) * width - 1 downto (3 * triple + 2) * width);

        -- What is written here has been read.
        left_over((2 * triple + 1) * width - 1 downto 2 * triple * width)       := saved_sum(a, b, c);
        left_over((2 * triple + 2) * width - 1 downto (2 * triple + 1) * width) := saved_carry(a, b, c);
      end loop;

      for other in 0 to count mod 3 - 1 loop
        a := left_over((count / 3 * 3 + other + 1) * width - 1 downto (count / 3 * 3 + other) * width);

        left_over((count / 3 * 2 + other + 1) * width - 1 downto (count / 3 * 2 + other) * width) := a;
      end loop;

      count := count / 3 * 2 + count mod 3;
    end loop;

    if count = 1 then
      return left_over(width - 1 downto 0);
    end if;
    return left_over(2 * width - 1 downto width) + left_over(width - 1 downto 0);

  end function sum_of_all;

end package body carry_save_pkg;
