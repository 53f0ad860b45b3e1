-- SPDX-License-Identifier: Apache-2.0
--
-- # error_compensation
--
-- Computes the compensated reading of equation (8), θ_com = R − ε(R), modulo the turn. The entity adds the pair sums of
-- the harmonics and the offset; the sum is ε. correction_ramp derives from ε the total correction, which makes no step
-- at a swap or when `apply` changes; the entity subtracts this total from the delayed reading.
--
-- **Latency.** 4 clocks from `pair_sums` and `angle` to the outputs, one angle per clock: two clocks for the adder
-- tree, one for the ramp, one for the subtraction, which also brings the result into the range of a turn.
--
-- **Folding.** With FOLD > 1 the pair sums of an angle arrive in FOLD clocks, from `first_sums` to
-- `last_sums`, and are added up; the reading and all other inputs of the angle belong to the clock of `last_sums`, from
-- which the latency counts. Only `zero_moved` is read in every clock. Between two angles the reading and ε do not
-- change, and the ramp continues at its rate per clock. The sums are exact, so they are the same for every FOLD.
--
-- **Rounding.** All fraction bits are kept up to the last clock; in that clock the total correction is rounded once, to
-- whole counts: corrected = R − floor(total + ½), the same number for angle and position. `correction` shows the total,
-- truncated to 11 fraction bits.
--
-- **Apply.** While `apply` is low, 0 replaces ε. A change of `apply` restarts the ramp, as a swap does. `apply`,
-- `swap_marker`, `zero_moved`, `put_back`, `referenced`, `angle` and `position` belong to the angle whose pair sums
-- arrive in the same clock. `referenced` is output with the corrected angle to which it belongs.
--
-- **Put back.** `position` contains `put_back` counts (modulo 2¹⁶) that replace lost counts and do not come from edges.
-- If `put_back` changes with an angle and `zero_moved` has toggled since the previous angle, once or several times, the
-- ramp absorbs the change: the corrected reading makes no step and gains these counts as the ramp decays. A toggle of
-- `zero_moved` without a change of `put_back` restarts the ramp too: the total changes without a step to the ε that
-- belongs to the angle from the new zero.
--
-- **Mean.** With MEAN, `mean_term` of the same angle is added to ε with all its bits (weighted_mean). When new words of
-- the mean become active, the reading may jump, because another head becomes the carrier (the head whose reading enters
-- the pipeline) or the carrier's offset changes. `jumped` is high with the first angle to which the new words apply,
-- and `jump` is the jump of the reading: the ramp absorbs this jump like counts that are put back, so the corrected
-- reading makes no step.
--
-- **Local table.** With LOCAL_TABLE, `local_value` of the same angle is added to ε with all its bits (local_table).
--
-- **Limit.** The total is clipped to whole counts strictly below half a turn, at
-- ±min(floor((counts_per_rev − 1) / 2), 2¹⁹ − 1) counts; `correction_limited` is high with each
-- output that was clipped. Since angle < counts_per_rev, adding or subtracting at most one turn then gives 0 <=
-- corrected_angle < counts_per_rev.
--
-- **Number formats.** pair sums s15.F, F = PAIR_FRACTION, in magnitude at most 2¹⁴ + 2; offset s13.11 counts; mean_term
-- s19.20 counts, in magnitude at most 2¹⁸·1.5 + 1; local_value s13.22 counts; the sum of all terms stays below 2²⁰; ε
-- s20.F; total s19.F; correction s19.11 counts; angles u24.0 counts; positions s31.0 counts modulo 2³².
--
-- **Reset.** The total, the remainder of the ramp and the last `apply` are 0: the first angle with `apply` high starts
-- a ramp from the correction 0. Angles in the pipeline are not cleared. While `counts_per_rev` changes, all angles in
-- the pipeline must be below the old and the new value.

library ieee;
  use ieee.std_logic_1164.all;
  use ieee.numeric_std.all;

  use work.carry_save_pkg.all;
  use work.number_formats_pkg.all;

entity error_compensation is
  generic (
    LANES       : positive range 1 to LANES_MAX := LANES_DEFAULT; -- lanes whose pair sums arrive in one clock
    FOLD        : positive range 1 to 8         := 1;             -- number of clocks in which the pair sums of an angle arrive
    MEAN        : boolean                       := false;         -- the mean of the heads is corrected
    LOCAL_TABLE : boolean                       := false          -- the value of a local table is added
  );
  port (
    clock              : in    std_ulogic;
    reset              : in    std_ulogic;
    pair_sums          : in    std_ulogic_vector(((LANES + 1) / 2) * PAIR_WIDTH - 1 downto 0); -- counts, s15.F, pair 0 in the low bits
    offset             : in    u_signed(AMPLITUDE_WIDTH - 1 downto 0);                         -- counts, s13.11
    angle              : in    u_unsigned(ANGLE_WIDTH - 1 downto 0);                           -- counts, below counts_per_rev
    position           : in    u_signed(POSITION_WIDTH - 1 downto 0);                          -- counts
    apply              : in    std_ulogic;                                                     -- high: correct this reading
    swap_marker        : in    std_ulogic;                                                     -- high with the first angle of a new bank
    zero_moved         : in    std_ulogic                               := '0';                -- toggles when the zero moves
    put_back           : in    u_signed(15 downto 0)                    := (others => '0');    -- counts put back for lost counts
    mean_term          : in    u_signed(MEAN_TERM_WIDTH - 1 downto 0)   := (others => '0');    -- counts, s19.20
    jumped             : in    std_ulogic                               := '0';                -- with the first angle of new mean words
    jump               : in    u_signed(15 downto 0)                    := (others => '0');    -- counts, jump of the reading
    local_value        : in    u_signed(LOCAL_VALUE_WIDTH - 1 downto 0) := (others => '0');    -- counts, s13.22
    referenced         : in    std_ulogic;                                                     -- high if this angle counts from an index
    counts_per_rev     : in    u_unsigned(COUNTS_PER_REV_WIDTH - 1 downto 0);                  -- counts
    ramp_rate          : in    u_unsigned(31 downto 0);                                        -- 2⁻¹¹ count per clock, u8.24
    ramp_acceleration  : in    u_unsigned(31 downto 0)                  := (others => '0');    -- 2⁻⁵⁹ count per clock², 0: no limit
    first_sums         : in    std_ulogic                               := '1';                -- high with the first pair sums of an angle
    last_sums          : in    std_ulogic                               := '1';                -- high with the last pair sums of an angle
    corrected_angle    : out   u_unsigned(ANGLE_WIDTH - 1 downto 0)     := (others => '0');    -- counts
    corrected_position : out   u_signed(POSITION_WIDTH - 1 downto 0)    := (others => '0');    -- counts
    corrected_referenced : out   std_ulogic                               := '0';                -- corrected_angle counts from an index
    correction         : out   u_signed(CORRECTION_WIDTH - 1 downto 0)  := (others => '0');    -- counts, s19.11
    correction_limited : out   std_ulogic                               := '0';                -- high if `correction` was clipped
    ramp_busy          : out   std_ulogic                               := '0';                -- high until the ramp has ended
    swap_done          : out   std_ulogic                               := '0'                 -- strobe: the first output of a new bank
  );
end entity error_compensation;

architecture rtl of error_compensation is

  constant PAIRS : positive := (LANES + 1) / 2;
  constant TERMS        : positive := PAIRS + 1 + boolean'pos(MEAN) + boolean'pos(LOCAL_TABLE);
  -- Number of sums that remain after the carry-save levels of the first clock. The second clock reduces three numbers
  -- by one more level before its carry chain. With FOLD > 1 the third of these numbers is the sum of the earlier blocks
  -- of the angle.
  constant SAVED        : positive := 3 - boolean'pos(FOLD > 1);
  constant SUM_WIDTH    : positive := 21 + PAIR_FRACTION;
  constant TURN_WIDTH   : positive := ANGLE_WIDTH + 3;
  constant ALIGN_OFFSET : natural  := PAIR_FRACTION - AMPLITUDE_FRACTION;
  constant ALIGN_MEAN   : natural  := PAIR_FRACTION - MEAN_TERM_FRACTION;
  constant ALIGN_LOCAL  : natural  := PAIR_FRACTION - LOCAL_VALUE_FRACTION;
  constant LIMIT_MAX    : u_unsigned(18 downto 0) := (others => '1');

  subtype turn_sum is u_signed(TURN_WIDTH - 1 downto 0);

  type angles is array (1 to 2) of u_unsigned(ANGLE_WIDTH - 1 downto 0);

  type positions is array (1 to 3) of u_signed(POSITION_WIDTH - 1 downto 0);

  signal unramped     : u_signed(SUM_WIDTH - 1 downto 0) := (others => '0');
  signal marker       : std_ulogic                       := '0';
  signal withdrawn    : u_signed(15 downto 0)            := (others => '0');
  signal limit        : u_unsigned(18 downto 0)          := (others => '0');
  signal total        : u_signed(19 + PAIR_FRACTION downto 0);
  signal limited      : std_ulogic;
  signal busy         : std_ulogic;

begin

  sum_and_subtract : process (clock) is

    -- Registers; the number in a name is the number of clocks from pair_sums until the register is valid.
    variable saved_sums     : u_signed(SAVED * SUM_WIDTH - 1 downto 0)             := (others => '0');
    variable sum_so_far     : u_signed(SUM_WIDTH - 1 downto 0)                      := (others => '0');
    variable last_1         : std_ulogic                                           := '0';
    variable apply_1        : std_ulogic                                           := '0';
    variable marker_1       : std_ulogic                                           := '0';
    variable moved_1        : std_ulogic                                           := '0';
    -- High if zero_moved has toggled since the previous angle; with FOLD > 1 it may toggle between two angles, even
    -- twice.
    variable moves          : std_ulogic                                           := '0';
    variable put_back_1     : u_signed(15 downto 0)                                := (others => '0');
    variable withdrawn_1    : u_signed(15 downto 0)                                := (others => '0');
    variable half_turn      : u_unsigned(COUNTS_PER_REV_WIDTH - 1 downto 0)          := (others => '0');
    variable swap_1_to_3    : std_ulogic_vector(1 to 3)                            := (others => '0');
    variable referenced_1_to_3 : std_ulogic_vector(1 to 3)                         := (others => '0');
    variable angle_1_to_2   : angles                                               := (others => (others => '0'));
    variable position_1_to_3 : positions                                           := (others => (others => '0'));
    -- The reading, the reading plus a turn, and the reading minus a turn
    variable reading_3      : turn_sum                                             := (others => '0');
    variable reading_more_3 : turn_sum                                             := (others => '0');
    variable reading_less_3 : turn_sum                                             := (others => '0');

    variable pair_sum   : u_signed(PAIR_WIDTH - 1 downto 0);
    variable terms_1    : u_signed(TERMS * SUM_WIDTH - 1 downto 0);
    variable terms_2    : u_signed(3 * SUM_WIDTH - 1 downto 0);
    variable wide_sum   : u_signed(SUM_WIDTH - 1 downto 0);

    variable round_up   : std_ulogic;
    variable negative   : turn_sum;
    variable turn       : turn_sum;
    variable straight   : turn_sum;
    variable turn_more  : turn_sum;
    variable turn_less  : turn_sum;

  begin

    if rising_edge(clock) then
      -- Fourth clock. -floor(total + 1/2) = not(whole part) + not(first fraction bit).
      round_up  := not total(PAIR_FRACTION - 1);
      negative  := resize(not total(total'high downto PAIR_FRACTION), TURN_WIDTH);
      straight  := add_with_carry(reading_3, negative, round_up);
      turn_more := add_with_carry(reading_more_3, negative, round_up);
      turn_less := add_with_carry(reading_less_3, negative, round_up);

      if straight(TURN_WIDTH - 1) = '1' then
        corrected_angle <= u_unsigned(turn_more(ANGLE_WIDTH - 1 downto 0));
      elsif turn_less(TURN_WIDTH - 1) = '0' then
        corrected_angle <= u_unsigned(turn_less(ANGLE_WIDTH - 1 downto 0));
      else
        corrected_angle <= u_unsigned(straight(ANGLE_WIDTH - 1 downto 0));
      end if;

      corrected_position <= add_with_carry(
        position_1_to_3(3),
        resize(not total(total'high downto PAIR_FRACTION), POSITION_WIDTH),
        round_up
      );
      correction         <= total(total'high downto PAIR_FRACTION - CORRECTION_FRACTION);
      corrected_referenced <= referenced_1_to_3(3);
      correction_limited <= limited;
      ramp_busy          <= busy;
      swap_done          <= swap_1_to_3(3);

      -- Third clock: correction_ramp computes the total; here the reading plus and minus a turn is computed.
      turn           := resize(u_signed('0' & counts_per_rev), TURN_WIDTH);
      reading_3      := resize(u_signed('0' & angle_1_to_2(2)), TURN_WIDTH);
      reading_more_3 := reading_3 + turn;
      reading_less_3 := reading_3 - turn;

      swap_1_to_3(3)     := swap_1_to_3(2);
      position_1_to_3(3) := position_1_to_3(2);
      referenced_1_to_3(3) := referenced_1_to_3(2);

      -- Second clock: reduce the remaining numbers to one sum, ε.
      terms_2(terms_2'high downto 2 * SUM_WIDTH) := sum_so_far;
      terms_2(saved_sums'range)                  := saved_sums;

      wide_sum       := sum_of_all(terms_2, SUM_WIDTH);
      sum_so_far     := wide_sum;
      -- If the next pair sums belong to another angle, the sum restarts at 0.
      if first_sums = '1' then
        sum_so_far := (others => '0');
      end if;
      marker         <= '0';
      swap_1_to_3(2) := '0';

      if last_1 = '1' or FOLD = 1 then
        if apply_1 = '1' then
          unramped <= wide_sum;
        else
          unramped <= (others => '0');
        end if;
        marker             <= marker_1;
        withdrawn          <= withdrawn_1;
        swap_1_to_3(2)     := swap_1_to_3(1);
        angle_1_to_2(2)    := angle_1_to_2(1);
        position_1_to_3(2) := position_1_to_3(1);
        referenced_1_to_3(2) := referenced_1_to_3(1);
      end if;

      -- First clock: reduce pair sums, offset and the other terms to the saved sums.
      for i in 0 to PAIRS - 1 loop
        pair_sum                                              := u_signed(pair_sums((i + 1) * PAIR_WIDTH - 1 downto i * PAIR_WIDTH));
        terms_1((i + 1) * SUM_WIDTH - 1 downto i * SUM_WIDTH) := resize(pair_sum, SUM_WIDTH);
      end loop;

      terms_1((PAIRS + 1) * SUM_WIDTH - 1 downto PAIRS * SUM_WIDTH) := shift_left(resize(offset, SUM_WIDTH), ALIGN_OFFSET)
                                                                       and (SUM_WIDTH - 1 downto 0 => last_sums);
      if MEAN then
        terms_1((PAIRS + 2) * SUM_WIDTH - 1 downto (PAIRS + 1) * SUM_WIDTH) := shift_left(resize(mean_term, SUM_WIDTH), ALIGN_MEAN)
                                                                               and (SUM_WIDTH - 1 downto 0 => last_sums);
      end if;
      if LOCAL_TABLE then
        terms_1(terms_1'high downto terms_1'length - SUM_WIDTH) := shift_left(resize(local_value, SUM_WIDTH), ALIGN_LOCAL)
                                                                   and (SUM_WIDTH - 1 downto 0 => last_sums);
      end if;

      saved_sums := carry_saved(terms_1, SUM_WIDTH, SAVED);

      moves   := moves or (zero_moved xor moved_1);
      moved_1 := zero_moved;
      if last_sums = '1' or FOLD = 1 then
        withdrawn_1        := (others => '0');
        if moves = '1' then
          withdrawn_1 := put_back_1 - put_back;
        end if;
        if MEAN and jumped = '1' then
          withdrawn_1 := -jump;
        end if;
        marker_1           := swap_marker or (apply xor apply_1) or moves;
        moves              := '0';
        apply_1            := apply;
        put_back_1         := put_back;
        swap_1_to_3(1)     := swap_marker;
        angle_1_to_2(1)    := angle;
        position_1_to_3(1) := position;
        referenced_1_to_3(1) := referenced;
      end if;
      last_1 := last_sums;

      -- The limit does not change while angles are corrected, so it may take two clocks: the first computes half a
      -- turn.
      if (or half_turn(half_turn'high downto limit'length)) = '1' then
        limit <= LIMIT_MAX;
      else
        limit <= half_turn(limit'range);
      end if;
      half_turn := shift_right(counts_per_rev - 1, 1);

      if reset = '1' then
        apply_1  := '0';
        marker_1 := '0';
        marker   <= '0';
        unramped <= (others => '0');
      end if;
    end if;

  end process sum_and_subtract;

  decay : entity work.correction_ramp
    port map (
      clock      => clock,
      reset      => reset,
      correction => unramped,
      marker     => marker,
      withdrawn  => withdrawn,
      limit      => limit,
      ramp_rate  => ramp_rate,
      ramp_acceleration => ramp_acceleration,
      total      => total,
      limited    => limited,
      busy       => busy
    );

end architecture rtl;
