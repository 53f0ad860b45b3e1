-- SPDX-License-Identifier: Apache-2.0
--
-- # input_synchroniser
--
-- Synchronises asynchronous pins to the clock with STAGES registers in series per pin, so that a register that samples
-- a changing pin has STAGES - 1 clocks to settle.
--
-- **Latency.** STAGES clocks from `asynchronous` to `synchronised`.
--
-- **Number formats.** There are none: the signals are single bits.
--
-- **Limits.** Pins that change together may appear one clock apart, because each pin is sampled
-- independently. The attribute `async_reg` makes the placer put the registers of a pin next to each other; tools
-- that do not know the attribute ignore it.
--
-- **Reset** does not affect the registers: they follow the pins at any time.

library ieee;
  use ieee.std_logic_1164.all;

  use work.number_formats_pkg.all;

entity input_synchroniser is
  generic (
    WIDTH  : positive              := 3; -- pins
    STAGES : positive range 2 to 4 := SYNCHRONISER_STAGES_DEFAULT -- number of registers per pin
  );
  port (
    clock        : in    std_ulogic;
    asynchronous : in    std_ulogic_vector(WIDTH - 1 downto 0); -- pins
    synchronised : out   std_ulogic_vector(WIDTH - 1 downto 0)  -- levels of the pins STAGES clocks ago
  );
end entity input_synchroniser;

architecture rtl of input_synchroniser is

  -- All stages in one vector: the first stage, which samples the pins, is in the low bits, the last stage in the high
  -- bits.
  signal stage_registers : std_ulogic_vector(WIDTH * STAGES - 1 downto 0) := (others => '0');

  attribute async_reg : string;
  attribute async_reg of stage_registers : signal is "true";

begin

  synchronised <= stage_registers(WIDTH * STAGES - 1 downto WIDTH * (STAGES - 1));

  synchronise : process (clock) is
  begin

    if rising_edge(clock) then
      stage_registers <= stage_registers(WIDTH * (STAGES - 1) - 1 downto 0) & asynchronous;
    end if;

  end process synchronise;

end architecture rtl;
