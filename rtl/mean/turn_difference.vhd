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
    variable more_2     : u_signed(difference'range) := (others => '0');
    variable less_2     : u_signed(difference'range) := (others => '0');
    variable above_2    : wide_count                 := (others => '0');
    variable below_2    : wide_count                 := (others => '0');

    variable turn       : wide_count;
    variable twice      : wide_count;

  begin

    if rising_edge(clock) then
      -- Third clock.
      if above_2(above_2'high) = '0' then
        difference <= less_2;
      elsif below_2(below_2'high) = '1' then
        difference <= more_2;
      else
        difference <= straight_2;
      end if;

      -- Second clock. The sums are computed in the width of a difference; the sum that is chosen in the third clock
      -- fits in it.
      turn       := resize(u_signed('0' & counts_per_rev), turn'length);
      twice      := shift_left(resize(straight_1, twice'length), 1);
      above_2    := twice - turn;
      below_2    := twice + turn;
      straight_2 := straight_1;
      more_2     := straight_1 + turn(difference'range);
      less_2     := straight_1 - turn(difference'range);

      -- First clock.
      straight_1 := u_signed('0' & minuend) - u_signed('0' & subtrahend);
    end if;

  end process subtract_and_fold;

end architecture rtl;
