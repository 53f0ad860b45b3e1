-- SPDX-License-Identifier: Apache-2.0
--
-- # glitch_filter
--
-- Each output takes over a new level of its input when that level has lasted `filter_length`
-- samples in a row, one a clock; a shorter pulse leaves no trace. All inputs are delayed alike, so
-- edges keep their distance.
--
-- **Latency.** `filter_length` clocks from a change of `unfiltered` that lasts to `filtered`.
--
-- **Number formats.** filter_length u8.0 clocks: 1 is off, 0 acts as 1.
--
-- **Run time.** `filter_length` may change in any clock; it is compared with the samples counted so
-- far. A new length acts in the same clock on a level that is already waiting.
--
-- **Reset** loads the outputs from the inputs and forgets the samples counted: levels that stand
-- during reset make no edge after it.

library ieee;
  use ieee.std_logic_1164.all;
  use ieee.numeric_std.all;

entity glitch_filter is
  generic (
    WIDTH : positive := 3 -- signals, filtered one by one
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

    -- Samples that the level has lasted, with the one at hand.
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
