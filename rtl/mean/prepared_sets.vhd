-- SPDX-License-Identifier: Apache-2.0
--
-- # prepared_sets
--
-- Stores prepared sets of coefficients and weights: one for all heads, and one for the loss of each head. A set
-- consists of the words of the lanes, the words of the mean, and the coefficient offset; it has no turn steps and no
-- local table. On request the entity writes one set into the idle bank, word by word, and then swaps the banks: all
-- words become active in the same clock, and the ramp absorbs the change of the output. All sets of four heads and 32
-- lanes fit into one block RAM of 36 Kbit.
--
-- **Words.** `access_word` is the number of a word in a set, with words of 4 bytes in the order of the register map:
-- lane * 4 + word for a lane, 512 + place for a word of `mean`, where place 15 is the coefficient offset. Access one
-- word at a time. A word that is not stored reads as 0.
--
-- **Processor.** The processor's writes to the idle bank pass through this entity, because processor and entity write
-- the same bank. While a set is being loaded, these writes wait; the entity performs them afterwards. If the processor
-- requests a `swap` in that time, only the swap of the set takes place: the set has overwritten the words that the
-- processor had written before, so no mixture of words becomes active.
--
-- **Refusal.** A swap, requested by the processor or for a set, takes place only if `may_activate` is high, that is, if
-- the idle words may be used (see head_failover). Otherwise `refused` pulses and the active words stay active; a set
-- that was loaded for this swap is dropped.
--
-- **Latency.** `swap_out` follows `load` by at most 4 * (4 * LANES + 10) + 4 clocks, 5.6 µs with 32 lanes at 100 MHz,
-- if no write of the processor is under way and coefficient_memory is not filling its idle bank. `loaded` comes with
-- `swap_comes`. The answer to an access follows it by 2 clocks if no set is being loaded. A write of the processor
-- appears at the outputs 2 clocks later if no set is being loaded and no other write is in flight.
--
-- **Number formats.** The entity does no arithmetic; the register map states the formats of the words.
--
-- **Reset** stops loading and drops writes that wait. It keeps the sets.

library ieee;
  use ieee.std_logic_1164.all;
  use ieee.numeric_std.all;

  use work.number_formats_pkg.all;

entity prepared_sets is
  generic (
    LANES : positive range 1 to LANES_MAX := LANES_DEFAULT;
    HEADS : positive range 3 to HEADS_MAX := 4
  );
  port (
    clock             : in    std_ulogic;
    reset             : in    std_ulogic;
    -- The stored words; address and data stay until the answer
    access_read       : in    std_ulogic;                     -- pulse
    access_write      : in    std_ulogic;                     -- pulse
    access_set        : in    u_unsigned(2 downto 0);         -- 0: all heads, k: head k is missing
    access_word       : in    u_unsigned(9 downto 0);         -- number of the word in the set
    access_data       : in    std_ulogic_vector(31 downto 0); -- word to be written
    access_done       : out   std_ulogic := '0';              -- pulse
    access_answer     : out   std_ulogic_vector(31 downto 0); -- the word that was read
    -- Writes of the processor to the idle bank; address and data stay until `acknowledge`
    write_lane        : in    std_ulogic;                     -- pulse
    write_offset      : in    std_ulogic;                     -- pulse
    write_mean        : in    std_ulogic;                     -- pulse
    write_turn_step   : in    std_ulogic := '0';              -- pulse
    write_address     : in    u_unsigned(7 downto 0);         -- lane * 4 + word, the place in the mean, or lane * 2 + word
    write_data        : in    std_ulogic_vector(31 downto 0); -- the word
    acknowledge_lane  : out   std_ulogic;                     -- pulse: a lane's word, the offset or a turn step is written
    acknowledge_mean  : out   std_ulogic;                     -- pulse: the word is written
    swap              : in    std_ulogic;                     -- pulse
    -- Request to load a set
    load              : in    std_ulogic;                     -- pulse: load set `number` and swap; ignored while busy
    number            : in    u_unsigned(2 downto 0);         -- number of the set
    busy              : out   std_ulogic;                     -- level: from the clock after `load` until `loaded` or a refusal
    loaded            : out   std_ulogic;                     -- pulse: the next angle is the first of the set
    -- To the banks
    lane_out          : out   std_ulogic := '0';              -- pulse
    offset_out        : out   std_ulogic := '0';              -- pulse
    mean_out          : out   std_ulogic := '0';              -- pulse
    turn_step_out     : out   std_ulogic := '0';              -- pulse
    address_out       : out   u_unsigned(7 downto 0) := (others => '0');
    data_out          : out   std_ulogic_vector(31 downto 0) := (others => '0');
    acknowledged      : in    std_ulogic;                     -- pulse: any word was written
    may_activate      : in    std_ulogic;                     -- level: the idle words may be swapped
    refused           : out   std_ulogic;                     -- pulse: a swap did not take place
    swap_out          : out   std_ulogic;                     -- pulse
    swap_comes        : in    std_ulogic                      -- the next angle is the first of the new bank
  );
end entity prepared_sets;

architecture rtl of prepared_sets is

  constant LANE_WORDS   : positive := 4 * LANES;
  constant MEAN_WORDS   : positive := 16;
  constant SET_WORDS    : positive := LANE_WORDS + MEAN_WORDS;
  constant STORED_WORDS : positive := (HEADS + 1) * SET_WORDS;
  constant OFFSET_PLACE : natural  := SET_WORDS - 1;
  -- Place of the last word of the mean, the choice of heads; the words between the choice and the offset are not
  -- loaded.
  constant LAST_OF_MEAN : natural  := LANE_WORDS + 2 * HEADS_MAX;

  subtype word is std_ulogic_vector(31 downto 0);

  type words is array (0 to STORED_WORDS - 1) of word;

  type stage is (IDLE, FETCH, HAND_OVER, WRITTEN, ASK_SWAP, WAIT_FOR_SWAP);

  type kind is (NOTHING, OF_LANE, OF_OFFSET, OF_MEAN, OF_TURN_STEP);

  -- Returns the place of the first word of a set.
  function first_word (set : u_unsigned(2 downto 0)) return natural is
  begin

    for place in 1 to HEADS loop
      if set = place then
        return place * SET_WORDS;
      end if;
    end loop;

    return 0;

  end function first_word;

  signal stored     : words := (others => (others => '0'));
  signal ram_place  : natural range 0 to STORED_WORDS - 1;
  signal ram_word   : word := (others => '0');
  signal ram_writes : std_ulogic;

  signal now        : stage := IDLE;
  signal base       : natural range 0 to STORED_WORDS - 1 := 0;
  signal place      : natural range 0 to SET_WORDS - 1    := 0;
  signal waiting    : kind := NOTHING;
  signal in_flight  : kind := NOTHING;
  signal own_write  : std_ulogic := '0';
  signal wants      : std_ulogic;
  signal asked      : std_ulogic := '0';
  signal writes     : std_ulogic := '0';
  signal is_read    : std_ulogic := '0';
  signal exists     : std_ulogic;
  signal is_stored  : std_ulogic := '0';

begin

  busy     <= '0' when now = IDLE else
 '1';
  wants    <= '1' when now = ASK_SWAP else
              swap when now = IDLE else
              '0';
  swap_out <= wants and may_activate;
  refused  <= wants and not may_activate;
  loaded   <= swap_comes when (now = ASK_SWAP and may_activate = '1') or now = WAIT_FOR_SWAP else
 '0';

  acknowledge_lane <= acknowledged when (in_flight = OF_LANE or in_flight = OF_OFFSET or in_flight = OF_TURN_STEP) and own_write = '0' else
 '0';
  acknowledge_mean <= acknowledged when in_flight = OF_MEAN and own_write = '0' else
 '0';

  exists <= '1' when (access_word(9) = '0' and access_word < LANE_WORDS)
                     or (access_word(9) = '1' and access_word(8 downto 0) < MEAN_WORDS) else
 '0';

  -- The memory has one port: while a set is being loaded it reads the set, otherwise it serves the access.
  choose_word : process (all) is
  begin

    ram_place <= base + place;
    if now = IDLE then
      ram_place <= 0;
      if exists = '1' and access_word(9) = '1' then
        ram_place <= first_word(access_set) + LANE_WORDS + to_integer(access_word(3 downto 0));
      elsif exists = '1' then
        ram_place <= first_word(access_set) + to_integer(access_word(7 downto 0));
      end if;
    end if;

  end process choose_word;

  ram_writes <= asked and writes and exists when now = IDLE else
 '0';

  memory : process (clock) is
  begin

    if rising_edge(clock) then
      ram_word <= stored(ram_place);
      if ram_writes = '1' then
        stored(ram_place) <= access_data;
      end if;
    end if;

  end process memory;

  -- An access waits while a set is being loaded.
  answer : process (clock) is
  begin

    if rising_edge(clock) then
      access_done <= '0';
      is_read     <= '0';
      if asked = '1' and now = IDLE then
        asked       <= '0';
        access_done <= '1';
        is_read     <= not writes and exists;
      end if;
      if access_read = '1' or access_write = '1' then
        asked  <= '1';
        writes <= access_write;
      end if;
      if reset = '1' then
        asked       <= '0';
        access_done <= '0';
      end if;
    end if;

  end process answer;

  access_answer <= ram_word when is_read = '1' else
                   (others => '0');

  write_bank : process (clock) is
  begin

    if rising_edge(clock) then
      lane_out   <= '0';
      offset_out <= '0';
      mean_out   <= '0';
      turn_step_out <= '0';

      if acknowledged = '1' then
        in_flight <= NOTHING;
      end if;

      case now is

        when IDLE =>

          if load = '1' then
            now   <= FETCH;
            base  <= first_word(number);
            place <= 0;
          elsif waiting /= NOTHING and in_flight = NOTHING then
            lane_out    <= '1' when waiting = OF_LANE else '0';
            offset_out  <= '1' when waiting = OF_OFFSET else '0';
            mean_out    <= '1' when waiting = OF_MEAN else '0';
            turn_step_out <= '1' when waiting = OF_TURN_STEP else '0';
            address_out <= write_address;
            data_out    <= write_data;
            in_flight   <= waiting;
            own_write   <= '0';
            waiting     <= NOTHING;
          end if;

        when FETCH =>

          -- The memory reads the first word. Loading continues when the processor's write in progress has ended.
          if in_flight = NOTHING then
            now <= HAND_OVER;
          end if;

        when HAND_OVER =>

          if in_flight = NOTHING or acknowledged = '1' then
            own_write   <= '1';
            address_out <= to_unsigned(place, 8) when place < LANE_WORDS else to_unsigned(place - LANE_WORDS, 8);
            data_out    <= ram_word;
            if place = OFFSET_PLACE then
              now        <= WRITTEN;
              offset_out <= '1';
              in_flight  <= OF_OFFSET;
            elsif place >= LANE_WORDS then
              mean_out  <= '1';
              in_flight <= OF_MEAN;
            else
              lane_out  <= '1';
              in_flight <= OF_LANE;
            end if;
            if place = LAST_OF_MEAN then
              place <= OFFSET_PLACE;
            elsif place /= OFFSET_PLACE then
              place <= place + 1;
            end if;
          end if;

        when WRITTEN =>

          if acknowledged = '1' then
            now <= ASK_SWAP;
          end if;

        when ASK_SWAP =>

          now <= IDLE when swap_comes = '1' or may_activate = '0' else
                 WAIT_FOR_SWAP;

        when WAIT_FOR_SWAP =>

          if swap_comes = '1' then
            now <= IDLE;
          end if;

      end case;

      if write_lane = '1' then
        waiting <= OF_LANE;
      elsif write_offset = '1' then
        waiting <= OF_OFFSET;
      elsif write_mean = '1' then
        waiting <= OF_MEAN;
      elsif write_turn_step = '1' then
        waiting <= OF_TURN_STEP;
      end if;

      if reset = '1' then
        now        <= IDLE;
        waiting    <= NOTHING;
        in_flight  <= NOTHING;
        own_write  <= '0';
        lane_out   <= '0';
        offset_out <= '0';
        mean_out   <= '0';
        turn_step_out <= '0';
      end if;
    end if;

  end process write_bank;

end architecture rtl;
