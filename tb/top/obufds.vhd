-- SPDX-License-Identifier: Apache-2.0
--
-- # obufds
--
-- Models the primitive OBUFDS for simulation.

library ieee;
  use ieee.std_logic_1164.all;

entity obufds is
  port (
    o  : out   std_ulogic;
    ob : out   std_ulogic;
    i  : in    std_ulogic
  );
end entity obufds;

architecture simulation of obufds is

begin

  o  <= i;
  ob <= not i;

end architecture simulation;
