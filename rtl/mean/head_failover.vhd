-- SPDX-License-Identifier: Apache-2.0
--
-- # head_failover
--
-- Leaves a failed head out of the mean, and includes it again later. The unit head_watch finds the failed head,
-- prepared_sets activates the set of words without this head, and parity_sum monitors the parity of the heads. The
-- entity contains head_watch and parity_sum, and the registers for both and for itself.
--
-- **Failure.** A set contains prepared words of the lanes and of the mean (prepared_sets). When a head fails, the set
-- without this head is loaded, provided that `failover.enable` is set, the active words use all heads and no head is
-- left out. Failures of other heads are then ignored, because only sets with one missing head are prepared. The head is
-- left out from the first angle on to which the new set applies, and `rearm_heads` clears the index in its decoder, so
-- that its next index defines its zero again. If the core refuses the set, the head stays in the mean, and
-- `heads_status.swap_refused` reports this; the set is not loaded at further failures until `failover` is written or a
-- swap takes place. While a set is being loaded, in the clock of a request for a set, and while `failover.enable` is 0,
-- a decoder's fault leaves no head out; the next index of this decoder's head shows the lost counts.
--
-- **Return.** A head that is left out comes back after its next index, either on request (`heads_command.come_back`) or
-- after the time `failover.return_after` unless this is 0; the set of all heads is then loaded. A dead head gives no
-- index, so it remains left out.
--
-- **Processor.** `heads_command.take_set` loads a set. A swap to words that the processor has written sets
-- `heads_status.set` to 7. Such a swap does not bring a left-out head back. The core refuses words that use this head,
-- and a set that uses it before its index. After a refusal the active words stay active and `heads_status.swap_refused`
-- is set, until `clear` or a write of `failover`. If the head comes back while the processor's words are active, it is
-- no longer left out, but no set is loaded: the processor must write words that use the head.
--
-- **Allowed words.** `may_activate` is high while both conditions hold. First, the idle words do not use the barred
-- head: while a set is being loaded, the head that is missing in this set, otherwise the left-out head. Second, while a
-- set is being loaded or a head is left out, the carrier of the idle words (the head whose reading enters the pipeline)
-- is a used head. `may_activate` follows its inputs by one clock.
--
-- **Parity.** `parity_beyond` rises only while the active words use all heads, every head has seen its index and no
-- head is left out. PARITY_CLOCKS clocks must also have passed since the readings settled: until then the parity may
-- still come from the readings before a zero moved or the words were swapped.
--
-- **Latency.** The first angle to which the new set applies comes 2 clocks plus the latency of prepared_sets (`load` to
-- `swap_out`) after head_watch has reported a failure, or later if the swap has to wait. `read_data` follows
-- `read_enable` by 1 clock and is 0 for words of other units in the window. head_registers signals `done` for its own
-- words and for the words of this entity.
--
-- **Number formats.** differences s16.4 counts, head 1 in the low bits; the register map states the formats of the
-- registers.
--
-- **Reset.** `heads_status.set` is 7 (no prepared set), no head is left out, and every setting is 0.

library ieee;
  use ieee.std_logic_1164.all;
  use ieee.numeric_std.all;

  use work.number_formats_pkg.all;

entity head_failover is
  generic (
    LANES         : positive range 1 to LANES_MAX := LANES_DEFAULT;
    HEADS         : positive range 3 to HEADS_MAX := 4;
    INTERVAL_BITS : positive range 5 to 20        := WATCH_INTERVAL_BITS -- as in head_watch; return_after: 2**(INTERVAL_BITS + 3) clocks
  );
  port (
    clock            : in    std_ulogic;
    reset            : in    std_ulogic;
    -- Registers of the window of the heads
    read_enable      : in    std_ulogic;                                                -- pulse
    write_enable     : in    std_ulogic;                                                -- pulse
    address          : in    u_unsigned(5 downto 0);                                    -- number of the word in the window
    write_data       : in    std_ulogic_vector(31 downto 0);                            -- the word
    read_data        : out   std_ulogic_vector(31 downto 0) := (others => '0');         -- the word
    take_snapshot    : in    std_ulogic;                                                -- pulse
    clear            : in    std_ulogic;                                                -- pulse: clears the sticky flags
    -- From the decoders, one bit per head, see head_watch
    steps            : in    std_ulogic_vector(HEADS - 1 downto 0);                     -- strobe
    steps_up         : in    std_ulogic_vector(HEADS - 1 downto 0);                     -- strobe
    illegals         : in    std_ulogic_vector(HEADS - 1 downto 0);                     -- sticky
    illegal_counts   : in    std_ulogic_vector(HEADS - 1 downto 0);                     -- lowest bit
    overspeeds       : in    std_ulogic_vector(HEADS - 1 downto 0);                     -- sticky
    overspeed_counts : in    std_ulogic_vector(HEADS - 1 downto 0);                     -- lowest bit
    swallowed        : in    std_ulogic_vector(HEADS - 1 downto 0);                     -- sticky
    index_errors     : in    std_ulogic_vector(HEADS - 1 downto 0);                     -- sticky
    index_error_counts : in    std_ulogic_vector(HEADS - 1 downto 0);                   -- lowest bit
    indices_seen     : in    std_ulogic_vector(HEADS - 1 downto 0);                     -- level
    -- From the mean
    used             : in    std_ulogic_vector(HEADS - 1 downto 0);                     -- level
    idle_used        : in    std_ulogic_vector(HEADS - 1 downto 0);                     -- level: used by the idle words
    idle_carrier_used : in    std_ulogic;                                               -- level: the idle words' carrier is a used head
    differences      : in    std_ulogic_vector(HEADS * HEAD_DIFFERENCE_WIDTH - 1 downto 0); -- counts, s16.4
    is_settled       : in    std_ulogic;                                                -- level: no reading jumps (may_swap of head_mean)
    -- The banks
    swap_comes       : in    std_ulogic;                                                -- pulse
    busy             : in    std_ulogic;                                                -- level: a set is being loaded
    loaded           : in    std_ulogic;                                                -- pulse
    refused          : in    std_ulogic;                                                -- pulse: a swap did not take place
    may_activate     : out   std_ulogic                     := '0';                     -- level: the idle words may be swapped
    load             : out   std_ulogic                     := '0';                     -- pulse
    number           : out   u_unsigned(2 downto 0)         := "000";                   -- number of the set
    -- Results
    rearm_heads      : out   std_ulogic_vector(HEADS - 1 downto 0);                     -- level
    left_out         : out   std_ulogic_vector(HEADS - 1 downto 0) := (others => '0');  -- level
    parity_beyond    : out   std_ulogic                     := '0';                     -- sticky
    changed          : out   std_ulogic                     := '0'                      -- pulse: a set was loaded, or a head came back
  );
end entity head_failover;

architecture rtl of head_failover is

  constant COMMAND_WORD      : natural  := 33;
  constant STATUS_WORD       : natural  := 34;
  constant FAILOVER_WORD     : natural  := 35;
  constant MISSING_WORD      : natural  := 36;
  constant PARITY_WORD       : natural  := 40;
  constant VALUE_WORD        : natural  := 44;
  constant STEP_LIMIT_WORD   : natural  := 45;
  constant PARITY_LIMIT_WORD : natural  := 46;
  -- `beyond` may come from readings of up to 20 clocks ago: 5 clocks of the differences, up to 7 clocks until
  -- parity_sum takes the next differences, and 8 clocks until the next parity. `is_settled` rises 9 clocks after a
  -- jump.
  constant PARITY_CLOCKS     : positive := 16;
  constant WHOLE_WIDTH       : positive := HEAD_DIFFERENCE_WIDTH - HEAD_OFFSET_FRACTION;

  subtype heads_bits is std_ulogic_vector(HEADS - 1 downto 0);

  -- Returns whether the set `set` uses a head whose bit in `chosen` is high.
  function uses_one (
    set    : u_unsigned(2 downto 0);
    chosen : heads_bits
  ) return boolean is

    variable present : heads_bits;

  begin

    present := chosen;

    for head in 0 to HEADS - 1 loop
      if set = head + 1 then
        present(head) := '0';
      end if;
    end loop;

    return (or present) = '1';

  end function uses_one;

  signal enabled        : std_ulogic                                                := '0';
  signal causes_wanted  : std_ulogic_vector(5 downto 0)                             := (others => '0');
  signal return_after   : u_unsigned(15 downto 0)                                   := (others => '0');
  signal missing_counts : u_unsigned(7 downto 0)                                    := (others => '0');
  signal step_limit     : u_unsigned(15 downto 0)                                   := (others => '0');
  signal parity_limit   : u_unsigned(15 downto 0)                                   := (others => '0');
  signal weights        : std_ulogic_vector(HEADS * HEAD_WEIGHT_WIDTH - 1 downto 0) := (others => '0');
  signal parity         : u_signed(CORRECTION_WIDTH - 1 downto 0);
  signal latched        : u_signed(CORRECTION_WIDTH - 1 downto 0)                   := (others => '0');
  signal beyond         : std_ulogic;

  signal wholes         : std_ulogic_vector(HEADS * WHOLE_WIDTH - 1 downto 0);
  signal watching       : std_ulogic                     := '0';
  signal restart        : std_ulogic                     := '1';
  signal failed         : heads_bits;
  signal causes         : std_ulogic_vector(5 downto 0);
  signal last_causes    : std_ulogic_vector(5 downto 0)  := (others => '0');
  signal set_in_force   : u_unsigned(2 downto 0)         := to_unsigned(OWN_WORDS_SET, 3);
  signal wants_set      : std_ulogic                     := '0';
  signal wanted_set     : u_unsigned(2 downto 0)         := "000";
  signal wants_return   : heads_bits                     := (others => '0');
  signal waited         : u_unsigned(15 downto 0)        := (others => '0');
  signal tick           : u_unsigned(INTERVAL_BITS + 2 downto 0) := (others => '0');
  signal rearming       : natural range 0 to FAILOVER_REARM_CLOCKS := 0;
  signal swap_refused   : std_ulogic                     := '0';
  signal set_refused    : std_ulogic                     := '0';
  -- Heads whose set was refused
  signal has_no_set     : heads_bits                     := (others => '0');
  signal parity_waits   : natural range 0 to PARITY_CLOCKS := PARITY_CLOCKS;

begin

  whole_counts : for head in 0 to HEADS - 1 generate

    wholes((head + 1) * WHOLE_WIDTH - 1 downto head * WHOLE_WIDTH)
    <= differences((head + 1) * HEAD_DIFFERENCE_WIDTH - 1 downto head * HEAD_DIFFERENCE_WIDTH + HEAD_OFFSET_FRACTION);

  end generate whole_counts;

  watch : entity work.head_watch
    generic map (
      HEADS         => HEADS,
      INTERVAL_BITS => INTERVAL_BITS
    )
    port map (
      clock              => clock,
      reset              => reset,
      watching           => watching,
      causes_wanted      => causes_wanted,
      steps              => steps,
      steps_up           => steps_up,
      illegals           => illegals,
      illegal_counts     => illegal_counts,
      overspeeds         => overspeeds,
      overspeed_counts   => overspeed_counts,
      swallowed          => swallowed,
      index_errors       => index_errors,
      index_error_counts => index_error_counts,
      differences        => wholes,
      restart            => restart,
      missing_counts     => missing_counts,
      step_limit         => step_limit,
      failed             => failed,
      causes             => causes
    );

  sum : entity work.parity_sum
    generic map (
      HEADS => HEADS
    )
    port map (
      clock       => clock,
      differences => differences,
      weights     => weights,
      limit       => parity_limit,
      parity      => parity,
      beyond      => beyond
    );

  rearm_heads <= left_out when rearming > 0 else
                 (others => '0');

  decide : process (clock) is

    variable may_return : std_ulogic;
    variable has_index  : std_ulogic;
    variable barred     : heads_bits;
    variable asked      : heads_bits;
    variable leaving    : heads_bits;

  begin

    if rising_edge(clock) then
      load        <= '0';
      changed     <= '0';
      set_refused <= '0';
      watching    <= enabled and (and used) and not (or left_out) and not busy and not load and not wants_set;
      restart     <= not is_settled or not (and indices_seen);
      tick        <= tick + 1;

      barred := left_out;
      if busy = '1' then

        for head in 0 to HEADS - 1 loop
          barred(head) := '1' when number = head + 1 else '0';
        end loop;

      end if;
      may_activate <= not (or (idle_used and barred)) and (idle_carrier_used or not (busy or (or left_out)));

      if rearming > 0 then
        rearming <= rearming - 1;
      end if;
      if (and tick) = '1' and (and waited) = '0' then
        waited <= waited + 1;
      end if;

      has_index  := '1' when rearming = 0 and (indices_seen and left_out) = left_out else '0';
      asked      := wants_return;
      may_return := '1' when (or left_out) = '1' and has_index = '1'
                             and ((or (wants_return and left_out)) = '1' or ((or return_after) = '1' and waited >= return_after)) else
                    '0';

      leaving := failed and not has_no_set;
      if busy = '0' and load = '0' then
        if wants_set = '1' then
          wants_set <= '0';
          if uses_one(wanted_set, left_out) and has_index = '0' then
            set_refused <= '1';
          else
            load   <= '1';
            number <= wanted_set;
          end if;
        elsif (or leaving) = '1' and watching = '1' then
          load        <= '1';
          last_causes <= causes;

          for head in HEADS - 1 downto 0 loop
            if leaving(head) = '1' then
              number <= to_unsigned(head + 1, 3);
            end if;
          end loop;

        elsif may_return = '1' and set_in_force /= OWN_WORDS_SET then
          load   <= '1';
          number <= "000";
        elsif may_return = '1' then
          left_out <= (others => '0');
          asked    := (others => '0');
          changed  <= '1';
        end if;
      end if;

      if loaded = '1' then
        set_in_force <= number;
        changed      <= '1';
        waited       <= (others => '0');
        tick         <= (others => '0');
        asked        := (others => '0');
        rearming     <= FAILOVER_REARM_CLOCKS;

        for head in 0 to HEADS - 1 loop
          left_out(head) <= '1' when number = head + 1 else '0';
        end loop;

      elsif swap_comes = '1' then
        set_in_force <= to_unsigned(OWN_WORDS_SET, 3);
      end if;

      for head in 0 to HEADS - 1 loop
        if refused = '1' and busy = '1' and number = head + 1 then
          has_no_set(head) <= '1';
        end if;
      end loop;

      if swap_comes = '1' or (write_enable = '1' and address = FAILOVER_WORD) then
        has_no_set <= (others => '0');
      end if;

      if write_enable = '1' and address = COMMAND_WORD then
        asked := asked or write_data(HEADS + 7 downto 8);
        if write_data(7) = '1' and u_unsigned(write_data(6 downto 4)) <= HEADS then
          wants_set  <= '1';
          wanted_set <= u_unsigned(write_data(6 downto 4));
        end if;
      end if;

      wants_return <= asked;

      if reset = '1' then
        load         <= '0';
        set_refused  <= '0';
        may_activate <= '0';
        watching     <= '0';
        restart      <= '1';
        changed      <= '0';
        set_in_force <= to_unsigned(OWN_WORDS_SET, 3);
        left_out     <= (others => '0');
        has_no_set   <= (others => '0');
        last_causes  <= (others => '0');
        wants_set    <= '0';
        wants_return <= (others => '0');
        waited       <= (others => '0');
        rearming     <= 0;
      end if;
    end if;

  end process decide;

  registers : process (clock) is

    variable chosen : std_ulogic_vector(31 downto 0);

  begin

    if rising_edge(clock) then
      chosen := (others => '0');
      if address = STATUS_WORD then
        chosen(HEADS - 1 downto 0) := left_out;
        chosen(6 downto 4)         := std_ulogic_vector(set_in_force);
        chosen(13)                 := busy;
        chosen(14)                 := parity_beyond;
        chosen(15)                 := swap_refused;
        chosen(21 downto 16)       := last_causes;
      elsif address = FAILOVER_WORD then
        chosen := std_ulogic_vector(return_after) & "000000" & causes_wanted & "000" & enabled;
      elsif address = MISSING_WORD then
        chosen(7 downto 0) := std_ulogic_vector(missing_counts);
      elsif address = VALUE_WORD then
        chosen := std_ulogic_vector(resize(latched, 32));
      elsif address = STEP_LIMIT_WORD then
        chosen(15 downto 0) := std_ulogic_vector(step_limit);
      elsif address = PARITY_LIMIT_WORD then
        chosen(15 downto 0) := std_ulogic_vector(parity_limit);
      end if;

      for head in 0 to HEADS - 1 loop
        if address = PARITY_WORD + head then
          chosen := std_ulogic_vector(resize(u_signed(
            weights((head + 1) * HEAD_WEIGHT_WIDTH - 1 downto head * HEAD_WEIGHT_WIDTH)
          ), 32));
          if write_enable = '1' then
            weights((head + 1) * HEAD_WEIGHT_WIDTH - 1 downto head * HEAD_WEIGHT_WIDTH) <= write_data(HEAD_WEIGHT_WIDTH - 1 downto 0);
          end if;
        end if;
      end loop;

      read_data <= chosen and (31 downto 0 => read_enable);

      parity_beyond <= parity_beyond and not clear;
      if is_settled = '0' or (and used) = '0' or (and indices_seen) = '0' or (or left_out) = '1' then
        parity_waits <= PARITY_CLOCKS;
      elsif parity_waits > 0 then
        parity_waits <= parity_waits - 1;
      elsif beyond = '1' then
        parity_beyond <= '1';
      end if;
      swap_refused <= (swap_refused and not clear) or refused or set_refused;
      if take_snapshot = '1' then
        latched <= parity;
      end if;

      if write_enable = '1' and address = FAILOVER_WORD then
        swap_refused  <= refused or set_refused;
        enabled       <= write_data(0);
        causes_wanted <= write_data(9 downto 4);
        return_after  <= u_unsigned(write_data(31 downto 16));
      elsif write_enable = '1' and address = MISSING_WORD then
        missing_counts <= u_unsigned(write_data(7 downto 0));
      elsif write_enable = '1' and address = STEP_LIMIT_WORD then
        step_limit <= u_unsigned(write_data(15 downto 0));
      elsif write_enable = '1' and address = PARITY_LIMIT_WORD then
        parity_limit <= u_unsigned(write_data(15 downto 0));
      end if;

      if reset = '1' then
        enabled        <= '0';
        causes_wanted  <= (others => '0');
        return_after   <= (others => '0');
        missing_counts <= (others => '0');
        step_limit     <= (others => '0');
        parity_limit   <= (others => '0');
        weights        <= (others => '0');
        parity_beyond  <= '0';
        parity_waits   <= PARITY_CLOCKS;
        swap_refused   <= '0';
      end if;
    end if;

  end process registers;

end architecture rtl;
