-- SPDX-License-Identifier: Apache-2.0
--
-- # status_leds
--
-- Drives four LEDs: alive, capture, fault, compensation. It lights an LED long enough for a person to see a state that
-- lasts only one clock.
--
-- **Latency.** Time is divided into windows of 2**HOLD_LOG2 clocks. Each of the LEDs capture, fault and compensation is
-- lit for a whole window if its state was high in any clock of the previous window.
--
-- **Number formats.** All ports are single bits; an LED is lit while its output is high.
--
-- **Alive.** While the clock runs and the reset is inactive, the LED alive changes every 8 windows, that is every 336
-- ms at 100 MHz and HOLD_LOG2 = 22.
--
-- **Reset** switches all LEDs off.

library ieee;
  use ieee.std_logic_1164.all;
  use ieee.numeric_std.all;

entity status_leds is
  generic (
    HOLD_LOG2 : positive range 1 to 28 := 22 -- log2 of a window's clocks
  );
  port (
    clock            : in    std_ulogic;
    reset            : in    std_ulogic;
    capturing        : in    std_ulogic;
    fault            : in    std_ulogic;
    compensating     : in    std_ulogic;
    led_alive        : out   std_ulogic;
    led_capture      : out   std_ulogic;
    led_fault        : out   std_ulogic;
    led_compensation : out   std_ulogic
  );
end entity status_leds;

architecture rtl of status_leds is

  -- The LED alive is lit for 8 windows, then off for 8 windows.
  constant COUNTER_WIDTH : positive := HOLD_LOG2 + 4;

  constant WINDOW_END : u_unsigned(HOLD_LOG2 - 1 downto 0) := (others => '1');

  signal counter : u_unsigned(COUNTER_WIDTH - 1 downto 0) := (others => '0');
  -- capture, fault, compensation
  signal seen  : std_ulogic_vector(2 downto 0) := (others => '0');
  signal shown : std_ulogic_vector(2 downto 0) := (others => '0');

begin

  led_alive        <= counter(counter'left);
  led_capture      <= shown(2);
  led_fault        <= shown(1);
  led_compensation <= shown(0);

  windows : process (clock) is

    variable now : std_ulogic_vector(2 downto 0);

  begin

    if rising_edge(clock) then
      now     := capturing & fault & compensating;
      counter <= counter + 1;

      if counter(HOLD_LOG2 - 1 downto 0) = WINDOW_END then
        shown <= seen or now;
        seen  <= (others => '0');
      else
        seen <= seen or now;
      end if;

      if reset = '1' then
        counter <= (others => '0');
        seen    <= (others => '0');
        shown   <= (others => '0');
      end if;
    end if;

  end process windows;

end architecture rtl;
