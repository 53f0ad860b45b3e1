-- SPDX-License-Identifier: Apache-2.0
--
-- # processor_watch
--
-- Raises `silent` when no pulse of `alive` has come from the processor for `limit` clocks. The main loop of the
-- firmware gives `alive`, so the entity also detects a main loop that hangs while the interrupts still run. `silent` is
-- a fault for fault_outputs; correction and output do not depend on the processor and continue with the last
-- coefficients.
--
-- **Latency.** `silent` rises limit + 2 clocks after the last `alive`, or after the last clock in which `limit` is 0;
-- it falls 1 clock after the next `alive`.
--
-- **Number formats.** limit u32.0 clocks; 0 switches the watch off.
--
-- **Reset** restarts the time without `alive`.

library ieee;
  use ieee.std_logic_1164.all;
  use ieee.numeric_std.all;

entity processor_watch is
  port (
    clock  : in    std_ulogic;
    reset  : in    std_ulogic;
    limit  : in    u_unsigned(31 downto 0); -- clocks, 0: off
    alive  : in    std_ulogic;              -- pulse: the processor works
    silent : out   std_ulogic := '0'        -- level: no alive has come for limit clocks
  );
end entity processor_watch;

architecture rtl of processor_watch is

begin

  watch : process (clock) is

    variable elapsed : u_unsigned(31 downto 0) := (others => '0'); -- clocks

  begin

    if rising_edge(clock) then
      if reset = '1' or alive = '1' or limit = 0 then
        elapsed := (others => '0');
        silent  <= '0';
      else
        if elapsed >= limit then
          silent <= '1';
        end if;
        -- The comparison is too slow to enable the counter, so its registered result stops the counter one clock late.
        if silent = '0' then
          elapsed := elapsed + 1;
        end if;
      end if;
    end if;

  end process watch;

end architecture rtl;
