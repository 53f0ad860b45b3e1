-- SPDX-License-Identifier: Apache-2.0
--
-- Declares functions that compare a count with a tolerance or a bound.

library ieee;
  use ieee.std_logic_1164.all;
  use ieee.numeric_std.all;

package tolerance_pkg is

  -- Returns whether -tolerance <= deviation <= tolerance. The comparison has only as many bits as the tolerance.
  function is_within (
    deviation : u_signed;
    tolerance : u_unsigned
  ) return std_ulogic;

  -- Returns whether |number| > bound.
  function is_beyond (
    number : u_signed;
    bound  : u_unsigned
  ) return std_ulogic;

  -- Returns whether a number is at most `bound`. It uses logic for each bit, because Yosys would build a carry chain
  -- for the comparison operator.
  function is_at_most (
    number : u_unsigned;
    bound  : natural
  ) return boolean;

end package tolerance_pkg;

package body tolerance_pkg is

  function is_within (
    deviation : u_signed;
    tolerance : u_unsigned
  ) return std_ulogic is

    variable high : u_signed(deviation'high downto tolerance'length);
    variable low  : u_unsigned(tolerance'range);

  begin

    high := deviation(deviation'high downto tolerance'length);
    low  := u_unsigned(deviation(tolerance'range));

    -- The magnitude of a negative number is its complement plus 1.
    if (high = 0) then
      return low ?<= tolerance;
    elsif (high = -1) then
      return (not low) ?< tolerance;
    end if;
    return '0';

  end function is_within;

  function is_beyond (
    number : u_signed;
    bound  : u_unsigned
  ) return std_ulogic is

    variable falls : std_ulogic;
    variable size  : u_unsigned(number'length downto 0);

  begin

    -- The magnitude of a negative number is its complement plus 1. No adder is needed for this 1: both sides of the
    -- comparison get one more bit on the right, and this bit of `size` is 1 for a negative number.
    falls := number(number'high);
    size  := u_unsigned(number xor (number'range => falls)) & falls;
    return size ?> (bound & '0');

  end function is_beyond;

  function is_at_most (
    number : u_unsigned;
    bound  : natural
  ) return boolean is

    variable bits   : u_unsigned(number'length - 1 downto 0);
    variable result : boolean := true;

  begin

    bits := number;

    for place in 0 to bits'high loop
      if bound / 2 ** place mod 2 = 1 then
        result := bits(place) = '0' or result;
      else
        result := bits(place) = '0' and result;
      end if;
    end loop;

    return result or bound >= 2 ** bits'length;

  end function is_at_most;

end package body tolerance_pkg;
