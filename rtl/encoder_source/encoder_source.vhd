-- SPDX-License-Identifier: Apache-2.0
--
-- # encoder_source
--
-- Generates the signals A, B and Z that two to four read heads of a steadily turning table would give. On a test bench,
-- a second board with this entity replaces the encoder. All heads read the same disc; the angles of heads 2 to 4 are
-- HEAD_SEPARATION, HEAD3_AHEAD and HEAD4_AHEAD counts ahead of head 1 (docs/architecture.md, "Head geometry"). A
-- calibration therefore finds the error ε of equation (2), whose orders 1 and 2 the generics define. The simulated axis
-- has no error motion. The outputs of heads whose number is above HEADS stay low.
--
-- **Latency.** 35 clocks from the true angle to the edge: compensation_pipeline 29, quadrature_output 6.
--
-- **Number formats.** True angle u24.24 counts; amplitudes s13.11 counts; the speed COUNTS_PER_SECOND is rounded to a
-- multiple of 2⁻²⁴ count per clock.
--
-- **Reset.** The table returns to its start, and each head writes its coefficients again.

library ieee;
  use ieee.std_logic_1164.all;
  use ieee.numeric_std.all;

  use work.number_formats_pkg.all;

entity encoder_source is
  generic (
    COUNTS_PER_REV    : positive range COUNTS_PER_REV_MIN to COUNTS_PER_REV_MAX := 16777216;
    COUNTS_PER_SECOND : positive                 := 1398101;   -- 30 deg/s at 2**24 counts per turn
    SOURCE_CLOCK_HZ   : positive                 := 125000000; -- frequency of `clock`
    HEADS             : positive range 2 to HEADS_MAX := 2;
    HEAD_SEPARATION   : natural                  := 1537911;   -- counts, 33 deg at 2**24 counts per turn
    HEAD3_AHEAD       : natural                  := 8248798;   -- counts, 177 deg at 2**24 counts per turn
    HEAD4_AHEAD       : natural                  := 12019011;  -- counts, 257.9 deg at 2**24 counts per turn
    ECCENTRICITY      : integer range 0 to 8191  := 1864;      -- counts, amplitude of order 1
    ECCENTRICITY_TURN : real range 0.0 to 1.0    := 0.334;     -- turn, phase of order 1
    OVALITY           : integer range 0 to 8191  := 78;        -- counts, amplitude of order 2
    OVALITY_TURN      : real range 0.0 to 1.0    := 0.668      -- turn, phase of order 2
  );
  port (
    clock   : in    std_ulogic;
    reset   : in    std_ulogic;
    head1_a : out   std_ulogic;
    head1_b : out   std_ulogic;
    head1_z : out   std_ulogic;
    head2_a : out   std_ulogic;
    head2_b : out   std_ulogic;
    head2_z : out   std_ulogic;
    head3_a : out   std_ulogic;
    head3_b : out   std_ulogic;
    head3_z : out   std_ulogic;
    head4_a : out   std_ulogic;
    head4_b : out   std_ulogic;
    head4_z : out   std_ulogic
  );
end entity encoder_source;

architecture rtl of encoder_source is

  type place_array is array (1 to HEADS_MAX) of natural;

  constant PLACES : place_array := (0, HEAD_SEPARATION, HEAD3_AHEAD, HEAD4_AHEAD);

  -- A, B and Z of each head.
  signal a : std_ulogic_vector(1 to HEADS_MAX) := (others => '0');
  signal b : std_ulogic_vector(1 to HEADS_MAX) := (others => '0');
  signal z : std_ulogic_vector(1 to HEADS_MAX) := (others => '0');

begin

  (head1_a, head2_a, head3_a, head4_a) <= a;
  (head1_b, head2_b, head3_b, head4_b) <= b;
  (head1_z, head2_z, head3_z, head4_z) <= z;

  heads_of_the_table : for number in PLACES'range generate

    present : if number <= HEADS generate

      assert PLACES(number) < COUNTS_PER_REV
        report "encoder_source: head " & integer'image(number) & " is a turn or more ahead"
        severity failure;

      head : entity work.encoder_source_head
        generic map (
          COUNTS_PER_REV    => COUNTS_PER_REV,
          COUNTS_PER_SECOND => COUNTS_PER_SECOND,
          SOURCE_CLOCK_HZ   => SOURCE_CLOCK_HZ,
          START             => PLACES(number),
          ECCENTRICITY      => ECCENTRICITY,
          ECCENTRICITY_TURN => ECCENTRICITY_TURN,
          OVALITY           => OVALITY,
          OVALITY_TURN      => OVALITY_TURN
        )
        port map (
          clock => clock,
          reset => reset,
          a     => a(number),
          b     => b(number),
          z     => z(number)
        );

    end generate present;

  end generate heads_of_the_table;

end architecture rtl;
