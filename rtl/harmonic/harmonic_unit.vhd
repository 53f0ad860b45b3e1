-- SPDX-License-Identifier: Apache-2.0
--
-- # harmonic_unit
--
-- Computes the terms amplitude · cos(phase) of equation (9) for all lanes in parallel and adds the terms in pairs. Each
-- lane is one harmonic_lane; the second lane of a pair adds the product of the first lane in its DSP48E1. Source:
-- figure 9 and section 3.3 of the paper.
--
-- **Latency.** CORDIC_ITERATIONS + 4 = 20 clocks from `phases` to `pair_sums`, one angle per clock.
-- `amplitudes` belong to the phases that came CORDIC_ITERATIONS = 16 clocks (AMPLITUDE_CLOCK) before.
--
-- **Number formats.** phases u0.24 turn; amplitudes s13.11 counts; pair sums s15.27 counts. Flat ports carry lane 0 in
-- the low bits; pair i consists of the lanes 2i and 2i + 1. If the number of lanes is odd, the last pair consists of
-- the last lane only.
--
-- **Rounding.** Only the cosines are rounded, to COSINE_WIDTH bits. With a COSINE_WIDTH of up to 18 the pair sums are
-- exact; with a wider cosine the pair sums are truncated to PAIR_FRACTION = 27 fraction bits.
--
-- There is no reset, because no register holds state.

library ieee;
  use ieee.std_logic_1164.all;
  use ieee.numeric_std.all;

  use work.number_formats_pkg.all;

entity harmonic_unit is
  generic (
    LANES             : positive range 1 to LANES_MAX := LANES_DEFAULT;
    COSINE_WIDTH      : positive range 8 to 24        := work.number_formats_pkg.COSINE_WIDTH;
    CORDIC_ITERATIONS : positive range 8 to 24        := work.number_formats_pkg.CORDIC_ITERATIONS;
    ROTATION          : string                        := "cordic" -- or "table": method of computing the cosine
  );
  port (
    clock      : in    std_ulogic;
    phases     : in    std_ulogic_vector(LANES * PHASE_WIDTH - 1 downto 0);           -- turn, u0.24
    amplitudes : in    std_ulogic_vector(LANES * AMPLITUDE_WIDTH - 1 downto 0);       -- counts, s13.11, AMPLITUDE_CLOCK clocks later
    pair_sums  : out   std_ulogic_vector(((LANES + 1) / 2) * PAIR_WIDTH - 1 downto 0) -- counts, s15.27, pair 0 in the low bits
  );
end entity harmonic_unit;

architecture rtl of harmonic_unit is

  constant PRODUCT_WIDTH    : positive := AMPLITUDE_WIDTH + COSINE_WIDTH;
  constant PRODUCT_FRACTION : positive := AMPLITUDE_FRACTION + COSINE_WIDTH - 2;

  -- Number of fraction bits that a product has more than a pair sum, and number that it has fewer; one of them is 0.
  constant CUT_OFF          : natural  := maximum(PRODUCT_FRACTION, PAIR_FRACTION) - PAIR_FRACTION;
  constant APPENDED         : natural  := maximum(PRODUCT_FRACTION, PAIR_FRACTION) - PRODUCT_FRACTION;

  subtype product is u_signed(PRODUCT_WIDTH - 1 downto 0);

  type products is array (natural range <>) of product;

  -- Products that the lanes add: the second lane of a pair adds the product of the first lane, the first lane adds 0.
  signal partners : products(0 to LANES - 1);
  signal sums     : products(0 to LANES - 1);

begin

  all_lanes : for lane in 0 to LANES - 1 generate

    constant IS_SECOND : boolean := lane mod 2 = 1;
    constant IS_LAST   : boolean := IS_SECOND or lane = LANES - 1;

  begin

    second : if IS_SECOND generate
      partners(lane) <= sums(lane - 1);
    else generate
      partners(lane) <= (others => '0');
    end generate second;

    one_lane : entity work.harmonic_lane
      generic map (
        COSINE_WIDTH      => COSINE_WIDTH,
        CORDIC_ITERATIONS => CORDIC_ITERATIONS,
        ADD_PARTNER       => IS_LAST,
        ROTATION          => ROTATION
      )
      port map (
        clock     => clock,
        phase     => u_unsigned(phases((lane + 1) * PHASE_WIDTH - 1 downto lane * PHASE_WIDTH)),
        amplitude => u_signed(amplitudes((lane + 1) * AMPLITUDE_WIDTH - 1 downto lane * AMPLITUDE_WIDTH)),
        partner   => partners(lane),
        product   => sums(lane)
      );

    pair : if IS_LAST generate

      constant PAIR_INDEX : natural := lane / 2;

      signal pair_sum : u_signed(PAIR_WIDTH - 1 downto 0);

    begin

      pair_sum <= shift_left(resize(shift_right(sums(lane), CUT_OFF), PAIR_WIDTH), APPENDED);

      pair_sums((PAIR_INDEX + 1) * PAIR_WIDTH - 1 downto PAIR_INDEX * PAIR_WIDTH) <= std_ulogic_vector(pair_sum);

    end generate pair;

  end generate all_lanes;

end architecture rtl;
