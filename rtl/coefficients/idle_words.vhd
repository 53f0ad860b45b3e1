-- SPDX-License-Identifier: Apache-2.0
--
-- # idle_words
--
-- Stores the words of the idle bank of coefficients in a block RAM. The processor reads them, and after a swap the
-- entity outputs all of them, one a clock, for the fill of the new idle bank: the words that were written for the bank
-- that is active now.
--
-- **Latency.** 2 clocks from `read_address` to `read_data`. 3 clocks from `start_fill` to the first word of the fill; a
-- fill outputs 4 * LANES words, in the order of their addresses.
--
-- **Number formats.** An address is lane * 4 + word, as for coefficient_memory: word 0: phase step, bits 31..0; word 1:
-- phase step, bits 47..32 and, with MODULATORS, the choice of the modulator in bits 18..16; word 2: phase offset u0.24;
-- word 3: amplitude s13.11. Only the bits of the format are stored; the amplitude is sign-extended. A word of a lane that
-- is not built is not stored and reads as 0.
--
-- **Reset.** There is none: a fill always ends. At power-up all words are 0.

library ieee;
  use ieee.std_logic_1164.all;
  use ieee.numeric_std.all;

  use work.number_formats_pkg.all;

entity idle_words is
  generic (
    LANES      : positive range 1 to LANES_MAX := LANES_DEFAULT;
    MODULATORS : boolean                       := false -- word 1 contains the choice of the modulator
  );
  port (
    clock         : in    std_ulogic;
    write_enable  : in    std_ulogic;                                        -- pulse: store a word
    write_address : in    u_unsigned(7 downto 0);                            -- lane * 4 + word
    write_data    : in    std_ulogic_vector(31 downto 0);                    -- the word
    read_address  : in    u_unsigned(7 downto 0);                            -- lane * 4 + word
    read_data     : out   std_ulogic_vector(31 downto 0);                    -- the word
    start_fill    : in    std_ulogic;                                        -- pulse: output all words
    fills         : out   std_ulogic;                                        -- level: words come after the next clock
    fill_enable   : out   std_ulogic;                                        -- level: a word comes in this clock
    fill_place    : out   u_unsigned(7 downto 0)         := (others => '0'); -- its address, lane * 4 + word
    fill_word     : out   std_ulogic_vector(31 downto 0) := (others => '0')  -- the word
  );
end entity idle_words;

architecture rtl of idle_words is

  constant LAST_WORD : positive := 4 * LANES - 1;

  -- Number of bits of word 1: the upper bits of the phase step, and the bits that choose the modulator.
  constant HIGH_BITS : positive := PHASE_STEP_WIDTH - 32 + 3 * boolean'pos(MODULATORS);

  subtype word is std_ulogic_vector(31 downto 0);

  subtype word_address is u_unsigned(7 downto 0);

  type words is array (0 to 4 * LANES_MAX - 1) of word;

  signal stored_words : words := (others => (others => '0'));
  signal read_stored  : word  := (others => '0');

  -- The address that is read for the fill, and the address of the clock before
  signal filling        : std_ulogic   := '0';
  signal fill_address   : word_address := (others => '0');
  signal fill_under_way : std_ulogic_vector(1 to 2) := (others => '0');
  signal fill_address_1 : word_address := (others => '0');
  signal fill_stored    : word         := (others => '0');

begin

  fills       <= filling or fill_under_way(1);
  fill_enable <= fill_under_way(2);

  fill : process (clock) is
  begin

    if rising_edge(clock) then
      if start_fill = '1' then
        filling      <= '1';
        fill_address <= (others => '0');
      else
        fill_address <= fill_address + 1;
        if fill_address = LAST_WORD then
          filling <= '0';
        end if;
      end if;

      fill_under_way <= filling & fill_under_way(1);
      fill_address_1 <= fill_address;
      fill_place     <= fill_address_1;
      fill_word      <= fill_stored;
    end if;

  end process fill;

  memory : process (clock) is

    variable stored : word;

  begin

    if rising_edge(clock) then
      read_data   <= read_stored;
      read_stored <= stored_words(to_integer(read_address));
      fill_stored <= stored_words(to_integer(fill_address));

      if write_enable = '1' and write_address < 4 * LANES then

        case to_integer(write_address(1 downto 0)) is

          when 0 =>
            stored := write_data;

          when 1 =>
            stored := std_ulogic_vector(resize(u_unsigned(write_data(HIGH_BITS - 1 downto 0)), 32));

          when 2 =>
            stored := std_ulogic_vector(resize(u_unsigned(write_data(PHASE_WIDTH - 1 downto 0)), 32));

          when others =>
            stored := std_ulogic_vector(resize(u_signed(write_data(AMPLITUDE_WIDTH - 1 downto 0)), 32));

        end case;

        stored_words(to_integer(write_address)) <= stored;
      end if;
    end if;

  end process memory;

end architecture rtl;
