-- SPDX-License-Identifier: Apache-2.0
--
-- # phase_lane
--
-- The phase n·θ + Φ of one lane of equation (9), in turns; section 3.3 of the paper. The order n
-- stands in the phase step K = round(n·2⁴⁸ / counts_per_rev), so that n·θ is θ·K modulo 2⁴⁸: any
-- order and any `counts_per_rev`, without a division.
--
-- **Latency.** 5 clocks from `angle` and `phase_step` to `phase`, one angle per clock.
-- `phase_offset` is used in the last clock: give it PHASE_LATENCY − 1 = 4 clocks after its angle.
--
-- **Number formats.** angle u24.0 counts; phase step u0.48 turn a count; phase offset and phase
-- u0.24 turn.
--
-- **Error.** K is off by at most 2⁻⁴⁹ turn a count and the angle is below 2²⁴, so θ·K is off by
-- less than 2⁻²⁵ turn at every order. θ·K + Φ is rounded once, half up, to 24 bits: another 2⁻²⁵
-- turn at most.
--
-- **Multipliers.** Three DSP48E1 in a cascade, for 17, 17 and 14 bits of K. The lowest 17 bits of
-- every partial product belong to the result, the others go on to the next multiplier. Bits of a
-- full turn and above are never formed. The first multiplier has one register less than the others:
-- between it and the second one there is an adder of a DSP48E1 more.
--
-- There is no reset: it would only touch angles on their way.

library ieee;
  use ieee.std_logic_1164.all;
  use ieee.numeric_std.all;

  use work.number_formats_pkg.all;

entity phase_lane is
  port (
    clock        : in    std_ulogic;
    angle        : in    u_unsigned(ANGLE_WIDTH - 1 downto 0);                   -- counts
    phase_step   : in    u_unsigned(PHASE_STEP_WIDTH - 1 downto 0);              -- turn a count, u0.48
    phase_offset : in    u_unsigned(PHASE_WIDTH - 1 downto 0);                   -- turn, u0.24, 4 clocks later
    phase        : out   u_unsigned(PHASE_WIDTH - 1 downto 0) := (others => '0') -- turn, u0.24
  );
end entity phase_lane;

architecture rtl of phase_lane is

  -- The multiplier takes 17 bits without sign at its narrow port.
  constant PART_WIDTH   : positive := 17;
  constant LOW_WIDTH    : positive := ANGLE_WIDTH + PART_WIDTH;
  constant MIDDLE_WIDTH : positive := PHASE_STEP_WIDTH - PART_WIDTH;
  constant HIGH_WIDTH   : positive := PHASE_STEP_WIDTH - 2 * PART_WIDTH;
  -- Bits of the middle product that are bits of the phase, and the one below that rounds it.
  constant LOWEST_BIT   : natural  := PHASE_STEP_WIDTH - PHASE_WIDTH - 1 - PART_WIDTH;

begin

  multiply_and_add : process (clock) is

    -- Registers; the number is the clock after `angle` in which they hold.
    variable angle_1          : u_unsigned(ANGLE_WIDTH - 1 downto 0)            := (others => '0');
    variable angle_2          : u_unsigned(HIGH_WIDTH - 1 downto 0)             := (others => '0');
    variable step_1           : u_unsigned(PHASE_STEP_WIDTH - 1 downto 0)       := (others => '0');
    variable high_step_2      : u_unsigned(HIGH_WIDTH - 1 downto 0)             := (others => '0');
    variable low_2            : u_unsigned(LOW_WIDTH - 1 downto 0)              := (others => '0');
    variable middle_product_2 : u_unsigned(LOW_WIDTH - 1 downto 0)              := (others => '0');
    variable middle_3         : u_unsigned(MIDDLE_WIDTH - 1 downto 0)           := (others => '0');
    variable high_product_3   : u_unsigned(2 * HIGH_WIDTH - 1 downto 0)         := (others => '0');
    variable middle_4         : u_unsigned(PART_WIDTH - 1 downto LOWEST_BIT)    := (others => '0');
    variable high_4           : u_unsigned(HIGH_WIDTH - 1 downto 0)             := (others => '0');

    variable turns : u_unsigned(PHASE_WIDTH downto 0);
    variable sum   : u_unsigned(PHASE_WIDTH downto 0);

  begin

    if rising_edge(clock) then
      -- Fifth clock: half of the last bit is added by adding the bit below to itself.
      turns := high_4 & middle_4;
      sum   := turns + (phase_offset & turns(0));
      phase <= sum(PHASE_WIDTH downto 1);

      -- Fourth clock.
      middle_4 := middle_3(PART_WIDTH - 1 downto LOWEST_BIT);
      high_4   := high_product_3(HIGH_WIDTH - 1 downto 0) + middle_3(MIDDLE_WIDTH - 1 downto PART_WIDTH);

      -- Third clock.
      high_product_3 := high_step_2 * angle_2;
      middle_3       := middle_product_2(MIDDLE_WIDTH - 1 downto 0) + low_2(LOW_WIDTH - 1 downto PART_WIDTH);

      -- Second clock. What only bits of whole turns depend on is left out.
      high_step_2      := step_1(PHASE_STEP_WIDTH - 1 downto 2 * PART_WIDTH);
      angle_2          := angle_1(HIGH_WIDTH - 1 downto 0);
      middle_product_2 := step_1(2 * PART_WIDTH - 1 downto PART_WIDTH) * angle_1;
      low_2            := step_1(PART_WIDTH - 1 downto 0) * angle_1;

      -- First clock.
      angle_1 := angle;
      step_1  := phase_step;
    end if;

  end process multiply_and_add;

end architecture rtl;
