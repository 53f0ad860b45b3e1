-- SPDX-License-Identifier: Apache-2.0
--
-- # glitch_filter
--
-- Passes a new level of each input on to its output after the input has held the level for `filter_length` consecutive
-- samples, one per clock; a shorter pulse has no effect. All inputs have the same delay, so the intervals between edges
-- are preserved.
--
-- **Latency.** `filter_length` clocks from a lasting change of `unfiltered` to `filtered`.
--
-- **Number formats.** filter_length u8.0 clocks: 1 turns the filter off, 0 acts as 1.
--
-- **Run time.** `filter_length` may change in any clock; the filter compares it with the samples counted so
-- far. A new length therefore also applies to a level that is already being counted.
--
-- **Reset** loads the outputs from the inputs and restarts the sample counters, so that the levels present during reset
-- cause no edge afterwards.

library ieee;
  use ieee.std_logic_1164.all;
  use ieee.numeric_std.all;

entity glitch_filter is
  generic (
    WIDTH : positive := 3 -- number of signals; each is filtered independently, with its own sample counter
  );
  port (
    clock         : in    std_ulogic;
    reset         : in    std_ulogic;                            -- loads the outputs from the inputs
    filter_length : in    u_unsigned(7 downto 0);                -- clocks
    unfiltered    : in    std_ulogic_vector(WIDTH - 1 downto 0); -- synchronous to clock
    filtered      : out   std_ulogic_vector(WIDTH - 1 downto 0)
  );
end entity glitch_filter;

architecture rtl of glitch_filter is

  type sample_counts is array (WIDTH - 1 downto 0) of u_unsigned(7 downto 0);

  constant FIRST : u_unsigned(7 downto 0) := to_unsigned(1, 8);

begin

  follow : process (clock) is

    -- Number of equal samples of the new level so far, including the present sample.
    variable lasted : sample_counts                         := (others => FIRST);
    variable level  : std_ulogic_vector(WIDTH - 1 downto 0) := (others => '0');

  begin

    if rising_edge(clock) then
      for i in level'range loop
        if (unfiltered(i) = level(i)) then
          lasted(i) := FIRST;
        elsif (lasted(i) >= filter_length) then
          lasted(i) := FIRST;
          level(i)  := unfiltered(i);
        else
          lasted(i) := lasted(i) + 1;
        end if;
      end loop;

      if (reset = '1') then
        lasted := (others => FIRST);
        level  := unfiltered;
      end if;
      filtered <= level;
    end if;

  end process follow;

end architecture rtl;
