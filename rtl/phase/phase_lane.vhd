-- SPDX-License-Identifier: Apache-2.0
--
-- # phase_lane
--
-- Computes the phase n·θ + Φ of one lane of equation (9), in turns. Source: section 3.3 of the paper. The phase step K
-- = round(n·2⁴⁸ / counts_per_rev) contains the order n: n·θ equals θ·K modulo 2⁴⁸, in units of 2⁻⁴⁸ turn. So the entity
-- needs no division, for any order and any counts_per_rev.
--
-- **Latency.** 5 clocks from `angle` and `phase_step` to `phase`; the entity accepts one angle per clock. It reads
-- `phase_offset` in the third clock: apply it PHASE_OFFSET_CLOCK = 2 clocks after its angle.
--
-- **Number formats.** angle u24.0 counts; phase step u0.48 turn per count; phase offset and phase u0.24 turn.
--
-- **Error.** The error of K is at most 2⁻⁴⁹ turn per count and the angle is below 2²⁴ counts, so the error of θ·K is
-- less than 2⁻²⁵ turn for every order. θ·K + Φ is rounded once, half up, to 24 bits, which adds at most 2⁻²⁵ turn.
--
-- **Multipliers.** Three cascaded DSP48E1 multiply the angle by 17, 17 and 14 bits of K. The lowest 17 bits of every
-- partial sum belong to the result; the other bits go to the adder of the next multiplier. Bits with the weight of a
-- full turn or more are never computed. The first adder adds the phase offset and the half unit for rounding. Each
-- multiplier has registers at its inputs, its product and its sum, and starts one clock after the previous one; so the
-- phase takes five clocks and no adder outside the multipliers.
--
-- There is no reset, because no register holds state.

library ieee;
  use ieee.std_logic_1164.all;
  use ieee.numeric_std.all;

  use work.number_formats_pkg.all;

entity phase_lane is
  port (
    clock        : in    std_ulogic;
    angle        : in    u_unsigned(ANGLE_WIDTH - 1 downto 0);                   -- counts
    phase_step   : in    u_unsigned(PHASE_STEP_WIDTH - 1 downto 0);              -- turn per count, u0.48
    phase_offset : in    u_unsigned(PHASE_WIDTH - 1 downto 0);                   -- turn, u0.24, 2 clocks after its angle
    phase        : out   u_unsigned(PHASE_WIDTH - 1 downto 0) := (others => '0') -- turn, u0.24
  );
end entity phase_lane;

architecture rtl of phase_lane is

  constant LOW_WIDTH    : positive := ANGLE_WIDTH + PHASE_PART_WIDTH;
  constant MIDDLE_WIDTH : positive := PHASE_STEP_WIDTH - PHASE_PART_WIDTH;
  constant HIGH_WIDTH   : positive := PHASE_STEP_WIDTH - 2 * PHASE_PART_WIDTH;
  -- The lowest bit of the middle sum that belongs to the phase.
  constant LOWEST_BIT   : natural  := PHASE_STEP_WIDTH - PHASE_WIDTH - PHASE_PART_WIDTH;
  -- Half a unit of the phase, added for rounding.
  constant REST_WIDTH   : positive := PHASE_STEP_WIDTH - PHASE_WIDTH;
  constant HALF         : u_unsigned(REST_WIDTH - 1 downto 0) := (REST_WIDTH - 1 => '1', others => '0');

begin

  multiply_and_add : process (clock) is

    -- Registers; the number in a name is the number of clocks from `angle` until the register is valid.
    variable angle_1          : u_unsigned(ANGLE_WIDTH - 1 downto 0)      := (others => '0');
    variable step_1           : u_unsigned(PHASE_STEP_WIDTH - 1 downto 0) := (others => '0');
    variable low_product_2    : u_unsigned(LOW_WIDTH - 1 downto 0)        := (others => '0');
    variable angle_2          : u_unsigned(ANGLE_WIDTH - 1 downto 0)      := (others => '0');
    variable middle_step_2    : u_unsigned(PHASE_PART_WIDTH - 1 downto 0) := (others => '0');
    variable high_step_2      : u_unsigned(HIGH_WIDTH - 1 downto 0)       := (others => '0');
    variable low_3            : u_unsigned(PHASE_STEP_WIDTH - 1 downto 0) := (others => '0');
    variable middle_product_3 : u_unsigned(LOW_WIDTH - 1 downto 0)        := (others => '0');
    variable angle_3          : u_unsigned(HIGH_WIDTH - 1 downto 0)       := (others => '0');
    variable high_step_3      : u_unsigned(HIGH_WIDTH - 1 downto 0)       := (others => '0');
    variable middle_4         : u_unsigned(MIDDLE_WIDTH - 1 downto 0)     := (others => '0');
    variable high_product_4   : u_unsigned(2 * HIGH_WIDTH - 1 downto 0)   := (others => '0');

  begin

    if rising_edge(clock) then
      -- Fifth clock: the third sum is the high part of the phase.
      phase(PHASE_WIDTH - 1 downto PHASE_WIDTH - HIGH_WIDTH) <= high_product_4(HIGH_WIDTH - 1 downto 0)
                                                                + middle_4(MIDDLE_WIDTH - 1 downto PHASE_PART_WIDTH);
      phase(PHASE_WIDTH - HIGH_WIDTH - 1 downto 0)           <= middle_4(PHASE_PART_WIDTH - 1 downto LOWEST_BIT);

      -- Fourth clock. Bits that would only add whole turns are not computed.
      high_product_4 := high_step_3 * angle_3;
      middle_4       := middle_product_3(MIDDLE_WIDTH - 1 downto 0) + low_3(PHASE_STEP_WIDTH - 1 downto PHASE_PART_WIDTH);

      -- Third clock.
      angle_3          := angle_2(HIGH_WIDTH - 1 downto 0);
      high_step_3      := high_step_2;
      middle_product_3 := middle_step_2 * angle_2;
      low_3            := (phase_offset & HALF) + low_product_2;

      -- Second clock.
      angle_2       := angle_1;
      high_step_2   := step_1(PHASE_STEP_WIDTH - 1 downto 2 * PHASE_PART_WIDTH);
      middle_step_2 := step_1(2 * PHASE_PART_WIDTH - 1 downto PHASE_PART_WIDTH);
      low_product_2 := step_1(PHASE_PART_WIDTH - 1 downto 0) * angle_1;

      -- First clock.
      angle_1 := angle;
      step_1  := phase_step;
    end if;

  end process multiply_and_add;

end architecture rtl;
