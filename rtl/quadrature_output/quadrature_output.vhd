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
-- `following_error` is 2 clocks behind the position.
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
-- Before the first index of the head the angle, and so Z, has no reference to the table.
--
-- **Enable.** While `enable` is low, A, B and Z keep their levels (an edge already decided may still
-- come within 2 clocks) and the output forgets how far it is behind; when it rises, the output
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

  use work.number_formats_pkg.all;

entity quadrature_output is
  port (
    clock              : in    std_ulogic;
    reset              : in    std_ulogic;
    enable             : in    std_ulogic;
    clear              : in    std_ulogic;                                    -- pulse: clears cannot_keep_up
    corrected_position : in    u_signed(POSITION_WIDTH - 1 downto 0);         -- counts, multi-turn
    corrected_angle    : in    u_unsigned(ANGLE_WIDTH - 1 downto 0);          -- counts, below counts_per_rev
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

  -- The lag in hand lacks the steps of the last three clocks: two are subtracted where it is
  -- saturated, the last one where it is judged.
  constant STEPS_UNDER_WAY : positive := 2;
  -- The lag saturated to -8 .. 7: enough for 2 counts of hysteresis and the steps under way.
  constant NEAR_WIDTH      : positive := 4;
  -- The lag saturates at 2**30.
  constant SATURATION      : u_signed(POSITION_WIDTH - 1 downto 0) := (POSITION_WIDTH - 2 => '1', others => '0');

  -- The angle and the angle some turns away, wide enough for -2 to +2 turns.
  constant WIDE_ANGLE_WIDTH : positive := COUNTS_PER_REV_WIDTH + 2;
  type angle_turns is array (-2 to 1) of u_signed(WIDE_ANGLE_WIDTH - 1 downto 0);

  -- +1, -1 or 0, made of its bits so that it shares the adder.
  function one_step (up, down : std_ulogic) return u_signed is

    variable step : u_signed(POSITION_WIDTH - 1 downto 0);

  begin

    step    := (others => down);
    step(0) := up or down;
    return step;

  end function one_step;

begin

  follow : process (clock) is

    variable following   : std_ulogic;
    -- following of the clocks before: (0) one clock ago
    variable enabled     : std_ulogic_vector(1 downto 0)            := (others => '0');
    variable output      : u_signed(POSITION_WIDTH - 1 downto 0)    := (others => '0');
    variable lag         : u_signed(POSITION_WIDTH - 1 downto 0)    := (others => '0');
    variable near_lag    : u_signed(NEAR_WIDTH - 1 downto 0);
    -- Without the step that the output takes now, and with it
    variable remaining   : u_signed(NEAR_WIDTH downto 0)            := (others => '0');
    variable left_over   : u_signed(NEAR_WIDTH downto 0);
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
    variable given_up    : u_signed(1 downto 0);
    variable limit       : u_signed(WIDE_ANGLE_WIDTH - 1 downto 0)  := (others => '0');

  begin

    if rising_edge(clock) then
      following := enable and not reset;

      -- Last stage: lag, angles and phase_then belong to one clock.
      a <= phase_then(1) xor phase_then(0);
      b <= phase_then(1);

      -- The output's angle is zero when lag = angle modulo counts_per_rev: no division is needed.
      if enabled /= "00" then
        z <= '0';
        for turns in angles'range loop
          if lag = resize(angles(turns), POSITION_WIDTH) then
            z <= '1';
          end if;
        end loop;
      end if;

      following_error <= (others => '0');
      if clear = '1' then
        cannot_keep_up <= '0';
      end if;

      if following = '1' and enabled(0) = '1' then
        following_error <= lag;
        if lag > limit or lag < -limit then
          cannot_keep_up <= '1';
        end if;
        if lag(lag'high) = '0' and lag(lag'high - 1) = '1' then
          following_error <= SATURATION;
        elsif lag(lag'high) = '1' and lag(lag'high - 1) = '0' then
          following_error <= -SATURATION;
        end if;
      end if;

      limit := resize(signed('0' & following_limit), limit'length);
      if ('0' & following_limit) >= (counts_per_rev & '0') then
        limit := signed('0' & counts_per_rev & '0') - 1;
      end if;

      -- Decide on a step.
      left_over := remaining - resize(one_step(up(0), down(0)), NEAR_WIDTH + 1);
      step_up   := '0';
      step_down := '0';
      if following = '1' and enabled = "11" and may_step = '1' then
        if left_over >= 2 or (left_over = 1 and last_was_up = '1') then
          step_up := '1';
        elsif left_over <= -2 or (left_over = -1 and last_was_up = '0') then
          step_down := '1';
        end if;
      end if;
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

      -- Saturate for the next decision.
      near_lag := lag(NEAR_WIDTH - 1 downto 0);
      if lag(POSITION_WIDTH - 1) = '0' and lag(POSITION_WIDTH - 2 downto NEAR_WIDTH - 1) /= 0 then
        near_lag := to_signed(2 ** (NEAR_WIDTH - 1) - 1, NEAR_WIDTH);
      elsif lag(POSITION_WIDTH - 1) = '1' and lag(POSITION_WIDTH - 2 downto NEAR_WIDTH - 1) /= -1 then
        near_lag := to_signed(-(2 ** (NEAR_WIDTH - 1)), NEAR_WIDTH);
      end if;
      remaining := resize(near_lag, NEAR_WIDTH + 1);
      for i in 0 to STEPS_UNDER_WAY - 1 loop
        remaining := remaining - resize(one_step(up(i), down(i)), NEAR_WIDTH + 1);
      end loop;

      -- Take the step decided one clock ago.
      phase_then  := phase;
      angles(0)   := signed(resize(corrected_angle, WIDE_ANGLE_WIDTH));
      angles(1)   := angles(0) + signed("00" & counts_per_rev);
      angles(-1)  := angles(0) - signed("00" & counts_per_rev);
      angles(-2)  := angles(0) - signed('0' & counts_per_rev & '0');
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
        output := output + one_step(up(0), down(0));
      end if;
      if following = '1' then
        phase := phase + unsigned(one_step(up(0), down(0))(1 downto 0));
      end if;

      up      := up(STEPS_UNDER_WAY - 2 downto 0) & step_up;
      down    := down(STEPS_UNDER_WAY - 2 downto 0) & step_down;
      enabled := enabled(0) & following;
      if following = '0' then
        up   := (others => '0');
        down := (others => '0');
      end if;

      if reset = '1' then
        enabled        := (others => '0');
        up             := (others => '0');
        down           := (others => '0');
        last_was_up    := '1';
        may_step       := '1';
        phase          := "00";
        phase_then     := "00";
        a              <= '0';
        b              <= '0';
        z              <= '0';
        cannot_keep_up <= '0';
      end if;
    end if;

  end process follow;

end architecture rtl;
