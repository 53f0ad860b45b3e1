-- SPDX-License-Identifier: Apache-2.0
--
-- # parity_sum
--
-- Computes the parity of the heads' readings, Σ cᵢ·rᵢ with Σ cᵢ = 0 and Σ cᵢ·e^{jβᵢ} = 0, where βᵢ are the angles of
-- the heads around the axis. The parity depends neither on the angle of the table nor on a translation of the axis, but
-- shows every error of a single head. Because Σ cᵢ = 0, the readings may be replaced by their differences from the
-- reading of the carrier (the head whose reading enters the pipeline), which weighted_mean computes anyway. One
-- multiplier computes the products of the heads one after the other.
--
-- **Latency.** `parity` is renewed every 8 clocks. It comes HEADS + 3 clocks after its `differences`, which all belong
-- to one clock; `beyond` follows `parity` by 1 clock.
--
-- **Number formats.** differences s16.4 counts, weights s1.16, parity s19.11 counts, rounded down; limit u16.0 counts;
-- 0 turns the limit off. `beyond` is high while |floor(parity)| is `limit` or more.
--
-- There is no reset: the parity depends only on the latest differences.

library ieee;
  use ieee.std_logic_1164.all;
  use ieee.numeric_std.all;

  use work.number_formats_pkg.all;
  use work.tolerance_pkg.all;

entity parity_sum is
  generic (
    HEADS : positive range 3 to HEADS_MAX := 4
  );
  port (
    clock       : in    std_ulogic;
    differences : in    std_ulogic_vector(HEADS * HEAD_DIFFERENCE_WIDTH - 1 downto 0); -- counts, s16.4, head 1 in the low bits
    weights     : in    std_ulogic_vector(HEADS * HEAD_WEIGHT_WIDTH - 1 downto 0);     -- s1.16
    limit       : in    u_unsigned(15 downto 0);                                       -- counts, 0: off
    parity      : out   u_signed(CORRECTION_WIDTH - 1 downto 0) := (others => '0');    -- counts, s19.11
    beyond      : out   std_ulogic                              := '0'                 -- level: |floor(parity)| >= limit
  );
end entity parity_sum;

architecture rtl of parity_sum is

  constant ROUNDED : positive := MEAN_TERM_FRACTION - CORRECTION_FRACTION;

begin

  one_after_the_other : process (clock) is

    variable turn      : u_unsigned(2 downto 0)                                              := "000";
    -- The differences of heads 2 and above, in the clock in which head 1 was read
    variable held      : std_ulogic_vector(differences'high downto HEAD_DIFFERENCE_WIDTH)    := (others => '0');
    -- Registers; the number in a name is the number of clocks from the clock in which `turn` selects a head until the
    -- register holds this head's value.
    variable factor_1  : u_signed(HEAD_DIFFERENCE_WIDTH - 1 downto 0)                        := (others => '0');
    variable weight_1  : u_signed(HEAD_WEIGHT_WIDTH - 1 downto 0)                            := (others => '0');
    variable product_2 : u_signed(HEAD_DIFFERENCE_WIDTH + HEAD_WEIGHT_WIDTH - 1 downto 0)    := (others => '0');
    variable sum_3     : u_signed(MEAN_TERM_WIDTH - 1 downto 0)                              := (others => '0');
    -- A register, so that no subtraction precedes the comparison
    variable below_limit : u_unsigned(limit'range)                                           := (others => '0');
    variable head      : natural range 0 to 7;
    variable is_first  : std_ulogic;

  begin

    if rising_edge(clock) then
      beyond     <= (or limit) and is_beyond(parity(parity'high downto CORRECTION_FRACTION), below_limit);
      below_limit := limit - 1;

      -- Head h (from 0 on) is read when `turn` is h; its product is added when `turn` is h + 2.
      head := to_integer(turn);
      if head = HEADS + 2 then
        parity <= resize(shift_right(sum_3, ROUNDED), parity'length);
      end if;
      -- The sum so far or 0 takes only the look-up tables of the carry chain.
      is_first := '1' when head = 2 else '0';
      sum_3    := resize(product_2, sum_3'length) + (sum_3 and (sum_3'range => not is_first));
      product_2 := factor_1 * weight_1;

      -- After the last head the products belong to no sum.
      factor_1 := u_signed(differences(HEAD_DIFFERENCE_WIDTH - 1 downto 0));
      weight_1 := u_signed(weights(HEAD_WEIGHT_WIDTH - 1 downto 0));

      for number in 1 to HEADS - 1 loop
        if turn(1 downto 0) = number then
          factor_1 := u_signed(held((number + 1) * HEAD_DIFFERENCE_WIDTH - 1 downto number * HEAD_DIFFERENCE_WIDTH));
          weight_1 := u_signed(weights((number + 1) * HEAD_WEIGHT_WIDTH - 1 downto number * HEAD_WEIGHT_WIDTH));
        end if;
      end loop;

      if head = 0 then
        held := differences(held'range);
      end if;

      turn := turn + 1;
    end if;

  end process one_after_the_other;

end architecture rtl;
