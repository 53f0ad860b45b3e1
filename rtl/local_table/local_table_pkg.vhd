-- SPDX-License-Identifier: Apache-2.0
--
-- # local_table_pkg
--
-- Declares the record that states, for one bank of the local table, which windows of the turn the table covers.

library ieee;
  use ieee.std_logic_1164.all;
  use ieee.numeric_std.all;

  use work.number_formats_pkg.all;

package local_table_pkg is

  type local_place is record
    enable   : std_ulogic_vector(LOCAL_WINDOWS - 1 downto 0);     -- one bit per window
    windows  : u_unsigned(1 downto 0);                            -- 0: 1 window of 4,096 points, 1: 2 of 2,048, 2: 4 of 1,024
    width    : u_unsigned(2 downto 0);                            -- a window is 2**-width turn long; width is 0 to 6
    fraction : u_unsigned(1 downto 0);                            -- fraction bits of the points: 0 to 3 for F = 4, 6, 8, 10
    start1   : u_unsigned(ANGLE_WIDTH - 1 downto 0);              -- counts, first count of window 1
    start2   : u_unsigned(ANGLE_WIDTH - 1 downto 0);              -- counts
    start3   : u_unsigned(ANGLE_WIDTH - 1 downto 0);              -- counts
    start4   : u_unsigned(ANGLE_WIDTH - 1 downto 0);              -- counts
    step     : u_unsigned(PHASE_STEP_WIDTH - 1 downto 0);         -- windows per count, u0.48
  end record local_place;

end package local_table_pkg;
