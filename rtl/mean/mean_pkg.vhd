-- SPDX-License-Identifier: Apache-2.0
--
-- # mean_pkg
--
-- Declares the records that mean_unit passes on: the reading that compensation_pipeline corrects, and the writes to the
-- idle banks. In a core without the mean, head 1 and the processor supply the values of these records.

library ieee;
  use ieee.std_logic_1164.all;
  use ieee.numeric_std.all;

  use work.number_formats_pkg.all;

package mean_pkg is

  -- The reading of head 1 or of the carrier, and the values that belong to this reading.
  type pipeline_reading is record
    angle         : u_unsigned(ANGLE_WIDTH - 1 downto 0);    -- counts, below counts_per_rev
    position      : u_signed(POSITION_WIDTH - 1 downto 0);   -- counts, including counts put back
    phase_of_zero : u_unsigned(1 downto 0);                  -- index of (A, B) in 00 10 11 01 at position 0
    put_back      : u_signed(15 downto 0);                   -- counts in position without an edge, modulo 2¹⁶
    zero_moved    : std_ulogic;                              -- toggles with the first angle from another zero
    referenced    : std_ulogic;                              -- level: the angle counts from an index
    apply         : std_ulogic;                              -- level: this reading is to be corrected
    -- MEAN_LATENCY clocks after the angle
    mean_term     : u_signed(MEAN_TERM_WIDTH - 1 downto 0);  -- counts, s19.20
    mean_limited  : std_ulogic;                              -- level: a difference in this term is limited
    jumped        : std_ulogic;                              -- pulse: the first angle of new words
    jump          : u_signed(15 downto 0);                   -- counts of the jump, valid with jumped
  end record pipeline_reading;

  -- A write to the idle banks, or a swap, from the processor or from a prepared set.
  type bank_update is record
    lane      : std_ulogic;                     -- pulse: write a word of a lane
    offset    : std_ulogic;                     -- pulse: write the coefficient offset
    turn_step : std_ulogic;                     -- pulse: write a word of a turn step
    mean      : std_ulogic;                     -- pulse: write a word of the mean
    address   : u_unsigned(7 downto 0);         -- lane * 4 + word, the place in the mean, or lane * 2 + word
    data      : std_ulogic_vector(31 downto 0); -- the word
    swap      : std_ulogic;                     -- pulse: the idle banks become active
  end record bank_update;

end package mean_pkg;
