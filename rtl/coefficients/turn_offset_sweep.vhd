-- SPDX-License-Identifier: Apache-2.0
--
-- # turn_offset_sweep
--
-- Prepares the phase offsets of lanes whose order n need not be an integer: within a turn a lane's phase is Φ + n·θ,
-- and from turn to turn it advances by the fractional part ν of n. The offset of turn m is Φ + frac(m·ν). One
-- multiplier computes it for turn m, the turn before and the turn after, for all lanes of both banks one after the
-- other (a sweep); then the next sweep begins. The entity stores the turn steps ν and the offsets Φ of both banks. If
-- the order is an integer, ν is 0, and the offset is Φ in every turn.
--
-- **Turns.** The offset of turn m is written to place m modulo 4 of its lane. A sweep takes 18 · LANES clocks. It uses
-- the turn at its start as m throughout, so that it writes the offsets of three neighbouring turns even if the angle
-- moves to another turn meanwhile. While the angle crosses a wrap back and forth, these offsets do not change. After a
-- wrap the offsets of the next turn are complete within two sweeps, 36 · LANES + 12 clocks after the first angle of the
-- new turn. The angle moves by at most one count per clock. Between two wraps in the same direction it moves by at
-- least half a turn, even if the zero moves. Therefore a turn of 72 · LANES + 48 counts is long enough at
-- every speed.
--
-- **Limits.** m has 24 bits: beyond ±2²³ turns it wraps, and the phase then steps by frac(2²⁴·ν). Prepared sets of
-- heads (FAILOVER) hold no turn steps: the lanes of a set keep the turn steps of the idle bank.
--
-- **Exact.** m·ν is calculated modulo one turn with all 48 bits: no error accumulates from turn to turn, and the offset
-- does not depend on the path to turn m. The offset is rounded once, half up, to 24 bits.
--
-- **Swap.** While `swept` is high, the offsets of the idle bank are complete. `swept` falls with a write and rises
-- 36 · LANES + 12 clocks after the last write, when at least one whole sweep has run since. After a swap, `take_over`
-- starts the copy of the active bank's turn steps into the idle bank. `copies` is high during this copy, for
-- 18 · LANES + 4 or 5 clocks; write no turn step while it is high.
--
-- **Latency.** 1 clock from `read_address` to `read_word`. The memory contains an offset 8 clocks after the sweep
-- begins to compute it.
--
-- **Number formats.** turn s23.0 turns; turn steps u0.48 turn per turn; offsets u0.24 turn.
--
-- **Reset.** There is none: the sweeps continue. At power-up every word is 0.

library ieee;
  use ieee.std_logic_1164.all;
  use ieee.numeric_std.all;

  use work.number_formats_pkg.all;

entity turn_offset_sweep is
  generic (
    LANES : positive range 1 to LANES_MAX := LANES_DEFAULT;
    FOLD  : positive range 1 to 8         := 1 -- number of lanes that share a pipeline: 1, 2, 4 or 8
  );
  port (
    clock        : in    std_ulogic;
    turn         : in    u_signed(TURN_NUMBER_WIDTH - 1 downto 0);                      -- number of turns of the present angle
    idle_bank    : in    std_ulogic;
    -- Writes of the words of the idle bank
    write_low    : in    std_ulogic;                                                    -- pulse: write bits 31 to 0 of the turn step
    write_high   : in    std_ulogic;                                                    -- pulse: write bits 47 to 32 of the turn step
    write_offset : in    std_ulogic;                                                    -- pulse: write the phase offset
    write_lane   : in    u_unsigned(5 downto 0);
    write_word   : in    std_ulogic_vector(31 downto 0);
    take_over    : in    std_ulogic;                                                    -- pulse: copy the turn steps into the idle bank
    copies       : out   std_ulogic;
    swept        : out   std_ulogic                               := '0';               -- level: a whole sweep has followed the last write
    read_address : in    u_unsigned(6 downto 0);                                        -- lane * 2 + word
    read_word    : out   std_ulogic_vector(31 downto 0);                                -- word of the idle bank's turn step
    -- Writes of the prepared offsets
    selected     : out   std_ulogic_vector(0 to LANES / FOLD - 1) := (others => '0');
    bank         : out   std_ulogic                               := '0';
    slot         : out   u_unsigned(2 downto 0)                   := (others => '0');
    of_turn      : out   u_unsigned(1 downto 0)                   := (others => '0');   -- turn modulo 4
    prepared     : out   std_ulogic_vector(PHASE_WIDTH - 1 downto 0) := (others => '0') -- turn, u0.24
  );
end entity turn_offset_sweep;

architecture rtl of turn_offset_sweep is

  constant BUILT        : positive := LANES / FOLD;
  constant PARTS        : positive := 3;
  constant SWEEP_CLOCKS : positive := TURN_SWEEP_CLOCKS_A_LANE * LANES;
  -- Clocks from the first of the three items of a sweep's last offset until the memory holds this offset, plus 2.
  constant TAIL_CLOCKS  : positive := 10;

  constant SUM_WIDTH    : positive := TURN_NUMBER_WIDTH + PHASE_PART_WIDTH + 1;
  constant HIGH_WIDTH   : positive := PHASE_STEP_WIDTH - 2 * PHASE_PART_WIDTH;
  constant LOWEST_BIT   : positive := PHASE_STEP_WIDTH - PHASE_WIDTH - PHASE_PART_WIDTH;

  subtype word is std_ulogic_vector(31 downto 0);

  subtype offset_of_phase is u_unsigned(PHASE_WIDTH - 1 downto 0);

  subtype turn_number is u_signed(TURN_NUMBER_WIDTH - 1 downto 0);

  subtype product is u_signed(SUM_WIDTH - 1 downto 0);

  type low_words is array (0 to 127) of word;

  subtype high_word is std_ulogic_vector(PHASE_STEP_WIDTH - 33 downto 0);

  type high_words is array (0 to 127) of high_word;

  type offsets is array (0 to 127) of offset_of_phase;

  -- An item in the pipeline: one part of a turn step, with its lane, bank and turn
  type item is record
    part  : natural range 0 to PARTS - 1;
    lane  : natural range 0 to LANES - 1;
    bank  : std_ulogic;
    which : natural range 0 to 2; -- turn m, m + 1, m - 1
  end record item;

  type items is array (natural range <>) of item;

  constant FIRST : item :=
  (
    part  => 0,
    lane  => 0,
    bank  => '0',
    which => 0
  );

  function next_item (now : item) return item is

    variable result : item;

  begin

    result := now;
    if now.part /= PARTS - 1 then
      result.part := now.part + 1;
      return result;
    end if;
    result.part := 0;
    if now.lane /= LANES - 1 then
      result.lane := now.lane + 1;
      return result;
    end if;
    result.lane := 0;
    result.bank := not now.bank;
    if now.bank = '0' then
      return result;
    end if;
    result.which := 0;
    if now.which /= 2 then
      result.which := now.which + 1;
    end if;
    return result;

  end function next_item;

  -- Returns the place of a lane's word: bank, then lane, in 7 bits.
  function place (of_bank : std_ulogic; lane : u_unsigned(5 downto 0)) return natural is
  begin

    return to_integer(u_unsigned'(of_bank & lane));

  end function place;

  signal steps_low   : low_words  := (others => (others => '0'));
  signal steps_high  : high_words := (others => (others => '0'));
  signal of_lanes    : offsets    := (others => (others => '0'));

  signal now         : item       := FIRST;
  signal low_1       : word                                       := (others => '0');
  signal high_1      : high_word := (others => '0');
  signal offset_1    : offset_of_phase                            := (others => '0');
  signal read_low    : word                                       := (others => '0');
  signal read_high   : high_word := (others => '0');
  signal read_is_high : std_ulogic                                := '0';

  signal copy_left   : natural range 0 to SWEEP_CLOCKS + 4        := 0;
  signal copying     : std_ulogic;
  signal copied      : std_ulogic                                 := '0';
  signal copied_lane : u_unsigned(5 downto 0)                     := (others => '0');
  signal copied_low  : word                                       := (others => '0');
  signal copied_high : high_word := (others => '0');
  signal to_lane     : u_unsigned(5 downto 0);
  signal to_low      : word;
  signal to_high     : high_word;
  signal read_bank   : std_ulogic;
  signal sweep_left  : natural range 0 to 2 * SWEEP_CLOCKS + TAIL_CLOCKS := 0;

begin

  copying   <= '1' when copy_left /= 0 else
               '0';
  copies    <= copying or copied;
  to_lane   <= copied_lane when copied = '1' else
               write_lane;
  to_low    <= copied_low when copied = '1' else
               write_word;
  to_high   <= copied_high when copied = '1' else
               write_word(high_word'range);
  -- Until the copy of the turn steps has ended, `read_word` comes from the active bank, because the idle bank gets the
  -- same words.
  read_bank <= idle_bank xor (copying or copied);
  read_word <= std_ulogic_vector(resize(u_unsigned(read_high), 32)) when read_is_high = '1' else
               read_low;

  remember : process (clock) is
  begin

    if rising_edge(clock) then
      low_1    <= steps_low(place(now.bank, to_unsigned(now.lane, 6)));
      high_1   <= steps_high(place(now.bank, to_unsigned(now.lane, 6)));
      offset_1 <= of_lanes(place(now.bank, to_unsigned(now.lane, 6)));

      read_low     <= steps_low(place(read_bank, read_address(6 downto 1)));
      read_high    <= steps_high(place(read_bank, read_address(6 downto 1)));
      read_is_high <= read_address(0);

      if (copied or write_low) = '1' then
        steps_low(place(idle_bank, to_lane)) <= to_low;
      end if;
      if (copied or write_high) = '1' then
        steps_high(place(idle_bank, to_lane)) <= to_high;
      end if;

      if write_offset = '1' then
        of_lanes(place(idle_bank, write_lane)) <= u_unsigned(write_word(PHASE_WIDTH - 1 downto 0));
      end if;
    end if;

  end process remember;

  multiply : process (clock) is

    -- Registers; the number in a name is the number of clocks from `now` until the register is valid.
    variable item_1_to_4 : items(1 to 4)                              := (others => FIRST);
    variable turn_2      : turn_number                                := (others => '0');
    variable part_2      : u_signed(PHASE_PART_WIDTH downto 0)        := (others => '0');
    variable offset_2    : offset_of_phase                            := (others => '0');
    variable low_turn_3  : u_unsigned(1 downto 0)                     := (others => '0');
    variable product_3   : product                                    := (others => '0');
    variable offset_3    : offset_of_phase                            := (others => '0');
    variable low_turn_4  : u_unsigned(1 downto 0)                     := (others => '0');
    variable sum_4       : product                                    := (others => '0');
    variable middle_4    : u_unsigned(PHASE_PART_WIDTH - LOWEST_BIT downto 0) := (others => '0');
    variable offset_4    : offset_of_phase                            := (others => '0');

    -- The turn m of this sweep and the turns next to it
    variable above       : turn_number                                := (others => '0');
    variable below       : turn_number                                := (others => '0');
    variable middle      : turn_number                                := (others => '0');

    variable fraction    : offset_of_phase;

  begin

    if rising_edge(clock) then
      -- Fifth clock: write to the memory of the phase offsets, which no other entity writes.
      selected <= (others => '0');
      bank     <= item_1_to_4(4).bank;
      of_turn  <= low_turn_4;

      for lane in 0 to LANES - 1 loop
        if item_1_to_4(4).lane = lane then
          slot                   <= to_unsigned(lane / BUILT, 3);
          selected(lane mod BUILT) <= '1' when item_1_to_4(4).part = PARTS - 1 else '0';
        end if;
      end loop;

      fraction := u_unsigned(sum_4(HIGH_WIDTH - 1 downto 0)) & middle_4(middle_4'high downto 1);
      prepared <= std_ulogic_vector(fraction + offset_4 + ("" & middle_4(0)));

      -- Fourth clock. The low 17 bits of a part are final bits of the product; the upper bits are added to the next
      -- part.
      middle_4   := u_unsigned(sum_4(PHASE_PART_WIDTH - 1 downto LOWEST_BIT - 1));
      low_turn_4 := low_turn_3;
      offset_4   := offset_3;
      if item_1_to_4(3).part = 0 then
        sum_4 := product_3;
      else
        sum_4 := product_3 + shift_right(sum_4, PHASE_PART_WIDTH);
      end if;

      -- Third clock: multiply.
      product_3  := turn_2 * part_2;
      low_turn_3 := u_unsigned(turn_2(1 downto 0));
      offset_3   := offset_2;

      -- Second clock: select the part of the turn step and the turn.
      offset_2 := offset_1;

      case item_1_to_4(1).part is

        when 0 =>
          part_2 := '0' & u_signed(low_1(PHASE_PART_WIDTH - 1 downto 0));

        when 1 =>
          part_2 := '0' & u_signed(high_1(2 * PHASE_PART_WIDTH - 33 downto 0)) & u_signed(low_1(31 downto PHASE_PART_WIDTH));

        when others =>
          part_2 := resize('0' & u_signed(high_1(high_1'high downto 2 * PHASE_PART_WIDTH - 32)), part_2'length);

      end case;

      case item_1_to_4(1).which is

        when 0 =>
          turn_2 := middle;

        when 1 =>
          turn_2 := above;

        when others =>
          turn_2 := below;

      end case;

      -- First clock: store the item, and go to the next item.
      item_1_to_4 := now & item_1_to_4(1 to 3);
      now         <= next_item(now);

      -- The turn is held for the whole sweep. Otherwise, if the angle moved back and forth, the sweep could omit one of
      -- the three turns.
      if now = FIRST then
        middle := turn;
        above  := turn + 1;
        below  := turn - 1;
      end if;
    end if;

  end process multiply;

  copy : process (clock) is
  begin

    if rising_edge(clock) then
      -- The words of a lane have been read in the clock of its last part.
      copied      <= copying and (now.bank xor idle_bank) when now.part = PARTS - 1 and now.which = 0 else
                     '0';
      copied_lane <= to_unsigned(now.lane, 6);
      copied_low  <= low_1;
      copied_high <= high_1;

      if copy_left /= 0 then
        copy_left <= copy_left - 1;
      end if;
      if take_over = '1' then
        copy_left <= SWEEP_CLOCKS + 4;
      end if;

      swept <= '1' when sweep_left = 0 else
               '0';
      if sweep_left /= 0 then
        sweep_left <= sweep_left - 1;
      end if;
      if (write_low or write_high or write_offset or copying or copied) = '1' then
        sweep_left <= 2 * SWEEP_CLOCKS + TAIL_CLOCKS;
        swept      <= '0';
      end if;
    end if;

  end process copy;

end architecture rtl;
