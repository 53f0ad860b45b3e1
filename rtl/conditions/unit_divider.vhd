-- SPDX-License-Identifier: Apache-2.0
--
-- # unit_divider
--
-- Divides two unsigned numbers, one bit per clock (restoring division), and limits the quotient to 1.
--
-- **Latency.** 19 clocks from `start` to `done`. `quotient` is valid with `done` and keeps its value until the next
-- `done`. Begin no other division before `done`.
--
-- **Number formats.** dividend and divisor have the same, arbitrary format; quotient u1.16, rounded half up, at
-- most 1. A division by 0 gives 0.
--
-- **Reset** ends a division; no `done` follows.

library ieee;
  use ieee.std_logic_1164.all;
  use ieee.numeric_std.all;

  use work.conditions_pkg.all;
  use work.number_formats_pkg.all;

entity unit_divider is
  port (
    clock    : in    std_ulogic;
    reset    : in    std_ulogic;
    start    : in    std_ulogic;                                -- strobe: begin a division
    dividend : in    u_unsigned(NOMINAL_WIDTH - 1 downto 0);    -- valid with start
    divisor  : in    u_unsigned(NOMINAL_WIDTH - 1 downto 0);    -- valid with start
    done     : out   std_ulogic                        := '0';  -- strobe: the quotient is new
    quotient : out   u_unsigned(MODULATOR_FRACTION downto 0)    -- u1.16
  );
end entity unit_divider;

architecture rtl of unit_divider is

  -- Number of bits after the first bit of the quotient, including the bit for its rounding
  constant STEPS : positive := MODULATOR_FRACTION + 1;

begin

  divide : process (clock) is

    variable rest    : u_unsigned(NOMINAL_WIDTH downto 0)     := (others => '0');
    variable against : u_unsigned(NOMINAL_WIDTH downto 0)     := (others => '0');
    variable found   : u_unsigned(STEPS downto 0)             := (others => '0');
    variable left    : natural range 0 to STEPS + 1           := 0;

    variable less    : u_unsigned(NOMINAL_WIDTH + 1 downto 0);

  begin

    if rising_edge(clock) then
      done <= '0';
      less := ('0' & rest) - ('0' & against);

      if start = '1' then
        rest    := '0' & dividend;
        against := '0' & divisor;
        left    := STEPS + 1;
        found   := (others => '0');
      elsif left > 0 then
        -- The first bit of `found` is the integer bit: the quotient is 1 if this bit is set. With a divisor of 0 the
        -- quotient is 0.
        found := found(STEPS - 1 downto 0) & not less(less'high);
        if less(less'high) = '0' then
          rest := less(rest'range);
        end if;
        rest := shift_left(rest, 1);
        left := left - 1;
        if left = 0 then
          done     <= '1';
          quotient <= resize(shift_right(found + 1, 1), quotient'length);
          if found(STEPS) = '1' then
            quotient <= to_unsigned(2 ** MODULATOR_FRACTION, quotient'length);
          end if;
          if (or against) = '0' then
            quotient <= (others => '0');
          end if;
        end if;
      end if;

      if reset = '1' then
        left := 0;
        done <= '0';
      end if;
    end if;

  end process divide;

end architecture rtl;
