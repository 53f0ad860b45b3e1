-- SPDX-License-Identifier: Apache-2.0
--
-- # head_mean
--
-- Outputs two values from which the pipeline computes the corrected mean of the heads: the reading of the carrier (the
-- head that is chosen at run time) minus the whole counts of its offset, and the term that turns this reading into the
-- mean (weighted_mean). The words of the mean (mean_words) are swapped together with the coefficients of the lanes.
--
-- **Position.** The count of the output continues when the carrier changes: `position` is the carrier's position plus a
-- base. With the first angle of a new set of words, `position` and angle jump by the same number of counts, the shorter
-- way round. `jump` is this number; the ramp uses it to absorb the jump, so that the corrected position makes no step.
-- With two heads `jump` includes the counts that are put back for the new carrier exactly with this first angle; with
-- more heads no zero moves with this angle. A jump beyond ±32,767 counts comes from a head that was never set up;
-- `position` then jumps only by this limit, and from then on differs from the angle by the remainder, until the next
-- reset.
--
-- **Zero.** `zero_moved` toggles when the zero of a head moves, because each head's zero moves the mean; the ramp
-- absorbs this change. If the zeros of several heads move in the same clock, it toggles once. `put_back` is the value
-- of the carrier, because `position` continues the carrier's count.
--
-- **Apply.** `apply` is high while the processor requests the correction and the carrier and every used head have seen
-- their index. `referenced` is high while the carrier has seen its index.
--
-- **Swap.** `may_swap` goes low when a bit of `zeros_moved` or `indices_seen` changes, a word is written, the words are
-- swapped, or `unsettle` is high. It stays low for 8 more clocks, so that the base of the next carrier is computed from
-- readings after this change.
--
-- **Latency.** Angle, position and the values that belong to them follow the heads by 0 clocks with two heads, and with
-- more heads by 1 clock, in which the offsets are subtracted. `mean_term`, `limited`, `jumped` and `jump` follow the
-- angle by MEAN_LATENCY clocks.
--
-- **Number formats.** angles u24.0 counts below counts_per_rev; positions s31.0 counts modulo 2³²; put_backs s15.0
-- counts modulo 2¹⁶; mean_term s19.20 counts; differences s16.4 counts, 5 clocks after the angle; jump s15.0 counts.
-- Flat ports carry head 1 in the low bits.
--
-- **Reset** sets the base to 0. The words keep their values.

library ieee;
  use ieee.std_logic_1164.all;
  use ieee.numeric_std.all;

  use work.number_formats_pkg.all;

entity head_mean is
  generic (
    HEADS : positive range 2 to HEADS_MAX := 2
  );
  port (
    clock             : in    std_ulogic;
    reset             : in    std_ulogic;
    -- The heads
    angles            : in    std_ulogic_vector(HEADS * ANGLE_WIDTH - 1 downto 0);          -- counts, below counts_per_rev
    positions         : in    std_ulogic_vector(HEADS * POSITION_WIDTH - 1 downto 0);       -- counts, including counts put back
    phases_of_zero    : in    std_ulogic_vector(HEADS * 2 - 1 downto 0);                    -- index of (A, B) in 00 10 11 01 at position 0
    put_backs         : in    std_ulogic_vector(HEADS * 16 - 1 downto 0);                   -- counts in position without an edge
    zeros_moved       : in    std_ulogic_vector(HEADS - 1 downto 0);                        -- toggles when the zero of a head moves
    indices_seen      : in    std_ulogic_vector(HEADS - 1 downto 0);                        -- level
    unsettle          : in    std_ulogic;                                                   -- level: angles start anew, no swap is allowed
    counts_per_rev    : in    u_unsigned(COUNTS_PER_REV_WIDTH - 1 downto 0);                -- counts
    compensate        : in    std_ulogic;                                                   -- level: the processor requests the correction
    -- The words, see mean_words
    write_enable      : in    std_ulogic;                                                   -- pulse
    write_address     : in    u_unsigned(3 downto 0);                                       -- number of the word
    write_data        : in    std_ulogic_vector(31 downto 0);                               -- the word
    write_acknowledge : out   std_ulogic;                                                   -- pulse: the word is written
    hold_writes       : in    std_ulogic;                                                   -- level: a swap is requested or waits
    read_address      : in    u_unsigned(3 downto 0);                                       -- number of the word
    read_data         : out   std_ulogic_vector(31 downto 0);                               -- the idle word, one clock later
    swap_comes        : in    std_ulogic;                                                   -- pulse: the next clock has the idle words
    may_swap          : out   std_ulogic;                                                   -- level: a swap is allowed
    -- To the pipeline
    angle             : out   u_unsigned(ANGLE_WIDTH - 1 downto 0);                         -- counts, below counts_per_rev
    position          : out   u_signed(POSITION_WIDTH - 1 downto 0);                        -- counts
    phase_of_zero     : out   u_unsigned(1 downto 0);                                       -- index of (A, B) in 00 10 11 01 at position 0
    put_back          : out   u_signed(15 downto 0);                                        -- counts in position without an edge
    zero_moved        : out   std_ulogic;                                                   -- toggles when the zero of a head moves
    referenced        : out   std_ulogic;                                                   -- level: the angle counts from an index
    apply             : out   std_ulogic;                                                   -- level: this reading is to be corrected
    carrier           : out   u_unsigned(1 downto 0);                                       -- number of the head - 1
    used              : out   std_ulogic_vector(HEADS - 1 downto 0);                        -- heads that the active words use
    idle_used         : out   std_ulogic_vector(HEADS - 1 downto 0);                        -- heads that the idle words use
    idle_carrier_used : out   std_ulogic;                                                   -- level: the idle words' carrier is a used head
    differences       : out   std_ulogic_vector(HEADS * HEAD_DIFFERENCE_WIDTH - 1 downto 0); -- counts, s16.4, reading - carrier's
    mean_term         : out   u_signed(MEAN_TERM_WIDTH - 1 downto 0);                       -- counts, s19.20
    limited           : out   std_ulogic;                                                   -- level: a difference in this term is limited
    jumped            : out   std_ulogic;                                                   -- pulse: the first angle of new words
    jump              : out   u_signed(15 downto 0)                                         -- counts of the jump, valid with jumped
  );
end entity head_mean;

architecture rtl of head_mean is

  constant WORDS_WIDTH   : positive := HEADS * (HEAD_OFFSET_WIDTH + HEAD_WEIGHT_WIDTH + 1) + 2;
  constant WEIGHTS_FIRST : positive := HEADS * HEAD_OFFSET_WIDTH;
  constant USED_FIRST    : positive := WEIGHTS_FIRST + HEADS * HEAD_WEIGHT_WIDTH;
  constant CARRIER_FIRST : positive := USED_FIRST + HEADS;
  -- With two heads the offsets are subtracted without a register; with more heads, the subtraction takes a clock.
  constant HAS_CLOCK     : boolean  := HEADS > 2;
  constant JUMP_CLOCKS   : positive := DIFFERENCE_LATENCY + 1;
  constant SETTLE_CLOCKS : positive := 8;

  subtype position_count is u_signed(POSITION_WIDTH - 1 downto 0);

  subtype mean_set is std_ulogic_vector(WORDS_WIDTH - 1 downto 0);

  subtype jump_count is u_signed(15 downto 0);

  type position_counts is array (1 to JUMP_CLOCKS) of position_count;

  -- Returns word `place` of a vector of words of equal width, or the first word if `place` is not below HEADS.
  function word_at (
    words : std_ulogic_vector;
    place : u_unsigned(1 downto 0);
    width : positive
  ) return std_ulogic_vector is

    variable side_by_side : std_ulogic_vector(words'length - 1 downto 0);
    variable chosen       : std_ulogic_vector(width - 1 downto 0);

  begin

    side_by_side := words;
    chosen       := side_by_side(width - 1 downto 0);

    for head in 1 to HEADS - 1 loop
      if place = head then
        chosen := side_by_side((head + 1) * width - 1 downto head * width);
      end if;
    end loop;

    return chosen;

  end function word_at;

  -- Returns an angle minus the whole counts of an offset, modulo a turn.
  function whole_reading (
    reading : std_ulogic_vector;
    offset  : std_ulogic_vector;
    turn    : u_unsigned
  ) return std_ulogic_vector is

    alias    offset_word : std_ulogic_vector(HEAD_OFFSET_WIDTH - 1 downto 0) is offset;
    variable whole       : u_unsigned(ANGLE_WIDTH downto 0);
    variable straight    : u_unsigned(ANGLE_WIDTH downto 0);
    variable more        : u_unsigned(ANGLE_WIDTH downto 0);

  begin

    whole    := '0' & u_unsigned(offset_word(HEAD_OFFSET_WIDTH - 1 downto HEAD_OFFSET_FRACTION));
    straight := ('0' & u_unsigned(reading)) - whole;
    more     := straight + turn;
    if straight(straight'high) = '1' then
      return std_ulogic_vector(more(ANGLE_WIDTH - 1 downto 0));
    end if;
    return std_ulogic_vector(straight(ANGLE_WIDTH - 1 downto 0));

  end function whole_reading;

  signal active_words : mean_set;
  signal idle_words   : mean_set;
  signal next_words   : mean_set;
  signal words_met    : mean_set;
  signal is_written   : std_ulogic;
  signal this_head    : u_unsigned(1 downto 0);
  signal next_head    : u_unsigned(1 downto 0);

  -- Readings minus their offsets: of all heads with the words in force, and of the idle words' carrier with the idle
  -- words
  signal wholes     : std_ulogic_vector(HEADS * ANGLE_WIDTH - 1 downto 0);
  signal whole_next : std_ulogic_vector(ANGLE_WIDTH - 1 downto 0);

  -- The readings and the heads' other values in the clock of the output angle
  signal wholes_now     : std_ulogic_vector(wholes'range)         := (others => '0');
  signal whole_next_now : std_ulogic_vector(whole_next'range)     := (others => '0');
  signal positions_now  : std_ulogic_vector(positions'range)      := (others => '0');
  signal phases_now     : std_ulogic_vector(phases_of_zero'range) := (others => '0');
  signal put_backs_now  : std_ulogic_vector(put_backs'range)      := (others => '0');
  signal zeros_now      : std_ulogic_vector(zeros_moved'range)    := (others => '0');
  signal seen_now       : std_ulogic_vector(indices_seen'range)   := (others => '0');
  signal compensate_now : std_ulogic                              := '0';
  signal zeros_before   : std_ulogic_vector(zeros_moved'range)    := (others => '0');
  signal seen_before    : std_ulogic_vector(indices_seen'range)   := (others => '0');
  -- The heads' toggles and zero_moved in the clock before
  signal zeros_last : std_ulogic_vector(zeros_moved'range) := (others => '0');
  signal moved_last : std_ulogic                           := '0';
  -- The counts put back in the clock before, and swap_comes of the clock before
  signal put_backs_last : std_ulogic_vector(put_backs'range) := (others => '0');
  signal is_first       : std_ulogic                         := '0';

  signal fractions   : std_ulogic_vector(HEADS * HEAD_OFFSET_FRACTION - 1 downto 0);
  signal own_count   : position_count;
  signal next_count  : position_count;
  signal base        : position_count         := (others => '0');
  signal next_base   : position_count         := (others => '0');
  signal phase_shift : u_unsigned(1 downto 0) := "00";
  signal to_next     : u_signed(ANGLE_WIDTH downto 0);
  signal unsettled   : std_ulogic;
  signal is_settled  : std_ulogic             := '0';

begin

  swapped_words : entity work.mean_words
    generic map (
      HEADS => HEADS
    )
    port map (
      clock             => clock,
      reset             => reset,
      write_enable      => write_enable,
      write_address     => write_address,
      write_data        => write_data,
      write_acknowledge => write_acknowledge,
      hold_writes       => hold_writes,
      read_address      => read_address,
      read_data         => read_data,
      swap_comes        => swap_comes,
      is_written        => is_written,
      active_words      => active_words,
      idle_words        => idle_words,
      next_words        => next_words
    );

  -- If a register follows the subtraction of the offsets, the words are needed one clock earlier.
  words_met <= next_words when HAS_CLOCK else
               active_words;
  this_head <= u_unsigned(active_words(CARRIER_FIRST + 1 downto CARRIER_FIRST));
  next_head <= u_unsigned(idle_words(CARRIER_FIRST + 1 downto CARRIER_FIRST));
  used      <= active_words(CARRIER_FIRST - 1 downto USED_FIRST);
  carrier   <= this_head;
  idle_used <= idle_words(CARRIER_FIRST - 1 downto USED_FIRST);
  idle_carrier_used <= word_at(idle_words(CARRIER_FIRST - 1 downto USED_FIRST), next_head, 1)(0);

  every_head : for head in 0 to HEADS - 1 generate

    wholes((head + 1) * ANGLE_WIDTH - 1 downto head * ANGLE_WIDTH) <= whole_reading(
      angles((head + 1) * ANGLE_WIDTH - 1 downto head * ANGLE_WIDTH),
      words_met((head + 1) * HEAD_OFFSET_WIDTH - 1 downto head * HEAD_OFFSET_WIDTH),
      counts_per_rev
    );

    fractions((head + 1) * HEAD_OFFSET_FRACTION - 1 downto head * HEAD_OFFSET_FRACTION)
    <= active_words(head * HEAD_OFFSET_WIDTH + HEAD_OFFSET_FRACTION - 1 downto head * HEAD_OFFSET_WIDTH);

  end generate every_head;

  whole_next <= whole_reading(
    word_at(angles, next_head, ANGLE_WIDTH),
    word_at(idle_words(WEIGHTS_FIRST - 1 downto 0), next_head, HEAD_OFFSET_WIDTH),
    counts_per_rev
  );

  own_clock : if HAS_CLOCK generate

    hold : process (clock) is
    begin

      if rising_edge(clock) then
        wholes_now     <= wholes;
        whole_next_now <= whole_next;
        positions_now  <= positions;
        phases_now     <= phases_of_zero;
        put_backs_now  <= put_backs;
        zeros_now      <= zeros_moved;
        seen_now       <= indices_seen;
        compensate_now <= compensate;
        if reset = '1' then
          compensate_now <= '0';
        end if;
      end if;

    end process hold;

  else generate
    wholes_now     <= wholes;
    whole_next_now <= whole_next;
    positions_now  <= positions;
    phases_now     <= phases_of_zero;
    put_backs_now  <= put_backs;
    zeros_now      <= zeros_moved;
    seen_now       <= indices_seen;
    compensate_now <= compensate;
  end generate own_clock;

  own_count     <= u_signed(word_at(positions_now, this_head, POSITION_WIDTH));
  next_count    <= u_signed(word_at(positions_now, next_head, POSITION_WIDTH));
  angle         <= u_unsigned(word_at(wholes_now, this_head, ANGLE_WIDTH));
  position      <= own_count + base;
  phase_of_zero <= u_unsigned(word_at(phases_now, this_head, 2)) - u_unsigned(base(1 downto 0)) + phase_shift;
  put_back      <= u_signed(word_at(put_backs_now, this_head, 16));
  -- Zeros of several heads that move in the same clock toggle zero_moved once.
  zero_moved    <= moved_last xor (or (zeros_now xor zeros_last));
  referenced    <= word_at(seen_now, this_head, 1)(0);
  apply         <= compensate_now and (and (seen_now or not used)) and word_at(seen_now, this_head, 1)(0);

  term : entity work.weighted_mean
    generic map (
      HEADS => HEADS
    )
    port map (
      clock            => clock,
      readings         => wholes_now,
      carrier_reading  => angle,
      fractions        => fractions,
      carrier_fraction => u_unsigned(word_at(fractions, this_head, HEAD_OFFSET_FRACTION)),
      weights          => active_words(USED_FIRST - 1 downto WEIGHTS_FIRST),
      used             => used,
      counts_per_rev   => counts_per_rev,
      fine_differences => differences,
      mean_term        => mean_term,
      limited          => limited
    );

  way_to_next : entity work.turn_difference
    port map (
      clock          => clock,
      minuend        => u_unsigned(whole_next_now),
      subtrahend     => angle,
      counts_per_rev => counts_per_rev,
      difference     => to_next
    );

  unsettled <= (or (zeros_moved xor zeros_before)) or (or (indices_seen xor seen_before)) or is_written or unsettle;

  carry_on : process (clock) is

    type jump_counts is array (JUMP_CLOCKS + 1 to MEAN_LATENCY + 1) of jump_count;

    -- Registers; the number in a name is the number of clocks from the readings until the register is valid.
    variable count_1_to_4   : position_counts                               := (others => (others => '0'));
    variable jump_4         : jump_count                                    := (others => '0');
    variable jump_5_to_11   : jump_counts                                   := (others => (others => '0'));
    variable jumped_1_to_11 : std_ulogic_vector(1 to MEAN_LATENCY + 1)      := (others => '0');
    variable settling       : natural range 0 to SETTLE_CLOCKS              := SETTLE_CLOCKS;
    -- Counts that were put back for the carrier with the first angle of its words; valid until the next swap
    variable put_back_late  : jump_count                                    := (others => '0');
    variable sign           : std_ulogic;

  begin

    if rising_edge(clock) then
      -- The jump belongs to the first angle of the new words, one clock after swap_comes; it is output MEAN_LATENCY
      -- clocks later.
      jump_5_to_11   := (jump_4 + put_back_late) & jump_5_to_11(JUMP_CLOCKS + 1 to MEAN_LATENCY);
      jump           <= jump_5_to_11(MEAN_LATENCY + 1);
      jumped_1_to_11 := swap_comes & jumped_1_to_11(1 to MEAN_LATENCY);
      jumped         <= jumped_1_to_11(MEAN_LATENCY + 1);

      next_base <= base + count_1_to_4(JUMP_CLOCKS) + resize(jump_4, POSITION_WIDTH);

      -- If the bits above the format are not copies of the sign, the jump is limited to +32,767 or -32,767.
      sign   := to_next(to_next'high);
      jump_4 := to_next(jump_4'range);
      if (or (to_next(to_next'high downto jump_4'high) xor (to_next'high downto jump_4'high => sign))) = '1' then
        jump_4    := (others => not sign);
        jump_4(0) := '1';
        jump_4(jump_4'high) := sign;
      end if;
      count_1_to_4 := (own_count - next_count) & count_1_to_4(1 to JUMP_CLOCKS - 1);

      -- may_swap ensures that no zero moves up to the clock of swap_comes. With more than two heads the readings are a
      -- clock older, so no zero moves with the first angle either.
      if is_first = '1' and not HAS_CLOCK then
        put_back_late := put_back - jump_count'(u_signed(word_at(put_backs_last, this_head, 16)));
      end if;
      put_backs_last <= put_backs_now;
      is_first       <= swap_comes;

      if swap_comes = '1' then
        base        <= next_base;
        phase_shift <= phase_of_zero - (u_unsigned(word_at(phases_now, next_head, 2)) - u_unsigned(next_base(1 downto 0)));
      end if;

      if unsettled = '1' or swap_comes = '1' then
        settling := SETTLE_CLOCKS;
      elsif settling > 0 then
        settling := settling - 1;
      end if;
      is_settled   <= '1' when settling = 0 else '0';
      zeros_last   <= zeros_now;
      moved_last   <= zero_moved;
      zeros_before <= zeros_moved;
      seen_before  <= indices_seen;

      if reset = '1' then
        base        <= (others => '0');
        phase_shift <= "00";
        settling    := SETTLE_CLOCKS;
        is_settled  <= '0';
        moved_last  <= '0';
        is_first    <= '0';
        jumped_1_to_11 := (others => '0');
      end if;
    end if;

  end process carry_on;

  may_swap <= is_settled and not unsettled;

end architecture rtl;
