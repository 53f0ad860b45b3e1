-- SPDX-License-Identifier: Apache-2.0
--
-- # mean_words
--
-- Stores two sets of the words of the weighted mean: offsets, weights, and the choice of the carrier and of the used
-- heads. The active words apply to the angles; the processor writes the idle words. `swap_comes` copies the idle words
-- to the active words, at the same angle at which the lanes' coefficients change. Only the weight of an unused head is
-- not copied: its active weight is 0.
--
-- **Words.** Words 0 to 3 are the offsets of heads 1 to 4, words 4 to 7 their weights. Word 8 is the choice: the
-- carrier (head number - 1) in bits 1 to 0 and one bit per head from bit 4 on (1: the head is used). Only the bits of
-- the formats are stored. Words of a head above HEADS are not stored and read as 0. If the carrier is above HEADS, head
-- 1 is the carrier.
--
-- **Writing.** Pulse `write_enable` with address and data. `write_acknowledge` pulses when the word is written: 2
-- clocks later, or after `hold_writes` has fallen. Hold `hold_writes` high while a swap waits, so that the swap takes
-- over exactly the acknowledged writes. Start no other write before the acknowledge.
--
-- **Latency.** 1 clock from `swap_comes` to the new active words; `next_words` are the active words of the next clock,
-- except that in the clock of `swap_comes` the weights of unused heads are not yet 0. `read_data`, the idle word with its
-- sign extended, follows `read_address` by 1 clock.
--
-- **Number formats.** offset u24.4 counts, weight s1.16. Each port with a whole set of words holds, from the low bits
-- on, the offsets of all heads, the weights of all heads, one bit per head (1: used), and the carrier.
--
-- **Reset** drops a pending write. The words keep their values, as the banks of the lanes do. At power-up head 1 is the
-- carrier and the only used head, so the output follows head 1.

library ieee;
  use ieee.std_logic_1164.all;
  use ieee.numeric_std.all;

  use work.number_formats_pkg.all;

entity mean_words is
  generic (
    HEADS : positive range 2 to HEADS_MAX := 2
  );
  port (
    clock             : in    std_ulogic;
    reset             : in    std_ulogic;
    write_enable      : in    std_ulogic;                     -- pulse
    write_address     : in    u_unsigned(3 downto 0);         -- number of the word
    write_data        : in    std_ulogic_vector(31 downto 0); -- the word
    write_acknowledge : out   std_ulogic := '0';              -- pulse: the word is written
    hold_writes       : in    std_ulogic;                     -- a swap is requested, waits or takes effect
    read_address      : in    u_unsigned(3 downto 0);         -- number of the word
    read_data         : out   std_ulogic_vector(31 downto 0); -- the idle word
    swap_comes        : in    std_ulogic;                     -- the idle words are active from the next clock on
    is_written        : out   std_ulogic;                     -- pulse: an idle word changes in the next clock
    active_words      : out   std_ulogic_vector(HEADS * (HEAD_OFFSET_WIDTH + HEAD_WEIGHT_WIDTH + 1) + 1 downto 0); -- see Number formats
    idle_words        : out   std_ulogic_vector(HEADS * (HEAD_OFFSET_WIDTH + HEAD_WEIGHT_WIDTH + 1) + 1 downto 0); -- see Number formats
    next_words        : out   std_ulogic_vector(HEADS * (HEAD_OFFSET_WIDTH + HEAD_WEIGHT_WIDTH + 1) + 1 downto 0)  -- see Number formats
  );
end entity mean_words;

architecture rtl of mean_words is

  constant WEIGHTS_FIRST : positive := HEADS * HEAD_OFFSET_WIDTH;
  constant USED_FIRST    : positive := WEIGHTS_FIRST + HEADS * HEAD_WEIGHT_WIDTH;
  constant CARRIER_FIRST : positive := USED_FIRST + HEADS;

  constant NO_WEIGHT : std_ulogic_vector(HEAD_WEIGHT_WIDTH - 1 downto 0) := (others => '0');

  subtype all_words is std_ulogic_vector(CARRIER_FIRST + 1 downto 0);

  constant HEAD1_ALONE : all_words := std_ulogic_vector(shift_left(to_unsigned(1, all_words'length), USED_FIRST));

  signal active    : all_words                      := HEAD1_ALONE;
  signal idle      : all_words                      := HEAD1_ALONE;
  signal pending   : std_ulogic                     := '0';
  signal address   : u_unsigned(3 downto 0)         := (others => '0');
  signal data      : std_ulogic_vector(31 downto 0) := (others => '0');
  signal write_now : std_ulogic;

begin

  -- `hold_writes` is high whenever `swap_comes` is. `swap_comes` itself must not be used here, because it depends on
  -- `is_written`: that would be a combinational loop.
  write_now    <= pending and not hold_writes and not reset;
  is_written   <= write_now;
  active_words <= active;
  idle_words   <= idle;
  next_words   <= idle when swap_comes = '1' else
                  active;

  store : process (clock) is

    variable word : std_ulogic_vector(31 downto 0);

  begin

    if rising_edge(clock) then
      if swap_comes = '1' then
        active <= idle;

        for head in 0 to HEADS - 1 loop
          if idle(USED_FIRST + head) = '0' then
            active(WEIGHTS_FIRST + (head + 1) * HEAD_WEIGHT_WIDTH - 1 downto WEIGHTS_FIRST + head * HEAD_WEIGHT_WIDTH)
            <= NO_WEIGHT;
          end if;
        end loop;

      end if;

      word := (others => '0');

      for head in 0 to HEADS - 1 loop
        if address = head and write_now = '1' then
          idle((head + 1) * HEAD_OFFSET_WIDTH - 1 downto head * HEAD_OFFSET_WIDTH) <= data(HEAD_OFFSET_WIDTH - 1 downto 0);
        end if;
        if address = HEADS_MAX + head and write_now = '1' then
          idle(WEIGHTS_FIRST + (head + 1) * HEAD_WEIGHT_WIDTH - 1 downto WEIGHTS_FIRST + head * HEAD_WEIGHT_WIDTH)
          <= data(HEAD_WEIGHT_WIDTH - 1 downto 0);
        end if;
        if read_address = head then
          word(HEAD_OFFSET_WIDTH - 1 downto 0) := idle((head + 1) * HEAD_OFFSET_WIDTH - 1 downto head * HEAD_OFFSET_WIDTH);
        end if;
        if read_address = HEADS_MAX + head then
          word := std_ulogic_vector(resize(u_signed(
            idle(WEIGHTS_FIRST + (head + 1) * HEAD_WEIGHT_WIDTH - 1 downto WEIGHTS_FIRST + head * HEAD_WEIGHT_WIDTH)
          ), 32));
        end if;
      end loop;

      if read_address = 2 * HEADS_MAX then
        word(1 downto 0)             := idle(CARRIER_FIRST + 1 downto CARRIER_FIRST);
        word(HEADS + 3 downto 4)     := idle(CARRIER_FIRST - 1 downto USED_FIRST);
      end if;
      read_data <= word;

      if address = 2 * HEADS_MAX and write_now = '1' then
        idle(CARRIER_FIRST - 1 downto USED_FIRST) <= data(HEADS + 3 downto 4);
        -- The comparison uses three bits: GHDL's synthesis cuts HEADS to the width of the other operand, and with two
        -- bits HEADS = 4 would become 0.
        idle(CARRIER_FIRST + 1 downto CARRIER_FIRST) <= data(1 downto 0) when u_unsigned('0' & data(1 downto 0)) < HEADS else "00";
      end if;

      write_acknowledge <= write_now;
      if write_now = '1' then
        pending <= '0';
      end if;

      if write_enable = '1' then
        pending <= '1';
        address <= write_address;
        data    <= write_data;
      end if;

      if reset = '1' then
        pending           <= '0';
        write_acknowledge <= '0';
      end if;
    end if;

  end process store;

end architecture rtl;
