-- SPDX-License-Identifier: Apache-2.0
--
-- # local_table_banks
--
-- Connects the local table (local_table) to the processor: stores the places of the windows for both banks, gives the
-- processor access to the words of the idle bank, and makes the idle bank active at a swap.
--
-- **Words of the place.** `address` selects a word. Word 0 is `choice`: enable in bits 3 to 0, windows in bits 5 to 4,
-- width in bits 10 to 8, fraction in bits 13 to 12. Words 1 to 4 are the starts of windows 1 to 4. Word 5 is the lower
-- 32 bits of step, word 6 its upper 16. Only these bits are stored; word 7 reads as 0.
--
-- **Swap.** A write of the word `choice` requests a swap of the table: the next swap of the lanes then also makes the
-- table's idle bank active; the first angle of the new bank comes in the clock after `swap_comes`. Without this request
-- a swap of the lanes does not change the table. Write `choice` after all other words.
--
-- **Copy.** After the swap, as soon as no angle in the pipeline uses the formerly active bank, the entity copies the
-- words of the new active bank into it: the place in one clock, then the points one after the other, 2 clocks each. An
-- access waits until the copy has ended, at most LOCAL_TABLE_LATENCY + 2 · 4,096 + 1 clocks.
--
-- **Access.** Pulse `read_enable` or `write_enable` with address and data; a pulse of `done` ends the access. Keep
-- address and data, and start no other access, until `done`. A write waits while `hold` is high: keep `hold` high from
-- the request of a swap until the swap has taken place, so that the swap takes over exactly the writes that `done` has
-- confirmed.
--
-- **Latency.** LOCAL_TABLE_LATENCY clocks from `angle` to `value`; the entity accepts one angle per clock. If the
-- access need not wait, `done` follows a read by 3 clocks and a write by 2 clocks.
--
-- **Number formats.** angle and starts u24.0 counts; step u0.48 windows per count; points s(17 − F).F counts, written
-- and read sign-extended; value s13.22 counts.
--
-- **Reset** drops an access and a requested swap of the table. It does not change the banks, and a copy continues. At
-- power-up no window is enabled.

library ieee;
  use ieee.std_logic_1164.all;
  use ieee.numeric_std.all;

  use work.local_table_pkg.all;
  use work.number_formats_pkg.all;

entity local_table_banks is
  port (
    clock          : in    std_ulogic;
    reset          : in    std_ulogic;
    angle          : in    u_unsigned(ANGLE_WIDTH - 1 downto 0);          -- counts, below counts_per_rev
    counts_per_rev : in    u_unsigned(COUNTS_PER_REV_WIDTH - 1 downto 0); -- counts
    swap_comes     : in    std_ulogic;                                    -- pulse: the next angle is the first of the new bank
    hold           : in    std_ulogic;                                    -- level: a swap is requested or waits
    -- The processor's side
    read_enable    : in    std_ulogic;                                    -- pulse
    write_enable   : in    std_ulogic;                                    -- pulse
    of_place       : in    std_ulogic;                                    -- level: the access is to a word of the place, not to a point
    address        : in    u_unsigned(LOCAL_INDEX_WIDTH - 1 downto 0);    -- number of the word or of the point
    write_data     : in    std_ulogic_vector(31 downto 0);
    done           : out   std_ulogic := '0';                             -- pulse
    read_data      : out   std_ulogic_vector(31 downto 0);                -- the word in the idle bank, with `done`
    value          : out   u_signed(LOCAL_VALUE_WIDTH - 1 downto 0)       -- counts, s13.22
  );
end entity local_table_banks;

architecture rtl of local_table_banks is

  subtype point is u_signed(LOCAL_POINT_WIDTH - 1 downto 0);

  subtype point_index is u_unsigned(LOCAL_INDEX_WIDTH - 1 downto 0);

  type places is array (0 to 1) of local_place;

  type state is (FREE, CLEARS, READS, WRITES);

  constant NOWHERE : local_place :=
  (
    enable   => (others => '0'),
    windows  => (others => '0'),
    width    => (others => '0'),
    fraction => (others => '0'),
    start1   => (others => '0'),
    start2   => (others => '0'),
    start3   => (others => '0'),
    start4   => (others => '0'),
    step     => (others => '0')
  );

  -- Returns the place with word `number` replaced by `word`.
  function changed (
    place  : local_place;
    number : u_unsigned(2 downto 0);
    word   : std_ulogic_vector(31 downto 0)
  ) return local_place is

    variable result : local_place;

  begin

    result := place;

    case to_integer(number) is

      when 0 =>
        result.enable   := word(3 downto 0);
        result.windows  := u_unsigned(word(5 downto 4));
        result.width    := u_unsigned(word(10 downto 8));
        result.fraction := u_unsigned(word(13 downto 12));

      when 1 =>
        result.start1 := u_unsigned(word(ANGLE_WIDTH - 1 downto 0));

      when 2 =>
        result.start2 := u_unsigned(word(ANGLE_WIDTH - 1 downto 0));

      when 3 =>
        result.start3 := u_unsigned(word(ANGLE_WIDTH - 1 downto 0));

      when 4 =>
        result.start4 := u_unsigned(word(ANGLE_WIDTH - 1 downto 0));

      when 5 =>
        result.step(31 downto 0) := u_unsigned(word);

      when 6 =>
        result.step(PHASE_STEP_WIDTH - 1 downto 32) := u_unsigned(word(PHASE_STEP_WIDTH - 33 downto 0));

      when others =>
        null;

    end case;

    return result;

  end function changed;

  function word_of (
    place  : local_place;
    number : u_unsigned(2 downto 0)
  ) return std_ulogic_vector is

    variable word : std_ulogic_vector(31 downto 0);

  begin

    word := (others => '0');

    case to_integer(number) is

      when 0 =>
        word(3 downto 0)   := place.enable;
        word(5 downto 4)   := std_ulogic_vector(place.windows);
        word(10 downto 8)  := std_ulogic_vector(place.width);
        word(13 downto 12) := std_ulogic_vector(place.fraction);

      when 1 =>
        word(ANGLE_WIDTH - 1 downto 0) := std_ulogic_vector(place.start1);

      when 2 =>
        word(ANGLE_WIDTH - 1 downto 0) := std_ulogic_vector(place.start2);

      when 3 =>
        word(ANGLE_WIDTH - 1 downto 0) := std_ulogic_vector(place.start3);

      when 4 =>
        word(ANGLE_WIDTH - 1 downto 0) := std_ulogic_vector(place.start4);

      when 5 =>
        word := std_ulogic_vector(place.step(31 downto 0));

      when 6 =>
        word(PHASE_STEP_WIDTH - 33 downto 0) := std_ulogic_vector(place.step(PHASE_STEP_WIDTH - 1 downto 32));

      when others =>
        null;

    end case;

    return word;

  end function word_of;

  -- Initial values are the state at power-up.
  signal place      : places     := (others => NOWHERE);
  signal active     : std_ulogic := '0';
  signal asked      : std_ulogic := '0';

  signal copy       : state                := FREE;
  signal copied     : point_index          := (others => '0');
  signal left_clear : natural range 0 to LOCAL_TABLE_LATENCY := 0;

  -- Flags: a read waits, a write waits, a read is in progress; the word of the place that was read
  signal to_read    : std_ulogic                     := '0';
  signal to_write   : std_ulogic                     := '0';
  signal looked_up  : std_ulogic                     := '0';
  signal place_word : std_ulogic_vector(31 downto 0) := (others => '0');

  signal takes      : std_ulogic;
  signal starts     : std_ulogic;
  signal stores     : std_ulogic;
  signal copies     : std_ulogic;
  signal write_bank : std_ulogic;
  signal there      : point_index;
  signal new_word   : point;
  signal read_word  : point;

  function number_of (bit : std_ulogic) return natural is
  begin

    if bit = '1' then
      return 1;
    end if;
    return 0;

  end function number_of;

begin

  -- takes: the table swaps its banks. starts: an access may begin. stores: a write of the processor takes place.
  -- copies: a copied point is written.
  takes  <= swap_comes and asked;
  starts <= '1' when copy = FREE and swap_comes = '0' else
            '0';
  stores <= to_write and starts and not hold;
  copies <= '1' when copy = WRITES else
            '0';

  write_bank <= active when copy = READS else
                not active;
  there      <= address when copy = FREE else
                copied;
  new_word   <= u_signed(write_data(LOCAL_POINT_WIDTH - 1 downto 0)) when copy = FREE else
                read_word;

  points : entity work.local_table
    port map (
      clock          => clock,
      angle          => angle,
      bank           => active,
      counts_per_rev => counts_per_rev,
      bank0_place    => place(0),
      bank1_place    => place(1),
      write_enable   => copies or (stores and not of_place),
      write_bank     => write_bank,
      write_address  => there,
      write_data     => new_word,
      read_word      => read_word,
      value          => value
    );

  read_data <= place_word when of_place = '1' else
               std_ulogic_vector(resize(read_word, 32));

  words_and_banks : process (clock) is
  begin

    if rising_edge(clock) then
      done      <= stores or looked_up;
      looked_up <= '0';

      -- The address does not change until `done`, so the memory has read the point one clock later.
      if to_read = '1' and starts = '1' then
        looked_up  <= '1';
        place_word <= word_of(place(number_of(not active)), address(2 downto 0));
      end if;

      if stores = '1' then
        to_write <= '0';
        if of_place = '1' and address(2 downto 0) = 0 then
          asked <= '1';
        end if;
      end if;

      -- The loop over the banks gives each bank's registers their own enable; no multiplexer between the banks is
      -- needed.
      for bank in 0 to 1 loop
        if number_of(active) /= bank then
          if stores = '1' and of_place = '1' then
            place(bank) <= changed(place(bank), address(2 downto 0), write_data);
          end if;
          if copy = CLEARS and left_clear = 1 then
            place(bank) <= place(1 - bank);
          end if;
        end if;
      end loop;

      to_read  <= read_enable or (to_read and not starts);
      if write_enable = '1' then
        to_write <= '1';
      end if;

      case copy is

        when FREE =>
          null;

        when CLEARS =>
          left_clear <= left_clear - 1;
          if left_clear = 1 then
            copy <= READS;
          end if;

        when READS =>
          copy <= WRITES;

        when WRITES =>
          copied <= copied + 1;
          copy   <= READS;
          if copied = 2 ** LOCAL_INDEX_WIDTH - 1 then
            copy <= FREE;
          end if;

      end case;

      if takes = '1' then
        active     <= not active;
        asked      <= '0';
        copied     <= (others => '0');
        left_clear <= LOCAL_TABLE_LATENCY;
        copy       <= CLEARS;
      end if;

      if reset = '1' then
        asked     <= '0';
        to_read   <= '0';
        to_write  <= '0';
        looked_up <= '0';
        done      <= '0';
      end if;
    end if;

  end process words_and_banks;

end architecture rtl;
