-- SPDX-License-Identifier: Apache-2.0
--
-- # quadrature_output
--
-- Follows the corrected position with the A, B and Z signals of an encoder, one count a step, so
-- that a servo drive reads the compensated angle. A leads B while the position rises:
-- (A, B) = 00, 10, 11, 01. Source: the end of section 3.3 of the paper (output of the
-- compensated signal) and figure 4 (order of the levels).
--
-- **Latency.** 6 clocks from `corrected_position` to the edge, when nothing holds the edge back.
-- `following_error` is 2 clocks behind the position, `cannot_keep_up` 3. `enable` and a change of
-- `following_limit` or `counts_per_rev` act on them 1 to 3 clocks late.
--
-- **Number formats.** corrected_position s31.0 counts, multi-turn; corrected_angle u24.0 counts,
-- of the same clock; minimum_spacing u16.0 clocks; following_limit u16.0 counts; following_error
-- s31.0 counts.
--
-- **Edges.** Two edges of A and B are at least `minimum_spacing` clocks apart (0 acts as 1: an edge
-- in every clock); a change holds from the next edge on. A and B never change together. On a
-- reversal the first count is held back until the position is 2 counts away from the output: a
-- position that trembles between two neighbouring counts gives no edges. After the reversal the
-- output follows to the very count.
--
-- **Z** is high while the angle of the output, which is corrected_angle - following error, is zero
-- modulo counts_per_rev. It changes together with the edge of A or B that enters or leaves the
-- zero. When corrected_angle jumps against corrected_position (first index), Z follows the new
-- angle at once and A and B make no edge. Z needs a following error below two turns; beyond, it is
-- low. (A turn of 4 counts at an edge every clock stays below: 4 counts are under way, 1 is held.)
-- While `referenced` is low the angle has no zero on the table, and Z is low: before the first index of
-- the head, and from a re-arm to the next one.
--
-- **Enable.** While `enable` is low, A, B and Z keep their levels (an edge already decided may still
-- come within 3 clocks) and the output forgets how far it is behind; when it rises, the output
-- starts from the present position with the held phase of A and B, without an edge, and Z takes the
-- level of the present angle.
--
-- **Following error** is position - output; it counts the edges still in the 4 clocks of the
-- pipeline as outstanding: 4 counts at one edge a clock. At +-2**30 counts it saturates: the output
-- then gives up the excess for good. It reads 0 while disabled.
--
-- **Cannot keep up** is set, while enabled, when |following error| exceeds `following_limit`
-- or 2 * counts_per_rev - 1, and stays until `clear` (or reset). A clear while the condition lasts
-- does not lower the flag. Disabling does not clear it.
--
-- **Reset.** A, B and Z low, the flag cleared.

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
    corrected_position : in    u_signed(POSITION_WIDTH - 1 downto 0);         -- counts, multi-turn
    corrected_angle    : in    u_unsigned(ANGLE_WIDTH - 1 downto 0);          -- counts, below counts_per_rev
    referenced         : in    std_ulogic;                                    -- corrected_angle counts from an index
    counts_per_rev     : in    u_unsigned(COUNTS_PER_REV_WIDTH - 1 downto 0); -- counts
    minimum_spacing    : in    u_unsigned(15 downto 0);                       -- clocks
    following_limit    : in    u_unsigned(15 downto 0);                       -- counts
    a                  : out   std_ulogic;
    b                  : out   std_ulogic;
    z                  : out   std_ulogic;
    following_error    : out   u_signed(POSITION_WIDTH - 1 downto 0);         -- counts
    cannot_keep_up     : out   std_ulogic                                     -- sticky
  );
end entity quadrature_output;

architecture rtl of quadrature_output is

  -- The lag in hand lacks the steps of the last three clocks: two are taken off where it is made
  -- narrow, the last one where it is judged.
  constant STEPS_UNDER_WAY : positive := 2;

  -- A small number in thermometer code: (k) is high where it is k or more. To take a step off is to
  -- shift it, so that what decides on a step has no adder.
  type thermometer is array (4 downto -3) of std_ulogic;

  -- The angle and the angle some turns away, wide enough for -2 to +2 turns.
  constant WIDE_ANGLE_WIDTH : positive := COUNTS_PER_REV_WIDTH + 2;
  type angle_turns is array (-2 to 1) of u_signed(WIDE_ANGLE_WIDTH - 1 downto 0);

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

    -- enable one clock ago, and of the clocks before: (0) two clocks ago
    variable following   : std_ulogic                               := '0';
    variable enabled     : std_ulogic_vector(1 downto 0)            := (others => '0');
    variable output      : u_signed(POSITION_WIDTH - 1 downto 0)    := (others => '0');
    variable lag         : u_signed(POSITION_WIDTH - 1 downto 0)    := (others => '0');
    variable saturates   : std_ulogic;
    variable negative    : std_ulogic;
    variable is_far      : std_ulogic;
    -- The lag without the step that the output takes now. One count of it is enough for a step up
    -- (one_up) or else for a step down, and two for a step the other way: after a step, with that
    -- step still to be taken off, one against it; otherwise one the way of the last step.
    variable remaining   : thermometer                              := (4 downto 1 => '0', others => '1');
    variable one_up      : std_ulogic                               := '1';
    -- (0) the step that the output takes now, (1) the one before
    variable up          : std_ulogic_vector(STEPS_UNDER_WAY - 1 downto 0) := (others => '0');
    variable down        : std_ulogic_vector(STEPS_UNDER_WAY - 1 downto 0) := (others => '0');
    variable step_up     : std_ulogic;
    variable step_down   : std_ulogic;
    variable last_was_up : std_ulogic                               := '1';
    variable spacing     : u_unsigned(15 downto 0)                  := (others => '0');
    variable may_step    : std_ulogic                               := '1';
    variable phase       : u_unsigned(1 downto 0)                   := "00";
    variable phase_then  : u_unsigned(1 downto 0)                   := "00";
    variable angles      : angle_turns                              := (others => (others => '0'));
    variable referenced_then : std_ulogic                           := '0';
    variable given_up    : u_signed(1 downto 0);
    -- following_limit, or what is less: two turns without a count
    variable limit       : u_signed(WIDE_ANGLE_WIDTH - 1 downto 0)  := (others => '0');
    variable turn_limit  : u_signed(WIDE_ANGLE_WIDTH - 1 downto 0)  := (others => '0');
    variable turns_are_less : std_ulogic                            := '0';
    -- Negative where the lag is above the limit, and below its negative
    variable above       : u_signed(POSITION_WIDTH downto 0);
    variable below       : u_signed(POSITION_WIDTH downto 0);
    variable too_far     : std_ulogic_vector(1 downto 0)            := "00";

  begin

    if rising_edge(clock) then
      -- Last stage: lag, angles and phase_then belong to one clock.
      a <= phase_then(1) xor phase_then(0);
      b <= phase_then(1);

      -- The output's angle is zero when lag = angle modulo counts_per_rev: no division is needed.
      if enabled /= "00" then
        z <= '0';
        for turns in angles'range loop
          if lag = resize(angles(turns), POSITION_WIDTH) then
            z <= referenced_then;
          end if;
        end loop;
      end if;

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

        saturates := lag(lag'high) xor lag(lag'high - 1);
        if saturates = '1' then
          following_error                           <= (others => '0');
          following_error(lag'high downto lag'high - 1) <= lag(lag'high) & '1';
        end if;
      end if;

      -- Settings: each clock does a part.
      limit := resize(signed('0' & following_limit), limit'length);
      if turns_are_less = '1' then
        limit := turn_limit;
      end if;
      turns_are_less := resize(signed('0' & following_limit), limit'length) ?> turn_limit;
      turn_limit     := signed('0' & counts_per_rev & '0') - 1;

      -- Decide on a step.
      step_up   := '0';
      step_down := '0';
      if following = '1' and enabled = "11" and may_step = '1' then
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

      -- Make the lag narrow for the next decision. Beyond -4 .. 3 two steps leave the last word to
      -- its sign.
      negative  := lag(lag'high);
      is_far    := or (lag(lag'high - 1 downto 2) xor (lag'high - 1 downto 2 => negative));
      remaining := thermometer_of(negative & lag(1 downto 0));
      for i in 0 to STEPS_UNDER_WAY - 1 loop
        remaining := less_a_step(remaining, up(i), down(i));
      end loop;
      if is_far = '1' then
        remaining := (others => not negative);
      end if;

      -- Take the step decided one clock ago.
      phase_then  := phase;
      angles(0)   := signed(resize(corrected_angle, WIDE_ANGLE_WIDTH));
      angles(1)   := angles(0) + signed("00" & counts_per_rev);
      angles(-1)  := angles(0) - signed("00" & counts_per_rev);
      angles(-2)  := angles(0) - signed('0' & counts_per_rev & '0');
      referenced_then := referenced;
      given_up    := lag(lag'high downto lag'high - 1);
      lag         := corrected_position - output;
      if following = '0' then
        output := corrected_position;
      elsif given_up = "01" then
        output                                   := corrected_position;
        output(output'high downto output'high - 1) := corrected_position(output'high downto output'high - 1) - 1;
      elsif given_up = "10" then
        output                                   := corrected_position;
        output(output'high downto output'high - 1) := corrected_position(output'high downto output'high - 1) + 1;
      else
        output := add_with_carry(output, (output'range => down(0)), up(0));
      end if;
      if following = '1' then
        phase := phase + u_unsigned'(down(0), up(0) or down(0));
      end if;

      up      := up(STEPS_UNDER_WAY - 2 downto 0) & step_up;
      down    := down(STEPS_UNDER_WAY - 2 downto 0) & step_down;
      enabled := enabled(0) & following;
      if following = '0' then
        up   := (others => '0');
        down := (others => '0');
      end if;
      following := enable;

      if reset = '1' then
        following      := '0';
        enabled        := (others => '0');
        up             := (others => '0');
        down           := (others => '0');
        last_was_up    := '1';
        one_up         := '1';
        may_step       := '1';
        too_far        := "00";
        phase          := "00";
        phase_then     := "00";
        a              <= '0';
        b              <= '0';
        z              <= '0';
        cannot_keep_up <= '0';
        following_error <= (others => '0');
      end if;
    end if;

  end process follow;

end architecture rtl;
