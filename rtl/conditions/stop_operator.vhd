-- SPDX-License-Identifier: Apache-2.0
--
-- # stop_operator
--
-- Computes the direction of motion with the hysteresis of friction (Prandtl's stop operator): a number, the place,
-- moves with the table and stops at ±width. Place / width is the direction h: +1 after a long motion upwards, -1 after
-- a long motion downwards; after a reversal h changes linearly with the motion. Source: Krasnosel'skii and Pokrovskii,
-- Systems with Hysteresis (1989), the stop operator: x = min(max(x + dR, -W), W), where x is the place, dR the motion
-- and W the width.
--
-- **Dead zone.** The place does not change while the table moves back and forth by up to `dead_zone` counts (a play
-- operator in front of the stop operator).
--
-- **In a servo's loop.** A lane of order 0 with amplitude a and the modulator h corrects a reversal error of 2·a. After a
-- reversal the output changes by at most 2·a in addition to the table's motion, and in proportion to this motion: its
-- velocity is between 1 - a/W and 1 + a/W times the velocity of the table. Export and firmware refuse a/W >= 1/2.
--
-- **Unknown.** At reset, and after a change of `width`, the place is unknown: it may be anywhere from -width to width.
-- Two operators begin at these ends; once their places are equal, the place is known. That takes at most 2·width counts
-- of motion to one side, plus the dead zone.
--
-- **Motion** is the sum of the counted edges: `position` without `put_back`. A step of more than STOP_STEP_MAX counts in a
-- clock comes from a change of the head that gives `position` (the carrier of the mean), or from a reset of the
-- decoder; it is ignored. Counts that this head lost are missing in the sum, even if they are put back.
--
-- **Latency.** 7 clocks from `position` to `place` and `known`.
--
-- **Number formats.** position s31.0 counts modulo 2³²; put_back s15.0 counts modulo 2¹⁶; width u20.4 counts; dead_zone
-- u8.0 counts; place s20.4 counts.
--
-- **Reset.** The place is unknown.

library ieee;
  use ieee.std_logic_1164.all;
  use ieee.numeric_std.all;

  use work.conditions_pkg.all;
  use work.number_formats_pkg.all;

entity stop_operator is
  port (
    clock     : in    std_ulogic;
    reset     : in    std_ulogic;
    position  : in    u_signed(POSITION_WIDTH - 1 downto 0);       -- counts
    put_back  : in    u_signed(15 downto 0);                       -- counts put back for lost counts
    width     : in    u_unsigned(STOP_WIDTH - 1 downto 0);         -- counts, u20.4
    dead_zone : in    u_unsigned(DEAD_ZONE_WIDTH - 1 downto 0);    -- counts
    place     : out   u_signed(STOP_WIDTH downto 0);               -- counts, s20.4, -width to width
    known     : out   std_ulogic                            := '0' -- high once the place is known, see Unknown
  );
end entity stop_operator;

architecture rtl of stop_operator is

  -- A place with one bit for the sign and one for the sum of two numbers
  subtype wide_place is u_signed(STOP_WIDTH + 1 downto 0);

  signal low   : wide_place := (others => '0');
  signal high  : wide_place := (others => '0');
  signal meets   : std_ulogic             := '0';
  signal reached : u_signed(place'range) := (others => '0');

begin

  follow : process (clock) is

    -- Registers; the number in a name is the number of clocks from the position until the register is valid.
    variable count_1      : u_signed(15 downto 0)                      := (others => '0');
    variable count_2      : u_signed(15 downto 0)                      := (others => '0');
    variable step_2       : u_signed(15 downto 0)                      := (others => '0');
    variable step_3       : u_signed(4 downto 0)                       := (others => '0');
    variable slack        : u_unsigned(DEAD_ZONE_WIDTH - 1 downto 0)   := (others => '0');
    variable motion_4     : u_signed(DEAD_ZONE_WIDTH + 1 downto 0)     := (others => '0');
    variable way_5        : wide_place                                 := (others => '0');
    variable to_top_5     : wide_place                                 := (others => '0');
    variable to_bottom_5  : wide_place                                 := (others => '0');
    variable width_before : u_unsigned(width'range)                    := (others => '0');
    variable settling     : u_unsigned(1 downto 0)                     := "11";

    variable top          : wide_place;
    variable moved        : u_signed(DEAD_ZONE_WIDTH + 1 downto 0);
    variable beyond       : u_signed(DEAD_ZONE_WIDTH + 1 downto 0);

    -- Returns the place after a motion by `way`, but not beyond the ends.
    function stopped (from, way, to_top, to_bottom, end_top : wide_place) return wide_place is
    begin

      if from > to_top then
        return end_top;
      elsif from < to_bottom then
        return -end_top;
      end if;
      return from + way;

    end function stopped;

  begin

    if rising_edge(clock) then
      top := u_signed("00" & width);

      -- Seventh clock: compare the places of both operators, and output the place.
      meets   <= '1' when low = high else '0';
      reached <= high(place'range);

      -- Fifth and sixth clock: move the places of both operators; the bounds are computed one clock earlier.
      low         <= stopped(low, way_5, to_top_5, to_bottom_5, top);
      high        <= stopped(high, way_5, to_top_5, to_bottom_5, top);
      way_5       := shift_left(resize(motion_4, way_5'length), STOP_FRACTION);
      to_top_5    := top - way_5;
      to_bottom_5 := -top - way_5;

      -- Fourth clock: remove the motion within the dead zone.
      moved  := u_signed("00" & slack) + step_3;
      beyond := moved - u_signed("00" & dead_zone);
      if moved(moved'high) = '1' then
        motion_4 := moved;
        slack    := (others => '0');
      elsif beyond > 0 then
        motion_4 := beyond;
        slack    := dead_zone;
      else
        motion_4 := (others => '0');
        slack    := u_unsigned(moved(slack'range));
      end if;

      -- Third clock: ignore steps that are too large for a motion of the table.
      step_3 := step_2(step_3'range);
      if step_2 > STOP_STEP_MAX or step_2 < -STOP_STEP_MAX then
        step_3 := (others => '0');
      end if;

      -- Second and first clock: compute the step of the counted position.
      step_2  := count_1 - count_2;
      count_2 := count_1;
      count_1 := position(15 downto 0) - put_back;

      if settling /= 0 then
        step_3   := (others => '0');
        settling := settling - 1;
      end if;

      if width /= width_before then
        low   <= -top;
        high  <= top;
        meets <= '0';
      end if;
      width_before := width;

      if reset = '1' then
        low          <= -top;
        high         <= top;
        meets        <= '0';
        slack        := (others => '0');
        motion_4     := (others => '0');
        settling     := "11";
      end if;
    end if;

  end process follow;

  place <= reached;
  known <= meets;

end architecture rtl;
