-- SPDX-License-Identifier: Apache-2.0
--
-- # conditions_pkg
--
-- Declares the formats of the conditions (direction, speed, words of the processor) that multiply the amplitudes of
-- lanes, and the steps of a sweep: in AMPLITUDE_SWEEP_CLOCKS clocks each lane of both banks gets a new effective
-- amplitude (amplitude_sweep).

library ieee;
  use ieee.std_logic_1164.all;
  use ieee.numeric_std.all;

  use work.number_formats_pkg.all;

package conditions_pkg is

  subtype modulator is u_signed(MODULATOR_WIDTH - 1 downto 0);

  constant MODULATOR_ONE    : modulator := to_signed(2 ** MODULATOR_FRACTION, MODULATOR_WIDTH);

  -- Numbers of the modulators in bits 18 to 16 of word 1 of a lane; other numbers act as UNMODULATED.
  constant UNMODULATED      : natural := 0;
  constant BY_DIRECTION     : natural := 1;
  constant BY_SPEED         : natural := 2;
  constant BY_SPEED_SQUARED : natural := 3;
  constant BY_WORD_A        : natural := 4;
  constant BY_WORD_B        : natural := 5;

  -- A sweep of amplitude_sweep: steps 0 to 127 process the lanes of both banks.
  constant DIRECTION_STEP   : natural := 0;   -- step in which the division of the direction begins
  constant SPEED_STEP       : natural := 32;  -- step in which the division of the speed begins
  constant IDLE_SPEED_STEP  : natural := 96;  -- step in which the division of the speed for the idle bank begins
  constant PRODUCT_CLOCKS   : natural := 32;  -- the divisor's computation begins this many clocks before these two steps
  constant SQUARE_STEP      : natural := 128; -- step in which the speed for bank 0 is multiplied by itself; bank 1 follows

  -- Formats of table_speed
  constant TRAVEL_WIDTH     : positive := 31; -- u20.11 counts
  constant ELAPSED_WIDTH    : positive := 24; -- clocks
  constant NOMINAL_WIDTH    : positive := 56; -- u24.32 counts

end package conditions_pkg;
