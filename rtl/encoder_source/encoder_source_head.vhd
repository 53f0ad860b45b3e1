-- SPDX-License-Identifier: Apache-2.0
--
-- # encoder_source_head
--
-- Generates the signals of one read head of encoder_source. The true angle θ increases by the same amount in every
-- clock, and the reading is R = θ + ε(θ), equation (2), where ε is the sum of a harmonic of order 1 and a harmonic of
-- order 2. The entity computes R with compensation_pipeline, which subtracts the correction that its coefficients
-- describe; so the coefficients here describe -ε.
--
-- **Latency.** 35 clocks from the true angle to the edge of `a` or `b`.
--
-- **Number formats.** True angle u24.24 counts, START at the beginning; position s31.0 counts, wraps.
--
-- **Reset.** The true angle goes back to START; the entity writes the coefficients and swaps the banks again.

library ieee;
  use ieee.math_real.all;
  use ieee.std_logic_1164.all;
  use ieee.numeric_std.all;

  use work.number_formats_pkg.all;

entity encoder_source_head is
  generic (
    COUNTS_PER_REV    : positive range COUNTS_PER_REV_MIN to COUNTS_PER_REV_MAX;
    COUNTS_PER_SECOND : positive;
    SOURCE_CLOCK_HZ   : positive;                -- frequency of `clock`
    START             : natural;                 -- counts, below COUNTS_PER_REV
    ECCENTRICITY      : integer range 0 to 8191; -- counts
    ECCENTRICITY_TURN : real range 0.0 to 1.0;   -- turn
    OVALITY           : integer range 0 to 8191; -- counts
    OVALITY_TURN      : real range 0.0 to 1.0    -- turn
  );
  port (
    clock : in    std_ulogic;
    reset : in    std_ulogic;
    a     : out   std_ulogic;
    b     : out   std_ulogic;
    z     : out   std_ulogic
  );
end entity encoder_source_head;

architecture rtl of encoder_source_head is

  constant LANES           : positive := 2;
  constant STEP_FRACTION   : positive := 24;
  constant WORDS           : positive := 4 * LANES;
  -- Smallest number of clocks between two edges of the output: an edge is permitted in every clock.
  constant MINIMUM_SPACING : positive := 1;

  -- Increase of the true angle in counts per clock, u0.24.
  constant STEP : u_unsigned(STEP_FRACTION - 1 downto 0) :=
    to_unsigned(integer(round(real(COUNTS_PER_SECOND) / real(SOURCE_CLOCK_HZ) * 2.0 ** STEP_FRACTION)), STEP_FRACTION);

  type word_array is array (0 to WORDS - 1) of std_ulogic_vector(31 downto 0);

  -- Returns round(order * 2**48 / COUNTS_PER_REV), by long division, because a real has too few bits.
  function phase_step (order : positive) return u_unsigned is

    constant WIDTH     : positive := PHASE_STEP_WIDTH + 2;
    variable remainder : natural;
    variable quotient  : u_unsigned(WIDTH - 1 downto 0) := (others => '0');

  begin

    remainder := order mod COUNTS_PER_REV;

    for bit_number in 1 to PHASE_STEP_WIDTH + 1 loop

      remainder := 2 * remainder;
      quotient  := shift_left(quotient, 1);

      if remainder >= COUNTS_PER_REV then
        remainder   := remainder - COUNTS_PER_REV;
        quotient(0) := '1';
      end if;

    end loop;

    quotient := quotient + 1;
    return quotient(PHASE_STEP_WIDTH downto 1);

  end function phase_step;

  function lane_words (order : positive; amplitude : natural; turn : real) return word_array is

    constant K     : u_unsigned(PHASE_STEP_WIDTH - 1 downto 0) := phase_step(order);
    variable words : word_array                                := (others => (others => '0'));

  begin

    words(0)              := std_ulogic_vector(K(31 downto 0));
    words(1)(15 downto 0) := std_ulogic_vector(K(47 downto 32));
    words(2)              := std_ulogic_vector(to_unsigned(integer(round(turn * 2.0 ** PHASE_WIDTH)) mod 2 ** PHASE_WIDTH, 32));
    words(3)              := std_ulogic_vector(to_signed(-amplitude * 2 ** AMPLITUDE_FRACTION, 32));
    return words;

  end function lane_words;

  function all_words return word_array is

    constant FIRST  : word_array := lane_words(1, ECCENTRICITY, ECCENTRICITY_TURN);
    constant SECOND : word_array := lane_words(2, OVALITY, OVALITY_TURN);
    variable words  : word_array;

  begin

    words(0 to 3) := FIRST(0 to 3);
    words(4 to 7) := SECOND(0 to 3);
    return words;

  end function all_words;

  constant COEFFICIENTS : word_array := all_words;

  type state_type is (WRITE_WORD, WAIT_FOR_WORD, SWAP_IN, WAIT_FOR_SWAP, TURNING);

  signal state              : state_type                              := WRITE_WORD;
  signal word               : natural range 0 to WORDS - 1            := 0;
  signal write_enable       : std_ulogic;
  signal write_data         : std_ulogic_vector(31 downto 0);
  signal write_acknowledge  : std_ulogic;
  signal swap               : std_ulogic;
  signal swap_done          : std_ulogic;
  signal apply              : std_ulogic                              := '0';
  signal fraction           : u_unsigned(STEP_FRACTION - 1 downto 0)  := (others => '0');
  signal angle              : u_unsigned(ANGLE_WIDTH - 1 downto 0)    := to_unsigned(START, ANGLE_WIDTH);
  signal position           : u_signed(POSITION_WIDTH - 1 downto 0)   := to_signed(START, POSITION_WIDTH);
  signal corrected_angle    : u_unsigned(ANGLE_WIDTH - 1 downto 0);
  signal corrected_position : u_signed(POSITION_WIDTH - 1 downto 0);
  signal ramp_busy          : std_ulogic;
  signal settled            : std_ulogic                              := '0';

begin

  write_enable <= '1' when state = WRITE_WORD else
                  '0';
  swap         <= '1' when state = SWAP_IN else
                  '0';
  write_data   <= COEFFICIENTS(word);

  load : process (clock) is
  begin

    if rising_edge(clock) then
      settled <= '0';

      case state is

        when WRITE_WORD =>

          state <= WAIT_FOR_WORD;

        when WAIT_FOR_WORD =>

          if write_acknowledge = '1' then
            if word = WORDS - 1 then
              state <= SWAP_IN;
            else
              word  <= word + 1;
              state <= WRITE_WORD;
            end if;
          end if;

        when SWAP_IN =>

          state <= WAIT_FOR_SWAP;
          apply <= '1';

        when WAIT_FOR_SWAP =>

          if swap_done = '1' then
            state <= TURNING;
          end if;

        when TURNING =>

          settled <= not ramp_busy or settled;

      end case;

      if reset = '1' then
        state   <= WRITE_WORD;
        word    <= 0;
        apply   <= '0';
        settled <= '0';
      end if;
    end if;

  end process load;

  turn : process (clock) is

    variable sum  : u_unsigned(STEP_FRACTION downto 0);
    variable step_up : std_ulogic;

  begin

    if rising_edge(clock) then
      sum      := ('0' & fraction) + STEP;
      fraction <= sum(STEP_FRACTION - 1 downto 0);
      step_up  := sum(STEP_FRACTION);

      if step_up = '1' then
        position <= position + 1;

        if angle = COUNTS_PER_REV - 1 then
          angle <= (others => '0');
        else
          angle <= angle + 1;
        end if;
      end if;

      if reset = '1' then
        fraction <= (others => '0');
        angle    <= to_unsigned(START, ANGLE_WIDTH);
        position <= to_signed(START, POSITION_WIDTH);
      end if;
    end if;

  end process turn;

  reading : entity work.compensation_pipeline
    generic map (
      LANES => LANES
    )
    port map (
      clock              => clock,
      reset              => reset,
      angle              => angle,
      position           => position,
      apply              => apply,
      referenced         => '1',
      counts_per_rev     => to_unsigned(COUNTS_PER_REV, COUNTS_PER_REV_WIDTH),
      ramp_rate          => (others => '1'),
      write_enable       => write_enable,
      write_offset       => '0',
      write_address      => to_unsigned(word, 8),
      write_data         => write_data,
      write_acknowledge  => write_acknowledge,
      read_address       => (others => '0'),
      read_data          => open,
      idle_offset        => open,
      swap               => swap,
      swap_busy          => open,
      corrected_angle    => corrected_angle,
      corrected_position => corrected_position,
      corrected_referenced => open,
      correction         => open,
      correction_limited => open,
      ramp_busy          => ramp_busy,
      swap_done          => swap_done
    );

  edges : entity work.quadrature_output
    port map (
      clock              => clock,
      reset              => reset,
      enable             => settled,
      clear              => '0',
      corrected_position => corrected_position,
      corrected_angle    => corrected_angle,
      referenced         => '1',
      phase_of_zero      => "00",
      z_gated            => '0',
      z_state            => "00",
      z_width            => "00",
      counts_per_rev     => to_unsigned(COUNTS_PER_REV, COUNTS_PER_REV_WIDTH),
      minimum_spacing    => to_unsigned(MINIMUM_SPACING, 16),
      following_limit    => (others => '1'),
      a                  => a,
      b                  => b,
      z                  => z,
      following_error    => open,
      cannot_keep_up     => open
    );

end architecture rtl;
