-- SPDX-License-Identifier: Apache-2.0
--
-- # coefficient_banks
--
-- Stores two banks of one kind of coefficient word, for the FOLD lanes that share a pipeline: a word for each slot.
-- It is a small memory, which tools build from look-up tables. coefficient_memory decides which bank is read and
-- which is written.
--
-- **Latency.** 1 clock from `read_bank` and `read_slot` to `read_word`; a word that is written in a clock
-- can be read in the next.
--
-- **Number formats.** WIDTH bits of any meaning; slot 0 to FOLD - 1.
--
-- There is no reset: at power-up all words are zero.

library ieee;
  use ieee.std_logic_1164.all;
  use ieee.numeric_std.all;

entity coefficient_banks is
  generic (
    FOLD  : positive range 1 to 8  := 1; -- lanes that share a pipeline: 1, 2, 4 or 8
    WIDTH : positive range 1 to 32 := 32
  );
  port (
    clock        : in    std_ulogic;
    write_enable : in    std_ulogic;
    write_bank   : in    std_ulogic;
    write_slot   : in    u_unsigned(2 downto 0);
    write_word   : in    std_ulogic_vector(WIDTH - 1 downto 0);
    read_bank    : in    std_ulogic;
    read_slot    : in    u_unsigned(2 downto 0);
    read_word    : out   std_ulogic_vector(WIDTH - 1 downto 0)
  );
end entity coefficient_banks;

architecture rtl of coefficient_banks is

  -- log2(FOLD)
  constant SLOT_BITS : natural := FOLD / 2 - FOLD / 8;

  type words is array (0 to 2 * FOLD - 1) of std_ulogic_vector(WIDTH - 1 downto 0);

  signal stored : words := (others => (others => '0'));

  function place (bank : std_ulogic; slot : u_unsigned(2 downto 0)) return natural is

    variable address : u_unsigned(SLOT_BITS downto 0);

  begin

    address := slot(SLOT_BITS - 1 downto 0) & bank;
    return to_integer(address);

  end function place;

begin

  memory : process (clock) is
  begin

    if rising_edge(clock) then
      read_word <= stored(place(read_bank, read_slot));
      if write_enable = '1' then
        stored(place(write_bank, write_slot)) <= write_word;
      end if;
    end if;

  end process memory;

end architecture rtl;
