-- SPDX-License-Identifier: Apache-2.0
--
-- # compensation_pipeline
--
-- Computes the compensated reading of equations (8) and (9) from the reading of head 1, or of the carrier of the mean
-- (the head whose reading enters the pipeline). It consists of coefficient_memory, phase_unit, harmonic_unit, the
-- delay_line for the reading, and error_compensation with the correction_ramp. Section 3.3 and figure 7 of the paper
-- describe it.
--
-- **Latency.** 29 clocks from `angle` and `position` to all outputs, one angle per clock: phase 5,
-- harmonics 20, compensation 4 (Table 1 of the paper). The delay line takes 25 clocks, as many as phase and harmonics
-- together.
--
-- **Folding.** FOLD lanes share one phase lane and one harmonic lane: LANES / FOLD of each are built, and an angle is
-- accepted every FOLD clocks, when `accept` is high. The blocks of lanes process this angle one after the other, one
-- block per clock. The corrected reading appears PIPELINE_LATENCY + FOLD - 1 clocks after its angle was
-- accepted. Until the next corrected reading, FOLD clocks later, only the ramp changes this output; so the reading to
-- which the output belongs is at most 29 + 2 * (FOLD - 1) clocks old. The sums are exact, so every FOLD gives the same
-- correction of an angle; with a cosine of more than 18 bits this requires an even LANES / FOLD. If the position moves
-- faster than one count in FOLD clocks, the corrected position makes steps of 2 to FOLD counts; quadrature_output sends
-- these counts at least `minimum_spacing` clocks apart. Below this speed (clock / FOLD counts per second: 12.5 million
-- for FOLD = 8 at 100 MHz) the pipeline reads every count, but 0 to FOLD - 1 clocks later than with FOLD = 1. Therefore
-- counts that come at equal distances leave with a jitter of FOLD - 1 clocks, and their distances are multiples of FOLD
-- clocks. With FOLD = 8 a motion of one count in 11 clocks gives edges 8 or 16 clocks apart. FOLD = 1 is the paper's
-- fully parallel form.
--
-- **Rotation.** With ROTATION = table the lanes find their cosine in a table (table_rotation) instead of by CORDIC:
-- latency and formats do not change; the last bits of the cosine differ.
--
-- **Apply.** Hold `apply` high while the reading is to be corrected, that is while the compensation is switched on and
-- the head (with the mean: the carrier and every used head) has seen its index. `apply` belongs to the angle of its
-- clock and travels with this angle. While `apply` is low, 0 replaces ε; a change of `apply` starts the ramp, so the
-- output makes no step. A swap starts the ramp too.
--
-- **Referenced.** `referenced` is high if the angle in the same clock counts from an index mark. It travels with the
-- angle and leaves as `corrected_referenced`, so that quadrature_output gives no Z for an angle without a zero.
--
-- **Put back.** `position` contains `put_back` counts, which replace the counts that head 1 (or the carrier) lost. A
-- change of `zero_moved` marks the first angle from another zero. `put_back` and `zero_moved` travel with the angle,
-- and the change of the correction decays at the ramp rate. With FOLD > 1, `zero_moved` may toggle in any clock, also
-- several times between two accepted angles: the next accepted angle then counts from another zero.
--
-- **Mean.** With MEAN, `angle` and `position` belong to the carrier; `mean_term`, `jumped` and `jump` must come
-- MEAN_LATENCY clocks after the reading to which they belong, as head_mean gives them. `swap_comes` is high in the
-- clock before the first angle of a new bank.
--
-- **Modulators.** With MODULATORS the amplitude of a lane can follow the direction, the speed or a word of the
-- processor (coefficient_memory).
--
-- **Local table.** With LOCAL_TABLE the value of a table over the turn, or over windows of the turn, is added to ε
-- (local_table_banks); a swap changes this table only if its word `choice` was written before.
--
-- **Real orders.** With REAL_ORDERS the phase of a lane continues from turn to turn by its turn step: turn_counter
-- counts the turns of the angle, and turn_offset_sweep prepares the phase offsets of the present turn and of the turns
-- next to it.
--
-- **Coefficients.** The header of coefficient_memory describes how they are written and swapped. The new bank applies
-- to the angle in the clock after `swap` and later, or with FOLD > 1 from the next accepted angle on. A swap waits
-- while the idle bank is filled after the previous swap, and until a write in progress has ended.
--
-- **Number formats.** angle u24.0 counts below counts_per_rev; position s31.0 counts, wraps modulo 2³²; correction
-- s19.11 counts; ramp_rate u8.24 in 2⁻¹¹ count per clock.
--
-- **Reset** sets the correction to 0, ends the ramp and drops a pending write. The banks keep their values, and the
-- pipeline still outputs the angles that it contains. While `counts_per_rev` changes, all angles in the pipeline must
-- be below the old and the new value; phase steps are valid only for the counts_per_rev for which they were computed.

library ieee;
  use ieee.std_logic_1164.all;
  use ieee.numeric_std.all;

  use work.conditions_pkg.all;
  use work.number_formats_pkg.all;

entity compensation_pipeline is
  generic (
    LANES        : positive range 1 to LANES_MAX := LANES_DEFAULT;
    COSINE_WIDTH : positive                      := work.number_formats_pkg.COSINE_WIDTH;
    FOLD         : positive range 1 to 8         := 1;       -- number of lanes that share a pipeline: 1, 2, 4 or 8
    MEAN         : boolean                       := false;   -- the mean of the heads is corrected
    ROTATION     : string                        := "cordic"; -- or "table": method of computing the cosine
    MODULATORS   : boolean                       := false;   -- amplitudes can follow motion or a processor word
    LOCAL_TABLE  : boolean                       := false;   -- a table corrects errors that a sum of orders cannot represent
    REAL_ORDERS  : boolean                       := false    -- the order of a lane need not be an integer
  );
  port (
    clock              : in    std_ulogic;
    reset              : in    std_ulogic;
    accept             : out   std_ulogic;                                    -- high if the reading of this clock is accepted
    angle              : in    u_unsigned(ANGLE_WIDTH - 1 downto 0);          -- counts, below counts_per_rev
    position           : in    u_signed(POSITION_WIDTH - 1 downto 0);         -- counts
    apply              : in    std_ulogic;                                    -- high: correct this reading
    zero_moved         : in    std_ulogic             := '0';                 -- toggles with the first angle from another zero
    put_back           : in    u_signed(15 downto 0)  := (others => '0');     -- counts put back for lost counts, modulo 2¹⁶
    referenced         : in    std_ulogic;                                    -- high if this angle counts from an index
    mean_term          : in    u_signed(MEAN_TERM_WIDTH - 1 downto 0) := (others => '0'); -- counts, s19.20
    jumped             : in    std_ulogic             := '0';                 -- high with the first angle of new mean words
    jump               : in    u_signed(15 downto 0)  := (others => '0');     -- counts, jump of the reading with this angle
    counts_per_rev     : in    u_unsigned(COUNTS_PER_REV_WIDTH - 1 downto 0); -- counts
    ramp_rate          : in    u_unsigned(31 downto 0);                       -- 2⁻¹¹ count per clock, u8.24
    ramp_acceleration  : in    u_unsigned(31 downto 0) := (others => '0');    -- 2⁻⁵⁹ count per clock², 0: no limit
    write_enable       : in    std_ulogic;                                    -- pulse: write a word of a lane
    write_offset       : in    std_ulogic;                                    -- pulse: write the offset
    write_address      : in    u_unsigned(7 downto 0);                        -- lane * 4 + word
    write_data         : in    std_ulogic_vector(31 downto 0);                -- the word
    write_acknowledge  : out   std_ulogic;                                    -- pulse: the word is written
    read_address       : in    u_unsigned(7 downto 0);                        -- lane * 4 + word
    read_data          : out   std_ulogic_vector(31 downto 0);                -- word of the idle bank, 2 clocks later
    idle_offset        : out   u_signed(AMPLITUDE_WIDTH - 1 downto 0);        -- counts, s13.11, the offset in the idle bank
    swap               : in    std_ulogic;                                    -- pulse: the idle bank becomes active
    swap_allowed       : in    std_ulogic := '1';                             -- high if the next angle may be the first of a new bank
    swap_comes         : out   std_ulogic;                                    -- high if the next angle is the first of a new bank
    swap_busy          : out   std_ulogic;                                    -- level: a swap waits, or the idle bank is being filled
    sweep_step         : in    u_unsigned(7 downto 0) := (others => '0');     -- see amplitude_sweep
    direction          : in    modulator              := (others => '0');     -- s1.16
    speed              : in    modulator              := (others => '0');     -- s1.16
    idle_speed         : in    modulator              := (others => '0');     -- s1.16, for the idle bank
    word_a             : in    modulator              := (others => '0');     -- s1.16
    word_b             : in    modulator              := (others => '0');     -- s1.16
    speed_squared      : out   modulator;                                     -- s1.16, as the lanes use it
    write_turn_step    : in    std_ulogic             := '0';                 -- pulse: write a word of a turn step, lane * 2 + word
    read_turn_step     : in    std_ulogic             := '0';                 -- read_address is the address of a turn step
    turn               : out   u_signed(TURN_NUMBER_WIDTH - 1 downto 0);      -- turns, two clocks after the angle to which it belongs
    local_read         : in    std_ulogic             := '0';                 -- pulse: read a word of the local table
    local_write        : in    std_ulogic             := '0';                 -- pulse: write a word of the local table
    local_of_place     : in    std_ulogic             := '0';                 -- high if the word belongs to the place of the windows
    local_address      : in    u_unsigned(LOCAL_INDEX_WIDTH - 1 downto 0) := (others => '0'); -- number of the word
    local_data         : in    std_ulogic_vector(31 downto 0) := (others => '0'); -- the word
    local_done         : out   std_ulogic;                                    -- pulse: the word is read or written
    local_answer       : out   std_ulogic_vector(31 downto 0);                -- word of the idle bank, valid with local_done
    corrected_angle    : out   u_unsigned(ANGLE_WIDTH - 1 downto 0);          -- counts
    corrected_position : out   u_signed(POSITION_WIDTH - 1 downto 0);         -- counts
    corrected_referenced : out   std_ulogic;                                    -- high if corrected_angle counts from an index
    correction         : out   u_signed(CORRECTION_WIDTH - 1 downto 0);       -- counts, s19.11
    correction_limited : out   std_ulogic;                                    -- high if the correction of this output was clipped
    ramp_busy          : out   std_ulogic;                                    -- high if the ramp had not ended at this output
    swap_done          : out   std_ulogic                                     -- strobe: the first output of a new bank
  );
end entity compensation_pipeline;

architecture rtl of compensation_pipeline is

  -- Returns the number of lanes in one block. Raises an error if FOLD, LANES / FOLD or ROTATION is not allowed.
  function built_lanes return positive is
  begin

    assert FOLD = 1 or FOLD = 2 or FOLD = 4 or FOLD = 8
      report "compensation_pipeline: FOLD is " & integer'image(FOLD) & "; expected 1, 2, 4 or 8"
      severity failure;
    assert LANES mod FOLD = 0
      report "compensation_pipeline: LANES = " & integer'image(LANES) & " is not a multiple of FOLD = "
             & integer'image(FOLD) & "; choose another number of lanes, or a smaller FOLD"
      severity failure;
    assert FOLD = 1 or COSINE_WIDTH <= 18 or (LANES / FOLD) mod 2 = 0
      report "compensation_pipeline: a cosine of more than 18 bits needs an even LANES / FOLD"
      severity failure;
    assert ROTATION = "cordic" or ROTATION = "table"
      report "compensation_pipeline: ROTATION is " & ROTATION & "; expected cordic or table"
      severity failure;
    return LANES / FOLD;

  end function built_lanes;

  constant BUILT         : positive := built_lanes;
  constant PAIRS         : positive := (BUILT + 1) / 2;
  constant READING_DELAY : positive := DELAY_LINE_LATENCY + FOLD - 1;
  constant READING_WIDTH : positive := ANGLE_WIDTH + POSITION_WIDTH + 3 + 17;
  constant MEAN_WIDTH    : positive := MEAN_TERM_WIDTH + 17;

  signal slot            : u_unsigned(2 downto 0);
  signal last_slot       : std_ulogic;
  signal first_sums      : std_ulogic;
  signal last_sums       : std_ulogic;
  signal phase_steps     : std_ulogic_vector(BUILT * PHASE_STEP_WIDTH - 1 downto 0);
  signal phase_offsets   : std_ulogic_vector(BUILT * PHASE_WIDTH - 1 downto 0);
  signal amplitudes      : std_ulogic_vector(BUILT * AMPLITUDE_WIDTH - 1 downto 0);
  signal offset          : u_signed(AMPLITUDE_WIDTH - 1 downto 0);
  signal swap_marker     : std_ulogic;
  signal held_angle      : u_unsigned(ANGLE_WIDTH - 1 downto 0) := (others => '0');
  signal angle_of_slot   : u_unsigned(ANGLE_WIDTH - 1 downto 0);
  signal phases          : std_ulogic_vector(BUILT * PHASE_WIDTH - 1 downto 0);
  signal pair_sums       : std_ulogic_vector(PAIRS * PAIR_WIDTH - 1 downto 0);
  signal reading         : std_ulogic_vector(READING_WIDTH - 1 downto 0);
  signal delayed_reading : std_ulogic_vector(READING_WIDTH - 1 downto 0);
  signal of_mean         : std_ulogic_vector(MEAN_WIDTH - 1 downto 0);
  signal delayed_mean    : std_ulogic_vector(MEAN_WIDTH - 1 downto 0);
  signal may_swap        : std_ulogic;
  signal new_bank_comes  : std_ulogic;
  signal swap_waits      : std_ulogic;
  signal turn_now        : u_signed(TURN_NUMBER_WIDTH - 1 downto 0);
  signal turn_select     : u_unsigned(1 downto 0);
  signal delayed_local   : std_ulogic_vector(LOCAL_VALUE_WIDTH - 1 downto 0);

begin

  assert PHASE_LATENCY + HARMONIC_LATENCY = DELAY_LINE_LATENCY
    report "compensation_pipeline: the delay line is not as long as phase and harmonics"
    severity failure;

  schedule : entity work.fold_sequence
    generic map (
      FOLD => FOLD
    )
    port map (
      clock      => clock,
      slot       => slot,
      accept     => accept,
      last_slot  => last_slot,
      first_sums => first_sums,
      last_sums  => last_sums
    );

  -- In slot 0 the lanes get the new angle, and in the other slots the stored angle of slot 0.
  hold : process (clock) is
  begin

    if rising_edge(clock) then
      if slot = 0 then
        held_angle <= angle;
      end if;
    end if;

  end process hold;

  may_swap      <= last_slot and swap_allowed;
  angle_of_slot <= angle when FOLD = 1 or slot = 0 else
                   held_angle;

  coefficients : entity work.coefficient_memory
    generic map (
      LANES              => LANES,
      FOLD               => FOLD,
      PHASE_OFFSET_DELAY => PHASE_OFFSET_CLOCK,
      AMPLITUDE_DELAY    => PHASE_LATENCY + AMPLITUDE_CLOCK,
      OFFSET_DELAY       => READING_DELAY,
      MODULATORS         => MODULATORS,
      REAL_ORDERS        => REAL_ORDERS
    )
    port map (
      clock             => clock,
      reset             => reset,
      write_enable      => write_enable,
      write_offset      => write_offset,
      write_address     => write_address,
      write_data        => write_data,
      write_acknowledge => write_acknowledge,
      read_address      => read_address,
      read_data         => read_data,
      idle_offset       => idle_offset,
      swap              => swap,
      swap_allowed      => may_swap,
      swap_comes        => new_bank_comes,
      swap_marker       => swap_marker,
      swap_busy         => swap_waits,
      slot              => slot,
      phase_steps       => phase_steps,
      phase_offsets     => phase_offsets,
      amplitudes        => amplitudes,
      offset            => offset,
      sweep_step        => sweep_step,
      direction         => direction,
      speed             => speed,
      idle_speed        => idle_speed,
      word_a            => word_a,
      word_b            => word_b,
      speed_squared     => speed_squared,
      write_turn_step   => write_turn_step,
      read_turn_step    => read_turn_step,
      turn              => turn_now,
      turn_select       => turn_select
    );

  turns_of_the_angle : if REAL_ORDERS generate

    counter : entity work.turn_counter
      port map (
        clock          => clock,
        reset          => reset,
        take           => slot ?= 0,
        angle          => angle,
        counts_per_rev => counts_per_rev,
        turn_select    => turn_select,
        turn           => turn_now
      );

  else generate
    turn_now    <= (others => '0');
    turn_select <= "00";
  end generate turns_of_the_angle;

  turn <= turn_now;

  swap_comes <= new_bank_comes;
  swap_busy  <= swap_waits;

  phase : entity work.phase_unit
    generic map (
      LANES => BUILT
    )
    port map (
      clock         => clock,
      angle         => angle_of_slot,
      phase_steps   => phase_steps,
      phase_offsets => phase_offsets,
      phases        => phases
    );

  harmonics : entity work.harmonic_unit
    generic map (
      LANES        => BUILT,
      COSINE_WIDTH => COSINE_WIDTH,
      ROTATION     => ROTATION
    )
    port map (
      clock      => clock,
      phases     => phases,
      amplitudes => amplitudes,
      pair_sums  => pair_sums
    );

  reading <= zero_moved & std_ulogic_vector(put_back) & referenced & swap_marker & apply
             & std_ulogic_vector(position) & std_ulogic_vector(angle);

  delay : entity work.delay_line
    generic map (
      WIDTH  => READING_WIDTH,
      CLOCKS => READING_DELAY
    )
    port map (
      clock     => clock,
      undelayed => reading,
      delayed   => delayed_reading
    );

  of_mean <= jumped & std_ulogic_vector(jump) & std_ulogic_vector(mean_term);

  mean_of_heads : if MEAN generate

    delay_of_mean : entity work.delay_line
      generic map (
        WIDTH  => MEAN_WIDTH,
        CLOCKS => READING_DELAY - MEAN_LATENCY
      )
      port map (
        clock     => clock,
        undelayed => of_mean,
        delayed   => delayed_mean
      );

  else generate
    delayed_mean <= (others => '0');
  end generate mean_of_heads;

  table_over_the_turn : if LOCAL_TABLE generate

    signal local_value : u_signed(LOCAL_VALUE_WIDTH - 1 downto 0);

  begin

    banks : entity work.local_table_banks
      port map (
        clock          => clock,
        reset          => reset,
        angle          => angle,
        counts_per_rev => counts_per_rev,
        swap_comes     => new_bank_comes,
        hold           => swap or swap_waits,
        read_enable    => local_read,
        write_enable   => local_write,
        of_place       => local_of_place,
        address        => local_address,
        write_data     => local_data,
        done           => local_done,
        read_data      => local_answer,
        value          => local_value
      );

    delay_of_local : entity work.delay_line
      generic map (
        WIDTH  => LOCAL_VALUE_WIDTH,
        CLOCKS => READING_DELAY - LOCAL_TABLE_LATENCY
      )
      port map (
        clock     => clock,
        undelayed => std_ulogic_vector(local_value),
        delayed   => delayed_local
      );

  else generate
    delayed_local <= (others => '0');
    local_done    <= '0';
    local_answer  <= (others => '0');
  end generate table_over_the_turn;

  compensation : entity work.error_compensation
    generic map (
      LANES       => BUILT,
      FOLD        => FOLD,
      MEAN        => MEAN,
      LOCAL_TABLE => LOCAL_TABLE
    )
    port map (
      clock              => clock,
      reset              => reset,
      pair_sums          => pair_sums,
      offset             => offset,
      angle              => u_unsigned(delayed_reading(ANGLE_WIDTH - 1 downto 0)),
      position           => u_signed(delayed_reading(ANGLE_WIDTH + POSITION_WIDTH - 1 downto ANGLE_WIDTH)),
      apply              => delayed_reading(READING_WIDTH - 20),
      swap_marker        => delayed_reading(READING_WIDTH - 19),
      referenced         => delayed_reading(READING_WIDTH - 18),
      put_back           => u_signed(delayed_reading(READING_WIDTH - 2 downto READING_WIDTH - 17)),
      zero_moved         => delayed_reading(READING_WIDTH - 1),
      mean_term          => u_signed(delayed_mean(MEAN_TERM_WIDTH - 1 downto 0)),
      jump               => u_signed(delayed_mean(MEAN_WIDTH - 2 downto MEAN_TERM_WIDTH)),
      jumped             => delayed_mean(MEAN_WIDTH - 1),
      local_value        => u_signed(delayed_local),
      counts_per_rev     => counts_per_rev,
      ramp_rate          => ramp_rate,
      ramp_acceleration  => ramp_acceleration,
      first_sums         => first_sums,
      last_sums          => last_sums,
      corrected_angle    => corrected_angle,
      corrected_position => corrected_position,
      corrected_referenced => corrected_referenced,
      correction         => correction,
      correction_limited => correction_limited,
      ramp_busy          => ramp_busy,
      swap_done          => swap_done
    );

end architecture rtl;
