-- SPDX-License-Identifier: Apache-2.0
--
-- Whether a count lies where it ought to.

library ieee;
  use ieee.std_logic_1164.all;
  use ieee.numeric_std.all;

package tolerance_pkg is

  -- Whether -tolerance <= deviation <= tolerance, with a comparison of the tolerance's bits only.
  function is_within (
    deviation : u_signed;
    tolerance : u_unsigned
  ) return std_ulogic;

  -- Whether a number is so much or less, bit by bit: Yosys would make a carry chain of the comparison.
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

    -- The size of a negative number is its complement and 1.
    if (high = 0) then
      return low ?<= tolerance;
    elsif (high = -1) then
      return (not low) ?< tolerance;
    end if;
    return '0';

  end function is_within;

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
