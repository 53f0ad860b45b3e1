-- SPDX-License-Identifier: Apache-2.0
--
-- # sampler
--
-- Stores the turn positions of all heads, latched in the same clock, at every trigger of `sample_trigger`. It fills the
-- two banks of `capture_memory` alternately, one turn of the table at a time, and hands each complete turn to the
-- processor with a header. Source: section 3.2 of the paper (1 kHz, 12,000 points per turn, both heads latched at one
-- clock edge).
--
-- **Latency.** The trigger belongs to one clock; its positions, time stamp and flags are the values in that clock. The
-- sample is in the memory 3 clocks later. `capture_ready` and `bank_ready` rise 3 clocks after the clock of the sample
-- that closes the turn. `read_valid` and `read_data` follow `read_enable` and `read_address` by 4 clocks; a read may
-- start in every clock.
--
-- **Number formats.** turn_position1/2 s31.0 counts; timestamp u64.0 clocks; counts_per_rev u25.0
-- counts; read_address u15.0 = sample * 2 + (head - 1).
--
-- **A turn** starts with its first sample. The closing sample is the first one at which head 1 is counts_per_rev or
-- more away from the first sample, in either direction; it is stored and counted. The sample after it starts the next
-- turn. The distance is checked from the second clock after the first sample on; this suffices, because a turn has at
-- least 4 counts and a decoder counts at most one count per clock. If the turn is not complete after DEPTH samples, the
-- bank is handed over with the flag `full_before_turn`.
--
-- **Ownership.** A bank that has been handed over is READY: it belongs to the processor, and the sampler does not write
-- it until `release_bank` pulses. `bank_ready` is high while a bank is READY, `ready_bank` is its number, and
-- `capture_ready` pulses when a bank becomes READY. At most one bank is READY; the sampler fills the other bank. If the
-- turn in the other bank is complete before the release of the READY bank, this turn is dropped and the sampler fills
-- the same bank again: `capture_overrun` pulses, `overrun_count` increments, and the next header carries `overrun`. The
-- latest release that avoids this comes one clock after the clock of the closing sample. A release without a READY bank
-- has no effect. Release the bank after the last read has been answered.
--
-- **Header.** `header_start_time` is the time stamp of the first sample, `header_sequence` counts the banks handed
-- over, from 0; `header_sample_count` is the number of stored pairs. `header_flags`: 0 index_seen1, 1 index_seen2, 2
-- index_error1, 3 index_error2, 4 illegal1, 5 illegal2, 6 overspeed1, 7 overspeed2, 8 overrun, 9 full_before_turn.
-- Flags 2 to 7 are set if the decoder's flag was high in any clock from the first to the last sample. So a flag that is
-- still high from an earlier fault sets its header flag too; a flag that the decoder raises some clocks after a fault
-- may appear only in the next bank. The header keeps its values while `bank_ready` is high.
--
-- **Enable.** Sampling runs while `enable`, `index_seen1` and `index_seen2` are all high. If one of these signals goes
-- low, the unfinished turn is dropped, which is not an overrun; a READY bank stays READY. Change counts_per_rev only
-- while `enable` is low. mode, sample_period and angle_step may change at any time (see `sample_trigger`); the present
-- turn then contains samples of both settings.
--
-- **Reading.** The read port reads only the samples of the READY bank. `read_data` is 0 if no bank is READY, and for
-- samples from header_sample_count on.
--
-- **More heads.** With HEADS = 3 or 4 a second memory stores the positions of the other heads in the same clocks; a
-- read with `read_further` high reads head 3 or 4 in place of head 1 or 2. Another unit selects the reference head,
-- whose position replaces that of head 1 for the turns and for the triggers of mode 1: `reference_position` and
-- `reference_zero_moved` belong to the reference head. Sampling then runs while `enable` is high, even if some heads
-- have not seen their index. Change the reference head only while `enable` is low. `header_further_flags` are flags 0
-- to 7 for heads 3 and 4 in place of 1 and 2. With HEADS = 2 this logic is not built.
--
-- **Reset** frees both banks and clears the sequence, `overrun_count` (which wraps) and a pending
-- overrun flag; the memory keeps its words, and the header is undefined until `bank_ready`.

library ieee;
  use ieee.std_logic_1164.all;
  use ieee.numeric_std.all;

  use work.number_formats_pkg.all;
  use work.tolerance_pkg.all;

entity sampler is
  generic (
    DEPTH : positive range 2 to 16384     := CAPTURE_DEPTH_DEFAULT; -- sample pairs per bank
    HEADS : positive range 2 to HEADS_MAX := 2
  );
  port (
    clock               : in    std_ulogic;
    reset               : in    std_ulogic;
    -- Settings
    enable              : in    std_ulogic;
    mode                : in    u_unsigned(1 downto 0);                              -- 0 equal time, 1 equal angle, 2 external
    external            : in    std_ulogic := '0';                                   -- strobe: a sample is requested from outside
    sample_period       : in    u_unsigned(31 downto 0);                             -- clocks
    angle_step          : in    u_unsigned(ANGLE_WIDTH - 1 downto 0);                -- counts
    counts_per_rev      : in    u_unsigned(COUNTS_PER_REV_WIDTH - 1 downto 0);       -- counts
    -- From the decoders
    timestamp           : in    u_unsigned(TIMESTAMP_WIDTH - 1 downto 0);            -- clocks
    turn_position1      : in    u_signed(POSITION_WIDTH - 1 downto 0);               -- counts from the zero, head 1
    turn_position2      : in    u_signed(POSITION_WIDTH - 1 downto 0);               -- counts from the zero, head 2
    zero_moved1         : in    std_ulogic := '0';                                   -- toggles with the first position from another zero
    index_seen1         : in    std_ulogic;                                          -- level
    index_seen2         : in    std_ulogic;                                          -- level
    index_error1        : in    std_ulogic;                                          -- level, sticky in the decoder
    index_error2        : in    std_ulogic;                                          -- level, sticky in the decoder
    illegal1            : in    std_ulogic;                                          -- level, sticky in the decoder
    illegal2            : in    std_ulogic;                                          -- level, sticky in the decoder
    overspeed1          : in    std_ulogic;                                          -- level, sticky in the decoder
    overspeed2          : in    std_ulogic;                                          -- level, sticky in the decoder
    -- From the decoders, with more than two heads
    further_positions    : in    std_ulogic_vector(2 * POSITION_WIDTH - 1 downto 0) := (others => '0'); -- counts, head 4, head 3
    further_flags        : in    std_ulogic_vector(7 downto 0) := (others => '0');                      -- levels, as flags 0 to 7
    reference_position   : in    u_signed(POSITION_WIDTH - 1 downto 0) := (others => '0');              -- counts from the zero
    reference_zero_moved : in    std_ulogic := '0';                                                     -- toggles when the zero moves
    -- To and from the processor
    release_bank        : in    std_ulogic;                                          -- pulse: the READY bank is free again
    capture_ready       : out   std_ulogic;                                          -- pulse: a bank became READY
    capture_overrun     : out   std_ulogic;                                          -- pulse: a turn was dropped
    capture_busy        : out   std_ulogic;                                          -- level: a turn is being captured
    bank_ready          : out   std_ulogic;                                          -- level: a bank belongs to the processor
    ready_bank          : out   std_ulogic;                                          -- number of the READY bank
    header_start_time   : out   u_unsigned(TIMESTAMP_WIDTH - 1 downto 0);            -- clocks
    header_sequence     : out   u_unsigned(31 downto 0);                             -- banks handed over before this one
    header_sample_count : out   u_unsigned(15 downto 0);                             -- sample pairs
    header_flags        : out   std_ulogic_vector(9 downto 0);                       -- see Header
    header_further_flags : out   std_ulogic_vector(7 downto 0);                      -- see More heads
    overrun_count       : out   u_unsigned(15 downto 0);                             -- dropped turns, wraps
    fill_count          : out   u_unsigned(15 downto 0);                             -- sample pairs in the bank being filled
    trigger             : out   std_ulogic;                                          -- one clock after each sample's clock
    -- Read port, READY bank
    read_enable         : in    std_ulogic;                                          -- starts a read
    read_address        : in    u_unsigned(14 downto 0);                             -- sample * 2 + head - 1
    read_further        : in    std_ulogic := '0';                                   -- 1: reads head 3 or 4
    read_valid          : out   std_ulogic;                                          -- 4 clocks after read_enable
    read_data           : out   std_ulogic_vector(POSITION_WIDTH - 1 downto 0)       -- counts
  );
end entity sampler;

architecture rtl of sampler is

  constant HAS_FURTHER : boolean  := HEADS > 2;
  constant FLAG_COUNT  : positive := 8 + 8 * boolean'pos(HAS_FURTHER);

  signal position            : u_signed(POSITION_WIDTH - 1 downto 0);
  signal zero_moved          : std_ulogic;
  signal running             : std_ulogic;
  signal running_then        : std_ulogic := '0';
  signal triggered           : std_ulogic;
  signal position1_then      : u_signed(POSITION_WIDTH - 1 downto 0);
  signal reference_then      : u_signed(POSITION_WIDTH - 1 downto 0);
  signal position2_then      : u_signed(POSITION_WIDTH - 1 downto 0);
  signal timestamp_then      : u_unsigned(TIMESTAMP_WIDTH - 1 downto 0);
  signal flags_then          : std_ulogic_vector(FLAG_COUNT - 1 downto 0);
  -- The positions one turn above and one turn below the first sample, and whether the position has reached one of them
  signal turn_above          : u_signed(POSITION_WIDTH - 1 downto 0) := (others => '0');
  signal turn_below          : u_signed(POSITION_WIDTH - 1 downto 0) := (others => '0');
  signal is_away_then        : std_ulogic := '0';
  signal write_enable        : std_ulogic := '0';
  signal write_address       : u_unsigned(14 downto 0) := (others => '0');
  signal write_data          : std_ulogic_vector(2 * POSITION_WIDTH - 1 downto 0);
  signal memory_read_address : u_unsigned(14 downto 0) := (others => '0');
  signal memory_read_data    : std_ulogic_vector(2 * POSITION_WIDTH - 1 downto 0);
  signal further_then        : std_ulogic_vector(2 * POSITION_WIDTH - 1 downto 0);
  signal further_write_data  : std_ulogic_vector(2 * POSITION_WIDTH - 1 downto 0);
  signal further_read_data   : std_ulogic_vector(2 * POSITION_WIDTH - 1 downto 0);

begin

  position   <= reference_position when HAS_FURTHER else
                turn_position1;
  zero_moved <= reference_zero_moved when HAS_FURTHER else
                zero_moved1;
  running    <= enable when HAS_FURTHER else
                enable and index_seen1 and index_seen2;
  trigger <= triggered;

  when_to_sample : entity work.sample_trigger
    port map (
      clock         => clock,
      reset         => reset,
      enable        => running,
      mode          => mode,
      external      => external,
      sample_period => sample_period,
      angle_step    => angle_step,
      turn_position => position,
      zero_moved    => zero_moved,
      trigger       => triggered
    );

  -- The trigger comes one clock after the clock to which it belongs, so all values that it latches are delayed by one
  -- clock too.
  align : process (clock) is

    -- The signs of these differences replace comparisons, because they stay correct across the wrap of turn_position.
    variable above : u_signed(POSITION_WIDTH - 1 downto 0);
    variable below : u_signed(POSITION_WIDTH - 1 downto 0);

  begin

    if rising_edge(clock) then
      above          := position - turn_above;
      below          := turn_below - position;
      is_away_then   <= not above(above'high) or not below(below'high);
      running_then   <= running and not reset;
      position1_then <= turn_position1;
      position2_then <= turn_position2;
      reference_then <= position;
      further_then   <= further_positions;
      timestamp_then <= timestamp;
      flags_then(7 downto 0) <= overspeed2 & overspeed1 & illegal2 & illegal1
                                & index_error2 & index_error1 & index_seen2 & index_seen1;
      if HAS_FURTHER then
        flags_then(FLAG_COUNT - 1 downto FLAG_COUNT - 8) <= further_flags;
      end if;
    end if;

  end process align;

  fill : process (clock) is

    variable first         : std_ulogic := '1';                                      -- the next sample starts a turn
    variable filling_bank  : std_ulogic := '0';
    variable samples       : u_unsigned(14 downto 0) := (others => '0');
    variable first_before  : std_ulogic := '1';                                      -- `first`, one clock ago
    -- Values for the next clock. was_judged: turn_above and turn_below have belonged to this turn for a clock. is_last:
    -- the next sample fills the bank.
    variable was_judged    : std_ulogic := '0';
    variable is_last       : std_ulogic := '0';
    variable is_before     : std_ulogic; -- high if the sample after the next fills the bank
    variable start_time    : u_unsigned(TIMESTAMP_WIDTH - 1 downto 0);
    variable flags         : std_ulogic_vector(FLAG_COUNT - 1 downto 0);
    variable closed        : std_ulogic;
    variable handed_over   : u_unsigned(31 downto 0) := (others => '0');
    variable owned         : std_ulogic := '0';
    variable handing_over  : std_ulogic := '0';
    variable overrun       : std_ulogic := '0';
    variable overrun_total : u_unsigned(15 downto 0) := (others => '0');

  begin

    if rising_edge(clock) then
      if release_bank = '1' then
        owned := '0';
      end if;

      -- The bank becomes READY one clock after its last word was written, so that a READY bank is never written.
      capture_ready   <= handing_over;
      owned           := owned or handing_over;
      handing_over    := '0';
      capture_overrun <= '0';

      -- While no turn has started, set the values that belong to the first sample of the next turn.
      if first = '1' then
        flags      := (others => '0');
        start_time := timestamp_then;
        turn_above <= reference_then + signed(resize(counts_per_rev, POSITION_WIDTH));
        turn_below <= reference_then - signed(resize(counts_per_rev, POSITION_WIDTH));
      end if;
      if first = '0' or triggered = '1' then
        flags := flags or flags_then;
      end if;

      first_before := first;
      is_before    := samples ?= DEPTH - 2;

      write_enable  <= '0';
      write_address <= samples;
      if filling_bank = '1' then
        write_address <= samples + DEPTH;
      end if;
      write_data    <= std_ulogic_vector(position2_then) & std_ulogic_vector(position1_then);
      further_write_data <= further_then;

      -- A trigger always belongs to a clock in which sampling was enabled.
      if triggered = '1' then
        write_enable <= '1';
        closed       := was_judged and is_away_then;
        samples      := samples + 1;
        first        := '0';
        if closed = '1' or is_last = '1' then
          if owned = '1' then
            overrun         := '1';
            overrun_total   := overrun_total + 1;
            capture_overrun <= '1';
          else
            handing_over        := '1';
            ready_bank          <= filling_bank;
            header_start_time   <= start_time;
            header_sequence     <= handed_over;
            header_sample_count <= resize(samples, 16);
            header_flags        <= '0' & overrun & flags(7 downto 0);
            header_flags(9)     <= not closed;
            header_further_flags <= flags(FLAG_COUNT - 1 downto FLAG_COUNT - 8) when HAS_FURTHER else (others => '0');
            overrun      := '0';
            handed_over  := handed_over + 1;
            filling_bank := not filling_bank;
          end if;
          first := '1';
        end if;
        is_last := is_before;
      end if;

      if running_then = '0' then
        first := '1';
      end if;

      if reset = '1' then
        first         := '1';
        filling_bank  := '0';
        handed_over   := (others => '0');
        owned         := '0';
        handing_over  := '0';
        overrun       := '0';
        overrun_total := (others => '0');
        ready_bank    <= '0';
        write_enable    <= '0';
        capture_ready   <= '0';
        capture_overrun <= '0';
      end if;

      if first = '1' then
        samples := (others => '0');
        is_last := '0';
      end if;
      was_judged := not first and not first_before;

      bank_ready    <= owned;
      capture_busy  <= not first;
      overrun_count <= overrun_total;
      fill_count    <= resize(samples, 16);
    end if;

  end process fill;

  banks : entity work.capture_memory
    generic map (
      DEPTH => DEPTH
    )
    port map (
      clock         => clock,
      write_enable  => write_enable,
      write_address => write_address,
      write_data    => write_data,
      read_address  => memory_read_address,
      read_data     => memory_read_data
    );

  further_heads : if HAS_FURTHER generate

    further_banks : entity work.capture_memory
      generic map (
        DEPTH => DEPTH
      )
      port map (
        clock         => clock,
        write_enable  => write_enable,
        write_address => write_address,
        write_data    => further_write_data,
        read_address  => memory_read_address,
        read_data     => further_read_data
      );

  else generate
    further_read_data <= (others => '0');
  end generate further_heads;

  read_ready_bank : process (clock) is

    variable enables  : std_ulogic_vector(3 downto 0) := (others => '0');
    variable readable : std_ulogic_vector(2 downto 0) := (others => '0');
    variable seconds  : std_ulogic_vector(2 downto 0) := (others => '0');
    variable further  : std_ulogic_vector(2 downto 0) := (others => '0');
    variable pair     : std_ulogic_vector(2 * POSITION_WIDTH - 1 downto 0);
    variable sample   : u_unsigned(14 downto 0);
    variable is_inside : boolean;

  begin

    if rising_edge(clock) then
      pair := memory_read_data;
      if HAS_FURTHER and further(2) = '1' then
        pair := further_read_data;
      end if;
      if readable(2) = '0' then
        read_data <= (others => '0');
      elsif seconds(2) = '0' then
        read_data <= pair(POSITION_WIDTH - 1 downto 0);
      else
        read_data <= pair(2 * POSITION_WIDTH - 1 downto POSITION_WIDTH);
      end if;

      enables  := enables(2 downto 0) & read_enable;
      seconds  := seconds(1 downto 0) & read_address(0);
      further  := further(1 downto 0) & read_further;
      readable := readable(1 downto 0) & '0';
      sample   := resize(read_address(14 downto 1), 15);

      if bank_ready = '1' and sample < header_sample_count then
        readable(0) := '1';
      end if;

      -- If no read is in progress, any valid address may be applied.
      memory_read_address <= (others => '0');
      is_inside           := is_at_most(sample, DEPTH - 1);
      if is_inside and ready_bank = '1' then
        memory_read_address <= sample + DEPTH;
      elsif is_inside then
        memory_read_address <= sample;
      end if;

      read_valid <= enables(3);

      if reset = '1' then
        enables    := (others => '0');
        read_valid <= '0';
      end if;
    end if;

  end process read_ready_bank;

end architecture rtl;
