-- SPDX-License-Identifier: Apache-2.0
--
-- # delay_line
--
-- Delays a word by a fixed number of clocks, so that a reading R reaches error_compensation together with the
-- correction that was computed from it (section 3.3 of the paper). Lanes that share a pipeline (FOLD > 1) take FOLD - 1
-- clocks longer, so compensation_pipeline sets CLOCKS to DELAY_LINE_LATENCY + FOLD - 1.
--
-- **Latency.** CLOCKS clocks from `undelayed` to `delayed`, one word per clock.
--
-- **Number formats.** WIDTH bits of any meaning.
--
-- There is no reset, so that a tool can use shift-register LUTs. All words are 0 at power-up.

library ieee;
  use ieee.std_logic_1164.all;

  use work.number_formats_pkg.all;

entity delay_line is
  generic (
    WIDTH  : positive := ANGLE_WIDTH + POSITION_WIDTH;
    CLOCKS : positive := DELAY_LINE_LATENCY
  );
  port (
    clock     : in    std_ulogic;
    undelayed : in    std_ulogic_vector(WIDTH - 1 downto 0);                   -- any word
    delayed   : out   std_ulogic_vector(WIDTH - 1 downto 0) := (others => '0') -- the word of CLOCKS clocks ago
  );
end entity delay_line;

architecture rtl of delay_line is

  type words is array (1 to CLOCKS) of std_ulogic_vector(WIDTH - 1 downto 0);

begin

  shift : process (clock) is

    variable stages : words := (others => (others => '0'));

  begin

    if rising_edge(clock) then
      stages  := undelayed & stages(1 to CLOCKS - 1);
      delayed <= stages(CLOCKS);
    end if;

  end process shift;

end architecture rtl;
