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
-- **Velocity.** r begins to move with no velocity and ends with none (ramp_velocity): its velocity changes by
-- `ramp_acceleration` in 256 clocks, up to `ramp_rate`. A marker changes r and not its velocity. So the velocity of
-- the total steps by that of ε alone; a marker holds the total for one clock and r for one more. The end is a
-- step of less than 2⁻¹¹ count. A rate of 0 brings r to a standstill and keeps it.
--
-- **Acceleration 0** lets the velocity be `ramp_rate` at once: k ≥ 2 clocks after the marker r has lost
-- floor((k − 2)·rate), in 2⁻ᶠ count, and it stops at 0 exactly. Change between 0 and
-- another acceleration, and make one smaller, only while r is 0: r may pass 0 and come back otherwise.
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
-- 0.125 count, 2⁻²⁴ is 0.0029 count a second at 100 MHz. ramp_acceleration u32 in 2⁻⁵⁹ count a clock and clock:
-- 0.0173 count/s² at 100 MHz.
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
    marker     : in    std_ulogic;                                               -- with the first ε of another origin
    inserted   : in    u_signed(15 downto 0);                                    -- counts, of the reading, with the marker
    limit      : in    u_unsigned(18 downto 0);                                  -- counts, u19.0
    ramp_rate  : in    u_unsigned(31 downto 0);                                  -- 2⁻¹¹ count a clock, u8.24
    ramp_acceleration : in    u_unsigned(31 downto 0);                           -- 2⁻⁵⁹ count a clock and clock
    total      : out   u_signed(19 + PAIR_FRACTION downto 0) := (others => '0'); -- counts, s19.F
    limited    : out   std_ulogic                            := '0';             -- this total was clipped
    busy       : out   std_ulogic                            := '0'              -- this total has a remainder, or is held
  );
end entity correction_ramp;

architecture rtl of correction_ramp is

  constant WIDTH : positive := 23 + PAIR_FRACTION;

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

  signal excess_now : sum := (others => '0');
  signal step       : u_unsigned(24 downto 0);
  signal falling    : std_ulogic;
  signal ends       : std_ulogic;
  signal moves      : std_ulogic;
  signal stops_at_zero : std_ulogic;

begin

  motion : entity work.ramp_velocity
    port map (
      clock        => clock,
      reset        => reset,
      marker       => marker,
      excess       => excess_now,
      rate         => ramp_rate,
      acceleration => ramp_acceleration,
      step         => step,
      falling      => falling,
      ends         => ends,
      moves        => moves,
      stops_at_zero => stops_at_zero
    );

  ramp : process (clock) is

    variable excess : sum := (others => '0'); -- -r: what ε is above the total
    variable held   : sum := (others => '0');

    variable unramped  : sum;
    variable unlimited : sum;
    variable top       : sum;
    variable above     : sum;
    variable below     : sum;
    variable decrement : sum;
    variable decayed   : sum;
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
      decrement := resize(u_signed('0' & step), WIDTH);
      decayed   := less_or_more(excess, decrement, not falling);

      busy    <= (or excess) or moves;
      limited <= '0';

      if marker = '1' then
        excess := unramped - held - jump;
        held   := held + jump;
        busy   <= '1';
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

        -- Where the velocity has no bound of its change, r passes 0 with it: that ends the ramp.
        if ends = '1' or (stops_at_zero = '1' and decayed(WIDTH - 1) = falling) then
          excess := (others => '0');
        else
          excess := decayed;
        end if;
      end if;

      if reset = '1' then
        excess  := (others => '0');
        held    := (others => '0');
        limited <= '0';
        busy    <= '0';
      end if;

      total      <= resize(held, total'length);
      excess_now <= excess;
    end if;

  end process ramp;

end architecture rtl;
