-- SPDX-License-Identifier: Apache-2.0
--
-- # correction_ramp
--
-- Adds a decaying remainder r to the correction ε, so that the applied correction makes no step when the coefficients
-- are swapped or the compensation is switched on or off. The applied correction is the total, ε + r. Each such change
-- comes with a `marker`: the entity then holds the total for three clocks and latches the remainder r = held total − ε.
-- From then on |r| decays to 0, while the total follows each change of ε at once. The rate of ε itself is never limited,
-- because a limit would clip a correction that must be fast.
--
-- **Velocity.** The decay of r begins and ends with velocity 0 (ramp_velocity): every 256 clocks the velocity of r
-- changes by at most 256 clocks · `ramp_acceleration`; its magnitude is at most `ramp_rate`. A marker changes r but not
-- the velocity of r, so the velocity of the total steps only by the change of the velocity of ε. After a marker the
-- total keeps its value for three clocks. r is latched in the second of them, so at their end the total steps by as
-- much as ε changes in two clocks; r then keeps its value for two further clocks. At the end of the ramp r steps to 0
-- from less than 2⁻¹⁰ count. With a rate of 0, r stops and keeps its value.
--
-- **Acceleration 0** sets the velocity to `ramp_rate` at once: k ≥ 5 clocks after the marker |r| has decreased by
-- floor((k − 5)·rate), in 2⁻ᶠ count, and r stops at 0 exactly. Change the acceleration to or from 0, or reduce it, only
-- while r is 0: otherwise r may pass 0 and return.
--
-- **Inserted counts.** If the reading jumps by whole counts in the clock of a marker (lost counts that are put back),
-- `withdrawn` is the negative of that jump: the total jumps with the reading and r absorbs the jump. So reading - total
-- makes no step; it gains these counts as r decays. If counts are put back much faster than r decays, the total reaches
-- the end of its range, 2¹⁹ counts. Then the total stays at its limit, `limited` is high, and further counts appear in
-- reading - total at once.
--
-- **Limit.** The total is clipped at `limit` and at -`limit` - 2⁻ᶠ; `limited` is high in the clock of each total that
-- would exceed ±`limit` without the clipping. A marker holds the clipped total, so r stays bounded however often the
-- bank is swapped. A change of `limit` acts two clocks later.
--
-- **One carry chain per clock.** The entity computes r one clock ahead (`next_excess`), and from it the bounds -r ±
-- limit, with which ε is compared in the next clock. When the ramp ends, r becomes 0 and the bounds become ±limit.
-- The lower limit, -`limit` - 2⁻ᶠ, is the complement of `limit`, so one look-up table per bit selects the total.
--
-- **Latency.** 1 clock from `correction` and `marker` to `total`, `limited` and `busy`.
--
-- **Number formats.** correction s20.F, F = PAIR_FRACTION; total s19.F; r s22.F, so that ε + r equals the held total
-- exactly; withdrawn s15.0 counts; limit u19.0 counts; ramp_rate u8.24 in 2⁻¹¹ count per clock: the value 255 is 0.125
-- count per clock, the smallest value 2⁻²⁴ is 0.0029 count per second at 100 MHz; ramp_acceleration u32.0 in 2⁻⁵⁹ count
-- per clock², which is 0.0173 count/s² at 100 MHz.
--
-- **Reset.** total, r and its velocity are 0.

library ieee;
  use ieee.std_logic_1164.all;
  use ieee.numeric_std.all;

  use work.carry_save_pkg.all;
  use work.number_formats_pkg.all;

entity correction_ramp is
  port (
    clock      : in    std_ulogic;
    reset      : in    std_ulogic;
    correction : in    u_signed(20 + PAIR_FRACTION downto 0);                    -- ε, counts, s20.F
    marker     : in    std_ulogic;                                               -- high with the first ε from another bank or setting
    withdrawn  : in    u_signed(15 downto 0);                                    -- counts that the reading loses at the marker
    limit      : in    u_unsigned(18 downto 0);                                  -- counts, u19.0
    ramp_rate  : in    u_unsigned(31 downto 0);                                  -- 2⁻¹¹ count per clock, u8.24
    ramp_acceleration : in    u_unsigned(31 downto 0);                           -- 2⁻⁵⁹ count per clock²
    total      : out   u_signed(19 + PAIR_FRACTION downto 0) := (others => '0'); -- counts, s19.F
    limited    : out   std_ulogic                            := '0';             -- high if this total was clipped
    busy       : out   std_ulogic                            := '0'              -- high if this total has a remainder, or is held
  );
end entity correction_ramp;

architecture rtl of correction_ramp is

  constant WIDTH       : positive := 23 + PAIR_FRACTION;
  constant WHOLE_WIDTH : positive := WIDTH - PAIR_FRACTION;

  subtype sum is u_signed(WIDTH - 1 downto 0);

  signal held        : u_signed(total'range) := (others => '0');
  -- -r, the excess of ε over the total: `excess` in this clock, `next_excess` in the next clock unless the ramp ends
  signal excess      : sum                   := (others => '0');
  signal next_excess : sum                   := (others => '0');
  -- Bounds with which ε is compared in this clock
  signal upper_bound : sum                   := (others => '0');
  signal lower_bound : sum                   := (others => '0');
  -- A marker came 1 or 2 clocks ago.
  signal marker_then : std_ulogic_vector(1 to 2) := "00";
  signal is_at_rest  : std_ulogic            := '1';
  signal ends_now    : std_ulogic;

  signal step           : u_signed(33 - RAMP_TICK_WIDTH downto 0);
  signal step_rises      : std_ulogic;
  signal falling        : std_ulogic;
  signal ends           : std_ulogic;
  signal moves          : std_ulogic;
  signal stops_at_zero  : std_ulogic;

begin

  motion : entity work.ramp_velocity
    port map (
      clock         => clock,
      reset         => reset,
      marker        => marker_then(1),
      excess        => next_excess,
      rate          => ramp_rate,
      acceleration  => ramp_acceleration,
      step          => step,
      step_rises     => step_rises,
      falling       => falling,
      ends          => ends,
      moves         => moves,
      stops_at_zero => stops_at_zero
    );

  total <= held;

  -- ramp_velocity ends the ramp by `ends`; with acceleration 0 the ramp ends when r would pass 0.
  ends_now <= is_at_rest or ends or (stops_at_zero and (next_excess(WIDTH - 1) xnor falling));

  choose_total : process (clock) is

    variable unlimited : sum;
    -- The total after the jump of the reading, with one bit more than the total
    variable jumped    : u_signed(WHOLE_WIDTH - 3 downto 0);
    variable overflows : std_ulogic;
    variable whole     : u_signed(WHOLE_WIDTH - 4 downto 0);
    variable above     : std_ulogic;
    variable below     : std_ulogic;

  begin

    if rising_edge(clock) then
      -- ε + r and its limits are computed in parallel, each on one carry chain.
      unlimited := resize(correction, WIDTH) - excess;
      above     := resize(correction, WIDTH) ?> upper_bound;
      below     := resize(correction, WIDTH) ?< lower_bound;
      jumped    := resize(held(held'high downto PAIR_FRACTION), jumped'length) - withdrawn;
      overflows := jumped(jumped'high) xor jumped(jumped'high - 1);
      whole     := jumped(whole'range);
      if overflows = '1' then
        whole := resize(u_signed('0' & limit), whole'length) xor (whole'range => jumped(jumped'high));
      end if;

      busy    <= (or excess) or moves or marker or (or marker_then);
      limited <= ((above or below) and not marker and not (or marker_then)) or (marker and overflows);

      if marker = '1' then
        held(held'high downto PAIR_FRACTION) <= whole;
      elsif marker_then = "00" then
        if above = '1' then
          held(held'high downto PAIR_FRACTION) <= resize(u_signed('0' & limit), whole'length);
        elsif below = '1' then
          held(held'high downto PAIR_FRACTION) <= not resize(u_signed('0' & limit), whole'length);
        else
          held(held'high downto PAIR_FRACTION) <= unlimited(held'high downto PAIR_FRACTION);
        end if;
      end if;

      if marker = '0' and marker_then = "00" then
        held(PAIR_FRACTION - 1 downto 0) <= (unlimited(PAIR_FRACTION - 1 downto 0) or (PAIR_FRACTION - 1 downto 0 => below))
                                            and (PAIR_FRACTION - 1 downto 0 => not above);
      end if;

      if reset = '1' then
        held    <= (others => '0');
        limited <= '0';
        busy    <= '0';
      end if;
    end if;

  end process choose_total;

  decay : process (clock) is

    variable whole : u_signed(WIDTH - 1 downto PAIR_FRACTION);
    variable top   : u_signed(WIDTH - 1 downto PAIR_FRACTION);

  begin

    if rising_edge(clock) then
      -- The limit is a whole number of counts, so nothing is added to the fraction bits.
      top         := resize(u_signed('0' & limit), top'length);
      whole       := next_excess(whole'range);
      upper_bound <= (whole + top) & next_excess(PAIR_FRACTION - 1 downto 0);
      lower_bound <= (whole - top) & next_excess(PAIR_FRACTION - 1 downto 0);
      if ends_now = '1' then
        upper_bound <= top & (PAIR_FRACTION - 1 downto 0 => '0');
        -- The negative limit is written in a form that Yosys does not merge with the difference above: the merged logic
        -- would have to wait for ends_now.
        lower_bound <= (not (top - 1)) & (PAIR_FRACTION - 1 downto 0 => '0');
      end if;

      excess      <= next_excess;
      next_excess <= add_with_carry(next_excess, resize(step, WIDTH), not step_rises);
      is_at_rest  <= ends_now;
      if ends_now = '1' then
        excess      <= (others => '0');
        next_excess <= (others => '0');
      end if;

      marker_then <= marker & marker_then(1);
      if marker_then(1) = '1' then
        next_excess <= resize(correction, WIDTH) - held;
        is_at_rest  <= '0';
      end if;

      if reset = '1' then
        excess      <= (others => '0');
        next_excess <= (others => '0');
        is_at_rest  <= '1';
        marker_then <= "00";
      end if;
    end if;

  end process decay;

end architecture rtl;
