-- SPDX-License-Identifier: Apache-2.0
--
-- # quadrature_decoder
--
-- Counts every edge of an incremental encoder's A and B (x4) into a multi-turn position and, beside
-- it, into an angle modulo `counts_per_rev` whose zero the first index defines. It checks the
-- distance of the index marks, the order of the edges and their spacing. Source: section 3.1 and
-- figures 4 and 5 of the paper: A leads B counter-clockwise, (A, B) = 00, 10, 11, 01 counts up.
--
-- **Latency.** SYNCHRONISER_STAGES + filter_length + 2 clocks from a change of a pin to `position`:
-- 5 with the filter off. position, angle, turn_position, direction, step, step_up,
-- last_edge_time, illegal and illegal_count belong to one clock; overspeed and overspeed_count follow 1
-- clock after it. index_seen, with the angle from the new zero, comes INDEX_SKEW clocks after the step of the index, or with
-- the next step if that is earlier. index_strobe, index_position, index_direction and index_interval
-- follow 1 clock after that, index_error and index_error_count 4 clocks.
--
-- **Number formats.** position, turn_position, index_position and index_interval s31.0 counts;
-- angle u24.0 counts; counts_per_rev u25.0 counts; filter_length u8.0 and minimum_edge_spacing
-- u16.0 clocks; index_tolerance u16.0 counts; timestamp and last_edge_time u64.0 clocks; counters
-- u16.0.
--
-- **Position** starts at RESET_POSITION with the reset and is never changed but by edges. It wraps modulo 2**32:
-- readers use differences, which are right while they stay within +-2**31 counts. The angle is a
-- counter of its own, so it stays right for any turn when the position wraps. `turn_position` is
-- position - position of the zero, and wraps likewise. While nothing wraps, angle is
-- turn_position modulo counts_per_rev in every clock, before the first index too.
--
-- **Phase.** `phase_of_zero` is the place of (A, B) in 00, 10, 11, 01 at position 0 and every fourth count from
-- there. It comes 2 clocks after the position and changes by illegal transitions only, after the reset.
--
-- **Index.** The zero is one edge of Z: the rising one while counting up, which is the falling one
-- while counting down. A change of Z belongs to the step of A or B beside which it comes, up to
-- INDEX_SKEW clocks before or after it; its level is taken so many clocks after the step, or just before
-- the next one, and compared with that of the step before. Up, the position after the step is
-- latched, down the one before it, so both directions give the same count. Where Z changes within a
-- count, further from both its edges, the step that leaves the count decides the direction, and that
-- count is latched; a reversal within it leaves no trace. Hence the direction is never that of a motion long past, and
-- neither skewed pins nor a tremble beside either edge of the mark take one edge of it for the other, as
-- long as two steps in opposite directions are further apart than Z is from its step. `filter_length` above
-- INDEX_SKEW sees to that. The first index after reset or rearm defines the zero of angle and
-- turn_position; later ones do not change them. Each later index must lie 0 or
-- +-counts_per_rev from the one before it, within +-`index_tolerance`, otherwise `index_error`: counts
-- were lost or added, or an index was. A real mark repeats to +-1 count, so that two of them lie up to 2
-- counts off; a slip of a period of A and B adds 4. `index_interval` reads 0 while there are fewer
-- than two.
-- With `zero_again` high the zero moves when it is proven wrong, 5 clocks after the mark that proves it is told: a mark
-- in the wrong place for which `other_head_agrees` (see zero_witness; the first mark after lost counts), or
-- the first mark after an `index_error` that lies one turn from the mark before it, within the tolerance (the second
-- mark after lost counts).
-- One false mark does not move the zero to its place: no other lies a turn from it. `index_seen` stays, so the
-- correction goes on. A turn of less than 9 counts keeps its zero. Where the zero moves to another count,
-- `zero_slip` is the angle that the mark had (the counts lost, with a minus), `zero_moved` turns over and `zero_moves`
-- counts, in the clock in which angle and turn_position count from the new zero; index_error is set, and
-- counts once, in the same clock. The position keeps what it lost. With `heal` high `put_back` loses `zero_slip`
-- in that clock, so that position + put_back keeps no slip; one of 2**14 counts and more is not put back.
-- `index_trusted` tells 3 clocks after index_strobe that the mark is where the zero says.
-- Where Z is meant to change within a count and comes near its edge at one speed only, the index is one
-- count off then.
-- **Fastest index.** With pins up to s clocks apart, 1 to INDEX_SKEW, that holds from s + INDEX_SKEW + 1 clocks a count on: 5, 6 and 7,
-- which is 14 million counts a second at 100 MHz. Where Z changes half a count beside its step it takes twice 7. Faster, Z
-- that comes before a step cannot be told from Z that comes after the step before it: a mark may be taken at its other
-- edge. Pins that change in one clock give every mark its place at any speed.
-- A Z edge before the first step after reset counts with that step.
--
-- **Faults.** `illegal`: A and B changed in one clock; nothing is counted, since the direction is
-- unknown. `overspeed`: a counted edge came less than minimum_edge_spacing clocks after the one
-- before it (0 and 1: never); it is counted all the same, one in every clock if need be.
-- An illegal transition is not an edge in this sense, nor in that of last_edge_time.
-- Edges that the filter swallows are over-speed too, and set `swallowed` with it, since then counts are lost: the levels before
-- the filter are decoded as well, and `overspeed` is set, and counted, when they are a whole period of A and B (4 counts) ahead of those
-- after it, or have broken the order 4 times where the filter shows nothing. Once the pins have
-- been quiet for filter_length clocks this starts anew. A pulse on one pin that is shorter than the
-- filter leaves no trace here either, unless another pin changes within it: then it
-- cannot be told from a period that was lost. Latency SYNCHRONISER_STAGES + 4 clocks from the pins.
--
-- **Clear semantics.** index_error, illegal, overspeed and swallowed stay set, and their counters stop at
-- 65,535, until `clear` or reset. A fault in the very clock of a clear is kept: flag set, counter 1.
-- Clear touches nothing else, rearm none of these.
--
-- **Rearm.** While `rearm` is high, angle and turn_position are 0, and the index is forgotten (index_seen
-- and index_interval are 0; index_position keeps its value). The position counts on. Angle and
-- turn_position count from 0 with the first step after it, and the next index defines the zero
-- anew.
-- `counts_per_rev` (4 to 2**24, any integer) is taken over while rearm or reset is high, and for
-- SYNCHRONISER_STAGES + 1 clocks after reset; at other times a change of it has no effect.
--
-- **Reset** may be as short as one clock. The levels of the pins in its last clock are where counting
-- starts: whatever they are, they make no edge; every later change counts.
-- filter_length, minimum_edge_spacing and index_tolerance may change at any time.
--
-- **last_edge_time** is the timestamp of the clock in which the edge was counted, the one before the
-- position shows it: SYNCHRONISER_STAGES + filter_length + 1 after that of the pin's change. With
-- position, read in the same clock, it gives the velocity.

library ieee;
  use ieee.std_logic_1164.all;
  use ieee.numeric_std.all;

  use work.carry_save_pkg.all;
  use work.number_formats_pkg.all;
  use work.tolerance_pkg.all;

entity quadrature_decoder is
  generic (
    SYNCHRONISER_STAGES : positive range 2 to 4 := 2; -- registers a pin
    RESET_POSITION      : integer               := 0  -- counts; near +-2**31 to meet the wrap in a test
  );
  port (
    clock                : in    std_ulogic;
    reset                : in    std_ulogic;
    -- Pins, asynchronous
    a                    : in    std_ulogic;
    b                    : in    std_ulogic;
    z                    : in    std_ulogic;                                          -- index
    -- Settings
    counts_per_rev       : in    u_unsigned(COUNTS_PER_REV_WIDTH - 1 downto 0);       -- counts, 4 to 2**24
    filter_length        : in    u_unsigned(7 downto 0);                              -- clocks, 1 is off
    minimum_edge_spacing : in    u_unsigned(15 downto 0);                             -- clocks, 0 is off
    index_tolerance      : in    u_unsigned(15 downto 0) := (others => '0');          -- counts
    timestamp            : in    u_unsigned(TIMESTAMP_WIDTH - 1 downto 0);            -- clocks
    clear                : in    std_ulogic;                                          -- pulse: clears the faults
    rearm                : in    std_ulogic;                                          -- level: forgets the index
    zero_again           : in    std_ulogic := '0';                                   -- level: agreeing marks move the zero
    heal                 : in    std_ulogic := '0';                                   -- level: put_back follows the zero
    other_head_agrees    : in    std_ulogic := '0';                                   -- 2 clocks after index_strobe: the mark is true
    -- Position
    position             : out   u_signed(POSITION_WIDTH - 1 downto 0);               -- counts, multi-turn
    angle                : out   u_unsigned(ANGLE_WIDTH - 1 downto 0);                -- counts, below counts_per_rev
    turn_position        : out   u_signed(POSITION_WIDTH - 1 downto 0);               -- counts from the first index
    phase_of_zero        : out   u_unsigned(1 downto 0);                              -- place of (A, B) at position 0 modulo 4
    direction            : out   std_ulogic;                                          -- of the last step, '1' up
    step                 : out   std_ulogic;                                          -- strobe: position changed
    step_up              : out   std_ulogic;                                          -- strobe: it rose
    last_edge_time       : out   u_unsigned(TIMESTAMP_WIDTH - 1 downto 0);            -- clocks
    -- Index
    index_seen           : out   std_ulogic;                                          -- level
    index_strobe         : out   std_ulogic;                                          -- strobe: the four below are new
    index_position       : out   u_signed(POSITION_WIDTH - 1 downto 0);               -- counts, of the last index
    index_direction      : out   std_ulogic;                                          -- of the last index, '1' up
    index_interval       : out   u_signed(POSITION_WIDTH - 1 downto 0);               -- counts, from the index before
    index_trusted        : out   std_ulogic;                                          -- strobe: the last index lies where the zero says
    zero_moved           : out   std_ulogic;                                          -- turns over where the zero moves to another count
    zero_moves           : out   u_unsigned(15 downto 0);                             -- how often; wraps
    zero_slip            : out   u_signed(COUNTS_PER_REV_WIDTH - 1 downto 0);         -- counts, angle of the mark that moved it last
    put_back             : out   u_signed(POSITION_WIDTH - 1 downto 0);               -- counts, for those that were lost
    -- Faults
    index_error          : out   std_ulogic;                                          -- sticky
    index_error_count    : out   u_unsigned(15 downto 0);                             -- saturates
    illegal              : out   std_ulogic;                                          -- sticky
    illegal_count        : out   u_unsigned(15 downto 0);                             -- saturates
    overspeed            : out   std_ulogic;                                          -- sticky
    overspeed_count      : out   u_unsigned(15 downto 0);                             -- saturates
    swallowed            : out   std_ulogic                                           -- sticky: the filter swallowed counts
  );
end entity quadrature_decoder;

architecture rtl of quadrature_decoder is

  constant LARGEST : positive := 2 ** 16 - 1;
  constant PERIOD  : positive := 4; -- counts of a period of A and B

  -- Clocks from an index told to its judgement.
  constant JUDGED_AFTER : positive := 3;

  -- Of a slip that is put back.
  constant HEAL_WIDTH : positive := 15;

  constant LONGEST_FILTER : u_unsigned(7 downto 0) := (others => '1'); -- clocks

  signal pins     : std_ulogic_vector(2 downto 0);
  signal levels   : std_ulogic_vector(2 downto 0);
  signal filtered : std_ulogic_vector(2 downto 0);
  signal preload  : std_ulogic;

  -- Reset and the clocks after it in which the synchroniser still holds older levels of the pins.
  signal settling : std_ulogic_vector(SYNCHRONISER_STAGES downto 0) := (others => '1');

  -- A place of a turn. Whether it is the first or the last one is kept beside it: a step needs no comparison.
  type turn_place is record
    count   : u_unsigned(ANGLE_WIDTH - 1 downto 0);
    is_zero : std_ulogic;
    is_last : std_ulogic;
  end record turn_place;

  type turn_places is array (0 to 1) of turn_place;

  constant ZERO_PLACE : turn_place := (count => (others => '0'), is_zero => '1', is_last => '0');

  -- A small number of counts. Its sums are tables: they are too narrow for a carry chain.
  subtype few_counts is u_signed(3 downto 0);

  type tables is array (natural range <>) of few_counts;

  -- A number of counts (bits 5 to 2) and a step: whether there is one, and up (bits 1 and 0).
  function with_a_step return tables is

    variable table  : tables(0 to 63);
    variable number : few_counts;

  begin

    for bits in table'range loop
      number      := u_signed(to_unsigned(bits / 4, 4));
      table(bits) := number;
      if (bits / 2 mod 2 = 1 and bits mod 2 = 1) then
        table(bits) := number + 1;
      elsif (bits / 2 mod 2 = 1) then
        table(bits) := number - 1;
      end if;
    end loop;

    return table;

  end function with_a_step;

  constant WITH_STEP : tables := with_a_step;

  -- From the zero of an index to the position, where the index is met in the clock of a step: whether there is a
  -- step, and up (bits 3 and 2), whether the index is within a count, and upwards (bits 1 and 0).
  function behind_index return tables is

    variable table  : tables(0 to 15);
    variable number : integer range -2 to 2;

  begin

    for bits in table'range loop
      number := 0;
      if (bits / 8 = 1) then
        number := 2 * (bits / 4 mod 2) - 1;
      end if;
      if (bits mod 2 = 0) then
        number := number - 1;
      elsif (bits / 2 mod 2 = 1) then
        number := number + 1;
      end if;
      table(bits) := to_signed(number, 4);
    end loop;

    return table;

  end function behind_index;

  constant BEHIND_INDEX_OF : tables := behind_index;

  -- From the zero of an index to the position before the step of the clock: whether it is within a count, and upwards
  -- (bits 1 and 0).
  constant BEFORE_INDEX_OF : tables(0 to 3) := BEHIND_INDEX_OF(0 to 3);

  -- A place, a step later; where an index is told, the one that is `from_zero` (-2 to 2) counts from 0. The choices
  -- exclude each other, so that a bit takes one look-up table after the carry chains of the two neighbours.
  function next_place (
    place             : turn_place;
    last, before_last : u_unsigned(ANGLE_WIDTH - 1 downto 0);
    stands, up        : std_ulogic;
    is_told           : std_ulogic;
    from_zero         : few_counts
  ) return turn_place is

    variable result    : turn_place;
    variable below     : u_unsigned(ANGLE_WIDTH - 1 downto 0);
    variable first     : u_unsigned(ANGLE_WIDTH - 1 downto 0);
    variable rises     : std_ulogic;
    variable falls     : std_ulogic;
    variable is_last   : std_ulogic;
    variable is_zero   : std_ulogic;
    variable is_before : std_ulogic;

  begin

    result := place;
    if (stands = '1' and is_told = '0') then
      return result;
    end if;

    rises     := not is_told and up and not place.is_last;
    falls     := not is_told and not up and not place.is_zero;
    is_last   := (not is_told and not up and place.is_zero) or (is_told and (from_zero ?= -1));
    is_zero   := (not is_told and up and place.is_last) or (is_told and (from_zero ?= 0));
    is_before := is_told and (from_zero ?= -2);

    -- The first and the second count.
    first    := (others => '0');
    first(0) := is_told and (from_zero ?= 1);
    first(1) := is_told and (from_zero ?= 2);

    below        := not (not place.count + 1);
    result.count := ((place.count + 1) and (below'range => rises))
                    or (below and (below'range => falls))
                    or (last and (below'range => is_last))
                    or (before_last and (below'range => is_before))
                    or first;

    result.is_last := is_last or (rises and (place.count ?= before_last));
    result.is_zero := is_zero or (falls and (place.count ?= 1));
    return result;

  end function next_place;

  -- By how many counts the unfiltered levels are ahead of the filtered ones (bits 6 to 4), after a step of either:
  -- whether there is one, and up (bits 3 and 2 unfiltered, 1 and 0 filtered). A period and more is PERIOD.
  function ahead_after_steps return tables is

    variable table : tables(0 to 127);
    variable ahead : integer range -6 to 5;

  begin

    for bits in table'range loop
      ahead := to_integer(u_signed(to_unsigned(bits / 16, 3)));
      if (bits / 8 mod 2 = 1) then
        ahead := ahead + 2 * (bits / 4 mod 2) - 1;
      end if;
      if (bits / 2 mod 2 = 1) then
        ahead := ahead - 2 * (bits mod 2) + 1;
      end if;
      table(bits) := to_signed(PERIOD, 4);
      if (abs ahead < PERIOD) then
        table(bits) := to_signed(ahead, 4);
      end if;
    end loop;

    return table;

  end function ahead_after_steps;

  constant AHEAD_AFTER : tables := ahead_after_steps;

  function saturating_increment (count : u_unsigned(15 downto 0)) return u_unsigned is
  begin

    if (count = LARGEST) then
      return count;
    end if;
    return count + 1;

  end function saturating_increment;

  -- The two counters of places of `decode`, and which of them is the angle
  signal counters        : turn_places := (others => ZERO_PLACE);
  signal angle_is_second : std_ulogic  := '0';
  signal place_of_angle  : u_unsigned(ANGLE_WIDTH - 1 downto 0);

begin

  pins    <= a & b & z;
  preload <= settling(settling'high);

  synchroniser : entity work.input_synchroniser
    generic map (
      WIDTH  => 3,
      STAGES => SYNCHRONISER_STAGES
    )
    port map (
      clock        => clock,
      asynchronous => pins,
      synchronised => levels
    );

  -- Its reset lasts to the last level from before the end of ours.
  filter : entity work.glitch_filter
    generic map (
      WIDTH => 3
    )
    port map (
      clock         => clock,
      reset         => settling(settling'high - 1),
      filter_length => filter_length,
      unfiltered    => levels,
      filtered      => filtered
    );

  place_of_angle <= counters(1).count when angle_is_second = '1' else
                    counters(0).count;
  angle          <= place_of_angle;

  decode : process (clock) is

    -- Levels of A, B and Z one clock ago
    variable before          : std_ulogic_vector(2 downto 0)           := (others => '0');
    variable a_changes       : std_ulogic;
    variable b_changes       : std_ulogic;
    -- Stage 1: what the levels say. `up` stays until the next step.
    variable moves           : std_ulogic                              := '0';
    variable stands          : std_ulogic                              := '1'; -- its complement, for what is decided by it
    variable up              : std_ulogic                              := '1';
    variable down            : std_ulogic                              := '0'; -- its complement, likewise
    variable breaks_order    : std_ulogic                              := '0';
    -- Z: the level that is taken as that of the last step, or of the count before it; the clocks until
    -- that of the step in hand is taken; the clocks since that
    variable index_level     : std_ulogic                              := '0';
    variable until_settled   : natural range 0 to INDEX_SKEW           := 0;
    variable since_settled   : natural range 0 to INDEX_SKEW + 1       := 0;
    variable settled_level   : std_ulogic;
    variable settles         : std_ulogic;
    -- Levels of the clocks before, the youngest in the low bit
    variable earlier_levels  : std_ulogic_vector(INDEX_SKEW downto 0)  := (others => '0');
    -- Z changed within the count that the step in hand left.
    variable may_be_inside   : std_ulogic;
    variable was_inside      : std_ulogic                              := '0';
    variable meets_index     : std_ulogic                              := '0';
    variable meets_up        : std_ulogic                              := '1';
    variable meets_inside    : std_ulogic                              := '0';
    variable leaves_inside   : std_ulogic                              := '0'; -- the same, upwards
    -- A and B before the filter, one clock ago, and what they say
    variable raw_before      : std_ulogic_vector(1 downto 0)           := (others => '0');
    variable raw_changes     : std_ulogic_vector(1 downto 0);
    variable raw_moves       : std_ulogic                              := '0';
    variable raw_up          : std_ulogic                              := '0';
    variable raw_breaks      : std_ulogic                              := '0';
    -- Clocks since they changed, less one
    variable still           : u_unsigned(7 downto 0)                  := (others => '0');
    variable is_quiet        : std_ulogic                              := '0';
    -- Counts by which they are ahead of the filtered ones, and breaks of the order that the filter hides
    variable ahead           : u_signed(2 downto 0)                    := "000";
    variable ahead_now       : few_counts;
    variable hidden_breaks   : natural range 0 to PERIOD - 1           := 0;
    variable edges_lost      : std_ulogic                              := '0';
    -- Stage 2: position, beside the registers of the ports. Two counters of places: one counts from the zero, the
    -- other one from the last index told. Where the zero moves to that index, they change their parts.
    variable places          : turn_places                             := (others => ZERO_PLACE);
    variable is_second       : std_ulogic                              := '0'; -- which of them is the angle
    variable last_angle      : u_unsigned(ANGLE_WIDTH - 1 downto 0)    := (others => '0');
    variable before_last     : u_unsigned(ANGLE_WIDTH - 1 downto 0)    := (others => '0');
    -- There are more than 8 counts in a turn.
    variable is_long_turn    : std_ulogic                              := '0';
    -- From the zero of the last index told to the position, while that is judged, and clocks since
    variable from_zero       : few_counts                              := "0000";
    variable from_index      : few_counts; -- of an index told now
    variable since_index     : natural range 0 to JUDGED_AFTER + 1     := 0;
    -- The angle before the step of the clock before, and from the zero of an index met there
    variable angle_then      : u_unsigned(ANGLE_WIDTH - 1 downto 0)    := (others => '0');
    variable from_zero_then  : few_counts                              := "0000";
    -- A mark was misplaced, and no two a turn apart have agreed since.
    variable is_in_doubt     : std_ulogic                              := '0';
    variable sets_zero       : std_ulogic;
    variable moves_zero      : std_ulogic;
    -- The angle of the last index told, less a turn, and which of them is the nearer to 0
    variable off_zero        : u_signed(COUNTS_PER_REV_WIDTH downto 0) := (others => '0');
    variable less_a_turn     : u_signed(COUNTS_PER_REV_WIDTH downto 0) := (others => '0');
    variable past_half       : u_signed(COUNTS_PER_REV_WIDTH + 1 downto 0) := (others => '0');
    variable slip            : u_signed(COUNTS_PER_REV_WIDTH - 1 downto 0) := (others => '0');
    -- The angle is neither 0 nor a turn.
    variable has_slip        : std_ulogic                              := '0';
    variable slip_then       : u_signed(COUNTS_PER_REV_WIDTH - 1 downto 0);
    variable is_slip         : std_ulogic;
    -- Indices told in the last clocks, the youngest in the low bit; one of them is judged, and no other came since
    variable told_then       : std_ulogic_vector(JUDGED_AFTER - 1 downto 0) := (others => '0');
    variable is_old_enough   : std_ulogic                              := '0';
    variable is_latest       : std_ulogic;
    variable is_small        : std_ulogic;
    -- An integer, since it counts in every clock: as a vector it makes an idle simulation 4 times slower.
    variable spacing         : natural range 0 to LARGEST              := LARGEST;
    variable too_near        : std_ulogic                              := '0';
    -- Place of (A, B) in 00, 10, 11, 01, of the clock of the position
    variable place           : u_unsigned(1 downto 0)                  := "00";
    variable passed_index    : std_ulogic                              := '0';
    variable passed_up       : std_ulogic                              := '1';
    -- Where an index told in this clock lies: after its step up, before its step down
    variable zero_now        : u_signed(POSITION_WIDTH - 1 downto 0)   := (others => '0');
    -- Stage 3: index
    variable index_before    : std_ulogic                              := '0';
    variable repeats         : std_ulogic                              := '0';
    -- Stage 4: the interval, less a turn upwards, less a turn downwards
    variable turn            : u_signed(POSITION_WIDTH - 1 downto 0)   := (others => '0');
    variable off_none        : u_signed(POSITION_WIDTH - 1 downto 0)   := (others => '0');
    variable off_up          : u_signed(POSITION_WIDTH - 1 downto 0)   := (others => '0');
    variable off_down        : u_signed(POSITION_WIDTH - 1 downto 0)   := (others => '0');
    variable to_judge        : std_ulogic                              := '0';
    -- Stage 5: which of them is within the tolerance
    variable are_within      : std_ulogic_vector(2 downto 0)           := "000";
    variable judged          : std_ulogic                              := '0';
    -- The index is not where it ought to be.
    variable misplaced       : std_ulogic;
    variable too_fast        : std_ulogic;

  begin

    if rising_edge(clock) then
      -- Faults, each with its event of the clock before.
      misplaced := judged and not (or are_within);
      -- Two marks a turn apart agree, or the other head counted a turn between this one and a good one.
      is_latest     := is_old_enough and not meets_index;
      moves_zero    := judged and (((are_within(1) or are_within(0)) and is_in_doubt) or (misplaced and other_head_agrees))
                       and zero_again and is_latest and is_long_turn;
      is_in_doubt   := (is_in_doubt or misplaced) and not moves_zero;
      index_trusted <= is_latest and not is_in_doubt and not rearm;
      is_slip       := moves_zero and has_slip and not rearm;
      is_small      := (and slip(slip'high downto HEAL_WIDTH - 1)) or not (or slip(slip'high downto HEAL_WIDTH - 1));
      misplaced     := misplaced or is_slip;
      too_fast  := too_near or edges_lost;
      if (clear = '1') then
        index_error       <= misplaced;
        index_error_count <= (0 => misplaced, others => '0');
        illegal           <= breaks_order;
        illegal_count     <= (0 => breaks_order, others => '0');
        overspeed         <= too_fast;
        overspeed_count   <= (0 => too_fast, others => '0');
        swallowed         <= edges_lost;
      else
        if (edges_lost = '1') then
          swallowed <= '1';
        end if;
        if (misplaced = '1') then
          index_error       <= '1';
          index_error_count <= saturating_increment(index_error_count);
        end if;
        if (breaks_order = '1') then
          illegal       <= '1';
          illegal_count <= saturating_increment(illegal_count);
        end if;
        if (too_fast = '1') then
          overspeed       <= '1';
          overspeed_count <= saturating_increment(overspeed_count);
        end if;
      end if;

      -- Stages 5 and 4: judge the index.
      judged     := to_judge;
      are_within := is_within(off_none, index_tolerance) & is_within(off_up, index_tolerance)
                    & is_within(off_down, index_tolerance);
      to_judge   := repeats;
      off_none   := index_interval;
      off_up     := index_interval - turn;
      off_down   := index_interval + turn;

      -- Stage 3: latch the index of the clock before.
      told_then    := told_then(told_then'high - 1 downto 0) & (passed_index and not rearm);
      index_strobe <= '0';
      repeats      := '0';
      if (passed_index = '1' and rearm = '0') then
        index_strobe    <= '1';
        repeats         := index_before;
        index_position  <= zero_now;
        index_direction <= passed_up;
        index_interval  <= (others => '0');
        if (index_before = '1') then
          index_interval <= zero_now - index_position;
        end if;
        index_before := '1';
      end if;

      phase_of_zero <= place - u_unsigned(position(1 downto 0));

      -- Stage 2: take the step.
      place     := before(1) & (before(2) xor before(1));
      if (preload = '1') then
        phase_of_zero <= "00";
        place         := filtered(1) & (filtered(2) xor filtered(1));
      end if;
      zero_now  := add_with_carry(position, (position'range => leaves_inside), not meets_up);
      direction <= up;
      step      <= moves;
      step_up   <= moves and up;

      too_near := '0';
      if (moves = '1') then
        if (up = '1') then
          position      <= position + 1;
          turn_position <= turn_position + 1;
        else
          position      <= not (not position + 1);
          turn_position <= not (not turn_position + 1);
        end if;

        last_edge_time <= timestamp;
        if (spacing < minimum_edge_spacing) then
          too_near := '1';
        end if;
        spacing := 1;
      elsif (spacing /= LARGEST) then
        spacing := spacing + 1;
      end if;

      -- The angle of the index, while it is judged; the step that it was met with is in neither.
      has_slip  := not ((off_zero ?= 0) or (off_zero ?= turn(off_zero'range)));
      slip_then := slip;
      slip      := less_a_turn(slip'range);
      if (past_half(past_half'high) = '1') then
        slip := off_zero(slip'range);
      end if;
      less_a_turn := off_zero - turn(off_zero'range);
      past_half   := (off_zero & '0') - turn(past_half'range);
      if (since_index = 0) then
        off_zero := signed(resize(angle_then, off_zero'length)) - resize(from_zero_then, off_zero'length);
      end if;
      angle_then     := place_of_angle;
      from_zero_then := BEFORE_INDEX_OF(to_integer(u_unsigned'(meets_inside & meets_up)));

      passed_index := meets_index;
      passed_up    := meets_up;
      -- From the zero to where the step of this clock leads.
      sets_zero := moves_zero;
      from_index := BEHIND_INDEX_OF(to_integer(u_unsigned'(not stands & up & meets_inside & meets_up)));
      if (meets_index = '1') then
        from_zero   := from_index;
        since_index := 0;
        sets_zero   := not index_seen;
        index_seen  <= '1';
      else
        from_zero := WITH_STEP(to_integer(u_unsigned(std_ulogic_vector(from_zero) & not stands & up)));
        if (since_index <= JUDGED_AFTER) then
          since_index := since_index + 1;
        end if;
      end if;

      places(0) := next_place(places(0), last_angle, before_last, stands, up, meets_index and is_second, from_index);
      places(1) := next_place(places(1), last_angle, before_last, stands, up, meets_index and not is_second, from_index);
      if (sets_zero = '1') then
        turn_position <= resize(from_zero, POSITION_WIDTH);
        is_second     := not is_second;
      end if;

      if (is_slip = '1') then
        zero_moved <= not zero_moved;
        zero_moves <= zero_moves + 1;
        zero_slip  <= slip_then;
        if (heal = '1' and is_small = '1') then
          put_back <= put_back - slip_then;
        end if;
      end if;

      -- What the filter swallows: steps of the clock before, at its input and at its output.
      edges_lost := '0';
      if (settling(settling'high - 1) = '1' or is_quiet = '1') then
        ahead         := "000";
        hidden_breaks := 0;
      else
        ahead_now  := AHEAD_AFTER(to_integer(u_unsigned(std_ulogic_vector(ahead) & raw_moves & raw_up & not stands & not down)));
        ahead      := ahead_now(ahead'range);
        edges_lost := ahead_now ?= PERIOD;
        if (breaks_order = '1') then
          hidden_breaks := 0;
        elsif (raw_breaks = '1' and hidden_breaks = PERIOD - 1) then
          edges_lost := '1';
        elsif (raw_breaks = '1') then
          hidden_breaks := hidden_breaks + 1;
        end if;
        if (edges_lost = '1') then
          ahead         := "000";
          hidden_breaks := 0;
        end if;
      end if;

      raw_changes := levels(2 downto 1) xor raw_before;
      raw_moves   := raw_changes(1) xor raw_changes(0);
      raw_breaks  := raw_changes(1) and raw_changes(0);
      raw_up      := levels(2) xor raw_before(0);
      is_quiet    := '0';
      if (raw_changes /= "00") then
        still := (others => '0');
      else
        is_quiet := still ?>= filter_length;
        if (still /= LONGEST_FILTER) then
          still := still + 1;
        end if;
      end if;
      raw_before := levels(2 downto 1);

      -- Stage 1: compare the levels with those of the clock before.
      a_changes    := filtered(2) xor before(2);
      b_changes    := filtered(1) xor before(1);
      breaks_order := a_changes and b_changes and not preload;
      moves        := (a_changes xor b_changes) and not preload;
      stands       := not moves;

      -- Z of the step before: when the pins had time to settle, or the last level before this step.
      settled_level := filtered(0);
      settles       := '0';
      -- It had for so long that it may have changed again within the count that a step leaves now.
      may_be_inside := '0';
      if (until_settled = 0 and since_settled >= INDEX_SKEW) then
        may_be_inside := '1';
      end if;

      if (until_settled /= 0) then
        if (moves = '1') then
          settled_level := before(0);
          settles       := '1';
        elsif (until_settled = 1) then
          settles := '1';
        end if;
        until_settled := until_settled - 1;
      end if;

      if (since_settled <= INDEX_SKEW) then
        since_settled := since_settled + 1;
      end if;

      meets_index := '0';
      if (settles = '1') then
        meets_inside  := was_inside and (index_level xnor up);
        meets_index   := meets_inside or ((settled_level xor index_level) and (settled_level xnor up));
        meets_up      := up;
        leaves_inside := up and meets_inside;
        index_level   := settled_level;
        until_settled := 0;
        since_settled := 0;
      end if;

      if (preload = '1') then
        meets_index   := '0';
        until_settled := 0;
        since_settled := 0;
        index_level   := filtered(0);
      end if;

      if (moves = '1') then
        up            := filtered(2) xor before(1);
        down          := filtered(2) xnor before(1);
        until_settled := INDEX_SKEW;
        was_inside    := '0';
        if (may_be_inside = '1') then
          was_inside  := earlier_levels(INDEX_SKEW) xor index_level;
          index_level := earlier_levels(INDEX_SKEW);
        end if;
      end if;
      earlier_levels := earlier_levels(INDEX_SKEW - 1 downto 0) & filtered(0);
      before         := filtered;

      -- Only where nothing counts by them.
      is_long_turn := or last_angle(last_angle'high downto 3);
      if (reset = '1' or preload = '1' or rearm = '1') then
        turn        := signed(resize(counts_per_rev, POSITION_WIDTH));
        last_angle  := resize(counts_per_rev - 1, ANGLE_WIDTH);
        before_last := resize(counts_per_rev - 2, ANGLE_WIDTH);
      end if;

      if (rearm = '1') then
        places         := (others => ZERO_PLACE);
        turn_position  <= (others => '0');
        index_seen     <= '0';
        index_interval <= (others => '0');
        passed_index   := '0';
        index_before   := '0';
        is_in_doubt    := '0';
        told_then      := (others => '0');
      end if;

      if (reset = '1') then
        moves             := '0';
        stands            := '1';
        up                := '1';
        down              := '0';
        until_settled     := 0;
        breaks_order      := '0';
        meets_index       := '0';
        spacing           := LARGEST;
        too_near          := '0';
        edges_lost        := '0';
        passed_index      := '0';
        index_before      := '0';
        repeats           := '0';
        is_in_doubt       := '0';
        told_then         := (others => '0');
        index_trusted     <= '0';
        zero_moved        <= '0';
        zero_moves        <= (others => '0');
        zero_slip         <= (others => '0');
        put_back          <= (others => '0');
        to_judge          := '0';
        judged            := '0';
        position          <= to_signed(RESET_POSITION, POSITION_WIDTH);
        places            := (others => ZERO_PLACE);
        turn_position     <= (others => '0');
        direction         <= '1';
        phase_of_zero     <= "00";
        step              <= '0';
        step_up           <= '0';
        last_edge_time    <= (others => '0');
        index_seen        <= '0';
        index_strobe      <= '0';
        index_position    <= (others => '0');
        index_direction   <= '1';
        index_interval    <= (others => '0');
        index_error       <= '0';
        index_error_count <= (others => '0');
        illegal           <= '0';
        illegal_count     <= (others => '0');
        overspeed         <= '0';
        overspeed_count   <= (others => '0');
        swallowed         <= '0';
      end if;

      is_old_enough := '0';
      if (since_index = JUDGED_AFTER) then
        is_old_enough := told_then(JUDGED_AFTER - 1);
      end if;

      counters        <= places;
      angle_is_second <= is_second;
    end if;

  end process decode;

  settle : process (clock) is
  begin

    if rising_edge(clock) then
      settling <= settling(settling'high - 1 downto 0) & '0';
      if (reset = '1') then
        settling <= (others => '1');
      end if;
    end if;

  end process settle;

end architecture rtl;
