-- SPDX-License-Identifier: Apache-2.0
--
-- # pulse_input
--
-- Gives a strobe for each active edge (rising, or falling if `falling_edge` is high) of an asynchronous pin, such as a
-- probe or a request for a sample.
--
-- **Latency.** SYNCHRONISER_STAGES + filter_length + 1 clocks from the pin's edge to `strobe`, that is 4 clocks with 2
-- stages and the filter off.
--
-- **Number formats.** filter_length u8.0 clocks: the entity accepts a level after this number of equal samples; 1 turns
-- the filter off.
--
-- **Reset.** The level that the pin has at the end of the reset gives no strobe.

library ieee;
  use ieee.std_logic_1164.all;
  use ieee.numeric_std.all;

  use work.number_formats_pkg.all;

entity pulse_input is
  generic (
    SYNCHRONISER_STAGES : positive range 2 to 4 := SYNCHRONISER_STAGES_DEFAULT
  );
  port (
    clock         : in    std_ulogic;
    reset         : in    std_ulogic;
    pin           : in    std_ulogic;             -- asynchronous
    falling_edge  : in    std_ulogic;             -- '1': falling edges give a strobe, '0': rising edges
    filter_length : in    u_unsigned(7 downto 0); -- clocks
    strobe        : out   std_ulogic := '0'
  );
end entity pulse_input;

architecture rtl of pulse_input is

  constant SETTLED_AFTER : positive := SYNCHRONISER_STAGES + 1;

  signal pins     : std_ulogic_vector(0 downto 0);
  signal levels   : std_ulogic_vector(0 downto 0);
  signal filtered : std_ulogic_vector(0 downto 0);
  -- Bits are high during the reset, and in the clocks after it in which the synchroniser still outputs levels from
  -- before the end of the reset.
  signal settling : std_ulogic_vector(SETTLED_AFTER - 1 downto 0) := (others => '1');

begin

  pins(0) <= pin;

  synchroniser : entity work.input_synchroniser
    generic map (
      WIDTH  => 1,
      STAGES => SYNCHRONISER_STAGES
    )
    port map (
      clock        => clock,
      asynchronous => pins,
      synchronised => levels
    );

  filter : entity work.glitch_filter
    generic map (
      WIDTH => 1
    )
    port map (
      clock         => clock,
      reset         => settling(settling'high - 1),
      filter_length => filter_length,
      unfiltered    => levels,
      filtered      => filtered
    );

  find_edge : process (clock) is

    variable before : std_ulogic := '0';

  begin

    if rising_edge(clock) then
      strobe   <= (filtered(0) xor before) and (filtered(0) xor falling_edge) and not settling(settling'high);
      before   := filtered(0);
      settling <= settling(settling'high - 1 downto 0) & '0';
      if reset = '1' then
        settling <= (others => '1');
        strobe   <= '0';
      end if;
    end if;

  end process find_edge;

end architecture rtl;
