-- SPDX-License-Identifier: Apache-2.0
--
-- # coefficient_memory
--
-- Stores two banks of coefficients for every lane of equation (9): the pipeline reads the active bank, the processor
-- writes the idle bank. A pulse of `swap` makes the idle bank the active one for all lanes at once. Then the entity
-- copies the active values into the new idle bank, so that the processor can change single words and swap again. The
-- source of this copy is idle_words, from which the processor also reads the words back. bank_swap decides when a swap
-- takes place.
--
-- **Words.** `write_address` = lane * 4 + word. Word 0: phase step, bits 31..0; word 1: phase step, bits 47..32; word
-- 2: phase offset; word 3: amplitude, sign-extended to 32 bits. A word of a lane that is not built is acknowledged, not
-- stored, and reads as 0. `write_offset` writes the offset, a constant that is added to the correction. Only the bits
-- of the format are stored; a read returns the stored bits.
--
-- **One bank for one angle.** The pipeline uses the phase step of an angle when the angle enters, the phase offset
-- PHASE_OFFSET_DELAY clocks later, the amplitude AMPLITUDE_DELAY clocks later and the offset OFFSET_DELAY clocks later.
-- After a swap each of these four outputs changes its bank with its own delay, so that all coefficients of one angle
-- come from one bank. `swap_marker` is high in the clock of the first angle of the new bank; if the swap need not wait,
-- this is the clock after `swap`.
--
-- **Folding.** FOLD lanes share one pipeline, and in each clock an output carries the words of one block of LANES /
-- FOLD neighbouring lanes. `phase_steps` carries block s in the clock in which `slot` is s; the phase offsets and
-- amplitudes of that block come with the delays above. A folded pipeline takes FOLD clocks for an angle. `swap_allowed`
-- must be high only in the clock before each new angle; a swap waits for this clock, and several waiting swaps count as
-- one.
--
-- **Writing.** Pulse `write_enable` or `write_offset` (never both) with address and data; a pulse of
-- `write_acknowledge`, 3 clocks later, ends the write. While a swap waits or the idle bank is being filled, the write
-- waits too: it ends at most (largest delay + 4 * LANES + 5) clocks after the swap took place. Start no other write
-- before the acknowledge. A swap takes over all acknowledged writes and no part of a pending write. `swap_busy` is high
-- from the clock after `swap` until the idle bank is filled. A further `swap` is allowed at any time; it waits until
-- the idle bank is filled and a write in progress has ended.
--
-- **Latency.** 1 clock from an immediate `swap` to the new phase steps; 2 clocks from `read_address` to `read_data`.
--
-- **Number formats.** phase step u0.48 turn per count; phase offset u0.24 turn; amplitude and offset s13.11 counts.
-- Flat outputs carry the first lane of the block in the low bits.
--
-- **Modulators.** With MODULATORS bits 18 to 16 of word 1 choose the modulator of the lane's amplitude
-- (amplitude_sweep). `amplitudes` then carries the effective amplitudes; reads and the copy into the idle bank use the
-- nominal amplitudes. A swap also waits until a whole sweep has run since the last write and since the fill, which
-- takes at most 2 · AMPLITUDE_SWEEP_CLOCKS clocks.
--
-- **Real orders.** With REAL_ORDERS each lane also has a turn step of two words. `write_turn_step` writes a word,
-- `read_turn_step` reads one; the address is lane * 2 + word, word 0 holds bits 31..0, word 1 bits 47..32.
-- turn_offset_sweep prepares the phase offsets of several turns; `turn_select`, which turn_counter outputs one clock
-- after the angle, selects the turn. A swap also waits until 36 · LANES + 12 clocks have passed since the last write
-- and since the fill, so that turn_offset_sweep has computed all offsets anew. The turn steps add 18 · LANES clocks to
-- the fill.
--
-- **Reset.** `reset` drops a pending write and a swap that waits; a write in progress ends without an acknowledge. The
-- reset keeps both banks and lets a swap that has taken place end; otherwise parts of two banks would stay active
-- together. At power-up both banks are zero.

library ieee;
  use ieee.std_logic_1164.all;
  use ieee.numeric_std.all;

  use work.conditions_pkg.all;
  use work.number_formats_pkg.all;

entity coefficient_memory is
  generic (
    LANES              : positive range 1 to LANES_MAX := LANES_DEFAULT;
    FOLD               : positive range 1 to 8         := 1; -- number of lanes that share a pipeline: 1, 2, 4 or 8
    PHASE_OFFSET_DELAY : positive range 1 to 63        := PHASE_OFFSET_CLOCK;
    AMPLITUDE_DELAY    : positive range 1 to 63        := PHASE_LATENCY + AMPLITUDE_CLOCK;
    OFFSET_DELAY       : positive range 1 to 63        := DELAY_LINE_LATENCY;
    MODULATORS         : boolean                       := false; -- amplitudes can follow motion or a processor word
    REAL_ORDERS        : boolean                       := false  -- the order of a lane need not be an integer
  );
  port (
    clock             : in    std_ulogic;
    reset             : in    std_ulogic;
    write_enable      : in    std_ulogic;                     -- pulse: write a word of a lane
    write_offset      : in    std_ulogic;                     -- pulse: write the offset
    write_address     : in    u_unsigned(7 downto 0);         -- lane * 4 + word
    write_data        : in    std_ulogic_vector(31 downto 0); -- the word
    write_acknowledge : out   std_ulogic;                     -- pulse: the word is written
    read_address      : in    u_unsigned(7 downto 0);         -- lane * 4 + word
    read_data         : out   std_ulogic_vector(31 downto 0); -- the word in the idle bank
    idle_offset       : out   u_signed(AMPLITUDE_WIDTH - 1 downto 0); -- counts, s13.11, the offset in the idle bank
    swap              : in    std_ulogic;                     -- pulse: the idle bank becomes active
    swap_allowed      : in    std_ulogic := '1';              -- high if the next clock brings a new angle
    swap_comes        : out   std_ulogic;                     -- high in the clock before swap_marker
    swap_marker       : out   std_ulogic;                     -- high with the first angle of a new bank
    swap_busy         : out   std_ulogic;                     -- level: a swap waits, or the idle bank is being filled
    slot              : in    u_unsigned(2 downto 0) := (others => '0'); -- number of the block of lanes; 0 with a new angle
    phase_steps       : out   std_ulogic_vector(LANES / FOLD * PHASE_STEP_WIDTH - 1 downto 0); -- turn per count, u0.48
    phase_offsets     : out   std_ulogic_vector(LANES / FOLD * PHASE_WIDTH - 1 downto 0);      -- turn, u0.24
    amplitudes        : out   std_ulogic_vector(LANES / FOLD * AMPLITUDE_WIDTH - 1 downto 0);  -- counts, s13.11
    offset            : out   u_signed(AMPLITUDE_WIDTH - 1 downto 0);                          -- counts, s13.11
    -- With MODULATORS, see amplitude_sweep
    sweep_step        : in    u_unsigned(7 downto 0) := (others => '0');
    direction         : in    modulator              := (others => '0');
    speed             : in    modulator              := (others => '0');
    idle_speed        : in    modulator              := (others => '0');
    word_a            : in    modulator              := (others => '0');
    word_b            : in    modulator              := (others => '0');
    speed_squared     : out   modulator;
    -- With REAL_ORDERS, see turn_offset_sweep and turn_counter
    write_turn_step   : in    std_ulogic                                := '0';             -- pulse: write a word of a turn step
    read_turn_step    : in    std_ulogic                                := '0';             -- read_address is the address of a turn step
    turn              : in    u_signed(TURN_NUMBER_WIDTH - 1 downto 0) := (others => '0'); -- number of turns of the present angle
    turn_select       : in    u_unsigned(1 downto 0)                    := "00"             -- turn modulo 4, a clock after the angle
  );
end entity coefficient_memory;

architecture rtl of coefficient_memory is

  constant BUILT : positive := LANES / FOLD;

  -- Number of turns for which each lane has a stored phase offset.
  constant PREPARED_TURNS : positive := 1 + 3 * boolean'pos(REAL_ORDERS);

  subtype word is std_ulogic_vector(31 downto 0);

  subtype word_address is u_unsigned(7 downto 0);

  subtype slot_number is u_unsigned(2 downto 0);

  -- Initial values are the state at power-up.
  signal idle_constant   : u_signed(offset'range) := (others => '0');
  signal active_constant : u_signed(offset'range) := (others => '0');

  -- The active bank, and bank and slot of the words that the outputs show in the next clock
  signal active         : std_ulogic;
  signal step_bank      : std_ulogic;
  signal step_slot      : slot_number;
  signal phase_bank     : std_ulogic;
  signal phase_slot     : slot_number;
  signal amplitude_bank : std_ulogic;
  signal amplitude_slot : slot_number;

  signal swap_waits      : std_ulogic;
  signal is_ready        : std_ulogic;
  signal swap_under_way  : std_ulogic;
  signal offset_changes  : std_ulogic;
  signal all_are_swapped : std_ulogic;

  -- A write that waits, with its address and its data
  signal pending_word   : std_ulogic   := '0';
  signal pending_offset : std_ulogic   := '0';
  signal pending_turn   : std_ulogic;
  signal starts_turn    : std_ulogic;
  signal address        : word_address := (others => '0');
  signal data           : word         := (others => '0');
  signal write_now      : std_ulogic;

  -- Filling of the idle bank
  signal fills       : std_ulogic;
  signal fill_enable : std_ulogic;
  signal fill_place  : word_address;
  signal fill_word   : word;

  -- High if no swap is taking effect and the idle bank is filled. (In the first such clock the last write of the fill
  -- may still take place.)
  signal is_quiet : std_ulogic := '1';

  -- The word that is written into the idle bank; `selected` has one bit for each kind of word of each lane of a block
  signal selected      : std_ulogic_vector(0 to 4 * BUILT - 1) := (others => '0');
  signal selected_slot : slot_number                           := (others => '0');
  signal written       : word                                  := (others => '0');
  signal writing       : std_ulogic                            := '0';
  signal answers       : std_ulogic                            := '0';
  signal idle_bank     : std_ulogic;

  -- Writes of the amplitudes: the word that enters the idle bank or, with MODULATORS, the product from amplitude_sweep
  signal swept            : std_ulogic;
  signal amplitude_enters : std_ulogic_vector(0 to BUILT - 1);
  signal amplitude_target : std_ulogic;
  signal amplitude_place  : slot_number;
  signal amplitude_word   : std_ulogic_vector(AMPLITUDE_WIDTH - 1 downto 0);

  -- Writes of the phase offsets: the word that enters the idle bank or, with REAL_ORDERS, the offset of a turn from
  -- turn_offset_sweep
  signal turns_swept      : std_ulogic;
  signal turns_copied     : std_ulogic;
  signal offset_enters    : std_ulogic_vector(0 to BUILT - 1);
  signal offset_target    : std_ulogic;
  signal offset_place     : slot_number;
  signal offset_turn      : u_unsigned(1 downto 0);
  signal offset_word      : std_ulogic_vector(PHASE_WIDTH - 1 downto 0);

  -- Address and kind of the word that is written in this clock
  signal written_place : word_address := (others => '0');
  signal is_written    : std_ulogic   := '0';
  signal is_turn_step  : std_ulogic   := '0';

  signal of_coefficients : word;

begin

  write_now <= (pending_word or pending_offset or pending_turn) and not swap_waits and not swap and is_quiet and not reset;
  is_ready  <= is_quiet and not writing and swept and turns_swept;

  swap_busy   <= swap_waits or not is_quiet;
  offset      <= active_constant;
  idle_offset <= idle_constant;
  idle_bank   <= not active;

  swapping : entity work.bank_swap
    generic map (
      FOLD               => FOLD,
      PHASE_OFFSET_DELAY => PHASE_OFFSET_DELAY,
      AMPLITUDE_DELAY    => AMPLITUDE_DELAY,
      OFFSET_DELAY       => OFFSET_DELAY
    )
    port map (
      clock          => clock,
      reset          => reset,
      swap           => swap,
      swap_allowed   => swap_allowed,
      ready          => is_ready,
      slot           => slot,
      waits          => swap_waits,
      takes_place    => swap_comes,
      marker         => swap_marker,
      under_way      => swap_under_way,
      offset_changes => offset_changes,
      ends           => all_are_swapped,
      active         => active,
      step_bank      => step_bank,
      step_slot      => step_slot,
      phase_bank     => phase_bank,
      phase_slot     => phase_slot,
      amplitude_bank => amplitude_bank,
      amplitude_slot => amplitude_slot
    );

  -- The processor reads these words, and they fill the idle bank when all outputs have changed their bank.
  idle : entity work.idle_words
    generic map (
      LANES      => LANES,
      MODULATORS => MODULATORS
    )
    port map (
      clock         => clock,
      write_enable  => write_now and pending_word,
      write_address => address,
      write_data    => data,
      read_address  => read_address,
      read_data     => of_coefficients,
      start_fill    => all_are_swapped,
      fills         => fills,
      fill_enable   => fill_enable,
      fill_place    => fill_place,
      fill_word     => fill_word
    );

  constants : process (clock) is
  begin

    if rising_edge(clock) then
      is_quiet <= not (swap_under_way or fills or turns_copied);

      if offset_changes = '1' then
        active_constant <= idle_constant;
      end if;
      if write_now = '1' and pending_offset = '1' then
        idle_constant <= u_signed(data(offset'range));
      end if;
    end if;

  end process constants;

  write : process (clock) is

    variable target : word_address;
    variable enters : std_ulogic;

  begin

    if rising_edge(clock) then
      if fill_enable = '1' then
        target  := fill_place;
        written <= fill_word;
      else
        target  := address;
        written <= data;
      end if;
      enters  := fill_enable or (write_now and pending_word);
      writing <= fill_enable or write_now;

      selected <= (others => '0');

      for lane in 0 to LANES - 1 loop
        if target(7 downto 2) = lane then
          selected_slot <= to_unsigned(lane / BUILT, 3);

          for kind in 0 to 3 loop
            selected(4 * (lane mod BUILT) + kind) <= enters and (target(1 downto 0) ?= kind);
          end loop;

        end if;
      end loop;

      answers           <= write_now;
      write_acknowledge <= answers and not reset;

      if write_now = '1' then
        pending_word   <= '0';
        pending_offset <= '0';
      end if;

      if (write_enable or write_offset or starts_turn) = '1' then
        pending_word   <= write_enable;
        pending_offset <= write_offset;
        address        <= write_address;
        data           <= write_data;
      end if;

      if reset = '1' then
        pending_word   <= '0';
        pending_offset <= '0';
      end if;
    end if;

  end process write;

  place : process (clock) is
  begin

    if rising_edge(clock) then
      is_written    <= fill_enable or (write_now and pending_word);
      is_turn_step  <= write_now and pending_turn;
      written_place <= fill_place when fill_enable = '1' else
                       address;
    end if;

  end process place;

  columns : for column in 0 to BUILT - 1 generate

    steps_low : entity work.coefficient_banks
      generic map (
        FOLD  => FOLD,
        WIDTH => 32
      )
      port map (
        clock        => clock,
        write_enable => selected(4 * column),
        write_bank   => idle_bank,
        write_slot   => selected_slot,
        write_word   => written,
        read_bank    => step_bank,
        read_slot    => step_slot,
        read_word    => phase_steps(column * PHASE_STEP_WIDTH + 31 downto column * PHASE_STEP_WIDTH)
      );

    steps_high : entity work.coefficient_banks
      generic map (
        FOLD  => FOLD,
        WIDTH => PHASE_STEP_WIDTH - 32
      )
      port map (
        clock        => clock,
        write_enable => selected(4 * column + 1),
        write_bank   => idle_bank,
        write_slot   => selected_slot,
        write_word   => written(PHASE_STEP_WIDTH - 33 downto 0),
        read_bank    => step_bank,
        read_slot    => step_slot,
        read_word    => phase_steps((column + 1) * PHASE_STEP_WIDTH - 1 downto column * PHASE_STEP_WIDTH + 32)
      );

    offsets_of_phase : entity work.coefficient_banks
      generic map (
        FOLD  => FOLD,
        WIDTH => PHASE_WIDTH,
        TURNS => PREPARED_TURNS
      )
      port map (
        clock        => clock,
        write_enable => offset_enters(column),
        write_bank   => offset_target,
        write_slot   => offset_place,
        write_turn   => offset_turn,
        write_word   => offset_word,
        read_bank    => phase_bank,
        read_slot    => phase_slot,
        read_turn    => turn_select,
        read_word    => phase_offsets((column + 1) * PHASE_WIDTH - 1 downto column * PHASE_WIDTH)
      );

    amplitudes_of_cosine : entity work.coefficient_banks
      generic map (
        FOLD  => FOLD,
        WIDTH => AMPLITUDE_WIDTH
      )
      port map (
        clock        => clock,
        write_enable => amplitude_enters(column),
        write_bank   => amplitude_target,
        write_slot   => amplitude_place,
        write_word   => amplitude_word,
        read_bank    => amplitude_bank,
        read_slot    => amplitude_slot,
        read_word    => amplitudes((column + 1) * AMPLITUDE_WIDTH - 1 downto column * AMPLITUDE_WIDTH)
      );

  end generate columns;

  modulated : if MODULATORS generate

    sweep : entity work.amplitude_sweep
      generic map (
        LANES => LANES,
        FOLD  => FOLD
      )
      port map (
        clock           => clock,
        sweep_step      => sweep_step,
        direction       => direction,
        speed           => speed,
        idle_speed      => idle_speed,
        word_a          => word_a,
        word_b          => word_b,
        speed_squared   => speed_squared,
        write_amplitude => is_written and (written_place(1 downto 0) ?= "11"),
        write_choice    => is_written and (written_place(1 downto 0) ?= "01"),
        write_bank      => idle_bank,
        write_lane      => written_place(7 downto 2),
        write_word      => written(AMPLITUDE_WIDTH - 1 downto 0),
        swept           => swept,
        selected        => amplitude_enters,
        bank            => amplitude_target,
        slot            => amplitude_place,
        effective       => amplitude_word
      );

  else generate

    straight : for column in 0 to BUILT - 1 generate

      amplitude_enters(column) <= selected(4 * column + 3);

    end generate straight;

    amplitude_target <= idle_bank;
    amplitude_place  <= selected_slot;
    amplitude_word   <= written(AMPLITUDE_WIDTH - 1 downto 0);
    swept            <= '1';
    speed_squared    <= (others => '0');
  end generate modulated;

  real_orders_too : if REAL_ORDERS generate

    signal waits          : std_ulogic := '0';
    signal written_lane   : u_unsigned(5 downto 0);
    signal is_built       : std_ulogic;
    signal turn_step_read : word;
    signal read_turn_then : std_ulogic := '0';
    signal turn_step_then : word       := (others => '0');

  begin

    assert PHASE_OFFSET_DELAY = 2
      report "coefficient_memory: phase offsets must be read in the clock after turn_select, 2 clocks after the angle"
      severity failure;

    turn_sweep : entity work.turn_offset_sweep
      generic map (
        LANES => LANES,
        FOLD  => FOLD
      )
      port map (
        clock        => clock,
        turn         => turn,
        idle_bank    => idle_bank,
        write_low    => is_turn_step and not written_place(0) and is_built,
        write_high   => is_turn_step and written_place(0) and is_built,
        write_offset => is_written and (written_place(1 downto 0) ?= "10"),
        write_lane   => written_lane,
        write_word   => written,
        take_over    => all_are_swapped,
        copies       => turns_copied,
        swept        => turns_swept,
        read_address => read_address(6 downto 0),
        read_word    => turn_step_read,
        selected     => offset_enters,
        bank         => offset_target,
        slot         => offset_place,
        of_turn      => offset_turn,
        prepared     => offset_word
      );

    written_lane <= written_place(6 downto 1) when is_turn_step = '1' else
                    written_place(7 downto 2);
    is_built     <= '1' when written_place(6 downto 1) < LANES else
                    '0';

    starts_turn  <= write_turn_step;
    pending_turn <= waits;

    answer : process (clock) is
    begin

      if rising_edge(clock) then
        waits          <= (write_turn_step or (waits and not write_now)) and not reset;
        read_turn_then <= read_turn_step;
        turn_step_then <= turn_step_read;
      end if;

    end process answer;

    read_data <= turn_step_then when read_turn_then = '1' else
                 of_coefficients;
  else generate

    of_every_turn : for column in 0 to BUILT - 1 generate

      offset_enters(column) <= selected(4 * column + 2);

    end generate of_every_turn;

    offset_target <= idle_bank;
    offset_place  <= selected_slot;
    offset_turn   <= "00";
    offset_word   <= written(PHASE_WIDTH - 1 downto 0);
    turns_swept   <= '1';
    turns_copied  <= '0';
    starts_turn   <= '0';
    pending_turn  <= '0';
    read_data     <= of_coefficients;
  end generate real_orders_too;

  check : process (clock) is
  begin

    if rising_edge(clock) then
      assert not (write_enable = '1' and write_offset = '1')
        report "coefficient_memory: write_enable and write_offset in one clock"
        severity failure;
      assert not ((write_enable or write_offset or starts_turn) = '1'
                  and (pending_word or pending_offset or pending_turn) = '1')
        report "coefficient_memory: a write was started before the last one was acknowledged"
        severity failure;
    end if;

  end process check;

end architecture rtl;
