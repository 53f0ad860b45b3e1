-- SPDX-License-Identifier: Apache-2.0
--
-- # coefficient_banks
--
-- Stores two banks of one kind of coefficient word. A bank has one word for each of the FOLD lanes that share a
-- pipeline; with TURNS = 4 it has four words for each of these lanes, one per turn. Tools build this small memory from
-- look-up tables. coefficient_memory decides which bank is read and which is written.
--
-- **Latency.** 1 clock from `read_bank`, `read_slot` and `read_turn` to `read_word`; a word that is written in one
-- clock can be read in the next clock.
--
-- **Number formats.** WIDTH bits of any meaning; slot 0 to FOLD - 1; turn 0 to TURNS - 1.
--
-- There is no reset: at power-up all words are zero.

library ieee;
  use ieee.std_logic_1164.all;
  use ieee.numeric_std.all;

entity coefficient_banks is
  generic (
    FOLD  : positive range 1 to 8  := 1; -- number of lanes that share a pipeline: 1, 2, 4 or 8
    WIDTH : positive range 1 to 32 := 32;
    TURNS : positive range 1 to 4  := 1  -- number of words per lane, one for each turn: 1 or 4
  );
  port (
    clock        : in    std_ulogic;
    write_enable : in    std_ulogic;
    write_bank   : in    std_ulogic;
    write_slot   : in    u_unsigned(2 downto 0);
    write_turn   : in    u_unsigned(1 downto 0) := "00";
    write_word   : in    std_ulogic_vector(WIDTH - 1 downto 0);
    read_bank    : in    std_ulogic;
    read_slot    : in    u_unsigned(2 downto 0);
    read_turn    : in    u_unsigned(1 downto 0) := "00";
    read_word    : out   std_ulogic_vector(WIDTH - 1 downto 0)
  );
end entity coefficient_banks;

architecture rtl of coefficient_banks is

  -- log2(FOLD) and log2(TURNS)
  constant SLOT_BITS : natural := FOLD / 2 - FOLD / 8;
  constant TURN_BITS : natural := TURNS / 2;

  type words is array (0 to 2 * FOLD * TURNS - 1) of std_ulogic_vector(WIDTH - 1 downto 0);

  signal stored : words := (others => (others => '0'));

  function place (
    bank : std_ulogic;
    slot : u_unsigned(2 downto 0);
    turn : u_unsigned(1 downto 0)
  ) return natural is

    variable address : u_unsigned(TURN_BITS + SLOT_BITS downto 0);

  begin

    address := turn(TURN_BITS - 1 downto 0) & slot(SLOT_BITS - 1 downto 0) & bank;
    return to_integer(address);

  end function place;

begin

  memory : process (clock) is
  begin

    if rising_edge(clock) then
      read_word <= stored(place(read_bank, read_slot, read_turn));
      if write_enable = '1' then
        stored(place(write_bank, write_slot, write_turn)) <= write_word;
      end if;
    end if;

  end process memory;

end architecture rtl;
