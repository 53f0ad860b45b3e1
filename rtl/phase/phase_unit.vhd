-- SPDX-License-Identifier: Apache-2.0
--
-- # phase_unit
--
-- Computes the phases n·θ + Φ of all lanes in parallel; each lane has its own phase_lane. Source: figure 8 and section
-- 3.3 of the paper.
--
-- **Latency.** 5 clocks from `angle` and `phase_steps` to `phases`; the entity accepts one angle per clock. It reads
-- `phase_offsets` in the third clock: apply them PHASE_OFFSET_CLOCK = 2 clocks after their angle, as coefficient_memory
-- does.
--
-- **Number formats.** angle u24.0 counts; phase steps u0.48 turn per count; phase offsets and phases u0.24 turn. Flat
-- ports carry lane 0 in the low bits.
--
-- There is no reset, because no register holds state.

library ieee;
  use ieee.std_logic_1164.all;
  use ieee.numeric_std.all;

  use work.number_formats_pkg.all;

entity phase_unit is
  generic (
    LANES : positive range 1 to LANES_MAX := LANES_DEFAULT
  );
  port (
    clock         : in    std_ulogic;
    angle         : in    u_unsigned(ANGLE_WIDTH - 1 downto 0);                     -- counts
    phase_steps   : in    std_ulogic_vector(LANES * PHASE_STEP_WIDTH - 1 downto 0); -- turn per count, u0.48
    phase_offsets : in    std_ulogic_vector(LANES * PHASE_WIDTH - 1 downto 0);      -- turn, u0.24
    phases        : out   std_ulogic_vector(LANES * PHASE_WIDTH - 1 downto 0)       -- turn, u0.24
  );
end entity phase_unit;

architecture rtl of phase_unit is

begin

  all_lanes : for lane in 0 to LANES - 1 generate

    signal phase : u_unsigned(PHASE_WIDTH - 1 downto 0);

  begin

    one_lane : entity work.phase_lane
      port map (
        clock        => clock,
        angle        => angle,
        phase_step   => u_unsigned(phase_steps((lane + 1) * PHASE_STEP_WIDTH - 1 downto lane * PHASE_STEP_WIDTH)),
        phase_offset => u_unsigned(phase_offsets((lane + 1) * PHASE_WIDTH - 1 downto lane * PHASE_WIDTH)),
        phase        => phase
      );

    phases((lane + 1) * PHASE_WIDTH - 1 downto lane * PHASE_WIDTH) <= std_ulogic_vector(phase);

  end generate all_lanes;

end architecture rtl;
