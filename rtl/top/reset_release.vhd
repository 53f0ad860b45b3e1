-- SPDX-License-Identifier: Apache-2.0
--
-- # reset_release
--
-- Generates the core's synchronous reset from the processor's reset, which may come at any time. The entity
-- synchronises the processor's reset to the clock, and ends the core's reset CLOCKS clocks after the synchronised reset
-- has ended.
--
-- **Latency.** `reset` rises 3 clocks after `asynchronous_reset_n` falls and falls 3 + CLOCKS clocks after
-- `asynchronous_reset_n` rises; each latency is one clock longer if the first register samples the edge late.
--
-- **Number formats.** All ports are single bits.
--
-- **Power-up.** At power-up `reset` is active, so no edge of `asynchronous_reset_n` is needed. The entity may miss a
-- pulse shorter than a clock period. While the clock does not run, `reset` does not change.

library ieee;
  use ieee.std_logic_1164.all;

entity reset_release is
  generic (
    CLOCKS : positive range 1 to 65535 := 64 -- clocks of reset after the end of the synchronised reset
  );
  port (
    clock                : in    std_ulogic;
    asynchronous_reset_n : in    std_ulogic;
    reset                : out   std_ulogic := '1'
  );
end entity reset_release;

architecture rtl of reset_release is

  signal reset_n : std_ulogic;
  signal elapsed : natural range 0 to CLOCKS := 0;

begin

  synchroniser : entity work.input_synchroniser
    generic map (
      WIDTH  => 1,
      STAGES => 2
    )
    port map (
      clock           => clock,
      asynchronous(0) => asynchronous_reset_n,
      synchronised(0) => reset_n
    );

  hold : process (clock) is
  begin

    if rising_edge(clock) then
      if reset_n = '0' then
        elapsed <= 0;
        reset   <= '1';
      elsif elapsed < CLOCKS then
        elapsed <= elapsed + 1;
      else
        reset <= '0';
      end if;
    end if;

  end process hold;

end architecture rtl;
