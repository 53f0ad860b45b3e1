-- SPDX-License-Identifier: Apache-2.0
--
-- # weighted_mean
--
-- Computes the term by which the weighted mean of the heads differs from the reading of the carrier s (the head whose
-- reading enters the pipeline). The output of the core is θ = r_s + Σ wᵢ·(rᵢ − r_s) − E(r_s) with rᵢ = Rᵢ − oᵢ: Rᵢ is
-- the reading of head i, oᵢ its offset, wᵢ its weight. head_mean outputs R_s minus the whole counts of o_s; the core
-- subtracts E and the term from this output. The fraction f_s of o_s is a part of the term, which is
-- f_s − Σ wᵢ·(rᵢ − r_s). If Σ wᵢ·e^{jβᵢ} = 0, where βᵢ are the angles of the heads around the axis, a translation of the
-- axis does not change the mean. The carrier's weight has no effect, because the carrier's difference is 0: the mean is
-- formed as if this weight made the sum of all weights 1.
--
-- **Turn.** Differences are taken the shorter way round (turn_difference); the fractions of the offsets are applied
-- after that.
--
-- **Limit.** A difference beyond ±65,536 counts comes from a head that has lost counts or was never set up. It is
-- limited to the range of s16.4, so that the term stays within ±2¹⁹ counts. `limited` is high with a term for which the
-- difference of a `used` head was limited.
--
-- **Rounding.** Products and their sum are exact.
--
-- **Latency.** `mean_term` and `limited` follow the readings and words by MEAN_LATENCY = 10 clocks, `differences` by
-- DIFFERENCE_LATENCY = 3 clocks, `fine_differences` (which include the fractions of the offsets and are limited) by 5
-- clocks. The entity accepts one set of readings per clock.
--
-- **Number formats.** readings u24.0 counts below counts_per_rev; fractions u0.4 counts; weights s1.16; differences
-- s24.0 counts; fine_differences s16.4 counts; mean_term s19.20 counts. Flat ports carry head 1 in the low bits.
--
-- There is no reset, because no register holds state.

library ieee;
  use ieee.std_logic_1164.all;
  use ieee.numeric_std.all;

  use work.number_formats_pkg.all;

entity weighted_mean is
  generic (
    HEADS : positive range 2 to HEADS_MAX := 2
  );
  port (
    clock            : in    std_ulogic;
    readings         : in    std_ulogic_vector(HEADS * ANGLE_WIDTH - 1 downto 0);          -- counts, each R minus the whole counts of o
    carrier_reading  : in    u_unsigned(ANGLE_WIDTH - 1 downto 0);                         -- counts, the carrier's element of `readings`
    fractions        : in    std_ulogic_vector(HEADS * HEAD_OFFSET_FRACTION - 1 downto 0); -- counts, u0.4, fraction of each offset o
    carrier_fraction : in    u_unsigned(HEAD_OFFSET_FRACTION - 1 downto 0);                -- counts, u0.4, of the carrier's offset o
    weights          : in    std_ulogic_vector(HEADS * HEAD_WEIGHT_WIDTH - 1 downto 0);    -- s1.16
    used             : in    std_ulogic_vector(HEADS - 1 downto 0);                        -- one bit per head: the active words use it
    counts_per_rev   : in    u_unsigned(COUNTS_PER_REV_WIDTH - 1 downto 0);                -- counts
    differences      : out   std_ulogic_vector(HEADS * (ANGLE_WIDTH + 1) - 1 downto 0);    -- counts, s24.0
    fine_differences : out   std_ulogic_vector(HEADS * HEAD_DIFFERENCE_WIDTH - 1 downto 0) := (others => '0'); -- counts, s16.4
    mean_term        : out   u_signed(MEAN_TERM_WIDTH - 1 downto 0) := (others => '0');    -- counts, s19.20
    limited          : out   std_ulogic                             := '0'                 -- level: a used head's difference in this term is limited
  );
end entity weighted_mean;

architecture rtl of weighted_mean is

  constant DIFFERENCE_WIDTH : positive := ANGLE_WIDTH + 1;
  constant FINE_WIDTH       : positive := DIFFERENCE_WIDTH + HEAD_OFFSET_FRACTION + 1;
  constant PRODUCT_WIDTH    : positive := HEAD_DIFFERENCE_WIDTH + HEAD_WEIGHT_WIDTH;
  constant FRACTION_SHIFT   : natural  := MEAN_TERM_FRACTION - HEAD_OFFSET_FRACTION;
  -- Number of clocks by which the carrier's fraction is delayed, so that it arrives with the sum of the products.
  constant LAST_FRACTION    : positive := MEAN_LATENCY - 2;

  subtype fraction_count is u_unsigned(HEAD_OFFSET_FRACTION - 1 downto 0);

  subtype head_weight is u_signed(HEAD_WEIGHT_WIDTH - 1 downto 0);

  subtype wide_product is u_signed(PRODUCT_WIDTH - 1 downto 0);

  type fraction_counts is array (1 to LAST_FRACTION) of fraction_count;

  type products_of_heads is array (0 to HEADS_MAX - 1) of wide_product;

  signal products        : products_of_heads := (others => (others => '0'));
  signal limited_heads_5 : std_ulogic_vector(HEADS - 1 downto 0) := (others => '0');

begin

  assert MEAN_LATENCY = DIFFERENCE_LATENCY + 7
    report "weighted_mean: the latency of the package is not that of the stages"
    severity failure;

  all_heads : for head in 0 to HEADS - 1 generate

    signal difference : u_signed(DIFFERENCE_WIDTH - 1 downto 0);

  begin

    on_shorter_way : entity work.turn_difference
      port map (
        clock          => clock,
        minuend        => u_unsigned(readings((head + 1) * ANGLE_WIDTH - 1 downto head * ANGLE_WIDTH)),
        subtrahend     => carrier_reading,
        counts_per_rev => counts_per_rev,
        difference     => difference
      );

    differences((head + 1) * DIFFERENCE_WIDTH - 1 downto head * DIFFERENCE_WIDTH) <= std_ulogic_vector(difference);

    refine_and_multiply : process (clock) is

      type weight_words is array (1 to 5) of head_weight;

      type fraction_differences is array (1 to 3) of u_signed(HEAD_OFFSET_FRACTION downto 0);

      -- Registers; the number in a name is the number of clocks from the readings until the register is valid.
      variable weight_1_to_5   : weight_words                                 := (others => (others => '0'));
      variable fraction_1_to_3 : fraction_differences                         := (others => (others => '0'));
      variable used_1_to_4     : std_ulogic_vector(1 to 4)                    := (others => '0');
      variable fine_4          : u_signed(FINE_WIDTH - 1 downto 0)            := (others => '0');
      variable limited_5       : u_signed(HEAD_DIFFERENCE_WIDTH - 1 downto 0) := (others => '0');
      variable product_6       : wide_product                                 := (others => '0');

      variable own_fraction    : fraction_count;
      variable own_weight      : head_weight;
      variable sign            : std_ulogic;
      variable is_beyond       : std_ulogic;

    begin

      if rising_edge(clock) then
        -- Sixth and seventh clock: the register inside the multiplier and the product register, the last one first.
        products(head) <= product_6;
        product_6      := limited_5 * weight_1_to_5(5);

        -- Fifth clock: if the bits above the format are not copies of the sign, the difference is limited.
        sign      := fine_4(fine_4'high);
        is_beyond := or (fine_4(fine_4'high downto HEAD_DIFFERENCE_WIDTH - 1)
                         xor (fine_4'high downto HEAD_DIFFERENCE_WIDTH - 1 => sign));
        limited_5 := fine_4(limited_5'range);
        if is_beyond = '1' then
          limited_5                 := (others => not sign);
          limited_5(limited_5'high) := sign;
        end if;
        fine_differences((head + 1) * HEAD_DIFFERENCE_WIDTH - 1 downto head * HEAD_DIFFERENCE_WIDTH) <= std_ulogic_vector(limited_5);
        limited_heads_5(head) <= is_beyond and used_1_to_4(4);

        -- Fourth clock.
        fine_4 := shift_left(resize(difference, FINE_WIDTH), HEAD_OFFSET_FRACTION)
                  + resize(fraction_1_to_3(3), FINE_WIDTH);

        -- First clock: the fraction of the carrier's offset minus the fraction of the head's own offset.
        own_fraction    := u_unsigned(fractions((head + 1) * HEAD_OFFSET_FRACTION - 1 downto head * HEAD_OFFSET_FRACTION));
        fraction_1_to_3 := (u_signed('0' & carrier_fraction) - u_signed('0' & own_fraction)) & fraction_1_to_3(1 to 2);
        own_weight      := u_signed(weights((head + 1) * HEAD_WEIGHT_WIDTH - 1 downto head * HEAD_WEIGHT_WIDTH));
        weight_1_to_5   := own_weight & weight_1_to_5(1 to 4);
        used_1_to_4     := used(head) & used_1_to_4(1 to 3);
      end if;

    end process refine_and_multiply;

  end generate all_heads;

  add : process (clock) is

    -- Registers; the number in a name is the number of clocks from the readings until the register is valid.
    variable fraction_1_to_8 : fraction_counts                       := (others => (others => '0'));
    variable first_pair_8    : u_signed(MEAN_TERM_WIDTH - 1 downto 0) := (others => '0');
    variable second_pair_8   : u_signed(MEAN_TERM_WIDTH - 1 downto 0) := (others => '0');
    variable first_term_9    : u_signed(MEAN_TERM_WIDTH - 1 downto 0) := (others => '0');
    variable second_pair_9   : u_signed(MEAN_TERM_WIDTH - 1 downto 0) := (others => '0');
    variable limited_6_to_9  : std_ulogic_vector(6 to 9)              := (others => '0');

    variable fraction        : u_signed(MEAN_TERM_WIDTH - 1 downto 0);

  begin

    if rising_edge(clock) then
      -- Tenth clock.
      mean_term <= first_term_9 - second_pair_9;
      limited   <= limited_6_to_9(9);

      -- Ninth clock.
      fraction      := shift_left(resize(u_signed('0' & fraction_1_to_8(8)), MEAN_TERM_WIDTH), FRACTION_SHIFT);
      first_term_9  := fraction - first_pair_8;
      second_pair_9 := second_pair_8;

      -- Eighth clock.
      first_pair_8   := resize(products(0), MEAN_TERM_WIDTH) + resize(products(1), MEAN_TERM_WIDTH);
      second_pair_8  := resize(products(2), MEAN_TERM_WIDTH) + resize(products(3), MEAN_TERM_WIDTH);
      limited_6_to_9 := (or limited_heads_5) & limited_6_to_9(6 to 8);

      fraction_1_to_8 := carrier_fraction & fraction_1_to_8(1 to 7);
    end if;

  end process add;

end architecture rtl;
