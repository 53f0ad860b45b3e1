-- SPDX-License-Identifier: Apache-2.0
--
-- # index_zero
--
-- Counts the angle modulo `counts_per_rev` from the zero that the first index mark defines (index_detector detects it).
-- It checks the distance between marks and, if `zero_again` permits, moves the zero. Source: section 3.1 and figure 5
-- of the paper.
--
-- **Latency.** angle and turn_position change 1 clock after `edge.moves`, in the same clock as the position of
-- edge_counter. At the first index, index_seen rises, and the angle counts from the new zero, INDEX_SKEW clocks after
-- the step of the index, or with the next step if that step comes earlier. index_strobe, index_position,
-- index_direction and index_interval follow 1 clock after index_seen (at later indices: 1 clock after the clock in
-- which index_seen would rise). `misplaced` comes 2 clocks after index_strobe, one clock before the angle counts from a
-- moved zero.
--
-- **Number formats.** position, turn_position, index_position and index_interval s31.0 counts; angle u24.0 counts;
-- counts_per_rev u25.0 counts; index_tolerance u16.0 counts.
--
-- **Angle.** The angle has its own counter, so it stays correct when the position wraps. `turn_position` is position -
-- position of the zero, and wraps likewise. As long as neither of the two wraps, angle equals turn_position modulo
-- counts_per_rev in every clock, even before the first index.
--
-- **Index.** The first index after reset or rearm defines the zero of angle and turn_position; later indices do not
-- change this zero, except by `zero_again`. Each later index must lie 0 or +-counts_per_rev from the index before it,
-- within +-`index_tolerance`; otherwise `index_error` is set, because counts or an index were lost or added. The
-- position of a true mark repeats within +-1 count, so two of its positions differ by up to 2 counts; a slip by one
-- period of A and B adds 4 counts. `index_interval` reads 0 while there are fewer than two marks.
--
-- **Moving the zero.** With `zero_again` high the zero moves 3 clocks after the `index_strobe` of a mark that proves
-- the zero wrong. A mark proves this in two cases. Either it is misplaced and `other_head_agrees` is high (see
-- zero_witness; possible at the first mark after lost counts). Or an `index_error` came before it, and it is the first
-- mark since then that lies one turn, within the tolerance, from the mark before it (the second mark after lost
-- counts). A single false mark does not move the zero, because no other mark lies one turn from it. `index_seen` stays
-- high, so the correction continues. If a turn has less than 9 counts, the zero never moves. If the zero moves to
-- another count, the following happens in the clock in which angle and turn_position first count from the new zero.
-- `zero_slip` becomes the angle that the mark had (the negative of the lost counts), `zero_moved` toggles, `zero_moves`
-- increments, index_error is set, and its counter increments once. The position keeps its error. With `heal` high,
-- `zero_slip` is subtracted from `put_back` in that clock, so that position + put_back does not contain the slip; a
-- slip outside of -2¹⁴ to 2¹⁴ - 1 counts is not put back. `index_trusted` pulses 3 clocks after index_strobe if the
-- mark lies at the zero.
--
-- **Rearm.** While `rearm` is high, angle and turn_position are 0 and the index is cleared (index_seen and
-- index_interval are 0; index_position keeps its value). The position keeps counting. After rearm, angle and
-- turn_position count from 0 with the first step, and the next index defines the zero again. `counts_per_rev` (4 to
-- 2²⁴, any integer) is sampled while rearm, preload or reset is high; at other times a change has no effect.
-- index_tolerance may change at any time.
--
-- **Reset** clears the index and all outputs.

library ieee;
  use ieee.std_logic_1164.all;
  use ieee.numeric_std.all;

  use work.carry_save_pkg.all;
  use work.decoder_pkg.all;
  use work.number_formats_pkg.all;
  use work.tolerance_pkg.all;

entity index_zero is
  port (
    clock             : in    std_ulogic;
    reset             : in    std_ulogic;
    preload           : in    std_ulogic;                                    -- level: detection starts from the present level of Z
    z                 : in    std_ulogic;                                    -- index, filtered
    edge              : in    counted_edge;
    position          : in    u_signed(POSITION_WIDTH - 1 downto 0);         -- counts, of edge_counter
    counts_per_rev    : in    u_unsigned(COUNTS_PER_REV_WIDTH - 1 downto 0); -- counts, 4 to 2**24
    index_tolerance   : in    u_unsigned(15 downto 0);                       -- counts
    rearm             : in    std_ulogic;                                    -- level: clears the index
    zero_again        : in    std_ulogic;                                    -- level: the zero moves if a mark proves it wrong
    heal              : in    std_ulogic;                                    -- level: lost counts are added to put_back
    other_head_agrees : in    std_ulogic;                                    -- the other head confirms the mark, see zero_witness
    angle             : out   u_unsigned(ANGLE_WIDTH - 1 downto 0);          -- counts, below counts_per_rev
    turn_position     : out   u_signed(POSITION_WIDTH - 1 downto 0);         -- counts from the zero
    index_seen        : out   std_ulogic;                                    -- level: an index has been seen
    index_strobe      : out   std_ulogic;                                    -- strobe: the three outputs below are new
    index_position    : out   u_signed(POSITION_WIDTH - 1 downto 0);         -- counts, position of the last index
    index_direction   : out   std_ulogic;                                    -- '1': the last index was passed upwards
    index_interval    : out   u_signed(POSITION_WIDTH - 1 downto 0);         -- counts between the last two indices
    index_trusted     : out   std_ulogic;                                    -- strobe: the last index lies at the zero
    zero_moved        : out   std_ulogic;                                    -- toggles when the zero moves to another count
    zero_moves        : out   u_unsigned(15 downto 0);                       -- number of moves of the zero; wraps
    zero_slip         : out   u_signed(COUNTS_PER_REV_WIDTH - 1 downto 0);   -- counts, angle of the mark that last moved the zero
    put_back          : out   u_signed(POSITION_WIDTH - 1 downto 0);         -- counts put back for lost counts, to be added to position
    misplaced         : out   std_ulogic                                     -- strobe: a mark lies outside the tolerance
  );
end entity index_zero;

architecture rtl of index_zero is

  -- A count within the turn. It carries flags for the first and the last count, so that a step needs no comparison.
  type turn_place is record
    count   : u_unsigned(ANGLE_WIDTH - 1 downto 0);
    is_zero : std_ulogic;
    is_last : std_ulogic;
  end record turn_place;

  type turn_places is array (0 to 1) of turn_place;

  constant ZERO_PLACE : turn_place := (count => (others => '0'), is_zero => '1', is_last => '0');

  -- A small number of counts. Sums of these numbers are tables, because they are too narrow for a carry chain.
  subtype few_counts is u_signed(3 downto 0);

  type tables is array (natural range <>) of few_counts;

  -- Returns the table of small numbers after a step. Index: the number before (bits 5 to 2), there is a step (bit 1),
  -- the step is up (bit 0).
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

  -- Returns the table of the counts from the zero of an index to the position, for the clock in which the index is
  -- detected. Index: there is a step in this clock (bit 3), the step is up (bit 2), the index lies within a count (bit
  -- 1), the index is passed upwards (bit 0).
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

  -- Counts from the zero of an index to the position before the step of the clock. Index: the index lies within a count
  -- (bit 1), the index is passed upwards (bit 0).
  constant BEFORE_INDEX_OF : tables(0 to 3) := BEHIND_INDEX_OF(0 to 3);

  -- Returns the count after a step. If an index is detected, it returns the count that lies `from_zero` (-2 to 2)
  -- counts from 0 instead. The cases exclude each other, so that a bit needs one look-up table after the carry chains
  -- of the two neighbouring counts.
  function next_place (
    place             : turn_place;
    last, before_last : u_unsigned(ANGLE_WIDTH - 1 downto 0);
    stands, up        : std_ulogic;
    has_index         : std_ulogic;
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
    if (stands = '1' and has_index = '0') then
      return result;
    end if;

    rises     := not has_index and up and not place.is_last;
    falls     := not has_index and not up and not place.is_zero;
    is_last   := (not has_index and not up and place.is_zero) or (has_index and (from_zero ?= -1));
    is_zero   := (not has_index and up and place.is_last) or (has_index and (from_zero ?= 0));
    is_before := has_index and (from_zero ?= -2);

    -- Count 1 or count 2.
    first    := (others => '0');
    first(0) := has_index and (from_zero ?= 1);
    first(1) := has_index and (from_zero ?= 2);

    -- not (not x + 1) = x - 1, on the same carry chain as x + 1.
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

  -- The two counters of the process `find`, and which of them is the angle
  signal counters        : turn_places := (others => ZERO_PLACE);
  signal angle_is_second : std_ulogic  := '0';
  signal place_of_angle  : u_unsigned(ANGLE_WIDTH - 1 downto 0);

  -- Stage 1, of index_detector. meets_index is high if an index that belongs to the previous step is detected in this
  -- clock.
  signal meets_index   : std_ulogic;
  signal meets_up      : std_ulogic;
  signal meets_inside  : std_ulogic;
  signal leaves_inside : std_ulogic;
  -- judged is high in the clock in which a mark is checked. are_within has one flag for each permitted distance from
  -- the previous mark, within the tolerance: 0 (bit 2), a turn up (bit 1), a turn down (bit 0)
  signal judged        : std_ulogic                    := '0';
  signal are_within    : std_ulogic_vector(2 downto 0) := "000";
  -- is_latest is high if the checked mark is the latest mark.
  signal is_old_enough : std_ulogic                    := '0';
  signal is_latest     : std_ulogic;
  -- High from a misplaced mark until a rearm or, if `zero_again` is high, until the zero moves or is confirmed
  -- (`moves_zero`).
  signal is_in_doubt   : std_ulogic                    := '0';
  -- High if the angle of the mark is neither 0 nor a whole turn.
  signal has_slip      : std_ulogic                    := '0';
  -- High if a turn has more than 8 counts.
  signal is_long_turn  : std_ulogic                    := '0';
  signal is_off        : std_ulogic;
  signal moves_zero    : std_ulogic;
  signal is_slip       : std_ulogic;

begin

  place_of_angle <= counters(1).count when angle_is_second = '1' else
                    counters(0).count;
  angle          <= place_of_angle;

  -- The zero moves if two marks lie one turn apart after a misplaced mark, or if a mark is misplaced and the other head
  -- counted one turn between the last trusted mark and this mark.
  is_off     <= judged and not (or are_within);
  is_latest  <= is_old_enough and not meets_index;
  moves_zero <= judged and (((are_within(1) or are_within(0)) and is_in_doubt) or (is_off and other_head_agrees))
                and zero_again and is_latest and is_long_turn;
  is_slip    <= moves_zero and has_slip and not rearm;
  misplaced  <= is_off or is_slip;

  detector : entity work.index_detector
    port map (
      clock         => clock,
      reset         => reset,
      preload       => preload,
      z             => z,
      edge          => edge,
      meets         => meets_index,
      is_up         => meets_up,
      is_inside     => meets_inside,
      leaves_inside => leaves_inside
    );

  find : process (clock) is

    -- Stage 2: two counters. One counter counts from the zero, the other one from the latest index. If the zero moves
    -- to that index, the counters exchange their roles.
    variable places          : turn_places                             := (others => ZERO_PLACE);
    variable is_second       : std_ulogic                              := '0'; -- number of the counter that is the angle
    variable last_angle      : u_unsigned(ANGLE_WIDTH - 1 downto 0)    := (others => '0');
    variable before_last     : u_unsigned(ANGLE_WIDTH - 1 downto 0)    := (others => '0');
    -- Counts from the zero of the latest index to the position, while this index is checked, and number of clocks since
    -- the index was detected
    variable from_zero       : few_counts                              := "0000";
    variable from_index      : few_counts; -- counts from the zero of the index that is detected now
    variable since_index     : natural range 0 to INDEX_JUDGED_AFTER + 1 := 0;
    -- The angle before the step of the previous clock, and the counts from the zero of an index that was detected in
    -- that clock to this angle
    variable angle_then      : u_unsigned(ANGLE_WIDTH - 1 downto 0)    := (others => '0');
    variable from_zero_then  : few_counts                              := "0000";
    variable still_in_doubt  : std_ulogic;
    variable sets_zero       : std_ulogic;
    -- The angle of the latest index, this angle minus a turn, and a number that is negative if the first of the two is
    -- nearer to 0
    variable off_zero        : u_signed(COUNTS_PER_REV_WIDTH downto 0) := (others => '0');
    variable less_a_turn     : u_signed(COUNTS_PER_REV_WIDTH downto 0) := (others => '0');
    variable past_half       : u_signed(COUNTS_PER_REV_WIDTH + 1 downto 0) := (others => '0');
    variable slip            : u_signed(COUNTS_PER_REV_WIDTH - 1 downto 0) := (others => '0');
    variable slip_then       : u_signed(COUNTS_PER_REV_WIDTH - 1 downto 0);
    -- One bit for each of the last clocks, high if an index was latched in that clock; the latest clock is the low bit
    variable index_then      : std_ulogic_vector(INDEX_JUDGED_AFTER - 1 downto 0) := (others => '0');
    variable is_small        : std_ulogic;
    variable passed_index    : std_ulogic                              := '0';
    variable passed_up       : std_ulogic                              := '1';
    -- Position of an index that is detected in this clock: the position after the step if counting up, before the step
    -- if counting down
    variable zero_now        : u_signed(POSITION_WIDTH - 1 downto 0)   := (others => '0');
    -- Stage 3. index_before: an index has been latched. repeats: an index came before the latest index.
    variable index_before    : std_ulogic                              := '0';
    variable repeats         : std_ulogic                              := '0';
    -- Stage 4: a turn, the interval, the interval minus a turn, and the interval plus a turn
    variable turn            : u_signed(POSITION_WIDTH - 1 downto 0)   := (others => '0');
    variable off_none        : u_signed(POSITION_WIDTH - 1 downto 0)   := (others => '0');
    variable off_up          : u_signed(POSITION_WIDTH - 1 downto 0)   := (others => '0');
    variable off_down        : u_signed(POSITION_WIDTH - 1 downto 0)   := (others => '0');
    variable to_judge        : std_ulogic                              := '0';

  begin

    if rising_edge(clock) then
      still_in_doubt := (is_in_doubt or is_off) and not moves_zero;
      is_in_doubt    <= still_in_doubt;
      index_trusted  <= is_latest and not still_in_doubt and not rearm;
      is_small       := (and slip(slip'high downto INDEX_HEAL_WIDTH - 1)) or not (or slip(slip'high downto INDEX_HEAL_WIDTH - 1));

      -- Stages 5 and 4: check the index.
      judged     <= to_judge;
      are_within <= is_within(off_none, index_tolerance) & is_within(off_up, index_tolerance)
                    & is_within(off_down, index_tolerance);
      to_judge   := repeats;
      off_none   := index_interval;
      off_up     := index_interval - turn;
      off_down   := index_interval + turn;

      -- Stage 3: latch the index of the clock before.
      index_then   := index_then(index_then'high - 1 downto 0) & (passed_index and not rearm);
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

      -- Stage 2: count the step.
      zero_now := add_with_carry(position, (position'range => leaves_inside), not meets_up);
      if (edge.moves = '1') then
        if (edge.up = '1') then
          turn_position <= turn_position + 1;
        else
          -- not (not x + 1) = x - 1, on the same carry chain as x + 1.
          turn_position <= not (not turn_position + 1);
        end if;
      end if;

      -- Compute the angle of the index while the index is checked, without the step at which it was detected.
      has_slip  <= not ((off_zero ?= 0) or (off_zero ?= turn(off_zero'range)));
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
      -- Count from the zero of the index, including the step of this clock.
      sets_zero := moves_zero;
      from_index := BEHIND_INDEX_OF(to_integer(u_unsigned'(not edge.stands & edge.up & meets_inside & meets_up)));
      if (meets_index = '1') then
        from_zero   := from_index;
        since_index := 0;
        sets_zero   := not index_seen;
        index_seen  <= '1';
      else
        from_zero := WITH_STEP(to_integer(u_unsigned(std_ulogic_vector(from_zero) & not edge.stands & edge.up)));
        if (since_index <= INDEX_JUDGED_AFTER) then
          since_index := since_index + 1;
        end if;
      end if;

      places(0) := next_place(places(0), last_angle, before_last, edge.stands, edge.up, meets_index and is_second, from_index);
      places(1) := next_place(places(1), last_angle, before_last, edge.stands, edge.up, meets_index and not is_second, from_index);
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

      -- A new counts_per_rev is sampled only while no unit counts with the old value.
      is_long_turn <= or last_angle(last_angle'high downto 3);
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
        is_in_doubt    <= '0';
        index_then     := (others => '0');
      end if;

      if (reset = '1') then
        passed_index    := '0';
        index_before    := '0';
        repeats         := '0';
        is_in_doubt     <= '0';
        index_then      := (others => '0');
        index_trusted   <= '0';
        zero_moved      <= '0';
        zero_moves      <= (others => '0');
        zero_slip       <= (others => '0');
        put_back        <= (others => '0');
        to_judge        := '0';
        judged          <= '0';
        places          := (others => ZERO_PLACE);
        turn_position   <= (others => '0');
        index_seen      <= '0';
        index_strobe    <= '0';
        index_position  <= (others => '0');
        index_direction <= '1';
        index_interval  <= (others => '0');
      end if;

      is_old_enough <= '0';
      if (since_index = INDEX_JUDGED_AFTER) then
        is_old_enough <= index_then(INDEX_JUDGED_AFTER - 1);
      end if;

      counters        <= places;
      angle_is_second <= is_second;
    end if;

  end process find;

end architecture rtl;
