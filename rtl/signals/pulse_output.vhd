-- SPDX-License-Identifier: Apache-2.0
--
-- # pulse_output
--
-- Converts each strobe to a pulse of `width` clocks, long enough for the instrument at the pin.
--
-- **Latency.** 1 clock from `strobe` to the pulse. A strobe during a pulse prolongs it: `width` clocks of the pulse
-- follow the new strobe.
--
-- **Number formats.** width u16.0 clocks; 0 acts as 1.
--
-- **Reset** ends the pulse.

library ieee;
  use ieee.std_logic_1164.all;
  use ieee.numeric_std.all;

entity pulse_output is
  port (
    clock  : in    std_ulogic;
    reset  : in    std_ulogic;
    strobe : in    std_ulogic;
    width  : in    u_unsigned(15 downto 0); -- clocks
    pulse  : out   std_ulogic := '0'        -- pin
  );
end entity pulse_output;

architecture rtl of pulse_output is

begin

  stretch : process (clock) is

    variable remaining : u_unsigned(15 downto 0) := (others => '0'); -- clocks of the pulse from this one on

  begin

    if rising_edge(clock) then
      if strobe = '1' then
        pulse     <= '1';
        remaining := width;
      elsif (or remaining(15 downto 1)) = '1' then
        remaining := remaining - 1;
      else
        pulse <= '0';
      end if;

      if reset = '1' then
        remaining := (others => '0');
        pulse     <= '0';
      end if;
    end if;

  end process stretch;

end architecture rtl;
