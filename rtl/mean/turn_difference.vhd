-- SPDX-License-Identifier: Apache-2.0
--
-- # turn_difference
--
-- Computes the difference of two angles the shorter way round: minuend - subtrahend, plus or minus a turn if necessary
-- to bring it within half a turn. So the difference of two heads makes no step when one head passes its zero before the
-- other head.
--
-- **Latency.** 3 clocks from the angles to `difference`; the entity accepts one pair of angles per clock.
--
-- **Number formats.** Angles u24.0 counts below counts_per_rev; difference s24.0 counts with
-- -counts_per_rev <= 2 * difference < counts_per_rev.
--
-- There is no reset. A difference uses the value that `counts_per_rev` has one clock after its angles.

library ieee;
  use ieee.std_logic_1164.all;
  use ieee.numeric_std.all;

  use work.carry_save_pkg.all;
  use work.number_formats_pkg.all;

entity turn_difference is
  port (
    clock          : in    std_ulogic;
    minuend        : in    u_unsigned(ANGLE_WIDTH - 1 downto 0);                 -- counts
    subtrahend     : in    u_unsigned(ANGLE_WIDTH - 1 downto 0);                 -- counts
    counts_per_rev : in    u_unsigned(COUNTS_PER_REV_WIDTH - 1 downto 0);        -- counts
    difference     : out   u_signed(ANGLE_WIDTH downto 0)    := (others => '0')  -- counts, s24.0
  );
end entity turn_difference;

architecture rtl of turn_difference is

  -- Width of twice a difference, plus or minus a turn.
  subtype wide_count is u_signed(ANGLE_WIDTH + 2 downto 0);

begin

  subtract_and_fold : process (clock) is

    -- Registers; the number in a name is the number of clocks from the angles until the register is valid.
    variable straight_1 : u_signed(difference'range) := (others => '0');
    variable straight_2 : u_signed(difference'range) := (others => '0');
    variable turn_2     : u_signed(difference'range) := (others => '0');
    variable excess_2   : wide_count                 := (others => '0');

    variable falls      : std_ulogic;
    variable is_longer  : std_ulogic;
    variable turn       : wide_count;
    variable twice      : wide_count;

  begin

    if rising_edge(clock) then
      -- Third clock. The straight difference is the longer way round if the turn did not change the sign of twice the
      -- difference. The turn or 0 takes only the look-up tables of the carry chain.
      falls      := straight_2(straight_2'high);
      is_longer  := excess_2(excess_2'high) xnor falls;
      difference <= less_or_more(straight_2, turn_2 and (turn_2'range => is_longer), falls);

      -- Second clock. The turn is subtracted from a positive difference and added to a negative one.
      turn       := resize(u_signed('0' & counts_per_rev), turn'length);
      twice      := shift_left(resize(straight_1, twice'length), 1);
      excess_2   := less_or_more(twice, turn, straight_1(straight_1'high));
      straight_2 := straight_1;
      turn_2     := turn(difference'range);

      -- First clock.
      straight_1 := u_signed('0' & minuend) - u_signed('0' & subtrahend);
    end if;

  end process subtract_and_fold;

end architecture rtl;
