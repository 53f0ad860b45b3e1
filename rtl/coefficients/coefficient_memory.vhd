-- SPDX-License-Identifier: Apache-2.0
--
-- # coefficient_memory
--
-- Two banks of coefficients for every lane of equation (9): the pipeline reads the active bank,
-- the processor writes the idle one. A pulse of `swap` copies the idle bank into the active one
-- for all lanes at once. Afterwards the idle bank still holds the same values, so single words
-- can be changed and swapped in again.
--
-- **Words.** `write_address` = lane * 4 + word. Word 0: phase step, bits 31..0; word 1: phase
-- step, bits 47..32; word 2: phase offset; word 3: amplitude, sign-extended to 32 bits. A word
-- of a lane that is not built is acknowledged, not stored, and reads as 0. `write_offset` writes
-- the offset, a constant added to the correction. Only the bits of the format are stored; the
-- read-back shows what is stored.
--
-- **One bank for one angle.** An angle meets its phase step on entering the pipeline, its phase
-- offset PHASE_OFFSET_DELAY clocks later, its amplitude AMPLITUDE_DELAY clocks later and the
-- offset OFFSET_DELAY clocks later. Each part of the bank is copied with exactly that delay, so
-- that every angle meets the coefficients of one bank. `swap_marker` is high in the clock of the
-- first angle that meets the new bank: the clock after `swap`.
--
-- **Folding.** A folded pipeline takes FOLD clocks for an angle. It holds `swap_allowed` high in the
-- clock before each new angle only; a swap waits for it, and swaps that wait together are one.
--
-- **Writing.** Pulse `write_enable` or `write_offset` (never both) with address and data; the
-- write is finished with the pulse of `write_acknowledge`, 2 clocks later or, while a copy is
-- under way, when that copy has ended (at most the largest delay + 2 clocks, and the wait of a swap). Start no other
-- write before. A swap takes over all acknowledged writes and no part of a pending one.
-- `swap_busy` is high while parts of a bank are still to be copied; a further `swap` then is
-- allowed.
--
-- **Latency.** 1 clock from an allowed `swap` to the new phase steps; 2 clocks from `read_address` to
-- `read_data`.
--
-- **Number formats.** phase step u0.48 turn a count; phase offset u0.24 turn; amplitude and
-- offset s13.11 counts. Flat outputs carry lane 0 in the low bits.
--
-- **Reset.** `reset` drops a pending write. It keeps both banks and lets a copy end, else a
-- mixed bank would stay; at power-up both banks are zero.

library ieee;
  use ieee.std_logic_1164.all;
  use ieee.numeric_std.all;

  use work.number_formats_pkg.all;

entity coefficient_memory is
  generic (
    LANES              : positive range 1 to LANES_MAX := LANES_DEFAULT;
    PHASE_OFFSET_DELAY : positive range 1 to 63        := PHASE_OFFSET_CLOCK;
    AMPLITUDE_DELAY    : positive range 1 to 63        := PHASE_LATENCY + AMPLITUDE_CLOCK;
    OFFSET_DELAY       : positive range 1 to 63        := DELAY_LINE_LATENCY
  );
  port (
    clock             : in    std_ulogic;
    reset             : in    std_ulogic;
    write_enable      : in    std_ulogic;                     -- pulse: write a word of a lane
    write_offset      : in    std_ulogic;                     -- pulse: write the offset
    write_address     : in    u_unsigned(7 downto 0);         -- lane * 4 + word
    write_data        : in    std_ulogic_vector(31 downto 0); -- the word
    write_acknowledge : out   std_ulogic;                     -- pulse: written
    read_address      : in    u_unsigned(7 downto 0);         -- lane * 4 + word
    read_data         : out   std_ulogic_vector(31 downto 0); -- the word in the idle bank
    idle_offset       : out   u_signed(AMPLITUDE_WIDTH - 1 downto 0); -- counts, s13.11, idle bank
    swap              : in    std_ulogic;                     -- pulse: the idle bank becomes active
    swap_allowed      : in    std_ulogic := '1';              -- the next clock brings a new angle
    swap_marker       : out   std_ulogic;                     -- with the first angle of a new bank
    swap_busy         : out   std_ulogic;                     -- parts of a bank are still to be copied
    phase_steps       : out   std_ulogic_vector(LANES * PHASE_STEP_WIDTH - 1 downto 0); -- turn a count, u0.48
    phase_offsets     : out   std_ulogic_vector(LANES * PHASE_WIDTH - 1 downto 0);      -- turn, u0.24
    amplitudes        : out   std_ulogic_vector(LANES * AMPLITUDE_WIDTH - 1 downto 0);  -- counts, s13.11
    offset            : out   u_signed(AMPLITUDE_WIDTH - 1 downto 0)                    -- counts, s13.11
  );
end entity coefficient_memory;

architecture rtl of coefficient_memory is

  constant LAST_COPY : positive := maximum(maximum(PHASE_OFFSET_DELAY, AMPLITUDE_DELAY), OFFSET_DELAY);

  subtype word is std_ulogic_vector(31 downto 0);

  type words is array (0 to 4 * LANES_MAX - 1) of word;

  -- Initial values are the state at power-up.
  signal idle_steps      : std_ulogic_vector(phase_steps'range)   := (others => '0');
  signal idle_offsets    : std_ulogic_vector(phase_offsets'range) := (others => '0');
  signal idle_amplitudes : std_ulogic_vector(amplitudes'range)    := (others => '0');
  signal idle_constant   : u_signed(offset'range)                 := (others => '0');

  signal active_steps      : std_ulogic_vector(phase_steps'range)   := (others => '0');
  signal active_offsets    : std_ulogic_vector(phase_offsets'range) := (others => '0');
  signal active_amplitudes : std_ulogic_vector(amplitudes'range)    := (others => '0');
  signal active_constant   : u_signed(offset'range)                 := (others => '0');

  signal read_back   : words := (others => (others => '0'));
  signal read_stored : word  := (others => '0');

  signal swap_waits : std_ulogic := '0';
  signal swap_now   : std_ulogic;

  -- copying(d) is high d clocks after a swap.
  signal copying : std_ulogic_vector(1 to LAST_COPY) := (others => '0');

  signal pending_word   : std_ulogic                    := '0';
  signal pending_offset : std_ulogic                    := '0';
  signal address        : natural range 0 to 255        := 0;
  -- The word that waits: a bit a word, so that each bit is a clock enable with write_now.
  signal selected       : std_ulogic_vector(0 to 4 * LANES - 1) := (others => '0');
  -- No copy is under way, but one of a swap in this clock.
  signal is_quiet       : std_ulogic                    := '1';
  signal data           : std_ulogic_vector(31 downto 0) := (others => '0');
  signal write_now      : std_ulogic;

begin

  write_now <= (pending_word or pending_offset) and not swap_waits and not swap and is_quiet and not reset;
  swap_now  <= (swap or swap_waits) and swap_allowed;

  swap_marker   <= copying(1);
  swap_busy     <= swap_waits or (or copying);
  phase_steps   <= active_steps;
  phase_offsets <= active_offsets;
  amplitudes    <= active_amplitudes;
  offset        <= active_constant;
  idle_offset   <= idle_constant;

  banks : process (clock) is
  begin

    if rising_edge(clock) then
      copying    <= swap_now & copying(1 to LAST_COPY - 1);
      swap_waits <= (swap or swap_waits) and not swap_allowed;
      is_quiet   <= not swap_now and not (or copying(1 to LAST_COPY - 1));

      if swap_now = '1' then
        active_steps <= idle_steps;
      end if;
      if copying(PHASE_OFFSET_DELAY) = '1' then
        active_offsets <= idle_offsets;
      end if;
      if copying(AMPLITUDE_DELAY) = '1' then
        active_amplitudes <= idle_amplitudes;
      end if;
      if copying(OFFSET_DELAY) = '1' then
        active_constant <= idle_constant;
      end if;

      write_acknowledge <= write_now;

      if write_now = '1' then
        pending_word   <= '0';
        pending_offset <= '0';

        for lane in 0 to LANES - 1 loop
          -- One condition a word, so that each becomes a clock enable.
          if selected(4 * lane) = '1' then
            idle_steps(lane * PHASE_STEP_WIDTH + 31 downto lane * PHASE_STEP_WIDTH) <= data;
          end if;
          if selected(4 * lane + 1) = '1' then
            idle_steps(lane * PHASE_STEP_WIDTH + 47 downto lane * PHASE_STEP_WIDTH + 32) <=
              data(15 downto 0);
          end if;
          if selected(4 * lane + 2) = '1' then
            idle_offsets(lane * PHASE_WIDTH + PHASE_WIDTH - 1 downto lane * PHASE_WIDTH) <=
              data(PHASE_WIDTH - 1 downto 0);
          end if;
          if selected(4 * lane + 3) = '1' then
            idle_amplitudes(lane * AMPLITUDE_WIDTH + AMPLITUDE_WIDTH - 1 downto lane * AMPLITUDE_WIDTH) <=
              data(AMPLITUDE_WIDTH - 1 downto 0);
          end if;
        end loop;

        if pending_offset = '1' then
          idle_constant <= u_signed(data(offset'range));
        end if;
      end if;

      if (write_enable or write_offset) = '1' then
        pending_word   <= write_enable;
        pending_offset <= write_offset;
        address        <= to_integer(write_address);

        for place in selected'range loop
          selected(place) <= write_enable and (write_address ?= place);
        end loop;

        data           <= write_data;
      end if;

      if reset = '1' then
        pending_word   <= '0';
        pending_offset <= '0';
      end if;
    end if;

  end process banks;

  -- One block RAM beside the registers, written with them.
  read_back_memory : process (clock) is

    variable stored : word;

  begin

    if rising_edge(clock) then
      read_data   <= read_stored;
      read_stored <= read_back(to_integer(read_address));

      if write_now = '1' and pending_word = '1' and address < 4 * LANES then

        case address mod 4 is

          when 0 =>
            stored := data;

          when 1 =>
            stored := std_ulogic_vector(resize(u_unsigned(data(15 downto 0)), 32));

          when 2 =>
            stored := std_ulogic_vector(resize(u_unsigned(data(PHASE_WIDTH - 1 downto 0)), 32));

          when others =>
            stored := std_ulogic_vector(resize(u_signed(data(AMPLITUDE_WIDTH - 1 downto 0)), 32));

        end case;

        read_back(address) <= stored;
      end if;
    end if;

  end process read_back_memory;

  check : process (clock) is
  begin

    if rising_edge(clock) then
      assert not (write_enable = '1' and write_offset = '1')
        report "coefficient_memory: write_enable and write_offset in one clock"
        severity failure;
      assert not ((write_enable or write_offset) = '1' and (pending_word or pending_offset) = '1')
        report "coefficient_memory: a write was started before the last one was acknowledged"
        severity failure;
    end if;

  end process check;

end architecture rtl;
