-- SPDX-License-Identifier: Apache-2.0
--
-- # ramp_velocity
--
-- Computes by how much the remainder of a ramp changes in each clock, so that the remainder reaches 0 without a step of
-- its velocity. Every 256 clocks the velocity rises by one step, 256 clocks · `acceleration`, up to `rate`, or falls by
-- one step, early enough that remainder and velocity reach 0 together. The velocity rises, or stays, only if the
-- remainder is at least the braking distance from the resulting velocity, so the remainder passes 0 by at most one unit
-- 2⁻ᶠ; then the ramp ends.
--
-- **Changes of the remainder** at any time (`marker`) cause no step of the velocity. If the changed remainder has the
-- other sign, or is smaller than the braking distance, the velocity falls first, and the remainder passes 0 and
-- returns. If a marker comes in the 15 clocks between the reading of the remainder and the change of the velocity, the
-- new remainder is unknown, and the velocity falls by one step. A series of markers in these 15 of every 256 clocks
-- therefore stops the ramp until the series ends; such markers never make the remainder pass 0.
--
-- **Acceleration 0** gives the velocity `rate` from the first clock on. The entity that adds `step` to the excess (the
-- negative remainder) must then set the excess to 0 when a step would make it pass 0; `stops_at_zero` requests this,
-- from the second clock after a marker on.
--
-- **Rate 0** brings the velocity down to 0 and keeps the remainder (a remainder below 2⁻¹⁰ count may become 0). A rate
-- below one step does the same, unless the acceleration is 0.
--
-- **Latency.** `step`, `ends` and `falling` belong to the clock in which they are output. The remainder is read once in
-- 256 clocks, 15 clocks before the velocity changes. The braking distance has a margin for these 15 clocks: an eighth
-- of the distance that the remainder covers in 256 clocks. After a `marker`, `step` is 0 for two clocks.
--
-- **Number formats.** excess s22.F counts, F = PAIR_FRACTION, the negative remainder; rate u8.24 in 2⁻¹¹ count per
-- clock; acceleration u32.0 in 2⁻⁵⁹ count per clock²; step s-2.F counts; while the excess falls, its change is `step`
-- plus one unit. Internal formats: velocity u-3.51 counts per clock (-3 integer bits: the highest bit has the weight
-- 2⁻⁴), whose bits from 2⁻³⁵ upwards are the distance of 256 clocks in 2⁻²⁷ count; braking distance u22.F counts, the
-- sum of such distances down to velocity 0.
--
-- **Reset.** The velocity is 0.

library ieee;
  use ieee.std_logic_1164.all;
  use ieee.numeric_std.all;

  use work.carry_save_pkg.all;
  use work.number_formats_pkg.all;

entity ramp_velocity is
  port (
    clock        : in    std_ulogic;
    reset        : in    std_ulogic;
    marker       : in    std_ulogic;                                               -- high if the excess changes with this clock
    excess       : in    u_signed(22 + PAIR_FRACTION downto 0);                    -- counts, s22.F
    rate         : in    u_unsigned(31 downto 0);                                  -- 2⁻¹¹ count per clock, u8.24
    acceleration : in    u_unsigned(31 downto 0);                                  -- 2⁻⁵⁹ count per clock²
    step         : out   u_signed(33 - RAMP_TICK_WIDTH downto 0) := (others => '0'); -- counts, s-2.F, to be added to the excess
    step_rises   : out   std_ulogic                         := '1';                -- low: add 2⁻ᶠ count to step
    falling      : out   std_ulogic                         := '0';                -- high: the excess falls; low: it rises
    ends         : out   std_ulogic                         := '0';                -- strobe: the excess must become 0
    moves        : out   std_ulogic                         := '0';                -- high if the velocity is not 0
    stops_at_zero : out   std_ulogic                        := '0'                 -- high if the acceleration is 0
  );
end entity ramp_velocity;

architecture rtl of ramp_velocity is

  constant WIDTH          : positive := 23 + PAIR_FRACTION;
  constant VELOCITY_WIDTH : positive := 32 + RAMP_VELOCITY_FRACTION;

  -- Numbers of the clocks, out of 256, in which the entity makes the remainder positive, compares it with two braking
  -- distances, chooses and changes the velocity.
  constant MEASURE        : natural := RAMP_LOOK_CLOCK + 1;
  constant COMPARE_FASTER : natural := RAMP_LOOK_CLOCK + 2;
  constant COMPARE_SAME   : natural := RAMP_LOOK_CLOCK + 3;
  constant CHOOSE         : natural := RAMP_LOOK_CLOCK + 4;
  constant TAKE_OFF       : natural := RAMP_LOOK_CLOCK + 5;
  constant DECIDE         : natural := 2 ** RAMP_TICK_WIDTH - 1;

  -- Action of a clock. It is decoded one clock earlier and stored in a register, because many bits depend on it.
  type moment_of_tick is (
    ADD, SUBTRACT, ADD_WAY, ADD_MARGIN, LOOK_NOW, MEASURE_NOW, COMPARE_FASTER_NOW, COMPARE_SAME_NOW, CHOOSE_NOW, TAKE_OFF_NOW,
    DECIDE_NOW, NOTHING
  );

  subtype way_count is u_unsigned(WIDTH - 1 downto 0);

  -- Returns the action of the clock that follows clock `tick`.
  function moment_after (
    tick : natural range 0 to DECIDE
  ) return moment_of_tick is
  begin

    case tick is

      when DECIDE =>
        return ADD;

      when 0 =>
        return SUBTRACT;

      when 1 =>
        return ADD_WAY;

      when 2 =>
        return ADD_MARGIN;

      when RAMP_LOOK_CLOCK - 1 =>
        return LOOK_NOW;

      when MEASURE - 1 =>
        return MEASURE_NOW;

      when COMPARE_FASTER - 1 =>
        return COMPARE_FASTER_NOW;

      when COMPARE_SAME - 1 =>
        return COMPARE_SAME_NOW;

      when CHOOSE - 1 =>
        return CHOOSE_NOW;

      when TAKE_OFF - 1 =>
        return TAKE_OFF_NOW;

      when DECIDE - 1 =>
        return DECIDE_NOW;

      when others =>
        return NOTHING;

    end case;

  end function moment_after;

  signal velocity   : u_unsigned(VELOCITY_WIDTH - 1 downto 0) := (others => '0');
  signal is_at_once : std_ulogic                              := '1';

begin

  choose_velocity : process (clock) is

    variable tick           : u_unsigned(RAMP_TICK_WIDTH - 1 downto 0) := (others => '0');
    variable moment         : moment_of_tick                          := ADD;
    variable whole          : u_unsigned(31 downto 0);
    variable limit          : u_unsigned(VELOCITY_WIDTH - 1 downto 0);
    -- Braking distance from the present velocity
    variable way            : way_count                               := (others => '0');
    -- The velocity after one step up (faster) and one step down (slower); the highest bit of slower is high if the step
    -- would make the velocity negative
    variable faster         : u_unsigned(VELOCITY_WIDTH downto 0)     := (others => '0');
    variable slower         : u_unsigned(VELOCITY_WIDTH downto 0)     := (others => '0');
    variable is_faster_too_fast : std_ulogic                          := '0';
    variable is_too_fast    : std_ulogic                              := '0';
    -- Smallest remainder for which the velocity may rise, without and with the margin, and for which it may stay. The
    -- first one is also the braking distance after a step up.
    variable way_straight   : way_count                               := (others => '0');
    variable way_faster     : way_count                               := (others => '0');
    variable way_same       : way_count                               := (others => '0');
    -- First the excess, then |excess|; for a negative excess |excess| minus one unit
    variable size           : way_count                               := (others => '0');
    -- High if the excess has changed since it was read.
    variable is_stale       : std_ulogic                              := '0';
    variable is_unknown     : std_ulogic;
    variable is_zero        : std_ulogic                              := '1';
    variable goes_away      : std_ulogic                              := '0';
    -- is_last: the next step down makes the velocity 0. is_slow: in 256 clocks the excess changes by at most one unit
    variable is_last        : std_ulogic                              := '0';
    variable is_slow        : std_ulogic                              := '0';
    -- The decisions on the next velocity
    variable brakes         : std_ulogic                              := '0';
    variable stops          : std_ulogic                              := '0';
    variable speeds         : std_ulogic                              := '0';
    variable is_end         : std_ulogic                              := '0';
    variable way_less       : way_count                               := (others => '0');
    variable is_short_of_faster : std_ulogic                          := '0';
    variable is_short_of_same : std_ulogic                            := '0';

    -- Operands of the carry chains in this clock, decoded with `moment`
    variable takes_off      : std_ulogic                              := '0';
    variable of_same        : std_ulogic                              := '0';
    variable of_margin      : std_ulogic                              := '0';
    variable of_way_back    : std_ulogic                              := '0';

    variable swing          : u_unsigned(VELOCITY_WIDTH downto 0);
    variable judged         : u_unsigned(VELOCITY_WIDTH downto 0);
    variable is_above_limit : std_ulogic;
    variable way_change     : way_count;
    variable next_way       : way_count;
    variable way_judged     : way_count;
    variable is_short       : std_ulogic;

  begin

    if rising_edge(clock) then
      whole := velocity(velocity'high downto RAMP_VELOCITY_FRACTION);
      limit := rate & (RAMP_VELOCITY_FRACTION - 1 downto 0 => '0');
      ends  <= '0';

      -- Four carry chains serve nine sums and comparisons, one after the other. The operands are selected in the look-up
      -- tables of the chains.
      swing := u_unsigned(less_or_more(signed('0' & velocity), signed(resize(acceleration, swing'length)), not takes_off));

      judged         := faster when of_margin = '0' else '0' & velocity;
      is_above_limit := is_less(signed("00" & limit), signed('0' & judged));

      if of_way_back = '1' then
        way_change := resize(whole, WIDTH);
      elsif of_margin = '1' then
        way_change := resize(whole(whole'high downto RAMP_MARGIN_BITS), WIDTH);
      else
        way_change := resize(faster(faster'high downto RAMP_VELOCITY_FRACTION), WIDTH);
      end if;
      next_way := u_unsigned(less_or_more(signed(way), signed(way_change), not of_way_back));

      way_judged    := way_faster when of_same = '0' else way_same;
      is_short   := is_less(signed('0' & size), signed('0' & way_judged));

      case moment is

        when ADD =>
          faster := swing;

        when SUBTRACT =>
          slower := swing;

        when ADD_WAY =>
          is_last       := slower(slower'high) or not (or slower);
          is_slow       := not (or whole(whole'high downto 1));
          is_faster_too_fast := is_above_limit;
          way_straight  := next_way;

        when ADD_MARGIN =>
          is_too_fast := is_above_limit;
          way_same    := next_way;
          way_faster := way_straight + faster(faster'high downto RAMP_VELOCITY_FRACTION + RAMP_MARGIN_BITS);

        when LOOK_NOW =>
          is_stale := '0';
          size     := u_unsigned(excess);

        when MEASURE_NOW =>
          is_zero   := not (or size);
          goes_away := moves and (falling xnor size(size'high));
          size      := size xor (size'range => size(size'high));

        when COMPARE_FASTER_NOW =>
          -- An excess of one unit below 0 counts as 0: with a small acceleration, no step would move it.
          is_zero            := is_zero or not (goes_away or (or size));
          is_short_of_faster := is_short;

        when COMPARE_SAME_NOW =>
          is_short_of_same := is_short;

        when CHOOSE_NOW =>
          brakes := is_too_fast or goes_away or is_short_of_same;
          stops  := (not moves and is_short_of_faster) or (is_zero and is_slow) or (brakes and is_last);
          speeds := not (is_short_of_faster or is_faster_too_fast or brakes);
          is_end := (not moves and is_short_of_faster) or (is_zero and is_slow);
          way_straight := next_way;

        when TAKE_OFF_NOW =>
          way_less := next_way;

        when DECIDE_NOW =>
          is_unknown := is_stale or marker;
          ends       <= is_end and not is_unknown;
          if (stops and not is_unknown) = '1' or (is_last and is_unknown) = '1' then
            moves    <= '0';
            velocity <= (others => '0');
            way      := (others => '0');
          elsif brakes = '1' or is_unknown = '1' then
            velocity <= slower(velocity'range);
            way      := way_less;
          elsif speeds = '1' then
            velocity <= faster(velocity'range);
            way      := way_straight;
            moves    <= '1';
            if moves = '0' then
              falling <= not excess(excess'high);
            end if;
          end if;

        when NOTHING =>
          null;

      end case;

      moment   := moment_after(to_integer(tick));
      tick     := tick + 1;
      is_stale := is_stale or marker;

      if is_at_once = '1' then
        ends     <= '0';
        falling  <= not excess(excess'high);
        velocity <= limit;
        moves    <= '0';
        way      := (others => '0');
      end if;
      stops_at_zero <= is_at_once and not marker;
      is_at_once    <= not (or acceleration);

      if reset = '1' then
        tick     := (others => '0');
        moment   := ADD;
        way      := (others => '0');
        is_zero  := '1';
        velocity <= (others => '0');
        moves    <= '0';
        ends     <= '0';
        stops_at_zero <= '0';
      end if;

      -- These belong to the next clock, as `moment` does, also after a reset.
      takes_off   := '1' when moment = SUBTRACT else '0';
      of_margin   := '1' when moment = ADD_MARGIN else '0';
      of_same     := '1' when moment = COMPARE_SAME_NOW else '0';
      of_way_back := '1' when moment = TAKE_OFF_NOW else '0';
    end if;

  end process choose_velocity;

  -- Adds the velocity in each clock and outputs the part that the excess can hold; the fraction below the last bit of
  -- the excess is added in the next clock.
  hand_out : process (clock) is

    variable fraction : u_unsigned(RAMP_TICK_WIDTH - 1 downto 0) := (others => '0');
    variable sum      : u_unsigned(32 downto 0);
    variable was_marker : std_ulogic := '0';

  begin

    if rising_edge(clock) then
      sum      := resize(fraction, sum'length) + resize(velocity(velocity'high downto RAMP_VELOCITY_FRACTION), sum'length);
      fraction := sum(fraction'range);
      -- A negative step is the complement of the sum; the entity that adds `step` also adds the missing unit
      -- (step_rises is low).
      step       <= u_signed('0' & sum(sum'high downto RAMP_TICK_WIDTH)) xor (step'range => falling);
      step_rises <= not falling;
      if reset = '1' or marker = '1' or was_marker = '1' then
        fraction   := (others => '0');
        step       <= (others => '0');
        step_rises <= '1';
      end if;
      was_marker := marker;
    end if;

  end process hand_out;

end architecture rtl;
