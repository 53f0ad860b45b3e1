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

end package body carry_save_pkg;
