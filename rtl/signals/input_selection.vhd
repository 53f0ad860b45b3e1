-- SPDX-License-Identifier: Apache-2.0
--
-- # input_selection
--
-- Adapts an encoder's signals to the decoder: inverts A, B or Z, and exchanges A and B, which reverses the counting
-- direction. Each head has one instance.
--
-- **Latency.** The entity is one level of logic in front of the synchroniser, without a register. Each output depends
-- on one pin at a time, so one edge of a pin causes one edge of an output.
--
-- **Changes.** A change of a setting while the decoder works may look like an edge or an illegal transition: re-arm and
-- clear the head afterwards.

library ieee;
  use ieee.std_logic_1164.all;

entity input_selection is
  port (
    pin_a    : in    std_ulogic; -- asynchronous
    pin_b    : in    std_ulogic; -- asynchronous
    pin_z    : in    std_ulogic; -- asynchronous
    invert_a : in    std_ulogic; -- inverts the pin
    invert_b : in    std_ulogic; -- inverts the pin
    invert_z : in    std_ulogic; -- inverts the pin
    swap_ab  : in    std_ulogic; -- exchanges A and B after the inversion
    a        : out   std_ulogic;
    b        : out   std_ulogic;
    z        : out   std_ulogic
  );
end entity input_selection;

architecture rtl of input_selection is

  signal upright_a : std_ulogic;
  signal upright_b : std_ulogic;

begin

  upright_a <= pin_a xor invert_a;
  upright_b <= pin_b xor invert_b;

  a <= upright_b when swap_ab = '1' else
       upright_a;
  b <= upright_a when swap_ab = '1' else
       upright_b;
  z <= pin_z xor invert_z;

end architecture rtl;
