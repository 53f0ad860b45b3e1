-- SPDX-License-Identifier: Apache-2.0
--
-- # harmonic_lane
--
-- Computes one term amplitude · cos(phase) of equation (9). The entities quadrant_fold and cordic_rotation compute the
-- cosine, which is rounded once, to COSINE_WIDTH bits; one DSP48E1 multiplies it by the amplitude and can also add the
-- product of a partner lane. With ROTATION = table, table_rotation replaces cordic_rotation; latency and formats do not
-- change.
--
-- **Latency.** The product comes CORDIC_ITERATIONS + 3 (19) clocks after `phase`: 1 clock for quadrant_fold,
-- CORDIC_ITERATIONS − 1 (15) for the rotation, 1 for the rounding, 2 for the multiplication. With ADD_PARTNER the
-- latency is CORDIC_ITERATIONS + 4 (20) clocks, so that the product of a partner lane without ADD_PARTNER is ready in
-- the clock in which it is added. The entity accepts one phase per clock. `amplitude` belongs to the phase that came
-- CORDIC_ITERATIONS (16, AMPLITUDE_CLOCK) clocks before, `partner` to the phase that came CORDIC_ITERATIONS + 3 (19)
-- clocks before.
--
-- **Number formats.** phase u0.24 turn; cosine s1.(COSINE_WIDTH − 2) (s1.16); amplitude s13.11 counts; products
-- s15.(COSINE_WIDTH + 9) counts (s15.27), exact.
--
-- **Rounding.** The cosine of the rotation, which has two extra bits, is rounded half up before the sign of the
-- quadrant is applied. So two phases whose cosines differ only in sign get rounded cosines of the same magnitude.
--
-- **Error.** cordic_rotation and table_rotation state the error of the cosine, swept over all phases.
--
-- There is no reset, because no register holds state.

library ieee;
  use ieee.std_logic_1164.all;
  use ieee.numeric_std.all;

  use work.number_formats_pkg.all;

entity harmonic_lane is
  generic (
    COSINE_WIDTH      : positive range 8 to 24 := work.number_formats_pkg.COSINE_WIDTH;
    CORDIC_ITERATIONS : positive range 8 to 24 := work.number_formats_pkg.CORDIC_ITERATIONS;
    ADD_PARTNER       : boolean                := false;
    ROTATION          : string                 := "cordic" -- or "table"
  );
  port (
    clock     : in    std_ulogic;
    phase     : in    u_unsigned(PHASE_WIDTH - 1 downto 0);                  -- turn, u0.24
    amplitude : in    u_signed(AMPLITUDE_WIDTH - 1 downto 0);                -- counts, s13.11, AMPLITUDE_CLOCK clocks after its phase
    partner   : in    u_signed(AMPLITUDE_WIDTH + COSINE_WIDTH - 1 downto 0); -- counts, s15.27, product of the partner lane
    product   : out   u_signed(AMPLITUDE_WIDTH + COSINE_WIDTH - 1 downto 0) := (others => '0') -- counts, s15.27
  );
end entity harmonic_lane;

architecture rtl of harmonic_lane is

  signal folded          : u_unsigned(PHASE_WIDTH - 3 downto 0);
  signal place           : u_unsigned(PHASE_WIDTH - 3 downto 0);
  signal mirrored        : std_ulogic;
  signal folded_negative : std_ulogic;
  signal rotated         : u_signed(COSINE_WIDTH + GUARD_WIDTH - 1 downto 0);

begin

  fold : entity work.quadrant_fold
    port map (
      clock    => clock,
      phase    => phase,
      folded   => folded,
      place    => place,
      mirrored => mirrored,
      negative => folded_negative
    );

  from_table : if ROTATION = "table" generate

    assert COSINE_WIDTH = work.number_formats_pkg.COSINE_WIDTH and CORDIC_ITERATIONS = work.number_formats_pkg.CORDIC_ITERATIONS
      report "harmonic_lane: ROTATION = table is built for the widths of number_formats_pkg only"
      severity failure;

    rotate : entity work.table_rotation
      port map (
        clock  => clock,
        folded => folded,
        cosine => rotated
      );

  else generate

    rotate : entity work.cordic_rotation
      generic map (
        COSINE_WIDTH      => COSINE_WIDTH,
        CORDIC_ITERATIONS => CORDIC_ITERATIONS
      )
      port map (
        clock    => clock,
        place    => place,
        mirrored => mirrored,
        cosine   => rotated
      );

  end generate from_table;

  round_and_multiply : process (clock) is

    -- Registers. With ADD_PARTNER, cosine and factor pass through a second register in front of the multiplier.
    variable negative       : std_ulogic_vector(1 to CORDIC_ITERATIONS - 1) := (others => '0');
    variable cosine         : u_signed(COSINE_WIDTH - 1 downto 0)           := (others => '0');
    variable factor         : u_signed(AMPLITUDE_WIDTH - 1 downto 0)        := (others => '0');
    variable later_cosine   : u_signed(COSINE_WIDTH - 1 downto 0)           := (others => '0');
    variable later_factor   : u_signed(AMPLITUDE_WIDTH - 1 downto 0)        := (others => '0');
    variable unadded        : u_signed(product'range)                       := (others => '0');

    variable signed_bits    : u_signed(rotated'range);
    variable sum            : u_signed(COSINE_WIDTH downto 0);

  begin

    if rising_edge(clock) then

      -- Multiplication, the last register first: the product, then the register inside the multiplier.
      if ADD_PARTNER then
        product      <= unadded + partner;
        unadded      := later_cosine * later_factor;
        later_cosine := cosine;
        later_factor := factor;
      else
        product <= unadded;
        unadded := cosine * factor;
      end if;
      factor := amplitude;

      -- Rounding. -x equals (not x) + 1. The code forms only the complement, guard bits included; the rounding of the
      -- guard bits compensates for the missing 1, so the result is the negative of the rounded value.
      signed_bits := rotated xor (rotated'range => negative(negative'right));
      sum         := signed_bits(rotated'high downto GUARD_WIDTH - 1) + ('0' & signed_bits(GUARD_WIDTH - 1));
      cosine      := sum(COSINE_WIDTH downto 1);
      negative    := folded_negative & negative(1 to negative'right - 1);
    end if;

  end process round_and_multiply;

end architecture rtl;
