-- SPDX-License-Identifier: Apache-2.0
--
-- # quadrature_output
--
-- Generates the encoder signals A, B and Z from the corrected position, one edge of A or B per count, so that a servo
-- drive reads the compensated angle. While the position rises, A leads B: (A, B) = 00, 10, 11, 01. Source: the end of
-- section 3.3 of the paper (output of the compensated signal) and figure 4 (order of the levels).
--
-- **Latency.** 6 clocks from `corrected_position` to the edge, if no rule below delays the edge. `following_error`
-- follows the position by 2 clocks and `cannot_keep_up` by 3; the last edge comes at most 3 clocks after
-- `cannot_keep_up` rises. A change of `enable` reaches `following_error` after 2 or 3 clocks; a change of
-- `following_limit` or `counts_per_rev` reaches `cannot_keep_up` after 3 to 5 clocks. A change of `phase_of_zero`
-- reaches the output's count, and a change of the settings of a gated Z reaches `z`, after 2 clocks.
--
-- **Number formats.** corrected_position s31.0 counts, multi-turn; corrected_angle u24.0 counts, the angle of the same
-- reading; minimum_spacing u16.0 clocks; following_limit u16.0 counts; following_error s31.0 counts; phase_of_zero and
-- z_state are indices in 00, 10, 11, 01.
--
-- **Edges.** Two edges of A and B are at least `minimum_spacing` clocks apart (0 acts as 1: an edge in every clock); a
-- change of minimum_spacing applies from the next edge on. A and B never change together. After a reversal the output
-- waits until the position is 2 counts away from the output's count: a position that vibrates between two neighbouring
-- counts gives no edges. Once the position has moved by these 2 counts, the output equals the position again.
--
-- **Phase.** At each count, A and B have the levels that the head's own A and B have at this count: the index of (A, B)
-- in 00, 10, 11, 01 is the output's count + `phase_of_zero`, modulo 4. So the zero lies in the same state of A and B
-- after every power-up, if counts_per_rev is a multiple of 4. The entity samples `phase_of_zero` while the output does
-- not follow the position; counts that the head loses while the output follows do not change the sampled value.
-- `phase_of_zero` belongs to the head's latest count, which is ahead of `corrected_position` by the latency of the
-- pipeline. Counts that are put back within this latency reach the output by the ramp; after that the output's levels
-- equal the head's levels. (If `phase_of_zero` were delayed like the position, the levels would stay wrong by these
-- counts.)
--
-- **Z** marks the zero of the output's angle, which is corrected_angle - following error, modulo counts_per_rev. Z is
-- high for 1, 2 or 4 counts (`z_width` 0, 1, 2: a quarter, half, or a whole period of A and B). If `z_gated` is low, Z
-- begins at the zero. If `z_gated` is high, Z begins in the state `z_state` of A and B (index in 00, 10, 11, 01), at
-- the only count with this state in the range from 2 counts before the zero to 1 count after it. Z changes together
-- with an edge of A or B. If corrected_angle jumps relative to corrected_position (first index), Z follows the new
-- angle 4 clocks later, without an edge of A and B. Z is low while `referenced` is low, because the angle then has no
-- zero on the table: before the first index of the head, and from a re-arm to the next index. (Z is correct even for
-- the smallest turn, 4 counts, at an edge every clock, when 4 counts are in the pipeline and 1 more count is held
-- back.)
--
-- **Pins.** `invert_a`, `invert_b` and `invert_z` invert the levels of their pins; `swap_ab` exchanges A and B before
-- the inversion, so that the receiver counts in the other direction. The rules above for edges, phase and Z apply to
-- the signals before exchange and inversion. Change these settings only while no receiver counts: a change causes one
-- edge, or two edges in the same clock.
--
-- **Enable.** While `enable` is low, A, B and Z keep their levels (an edge already decided may still come within 3
-- clocks) and the following error is 0. When `enable` rises, at most 2 edges lead from the held levels of A and B to
-- the levels of the present position; Z takes the level of the present angle.
--
-- **Following error** is the position minus the output's count. An edge that is decided but still within the 4 clocks
-- of the pipeline is not yet in the output's count: at one edge per clock, these are 4 counts. The following error is 0
-- while the output is disabled and after a fault.
--
-- **Fault.** While `enable` is high, `cannot_keep_up` is set when |following error| exceeds `following_limit` or 2 *
-- counts_per_rev - 1. From then on the output stands still as if disabled. It does not make up for the missed counts,
-- so it never moves on by itself after it has stopped. `clear` ends the fault: the output starts from the present
-- position, as when `enable` rises. The receiver loses the counts in between and has to find its zero again. A low
-- `enable` does not clear the fault. Below the limit every count is sent, at most following_limit * minimum_spacing
-- clocks late.
--
-- **Reset** stops the output and clears the fault; Z is low. A and B keep their levels; otherwise a receiver could get
-- a falling edge of both in the same clock. At power-up they are low.

library ieee;
  use ieee.std_logic_1164.all;
  use ieee.numeric_std.all;

  use work.carry_save_pkg.all;
  use work.number_formats_pkg.all;

entity quadrature_output is
  port (
    clock              : in    std_ulogic;
    reset              : in    std_ulogic;
    enable             : in    std_ulogic;
    clear              : in    std_ulogic;                                    -- pulse: clears cannot_keep_up
    invert_a           : in    std_ulogic := '0';                             -- inverts the pin
    invert_b           : in    std_ulogic := '0';                             -- inverts the pin
    invert_z           : in    std_ulogic := '0';                             -- inverts the pin
    swap_ab            : in    std_ulogic := '0';                             -- exchanges A and B before the inversion
    corrected_position : in    u_signed(POSITION_WIDTH - 1 downto 0);         -- counts, multi-turn
    corrected_angle    : in    u_unsigned(ANGLE_WIDTH - 1 downto 0);          -- counts, below counts_per_rev
    referenced         : in    std_ulogic;                                    -- corrected_angle counts from an index
    phase_of_zero      : in    u_unsigned(1 downto 0);                        -- index of (A, B) in 00, 10, 11, 01 at position 0
    z_gated            : in    std_ulogic;                                    -- 1: Z begins in z_state, 0: at the zero
    z_state            : in    u_unsigned(1 downto 0);                        -- index of (A, B) in 00, 10, 11, 01
    z_width            : in    u_unsigned(1 downto 0);                        -- 0: 1 count, 1: 2 counts, 2: 4 counts
    counts_per_rev     : in    u_unsigned(COUNTS_PER_REV_WIDTH - 1 downto 0); -- counts
    minimum_spacing    : in    u_unsigned(15 downto 0);                       -- clocks
    following_limit    : in    u_unsigned(15 downto 0);                       -- counts
    a                  : out   std_ulogic := '0';
    b                  : out   std_ulogic := '0';
    z                  : out   std_ulogic := '0';
    following_error    : out   u_signed(POSITION_WIDTH - 1 downto 0);         -- counts
    cannot_keep_up     : out   std_ulogic := '0'                              -- sticky: the output has stopped
  );
end entity quadrature_output;

architecture rtl of quadrature_output is

  -- `lag` does not include the steps of the last three clocks: the first two are subtracted when the lag is narrowed,
  -- the last one in the decision on a step.
  constant STEPS_UNDER_WAY : positive := 2;

  -- A small number in thermometer code: bit k is high if the number is k or more. A shift of the bits by one place
  -- subtracts a step, so the decision on a step needs no adder.
  type thermometer is array (4 downto -3) of std_ulogic;

  -- Width of a limit of the lag: -2 to +2 turns in counts.
  constant LIMIT_WIDTH : positive := COUNTS_PER_REV_WIDTH + 2;

  -- One number for each turn, from 2 turns before to 1 turn after the turn of the corrected angle.
  type of_turns is array (-2 to 1) of u_signed(POSITION_WIDTH - 1 downto 0);

  function counts_of (width : u_unsigned(1 downto 0)) return positive is
  begin

    if width = 0 then
      return 1;
    elsif width = 1 then
      return 2;
    end if;
    return 4;

  end function counts_of;

  -- Level of a Z that is not gated, by the number of counts after the zero.
  function is_high_ungated (behind_zero : u_signed(3 downto 0); width : u_unsigned(1 downto 0)) return std_ulogic is
  begin

    if behind_zero >= 0 and behind_zero < counts_of(width) then
      return '1';
    end if;
    return '0';

  end function is_high_ungated;

  type gate_table is array (0 to 63) of std_ulogic;

  -- For a gated Z: high if the count at which (A, B) entered z_state, behind_zero - behind_state, lies from 2 counts
  -- before the zero to 1 count after it. The index is behind_zero (4 bits) and behind_state (2 bits). A table replaces
  -- the subtraction, which would need a carry chain.
  function gate_of_place return gate_table is

    variable table  : gate_table;
    variable behind : integer range -11 to 7;

  begin

    for bits in table'range loop
      behind      := to_integer(u_signed(to_unsigned(bits / 4, 4))) - bits mod 4;
      table(bits) := '0';
      if behind >= -2 and behind <= 1 then
        table(bits) := '1';
      end if;
    end loop;

    return table;

  end function gate_of_place;

  constant GATE : gate_table := gate_of_place;

  function thermometer_of (number : u_signed(2 downto 0)) return thermometer is

    variable result : thermometer;

  begin

    for k in thermometer'range loop
      result(k) := resize(number, 4) ?>= k;
    end loop;

    return result;

  end function thermometer_of;

  function less_a_step (number : thermometer; up, down : std_ulogic) return thermometer is

    variable result : thermometer;

  begin

    result := number;
    if up = '1' then
      result := '0' & number(4 downto -2);
    elsif down = '1' then
      result := number(3 downto -3) & '1';
    end if;
    return result;

  end function less_a_step;

begin

  follow : process (clock) is

    -- `following` is the enable (without a fault) one clock ago; `enabled` holds the two values before that, (0) the
    -- later one.
    variable following   : std_ulogic                               := '0';
    variable a_level     : std_ulogic;
    variable b_level     : std_ulogic;
    variable z_level     : std_ulogic                               := '0';
    variable is_at_zero  : std_ulogic;
    variable z_follows   : std_ulogic;
    variable z_held      : std_ulogic;
    variable enabled     : std_ulogic_vector(1 downto 0)            := (others => '0');
    -- High if the output follows the position, and has followed it for two clocks.
    variable is_open     : std_ulogic                               := '0';
    variable output      : u_signed(POSITION_WIDTH - 1 downto 0)    := (others => '0');
    variable lag         : u_signed(POSITION_WIDTH - 1 downto 0)    := (others => '0');
    variable negative    : std_ulogic;
    variable is_far      : std_ulogic;
    -- The lag minus the steps under way, except a step of the previous clock; one_up accounts for that step. If one_up
    -- is high, a step up needs one count of lag and a step down two; otherwise a step up needs two and a step down one.
    variable remaining   : thermometer                              := (4 downto 1 => '0', others => '1');
    variable one_up      : std_ulogic                               := '1';
    -- Steps: (0) the step that the output makes now, (1) the step before
    variable up          : std_ulogic_vector(STEPS_UNDER_WAY - 1 downto 0) := (others => '0');
    variable down        : std_ulogic_vector(STEPS_UNDER_WAY - 1 downto 0) := (others => '0');
    variable step_up     : std_ulogic;
    variable step_down   : std_ulogic;
    variable last_was_up : std_ulogic                               := '1';
    variable spacing     : u_unsigned(15 downto 0)                  := (others => '0');
    variable may_step    : std_ulogic                               := '1';
    variable phase       : u_unsigned(1 downto 0)                   := "00";
    variable phase_then  : u_unsigned(1 downto 0)                   := "00";
    -- While the output does not follow: the lowest bits of a count at which (A, B) have the held levels
    variable place_of_output : u_unsigned(1 downto 0)               := "00";
    -- 1 minus these bits; this number plus the position; the output's count after its step
    variable less_place  : u_signed(POSITION_WIDTH - 1 downto 0);
    variable started     : u_signed(POSITION_WIDTH - 1 downto 0);
    variable stepped     : u_signed(POSITION_WIDTH - 1 downto 0);
    -- Counts from the position to the angle; the same for the angle plus each number of turns; counts from the zero of
    -- each turn to the output
    variable angle_ahead  : u_signed(POSITION_WIDTH - 1 downto 0)    := (others => '0');
    variable angles_ahead  : of_turns                                 := (others => (others => '0'));
    variable behind_zero : of_turns                                 := (others => (others => '0'));
    -- `referenced` of the last three clocks, (2) the oldest
    variable referenced_then : std_ulogic_vector(2 downto 0)        := "000";
    variable beyond      : u_signed(POSITION_WIDTH - 1 downto 3);
    variable near        : u_signed(3 downto 0);
    variable gated       : std_ulogic;
    -- Counts since (A, B) was in z_state, and whether a gated Z is still high after this number of counts
    variable behind_state  : u_unsigned(1 downto 0)                 := "00";
    variable is_state_high : std_ulogic                             := '0';
    -- following_limit, or two turns minus one count if that is less
    variable limit       : u_signed(LIMIT_WIDTH - 1 downto 0)       := (others => '0');
    variable turn_limit  : u_signed(LIMIT_WIDTH - 1 downto 0)       := (others => '0');
    variable turns_are_less : std_ulogic                            := '0';
    -- Negative if the lag is above the limit, or below the negative limit
    variable above       : u_signed(POSITION_WIDTH downto 0);
    variable below       : u_signed(POSITION_WIDTH downto 0);
    variable too_far     : std_ulogic_vector(1 downto 0)            := "00";

  begin

    if rising_edge(clock) then
      -- Last stage: lag, behind_zero and phase_then belong to the same clock.
      a_level := phase_then(1) xor phase_then(0);
      b_level := phase_then(1);
      a       <= a_level xor invert_a;
      b       <= b_level xor invert_b;
      if swap_ab = '1' then
        a <= b_level xor invert_a;
        b <= a_level xor invert_b;
      end if;

      is_at_zero := '0';
      for turns in behind_zero'range loop
        beyond := behind_zero(turns)(beyond'range);
        near   := behind_zero(turns)(near'range);
        gated  := is_state_high and GATE(to_integer(u_unsigned(near) & behind_state));
        if (and beyond) = '1' or (or beyond) = '0' then
          is_at_zero := is_at_zero
                        or (referenced_then(2) and (gated or (not z_gated and is_high_ungated(near, z_width))));
        end if;
      end loop;

      -- The held level of Z takes one look-up table; a second one combines it with the results of the four turns.
      z_follows := (or enabled) and not reset;
      z_held    := z_level and not z_follows and not reset;
      z_level   := z_held or (z_follows and is_at_zero);
      z         <= (z_held xor invert_z) xor (z_follows and is_at_zero);

      following_error <= (others => '0');
      if clear = '1' then
        cannot_keep_up <= '0';
      end if;

      if too_far /= "00" then
        cannot_keep_up <= '1';
      end if;

      too_far := "00";
      if following = '1' and enabled(0) = '1' then
        following_error <= lag;

        above   := resize(limit, above'length) - lag;
        below   := resize(limit, below'length) + lag;
        too_far := above(above'high) & below(below'high);
      end if;

      -- Compute the limit from the settings, in several clocks.
      limit := resize(signed('0' & following_limit), limit'length);
      if turns_are_less = '1' then
        limit := turn_limit;
      end if;
      turns_are_less := resize(signed('0' & following_limit), limit'length) ?> turn_limit;
      turn_limit     := signed('0' & counts_per_rev & '0') - 1;

      -- Decide on a step.
      step_up   := '0';
      step_down := '0';
      if is_open = '1' and may_step = '1' then
        step_up   := remaining(2) or (remaining(1) and one_up);
        step_down := not remaining(-1) or (not remaining(0) and not one_up);
      end if;

      one_up := step_down or (not step_up and last_was_up);
      if step_up = '1' or step_down = '1' then
        last_was_up := step_up;
        may_step    := '0';
        if minimum_spacing <= 1 then
          may_step := '1';
        end if;
        spacing := minimum_spacing;
      elsif may_step = '0' then
        if spacing <= 2 then
          may_step := '1';
        end if;
        spacing := spacing - 1;
      end if;

      -- Convert the lag to thermometer code for the next decision. If the lag is outside -4 .. 3 only its sign matters,
      -- because two steps cannot change the decision.
      negative  := lag(lag'high);
      is_far    := or (lag(lag'high - 1 downto 2) xor (lag'high - 1 downto 2 => negative));
      remaining := thermometer_of(negative & lag(1 downto 0));
      for i in 0 to STEPS_UNDER_WAY - 1 loop
        remaining := less_a_step(remaining, up(i), down(i));
      end loop;
      if is_far = '1' then
        remaining := (others => not negative);
      end if;

      -- Make the step that was decided one clock ago.
      phase_then    := phase;
      behind_state  := phase - z_state;
      is_state_high := z_gated and (resize(behind_state, 3) ?< counts_of(z_width));
      for turns in angles_ahead'range loop
        behind_zero(turns) := angles_ahead(turns) + output;
      end loop;
      angles_ahead(0)   := angle_ahead;
      angles_ahead(1)   := angle_ahead + signed('0' & counts_per_rev);
      angles_ahead(-1)  := angle_ahead - signed('0' & counts_per_rev);
      angles_ahead(-2)  := angle_ahead - signed('0' & counts_per_rev & '0');
      angle_ahead     := signed(resize(corrected_angle, POSITION_WIDTH)) - corrected_position;
      referenced_then := referenced_then(1 downto 0) & referenced;

      lag := corrected_position - output;
      -- While the output does not follow, its count lies from 2 counts before the position to 1 count after it: it is
      -- the only count in this range at which (A, B) have the held levels. This is the largest such count up to
      -- position + 1: place + 4 * floor((position + 1 - place) / 4), where 1 - place is -2 to 1.
      less_place := (0 => not place_of_output(0), others => place_of_output(1));
      started    := corrected_position + less_place;
      stepped    := add_with_carry(output, (output'range => down(0)), up(0));
      output     := stepped;
      if following = '0' then
        output             := started;
        output(1 downto 0) := u_signed(place_of_output);
      end if;
      -- The two bits down & (up or down) are 1, 0 or -1.
      if following = '1' then
        phase := phase + u_unsigned'(down(0), up(0) or down(0));
      end if;
      place_of_output := phase - phase_of_zero;

      up      := up(STEPS_UNDER_WAY - 2 downto 0) & step_up;
      down    := down(STEPS_UNDER_WAY - 2 downto 0) & step_down;
      enabled := enabled(0) & following;
      if following = '0' then
        up   := (others => '0');
        down := (others => '0');
      end if;
      following := enable and not cannot_keep_up;

      is_open   := following and enabled(1) and enabled(0) and not reset;

      if reset = '1' then
        following      := '0';
        enabled        := (others => '0');
        up             := (others => '0');
        down           := (others => '0');
        last_was_up    := '1';
        one_up         := '1';
        may_step       := '1';
        too_far        := "00";
        cannot_keep_up <= '0';
        following_error <= (others => '0');
      end if;
    end if;

  end process follow;

end architecture rtl;
