-- SPDX-License-Identifier: Apache-2.0
--
-- # slewed_word
--
-- Moves `word` towards `target` by at most `slew` per strobe of `step`, so that an amplitude that is multiplied by the
-- word makes no jump.
--
-- **Latency.** 1 clock from `step` to `word`.
--
-- **Number formats.** target and word s1.16; slew u0.32 per step. The entity stores the word as s1.32; `word` is this
-- value, truncated.
--
-- **Reset.** `word` is 0.

library ieee;
  use ieee.std_logic_1164.all;
  use ieee.numeric_std.all;

  use work.carry_save_pkg.all;
  use work.conditions_pkg.all;
  use work.number_formats_pkg.all;
  use work.tolerance_pkg.all;

entity slewed_word is
  port (
    clock   : in    std_ulogic;
    reset   : in    std_ulogic;
    step    : in    std_ulogic;               -- strobe: move word by at most slew
    slew    : in    u_unsigned(31 downto 0);  -- u0.32
    target  : in    modulator;                -- s1.16
    word    : out   modulator;                -- s1.16
    reached : out   std_ulogic := '0'         -- high if the last step reached `target`
  );
end entity slewed_word;

architecture rtl of slewed_word is

  constant BELOW : positive := 32 - MODULATOR_FRACTION;

  subtype fine_word is u_signed(MODULATOR_WIDTH + BELOW downto 0);

  signal fine : fine_word := (others => '0');

begin

  lead : process (clock) is

    variable way   : fine_word;
    variable goal  : fine_word;
    variable falls : std_ulogic;

  begin

    if rising_edge(clock) then
      if step = '1' then
        goal    := resize(target, fine'length - BELOW) & (BELOW - 1 downto 0 => '0');
        way     := goal - fine;
        reached <= '0';
        falls   := way(way'high);
        if is_beyond(way, slew) = '1' then
          fine <= add_with_carry(fine, u_signed("000" & slew) xor (fine'range => falls), falls);
        else
          fine    <= goal;
          reached <= '1';
        end if;
      end if;

      if reset = '1' then
        fine    <= (others => '0');
        reached <= '0';
      end if;
    end if;

  end process lead;

  word <= fine(MODULATOR_WIDTH + BELOW - 1 downto BELOW);

end architecture rtl;
