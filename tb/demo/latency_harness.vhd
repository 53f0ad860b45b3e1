-- SPDX-License-Identifier: Apache-2.0
--
-- # latency_harness
--
-- Connects the units of the compensation in series, for simulation. The signals between the units are ports, so that a
-- step of the angle shows the latency of each unit. There is one lane, with constant coefficients.

library ieee;
  use ieee.std_logic_1164.all;
  use ieee.numeric_std.all;

  use work.number_formats_pkg.all;

entity latency_harness is
  port (
    clock           : in    std_ulogic;
    reset           : in    std_ulogic;
    angle           : in    u_unsigned(ANGLE_WIDTH - 1 downto 0);                 -- 2**24 counts per turn
    phases          : out   std_ulogic_vector(PHASE_WIDTH - 1 downto 0);
    pair_sums       : out   std_ulogic_vector(PAIR_WIDTH - 1 downto 0);
    delayed_angle   : out   std_ulogic_vector(ANGLE_WIDTH - 1 downto 0);
    corrected_angle : out   u_unsigned(ANGLE_WIDTH - 1 downto 0)
  );
end entity latency_harness;

architecture simulation of latency_harness is

  -- The lane has order 1 at 2**24 counts per turn and an amplitude of 1000 counts.
  constant PHASE_STEP : std_ulogic_vector(PHASE_STEP_WIDTH - 1 downto 0) := (24 => '1', others => '0');
  constant AMPLITUDE  : std_ulogic_vector(AMPLITUDE_WIDTH - 1 downto 0)
    := std_ulogic_vector(to_unsigned(1000 * 2 ** AMPLITUDE_FRACTION, AMPLITUDE_WIDTH));

begin

  phase : entity work.phase_unit
    generic map (
      LANES => 1
    )
    port map (
      clock         => clock,
      angle         => angle,
      phase_steps   => PHASE_STEP,
      phase_offsets => (PHASE_WIDTH - 1 downto 0 => '0'),
      phases        => phases
    );

  harmonic : entity work.harmonic_unit
    generic map (
      LANES => 1
    )
    port map (
      clock      => clock,
      phases     => phases,
      amplitudes => AMPLITUDE,
      pair_sums  => pair_sums
    );

  delay : entity work.delay_line
    generic map (
      WIDTH => ANGLE_WIDTH
    )
    port map (
      clock     => clock,
      undelayed => std_ulogic_vector(angle),
      delayed   => delayed_angle
    );

  compensation : entity work.error_compensation
    generic map (
      LANES => 1
    )
    port map (
      clock              => clock,
      reset              => reset,
      pair_sums          => pair_sums,
      offset             => (others => '0'),
      angle              => u_unsigned(delayed_angle),
      position           => (others => '0'),
      apply              => '1',
      swap_marker        => '0',
      referenced         => '1',
      counts_per_rev     => to_unsigned(COUNTS_PER_REV_MAX, COUNTS_PER_REV_WIDTH),
      ramp_rate          => (others => '1'),
      corrected_angle    => corrected_angle,
      corrected_position => open,
      corrected_referenced => open,
      correction         => open,
      correction_limited => open,
      ramp_busy          => open,
      swap_done          => open
    );

end architecture simulation;
