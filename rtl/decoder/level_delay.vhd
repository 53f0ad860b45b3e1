-- SPDX-License-Identifier: Apache-2.0
--
-- # level_delay
--
-- Delays A, B and Z of a head together by 0 to 255 clocks. This compensates the longer delay of another head's
-- electronics: an uncompensated delay of 100 ns is an error of 0.032 arcsec at 90 degrees per second.
--
-- **Latency.** `delay` clocks from `levels` to `delayed`, 0 included. A change of `delay` takes effect within 2 clocks
-- and skips or repeats levels, so change it only while the table stands still.
--
-- **Number formats.** delay u8.0 clocks.
--
-- There is no reset. In the first `delay` + 2 clocks after power-up, `delayed` may be 0 in place of the levels of the
-- pins. After an increase of `delay`, levels that were already output are output again.

library ieee;
  use ieee.std_logic_1164.all;
  use ieee.numeric_std.all;

entity level_delay is
  generic (
    WIDTH : positive := 3
  );
  port (
    clock   : in    std_ulogic;
    delay   : in    u_unsigned(7 downto 0);               -- clocks
    levels  : in    std_ulogic_vector(WIDTH - 1 downto 0);
    delayed : out   std_ulogic_vector(WIDTH - 1 downto 0) -- the levels `delay` clocks ago
  );
end entity level_delay;

architecture rtl of level_delay is

  type levels_of_clocks is array (0 to 255) of std_ulogic_vector(WIDTH - 1 downto 0);

  signal memory      : levels_of_clocks                     := (others => (others => '0'));
  signal stored      : std_ulogic_vector(WIDTH - 1 downto 0) := (others => '0');
  signal previous    : std_ulogic_vector(WIDTH - 1 downto 0) := (others => '0');
  signal is_none     : std_ulogic                           := '1';
  signal is_one      : std_ulogic                           := '0';

begin

  -- With a delay of two clocks or more, a word has been written into the memory before it is read.
  delayed <= levels when is_none = '1' else
             previous when is_one = '1' else
             stored;

  remember : process (clock) is

    variable place     : u_unsigned(7 downto 0) := (others => '0');
    variable back      : u_unsigned(7 downto 0) := (others => '0');
    variable read_from : u_unsigned(7 downto 0);

  begin

    if rising_edge(clock) then
      read_from                 := place - back;
      stored                    <= memory(to_integer(read_from));
      memory(to_integer(place)) <= levels;
      place                     := place + 1;

      previous <= levels;
      is_none  <= delay ?= 0;
      is_one   <= delay ?= 1;
      back     := delay - 1;
    end if;

  end process remember;

end architecture rtl;
