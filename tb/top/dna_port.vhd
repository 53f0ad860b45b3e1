-- SPDX-License-Identifier: Apache-2.0
--
-- # dna_port
--
-- Models the primitive DNA_PORT for simulation, by the table of its operations in UG470: READ loads the identifier,
-- SHIFT shifts it towards bit 56, which is DOUT.

library ieee;
  use ieee.std_logic_1164.all;

entity dna_port is
  port (
    dout  : out   std_ulogic;
    clk   : in    std_ulogic;
    din   : in    std_ulogic;
    read  : in    std_ulogic;
    shift : in    std_ulogic
  );
end entity dna_port;

architecture simulation of dna_port is

  -- Each group of four bits differs from its neighbours, and the first and the last bit are 1, so that the tests detect
  -- a shift by a wrong number of bits.
  constant IDENTIFIER : std_ulogic_vector(56 downto 0) := '1' & x"23456789ABCDEF";

  signal moved : std_ulogic_vector(56 downto 0) := (others => '0');

begin

  dout <= moved(56);

  operations : process (clk) is
  begin

    if rising_edge(clk) then
      if read = '1' then
        moved <= IDENTIFIER;
      elsif shift = '1' then
        moved <= moved(55 downto 0) & din;
      end if;
    end if;

  end process operations;

end architecture simulation;
