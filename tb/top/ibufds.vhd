-- SPDX-License-Identifier: Apache-2.0
--
-- # ibufds
--
-- Models the primitive IBUFDS for simulation; if both wires of the pair are equal, the output is undefined ('X').

library ieee;
  use ieee.std_logic_1164.all;

entity ibufds is
  port (
    o  : out   std_ulogic;
    i  : in    std_ulogic;
    ib : in    std_ulogic
  );
end entity ibufds;

architecture simulation of ibufds is

begin

  o <= i when i = not ib else
       'X';

end architecture simulation;
