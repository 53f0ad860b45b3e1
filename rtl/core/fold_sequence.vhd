-- SPDX-License-Identifier: Apache-2.0
--
-- # fold_sequence
--
-- Generates the slot number and the strobes of a folded pipeline: an angle is accepted every FOLD clocks, in slot 0,
-- and the blocks of lanes process it one after the other, in the slots 0 to FOLD - 1. With FOLD = 1 every clock is slot
-- 0 and every strobe is high.
--
-- **Latency.** The outputs describe the clock in which they are output. `first_sums` belongs to the angle accepted
-- SUMS_CLOCK clocks before, `last_sums` to the angle accepted SUMS_CLOCK + FOLD - 1 clocks before.
--
-- **Number formats.** slot 0 to FOLD - 1.
--
-- There is no reset: the sequence runs from power-up on, so that a reset never interrupts the processing of an angle.

library ieee;
  use ieee.std_logic_1164.all;
  use ieee.numeric_std.all;

  use work.number_formats_pkg.all;

entity fold_sequence is
  generic (
    FOLD       : positive range 1 to 8 := 1; -- number of lanes that share a pipeline: 1, 2, 4 or 8
    SUMS_CLOCK : positive              := DELAY_LINE_LATENCY -- clocks from an angle to its first pair sums
  );
  port (
    clock      : in    std_ulogic;
    slot       : out   u_unsigned(2 downto 0); -- block of lanes that processes its angle now
    accept     : out   std_ulogic;             -- high if the angle of this clock is accepted
    last_slot  : out   std_ulogic;             -- high if the angle of the next clock is accepted
    first_sums : out   std_ulogic;             -- high if the first pair sums of an angle arrive
    last_sums  : out   std_ulogic              -- high if the last pair sums of an angle arrive
  );
end entity fold_sequence;

architecture rtl of fold_sequence is

begin

  unfolded : if FOLD = 1 generate

    slot       <= (others => '0');
    accept     <= '1';
    last_slot  <= '1';
    first_sums <= '1';
    last_sums  <= '1';

  end generate unfolded;

  folded : if FOLD > 1 generate

    -- The slot as one bit per slot, and as a number.
    signal ring   : std_ulogic_vector(0 to FOLD - 1) := (0 => '1', others => '0');
    signal number : natural range 0 to FOLD - 1      := 0;

  begin

    count : process (clock) is
    begin

      if rising_edge(clock) then
        ring   <= ring(FOLD - 1) & ring(0 to FOLD - 2);
        number <= (number + 1) mod FOLD;
      end if;

    end process count;

    slot       <= to_unsigned(number, 3);
    accept     <= ring(0);
    last_slot  <= ring(FOLD - 1);
    first_sums <= ring(SUMS_CLOCK mod FOLD);
    last_sums  <= ring((SUMS_CLOCK + FOLD - 1) mod FOLD);

  end generate folded;

end architecture rtl;
