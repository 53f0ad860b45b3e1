-- SPDX-License-Identifier: Apache-2.0
--
-- # compensation_pipeline
--
-- From the reading of the reference head to the compensated reading of equations (8) and (9):
-- coefficient_memory, phase_unit, harmonic_unit, beside them the delay_line for the reading, and
-- error_compensation with the correction_ramp. Section 3.2 of the paper.
--
-- **Latency.** 29 clocks from `angle` and `position` to all outputs, one angle per clock: phase 5,
-- harmonics 20, compensation 4 (Table 1 of the paper). The delay line is 25 clocks, as long as
-- phase and harmonics together.
--
-- **Apply.** Hold `apply` high while the reading may be corrected: compensation on, not bypassed,
-- index seen. It belongs to the angle of its clock and travels with it. While it is low ε counts
-- as 0; a change of it starts the ramp, so neither switching on nor off steps the output. A swap
-- starts the ramp too.
--
-- **Coefficients.** Written and swapped as described for coefficient_memory; the new bank holds
-- from the angle in the clock after `swap`.
--
-- **Number formats.** angle u24.0 counts below counts_per_rev; position s31.0 counts, wraps
-- modulo 2³²; correction s19.11 counts; ramp_rate u8.24 in 2⁻¹¹ count a clock.
--
-- **Reset.** No correction, no ramp, no pending write. The banks keep their values, and angles
-- in the pipeline come out. While `counts_per_rev` changes, all angles in the pipeline must be
-- below the old and the new value; the phase steps belong to one counts_per_rev.

library ieee;
  use ieee.std_logic_1164.all;
  use ieee.numeric_std.all;

  use work.number_formats_pkg.all;

entity compensation_pipeline is
  generic (
    LANES        : positive range 1 to LANES_MAX := LANES_DEFAULT;
    COSINE_WIDTH : positive                      := work.number_formats_pkg.COSINE_WIDTH
  );
  port (
    clock              : in    std_ulogic;
    reset              : in    std_ulogic;
    angle              : in    u_unsigned(ANGLE_WIDTH - 1 downto 0);          -- counts, below counts_per_rev
    position           : in    u_signed(POSITION_WIDTH - 1 downto 0);         -- counts
    apply              : in    std_ulogic;                                    -- correct this reading
    counts_per_rev     : in    u_unsigned(COUNTS_PER_REV_WIDTH - 1 downto 0); -- counts
    ramp_rate          : in    u_unsigned(31 downto 0);                       -- 2⁻¹¹ count a clock, u8.24
    write_enable       : in    std_ulogic;                                    -- pulse: write a word of a lane
    write_offset       : in    std_ulogic;                                    -- pulse: write the offset
    write_address      : in    u_unsigned(7 downto 0);                        -- lane * 4 + word
    write_data         : in    std_ulogic_vector(31 downto 0);                -- the word
    write_acknowledge  : out   std_ulogic;                                    -- pulse: written
    read_address       : in    u_unsigned(7 downto 0);                        -- lane * 4 + word
    read_data          : out   std_ulogic_vector(31 downto 0);                -- idle bank, 2 clocks later
    idle_offset        : out   u_signed(AMPLITUDE_WIDTH - 1 downto 0);        -- counts, s13.11, idle bank
    swap               : in    std_ulogic;                                    -- pulse: the idle bank becomes active
    swap_busy          : out   std_ulogic;                                    -- parts of a bank are still to be copied
    corrected_angle    : out   u_unsigned(ANGLE_WIDTH - 1 downto 0);          -- counts
    corrected_position : out   u_signed(POSITION_WIDTH - 1 downto 0);         -- counts
    correction         : out   u_signed(CORRECTION_WIDTH - 1 downto 0);       -- counts, s19.11
    correction_limited : out   std_ulogic;                                    -- this output was clipped
    ramp_busy          : out   std_ulogic;                                    -- this output is held or has a remainder
    swap_done          : out   std_ulogic                                     -- the first output of a new bank
  );
end entity compensation_pipeline;

architecture rtl of compensation_pipeline is

  constant PAIRS         : positive := (LANES + 1) / 2;
  constant READING_WIDTH : positive := ANGLE_WIDTH + POSITION_WIDTH + 2;

  signal phase_steps     : std_ulogic_vector(LANES * PHASE_STEP_WIDTH - 1 downto 0);
  signal phase_offsets   : std_ulogic_vector(LANES * PHASE_WIDTH - 1 downto 0);
  signal amplitudes      : std_ulogic_vector(LANES * AMPLITUDE_WIDTH - 1 downto 0);
  signal offset          : u_signed(AMPLITUDE_WIDTH - 1 downto 0);
  signal swap_marker     : std_ulogic;
  signal phases          : std_ulogic_vector(LANES * PHASE_WIDTH - 1 downto 0);
  signal pair_sums       : std_ulogic_vector(PAIRS * PAIR_WIDTH - 1 downto 0);
  signal reading         : std_ulogic_vector(READING_WIDTH - 1 downto 0);
  signal delayed_reading : std_ulogic_vector(READING_WIDTH - 1 downto 0);

begin

  assert PHASE_LATENCY + HARMONIC_LATENCY = DELAY_LINE_LATENCY
    report "compensation_pipeline: the delay line is not as long as phase and harmonics"
    severity failure;

  coefficients : entity work.coefficient_memory
    generic map (
      LANES              => LANES,
      PHASE_OFFSET_DELAY => PHASE_LATENCY - 1,
      AMPLITUDE_DELAY    => PHASE_LATENCY + AMPLITUDE_CLOCK,
      OFFSET_DELAY       => DELAY_LINE_LATENCY
    )
    port map (
      clock             => clock,
      reset             => reset,
      write_enable      => write_enable,
      write_offset      => write_offset,
      write_address     => write_address,
      write_data        => write_data,
      write_acknowledge => write_acknowledge,
      read_address      => read_address,
      read_data         => read_data,
      idle_offset       => idle_offset,
      swap              => swap,
      swap_marker       => swap_marker,
      swap_busy         => swap_busy,
      phase_steps       => phase_steps,
      phase_offsets     => phase_offsets,
      amplitudes        => amplitudes,
      offset            => offset
    );

  phase : entity work.phase_unit
    generic map (
      LANES => LANES
    )
    port map (
      clock         => clock,
      angle         => angle,
      phase_steps   => phase_steps,
      phase_offsets => phase_offsets,
      phases        => phases
    );

  harmonics : entity work.harmonic_unit
    generic map (
      LANES        => LANES,
      COSINE_WIDTH => COSINE_WIDTH
    )
    port map (
      clock      => clock,
      phases     => phases,
      amplitudes => amplitudes,
      pair_sums  => pair_sums
    );

  reading <= swap_marker & apply & std_ulogic_vector(position) & std_ulogic_vector(angle);

  delay : entity work.delay_line
    generic map (
      WIDTH  => READING_WIDTH,
      CLOCKS => DELAY_LINE_LATENCY
    )
    port map (
      clock     => clock,
      undelayed => reading,
      delayed   => delayed_reading
    );

  compensation : entity work.error_compensation
    generic map (
      LANES => LANES
    )
    port map (
      clock              => clock,
      reset              => reset,
      pair_sums          => pair_sums,
      offset             => offset,
      angle              => u_unsigned(delayed_reading(ANGLE_WIDTH - 1 downto 0)),
      position           => u_signed(delayed_reading(ANGLE_WIDTH + POSITION_WIDTH - 1 downto ANGLE_WIDTH)),
      apply              => delayed_reading(READING_WIDTH - 2),
      swap_marker        => delayed_reading(READING_WIDTH - 1),
      counts_per_rev     => counts_per_rev,
      ramp_rate          => ramp_rate,
      corrected_angle    => corrected_angle,
      corrected_position => corrected_position,
      correction         => correction,
      correction_limited => correction_limited,
      ramp_busy          => ramp_busy,
      swap_done          => swap_done
    );

end architecture rtl;
