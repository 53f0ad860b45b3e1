-- SPDX-License-Identifier: Apache-2.0
--
-- # decoder_pkg
--
-- Declares the records of a decoder's signals: the edges of A and B, which the decoder's entities exchange, and the
-- decoder's outputs.

library ieee;
  use ieee.std_logic_1164.all;
  use ieee.numeric_std.all;

  use work.number_formats_pkg.all;

package decoder_pkg is

  -- The steps of the filtered levels of A and B. `comes` belongs to the clock of the levels, the other fields to the
  -- clock after it; `up` and `down` keep their value until the next edge. `stands` = not `moves` and `down` = not `up`
  -- are separate registers, which shortens the paths of the decisions that use them.
  type counted_edge is record
    comes        : std_ulogic; -- exactly one of A and B has changed: a count
    moves        : std_ulogic; -- `comes`, one clock later
    stands       : std_ulogic; -- complement of moves
    up           : std_ulogic; -- direction of the last count
    down         : std_ulogic; -- complement of up
    breaks_order : std_ulogic; -- A and B changed in the same clock
  end record counted_edge;

  -- The outputs of quadrature_decoder, for one head.
  type decoded_head is record
    -- Position
    position          : u_signed(POSITION_WIDTH - 1 downto 0);       -- counts, multi-turn
    angle             : u_unsigned(ANGLE_WIDTH - 1 downto 0);        -- counts, below counts_per_rev
    turn_position     : u_signed(POSITION_WIDTH - 1 downto 0);       -- counts from the zero
    phase_of_zero     : u_unsigned(1 downto 0);                      -- index of (A, B) in 00, 10, 11, 01 at position 0 modulo 4
    direction         : std_ulogic;                                  -- '1': the last step was up
    step              : std_ulogic;                                  -- strobe: position changed
    step_up           : std_ulogic;                                  -- strobe: position rose
    last_edge_time    : u_unsigned(TIMESTAMP_WIDTH - 1 downto 0);    -- clocks
    -- Index
    index_seen        : std_ulogic;                                  -- level: an index has been seen
    index_strobe      : std_ulogic;                                  -- strobe: the three fields below are new
    index_position    : u_signed(POSITION_WIDTH - 1 downto 0);       -- counts, position of the last index
    index_direction   : std_ulogic;                                  -- '1': the last index was passed upwards
    index_interval    : u_signed(POSITION_WIDTH - 1 downto 0);       -- counts between the last two indices
    index_trusted     : std_ulogic;                                  -- strobe: the last index agrees with the zero
    zero_moved        : std_ulogic;                                  -- toggles when the zero moves to another count
    zero_moves        : u_unsigned(15 downto 0);                     -- number of moves of the zero; wraps
    zero_slip         : u_signed(COUNTS_PER_REV_WIDTH - 1 downto 0); -- counts, angle of the mark that last moved the zero
    put_back          : u_signed(POSITION_WIDTH - 1 downto 0);       -- counts put back for lost counts, to be added to position
    -- Faults
    index_error       : std_ulogic;                                  -- sticky: an index mark was misplaced
    index_error_count : u_unsigned(15 downto 0);                     -- number of these faults; saturates
    illegal           : std_ulogic;                                  -- sticky: A and B changed in the same clock
    illegal_count     : u_unsigned(15 downto 0);                     -- number of these faults; saturates
    overspeed         : std_ulogic;                                  -- sticky: edges came too fast
    overspeed_count   : u_unsigned(15 downto 0);                     -- number of these faults; saturates
    swallowed         : std_ulogic;                                  -- sticky: the filter suppressed counts
  end record decoded_head;

  -- The outputs of the decoders of several heads, head 1 first.
  type decoded_heads is array (positive range <>) of decoded_head;

end package decoder_pkg;
