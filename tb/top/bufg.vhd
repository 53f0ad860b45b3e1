-- SPDX-License-Identifier: Apache-2.0
--
-- # bufg
--
-- Models the primitive BUFG for simulation: the output equals the input.

library ieee;
  use ieee.std_logic_1164.all;

entity bufg is
  port (
    i : in    std_ulogic;
    o : out   std_ulogic
  );
end entity bufg;

architecture simulation of bufg is

begin

  o <= i;

end architecture simulation;
