-- SPDX-License-Identifier: Apache-2.0
--
-- # correction_ramp
--
-- Makes the correction go on without a step when the coefficients are swapped or the
-- compensation is switched on or off, so that a servo behind the output sees no jump. The
-- correction that is used is total = ε + r. In the clock of a `marker` the total is held and the
-- remainder r = held total − ε is caught; from then on |r| decays to 0 while ε is followed at
-- once. ε itself is never limited in its rate: that would clip a correction that is rightly fast.
--
-- **Rate.** |r| falls by `ramp_rate` a clock on average. A phase accumulator, set to 0 by the
-- marker, hands out whole units of 2⁻¹¹ count: k ≥ 2 clocks after the marker r has lost
-- floor((k − 2)·rate) units, and it stops at 0 exactly. A rate of 0 keeps r for ever. Hence the
-- total changes by at most |change of ε| + one clock's units, and in the clock of a marker by 0.
-- Markers may come at any time, also while r decays and in consecutive clocks.
--
-- **Inserted counts.** Where the reading jumps by whole counts in the clock of a marker (lost counts that are put back),
-- `inserted` is that jump: the total jumps with it and r takes it up, so that reading - total goes on
-- without a step and gains these counts as r decays.
--
-- **Limit.** The total is clipped at ±`limit`; `limited` is high with a total that was clipped.
-- What a marker holds is the clipped total, so r stays bounded however often the bank is swapped.
--
-- **Latency.** 1 clock from `correction` and `marker` to `total`, `limited` and `busy`.
--
-- **Number formats.** correction s20.F, F = PAIR_FRACTION; total s19.F; r s22.F, so that the held
-- total is met exactly; inserted s15.0 counts; limit u19.0 counts; ramp_rate u8.24 in 2⁻¹¹ count a clock: 255 is
-- 0.125 count, 2⁻²⁴ is 0.0029 count a second at 100 MHz.
--
-- **Reset.** total and r are 0.

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
    marker     : in    std_ulogic;                                               -- with the first ε of another origin
    inserted   : in    u_signed(15 downto 0);                                    -- counts, of the reading, with the marker
    limit      : in    u_unsigned(18 downto 0);                                  -- counts, u19.0
    ramp_rate  : in    u_unsigned(31 downto 0);                                  -- 2⁻¹¹ count a clock, u8.24
    total      : out   u_signed(19 + PAIR_FRACTION downto 0) := (others => '0'); -- counts, s19.F
    limited    : out   std_ulogic                            := '0';             -- this total was clipped
    busy       : out   std_ulogic                            := '0'              -- this total has a remainder, or is held
  );
end entity correction_ramp;

architecture rtl of correction_ramp is

  constant WIDTH     : positive := 23 + PAIR_FRACTION;
  constant RATE_UNIT : natural  := PAIR_FRACTION - CORRECTION_FRACTION;

  subtype sum is u_signed(WIDTH - 1 downto 0);

  -- a + b + 1 + limit on one carry chain. The limit is whole counts: below them there are only two
  -- numbers to add.
  function sum_and_limit (a, b : sum; limit : u_unsigned) return sum is

    variable whole_a : u_signed(WIDTH - 1 downto PAIR_FRACTION);
    variable whole_b : u_signed(WIDTH - 1 downto PAIR_FRACTION);
    variable whole   : u_signed(WIDTH - 1 downto PAIR_FRACTION);

  begin

    whole_a := a(whole_a'range);
    whole_b := b(whole_b'range);
    whole   := resize(u_signed('0' & limit), whole'length);
    return add_with_carry(
      saved_sum(whole_a, whole_b, whole) & a(PAIR_FRACTION - 1 downto 0),
      saved_carry(whole_a, whole_b, whole) & b(PAIR_FRACTION - 1 downto 0),
      '1'
    );

  end function sum_and_limit;

begin

  ramp : process (clock) is

    variable excess      : sum                    := (others => '0'); -- -r: what ε is above the total
    variable held        : sum                    := (others => '0');
    variable accumulator : u_unsigned(32 downto 0) := (others => '0');
    variable step        : u_unsigned(8 downto 0)  := (others => '0');

    variable unramped  : sum;
    variable unlimited : sum;
    variable top       : sum;
    variable above     : sum;
    variable below     : sum;
    variable decrement : sum;
    variable decayed   : sum;
    variable rising    : std_ulogic;
    variable jump      : sum;

  begin

    if rising_edge(clock) then
      -- ε + r and its distances to both limits, side by side on a carry chain each.
      unramped  := resize(correction, WIDTH);
      top       := shift_left(resize(u_signed('0' & limit), WIDTH), PAIR_FRACTION);
      unlimited := unramped - excess;
      above     := sum_and_limit(not unramped, excess, limit);
      below     := sum_and_limit(unramped, not excess, limit);

      jump      := shift_left(resize(inserted, WIDTH), PAIR_FRACTION);
      rising    := excess(WIDTH - 1);
      decrement := shift_left(resize(u_signed('0' & step), WIDTH), RATE_UNIT);
      decayed   := less_or_more(excess, decrement, rising);

      busy    <= or excess;
      limited <= '0';

      if marker = '1' then
        excess      := unramped - held - jump;
        held        := held + jump;
        busy        <= '1';
        accumulator := (others => '0');
        step        := (others => '0');
      else
        if above(WIDTH - 1) = '1' then
          held    := top;
          limited <= '1';
        elsif below(WIDTH - 1) = '1' then
          held    := -top;
          limited <= '1';
        else
          held := unlimited;
        end if;

        -- A change of sign ends the ramp.
        if decayed(WIDTH - 1) /= excess(WIDTH - 1) then
          excess := (others => '0');
        else
          excess := decayed;
        end if;

        accumulator := resize(accumulator(23 downto 0), 33) + resize(ramp_rate, 33);
        step        := accumulator(32 downto 24);
      end if;

      if reset = '1' then
        excess      := (others => '0');
        held        := (others => '0');
        accumulator := (others => '0');
        step        := (others => '0');
        limited     <= '0';
        busy        <= '0';
      end if;

      total <= resize(held, total'length);
    end if;

  end process ramp;

end architecture rtl;
