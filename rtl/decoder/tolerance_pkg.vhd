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

end package body tolerance_pkg;
