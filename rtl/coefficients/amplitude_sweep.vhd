-- SPDX-License-Identifier: Apache-2.0
--
-- # amplitude_sweep
--
-- Multiplies the nominal amplitude of each lane by the lane's modulator and writes the product, the effective
-- amplitude. A lane corrects one harmonic. Its modulator is the factor that the amplitude follows: the direction, the
-- speed, the squared speed, a word of the processor, or 1. One multiplier serves all lanes of both banks one after the
-- other. (The pipeline reads the active bank; the processor writes the idle bank, see coefficient_memory.) The entity
-- stores the nominal amplitude and the choice of the modulator for each lane of both banks.
--
-- **Sweep.** A sweep lasts AMPLITUDE_SWEEP_CLOCKS clocks, in which `sweep_step` counts from 0 to
-- AMPLITUDE_SWEEP_CLOCKS - 1; sweeps follow one another without a pause. Steps 0 to 63 process the lanes of bank 0,
-- steps 64 to 127 the lanes of bank 1; steps of lanes that are not built write nothing. In the last step the entity
-- latches the modulators for the whole next sweep. Each bank has its own speed, because its nominal speed may differ:
-- `speed` for the active bank, `idle_speed` for the idle bank. In SQUARE_STEP the entity latches both and then squares
-- each, which gives the modulator `speed_squared`.
--
-- **Swap.** `swept` is high from the end of the first whole sweep after the last write of a nominal word until the next
-- write; during this time the effective amplitudes of the idle bank are complete. After a write it is high again within
-- 2 · AMPLITUDE_SWEEP_CLOCKS + 1 clocks.
--
-- **Latency.** The effective amplitude of a step is written 5 clocks after `sweep_step`; the memory holds it a clock
-- later.
--
-- **Number formats.** amplitudes s13.11 counts; modulators s1.16, with a magnitude of at most 1.
--
-- **Rounding.** Each product is rounded once, half up, to s13.11: a modulator of 1 does not change the amplitude. The
-- product of -8192 counts and -1, which exceeds the format, becomes the largest amplitude.
--
-- **Reset.** There is none: the sweeps continue. At power-up every word is 0.

library ieee;
  use ieee.std_logic_1164.all;
  use ieee.numeric_std.all;

  use work.conditions_pkg.all;
  use work.number_formats_pkg.all;

entity amplitude_sweep is
  generic (
    LANES : positive range 1 to LANES_MAX := LANES_DEFAULT;
    FOLD  : positive range 1 to 8         := 1 -- number of lanes that share a pipeline: 1, 2, 4 or 8
  );
  port (
    clock           : in    std_ulogic;
    sweep_step      : in    u_unsigned(7 downto 0);
    direction       : in    modulator;
    speed           : in    modulator;
    idle_speed      : in    modulator;
    word_a          : in    modulator;
    word_b          : in    modulator;
    speed_squared   : out   modulator := (others => '0');
    -- Writes of the nominal words of the idle bank
    write_amplitude : in    std_ulogic;                                  -- pulse: write the amplitude
    write_choice    : in    std_ulogic;                                  -- pulse: write the choice of the modulator
    write_bank      : in    std_ulogic;                                  -- number of the idle bank
    write_lane      : in    u_unsigned(5 downto 0);
    write_word      : in    std_ulogic_vector(AMPLITUDE_WIDTH - 1 downto 0);
    swept           : out   std_ulogic := '0';                           -- level: a whole sweep has followed the last write
    -- Writes of the effective amplitudes
    selected        : out   std_ulogic_vector(0 to LANES / FOLD - 1) := (others => '0');
    bank            : out   std_ulogic                               := '0';
    slot            : out   u_unsigned(2 downto 0)                   := (others => '0');
    effective       : out   std_ulogic_vector(AMPLITUDE_WIDTH - 1 downto 0)
  );
end entity amplitude_sweep;

architecture rtl of amplitude_sweep is

  constant BUILT : positive := LANES / FOLD;

  subtype amplitude is u_signed(AMPLITUDE_WIDTH - 1 downto 0);

  subtype bank_and_lane is u_unsigned(6 downto 0);

  type nominal_words is array (0 to 127) of std_ulogic_vector(AMPLITUDE_WIDTH - 1 downto 0);

  type choices is array (0 to 127) of std_ulogic_vector(2 downto 0);

  type steps_then is array (1 to 4) of u_unsigned(7 downto 0);

  type of_banks is array (0 to 1) of modulator;

  signal nominal        : nominal_words                                  := (others => (others => '0'));
  signal choice         : choices                                        := (others => (others => '0'));
  signal nominal_read   : std_ulogic_vector(AMPLITUDE_WIDTH - 1 downto 0) := (others => '0');
  signal choice_read    : std_ulogic_vector(2 downto 0)                  := (others => '0');
  signal write_place    : bank_and_lane;

begin

  write_place <= write_bank & write_lane;

  remember : process (clock) is
  begin

    if rising_edge(clock) then
      nominal_read <= nominal(to_integer(sweep_step(6 downto 0)));
      choice_read  <= choice(to_integer(sweep_step(6 downto 0)));
      if write_amplitude = '1' then
        nominal(to_integer(write_place)) <= write_word;
      end if;
      if write_choice = '1' then
        choice(to_integer(write_place)) <= write_word(18 downto 16);
      end if;
    end if;

  end process remember;

  multiply : process (clock) is

    -- Registers; the number in a name is the number of clocks from sweep_step until the register is valid.
    variable step_1_to_4 : steps_then                                      := (others => (others => '0'));
    variable amplitude_2 : amplitude                                       := (others => '0');
    variable modulator_2 : modulator                                       := (others => '0');
    variable product_3   : u_signed(AMPLITUDE_WIDTH + MODULATOR_WIDTH - 1 downto 0) := (others => '0');
    variable rounded_4   : u_signed(AMPLITUDE_WIDTH downto 0)              := (others => '0');

    -- Modulators, held for the whole sweep
    variable held_direction : modulator := (others => '0');
    variable held_speed     : of_banks  := (others => (others => '0'));
    variable held_square    : of_banks  := (others => (others => '0'));
    variable held_a         : modulator := (others => '0');
    variable held_b         : modulator := (others => '0');
    -- Speeds for the next sweep. They are stored by number of the bank, so that each bank keeps its speed if a swap
    -- comes during the sweep.
    variable next_speed     : of_banks  := (others => (others => '0'));
    variable next_square    : of_banks  := (others => (others => '0'));

    variable lane           : u_unsigned(5 downto 0);
    variable bank_2         : natural range 0 to 1;
    variable idle           : natural range 0 to 1;
    variable sum            : u_signed(product_3'range);

  begin

    if rising_edge(clock) then
      -- Fifth clock: write to the memory of the effective amplitudes, which no other entity writes.
      selected  <= (others => '0');
      lane      := step_1_to_4(4)(5 downto 0);
      bank      <= step_1_to_4(4)(6);

      for built_lane in 0 to LANES - 1 loop
        if lane = built_lane then
          slot                             <= to_unsigned(built_lane / BUILT, 3);
          selected(built_lane mod BUILT) <= not step_1_to_4(4)(7);
        end if;
      end loop;

      effective <= std_ulogic_vector(rounded_4(amplitude'range));
      if (rounded_4(AMPLITUDE_WIDTH) xor rounded_4(AMPLITUDE_WIDTH - 1)) = '1' then
        effective <= '0' & (AMPLITUDE_WIDTH - 2 downto 0 => '1');
      end if;
      if step_1_to_4(4) = SQUARE_STEP then
        next_square(0) := rounded_4(modulator'range);
      elsif step_1_to_4(4) = SQUARE_STEP + 1 then
        next_square(1) := rounded_4(modulator'range);
      end if;

      -- Fourth clock: round the product.
      sum       := product_3 + 2 ** (MODULATOR_FRACTION - 1);
      rounded_4 := sum(AMPLITUDE_WIDTH + MODULATOR_FRACTION downto MODULATOR_FRACTION);

      -- Third clock: multiply.
      product_3 := amplitude_2 * modulator_2;

      -- Second clock: select the modulator of the lane.
      amplitude_2 := u_signed(nominal_read);
      bank_2      := 1 when step_1_to_4(1)(6) = '1' else 0;

      case to_integer(u_unsigned(choice_read)) is

        when BY_DIRECTION =>
          modulator_2 := held_direction;

        when BY_SPEED =>
          modulator_2 := held_speed(bank_2);

        when BY_SPEED_SQUARED =>
          modulator_2 := held_square(bank_2);

        when BY_WORD_A =>
          modulator_2 := held_a;

        when BY_WORD_B =>
          modulator_2 := held_b;

        when others =>
          modulator_2 := MODULATOR_ONE;

      end case;

      if step_1_to_4(1) = SQUARE_STEP then
        amplitude_2 := resize(next_speed(0), AMPLITUDE_WIDTH);
        modulator_2 := next_speed(0);
      elsif step_1_to_4(1) = SQUARE_STEP + 1 then
        amplitude_2 := resize(next_speed(1), AMPLITUDE_WIDTH);
        modulator_2 := next_speed(1);
      end if;

      -- First clock: store the step; in the last step of a sweep, latch the modulators.
      step_1_to_4 := sweep_step & step_1_to_4(1 to 3);
      idle        := 1 when write_bank = '1' else 0;

      if sweep_step = SQUARE_STEP then
        next_speed(idle)     := idle_speed;
        next_speed(1 - idle) := speed;
      elsif sweep_step = AMPLITUDE_SWEEP_CLOCKS - 1 then
        held_direction := direction;
        held_speed     := next_speed;
        held_square    := next_square;
        held_a         := word_a;
        held_b         := word_b;
      end if;
      speed_squared <= held_square(1 - idle);
    end if;

  end process multiply;

  judge : process (clock) is

    variable is_whole : std_ulogic := '0';

  begin

    if rising_edge(clock) then
      if sweep_step = 0 then
        is_whole := '1';
      elsif sweep_step = AMPLITUDE_SWEEP_CLOCKS - 1 then
        swept <= is_whole;
      end if;
      if (write_amplitude or write_choice) = '1' then
        is_whole := '0';
        swept    <= '0';
      end if;
    end if;

  end process judge;

end architecture rtl;
