-- SPDX-License-Identifier: Apache-2.0
--
-- # head_watch
--
-- Finds a failed head while the mean uses all heads. A head has failed if its decoder reports a fault, if its edges are
-- missing, or if its reading makes a step that no other head shows.
--
-- **Faults of a decoder.** A head fails in the clock in which its flag `illegal`, `overspeed`, `swallowed` or
-- `index_error` rises or its counter increments; the lowest bit of the counter shows the increment. A counter at its
-- maximum shows no further fault, so clear it in time. Flags that were set before `watching` rose do not count.
--
-- **Missing edges.** A head counts as dead if every other head has moved by `missing_counts` counts or more since this
-- head's last edge; counts up and counts down cancel. No head counts as dead while the table stands still. The value 0
-- turns this check off.
--
-- **Step.** The carrier is the head whose reading enters the pipeline. The entity compares the difference between each
-- reading and the carrier's reading with the value that this difference had 7 to 8 intervals of 2**INTERVAL_BITS clocks
-- earlier (1.15 to 1.31 ms at 100 MHz). Head k has stepped if the changes of all other heads agree within less than
-- `step_limit` counts, and if this is true for no other head in place of k. Choose step_limit larger than the change of
-- any difference of two heads that the motion of the axis causes in that time. Then this motion never makes the entity
-- report a head that has not stepped. The entity finds every step of one head by 2 * step_limit counts or more: the
-- other heads then agree with each other and differ from the stepping head by more than step_limit. If two of four
-- heads step, the entity reports no head. If two of three heads step, it reports the third head if the two steps are
-- equal to within step_limit, otherwise no head. The value 0 turns this check off.
--
-- **Restart.** While `restart` is high, and for 16 clocks after that, the entity does not search for steps; it then
-- stores the readings anew and compares later readings with these. Hold `restart` high while readings jump without a
-- fault, that is after a swap of the words or a move of a zero.
--
-- **Latency.** `failed` follows a decoder's fault by 2 clocks, the last of the counted steps (missing edges) by 3
-- clocks, and a step in `differences` by at most 16 clocks.
--
-- **Number formats.** differences s16.0 counts, head 1 in the low bits; missing_counts u8.0 counts; step_limit u16.0
-- counts. `failed` has one bit per head; `causes` and `causes_wanted` have one bit per cause, from bit 0 on in the
-- order of the register `failover`: illegal, overspeed, swallowed, missing_edges, step, index. `failed` and `causes`
-- are high for one clock; for missing edges they stay high until the head gives an edge or `watching` falls.
--
-- **Reset** clears the readings and the counts.

library ieee;
  use ieee.std_logic_1164.all;
  use ieee.numeric_std.all;

  use work.number_formats_pkg.all;
  use work.tolerance_pkg.all;

entity head_watch is
  generic (
    HEADS         : positive range 3 to HEADS_MAX := 4;
    INTERVAL_BITS : positive range 5 to 20        := WATCH_INTERVAL_BITS -- the readings are stored every 2**INTERVAL_BITS clocks
  );
  port (
    clock          : in    std_ulogic;
    reset          : in    std_ulogic;
    watching       : in    std_ulogic;                                                -- level: all heads are in the mean
    causes_wanted  : in    std_ulogic_vector(5 downto 0);                             -- one bit per cause
    -- From the decoders, one bit per head
    steps          : in    std_ulogic_vector(HEADS - 1 downto 0);                     -- strobe: a count
    steps_up       : in    std_ulogic_vector(HEADS - 1 downto 0);                     -- strobe: upwards
    illegals       : in    std_ulogic_vector(HEADS - 1 downto 0);                     -- sticky
    illegal_counts : in    std_ulogic_vector(HEADS - 1 downto 0);                     -- lowest bit of the counter
    overspeeds     : in    std_ulogic_vector(HEADS - 1 downto 0);                     -- sticky
    overspeed_counts : in    std_ulogic_vector(HEADS - 1 downto 0);                   -- lowest bit of the counter
    swallowed      : in    std_ulogic_vector(HEADS - 1 downto 0);                     -- sticky
    index_errors   : in    std_ulogic_vector(HEADS - 1 downto 0);                     -- sticky
    index_error_counts : in    std_ulogic_vector(HEADS - 1 downto 0);                 -- lowest bit of the counter
    -- From the mean
    differences    : in    std_ulogic_vector(HEADS * (HEAD_DIFFERENCE_WIDTH - HEAD_OFFSET_FRACTION) - 1 downto 0); -- counts, s16.0
    restart        : in    std_ulogic;                                                -- level: readings jump
    -- Settings
    missing_counts : in    u_unsigned(7 downto 0);                                    -- counts, 0: off
    step_limit     : in    u_unsigned(15 downto 0);                                   -- counts, 0: off
    failed         : out   std_ulogic_vector(HEADS - 1 downto 0) := (others => '0');  -- one bit per head, see Number formats
    causes         : out   std_ulogic_vector(5 downto 0)         := (others => '0')   -- one bit per cause, see Number formats
  );
end entity head_watch;

architecture rtl of head_watch is

  constant READING_WIDTH : positive := HEAD_DIFFERENCE_WIDTH - HEAD_OFFSET_FRACTION;
  constant MOVED_WIDTH   : positive := READING_WIDTH + 2;
  constant PAIRS         : positive := HEADS * (HEADS - 1) / 2;

  subtype heads_bits is std_ulogic_vector(HEADS - 1 downto 0);

  subtype moved_count is u_signed(MOVED_WIDTH - 1 downto 0);

  type moved_counts is array (0 to HEADS - 1) of moved_count;

  type stored_readings is array (0 to WATCH_READINGS - 1) of std_ulogic_vector(HEADS * READING_WIDTH - 1 downto 0);

  type pair is record
    first  : natural range 0 to HEADS - 1;
    second : natural range 0 to HEADS - 1;
  end record pair;

  type pairs_of_heads is array (0 to PAIRS - 1) of pair;

  function every_pair return pairs_of_heads is

    variable result : pairs_of_heads;
    variable place  : natural := 0;

  begin

    for first in 0 to HEADS - 2 loop

      for second in first + 1 to HEADS - 1 loop
        result(place) := (first => first, second => second);
        place         := place + 1;
      end loop;

    end loop;

    return result;

  end function every_pair;

  constant PAIR_LIST : pairs_of_heads := every_pair;

  signal dead    : heads_bits := (others => '0');
  signal stepped : heads_bits := (others => '0');
  signal faulty  : heads_bits := (others => '0');
  signal faults  : std_ulogic_vector(5 downto 0) := (others => '0');

begin

  decoders : process (clock) is

    type heads_bits_of_causes is array (0 to 3) of heads_bits;

    -- Flags and lowest bits of their counters, one clock ago
    variable flags_before  : heads_bits_of_causes := (others => (others => '0'));
    variable counts_before : heads_bits_of_causes := (others => (others => '0'));

    variable flags         : heads_bits_of_causes;
    variable counts        : heads_bits_of_causes;
    variable new_faults    : heads_bits_of_causes;

  begin

    if rising_edge(clock) then
      flags  := (illegals, overspeeds, swallowed, index_errors);
      counts := (illegal_counts, overspeed_counts, (others => '0'), index_error_counts);

      for cause in flags'range loop
        new_faults(cause) := flags(cause) and (not flags_before(cause) or (counts(cause) xor counts_before(cause)));
      end loop;

      faulty <= (new_faults(0) and (faulty'range => causes_wanted(0)))
                or (new_faults(1) and (faulty'range => causes_wanted(1)))
                or (new_faults(2) and (faulty'range => causes_wanted(2)))
                or (new_faults(3) and (faulty'range => causes_wanted(5)));
      faults <= ((or new_faults(3)) & "00" & (or new_faults(2)) & (or new_faults(1)) & (or new_faults(0))) and causes_wanted;

      flags_before  := flags;
      counts_before := counts;
      if watching = '0' then
        faulty <= (others => '0');
        faults <= (others => '0');
      end if;
    end if;

  end process decoders;

  missing_edges : process (clock) is

    subtype way is integer range -WATCH_AHEAD_MAX to WATCH_AHEAD_MAX;

    type ways is array (0 to HEADS - 1) of way;

    type ways_of_heads is array (0 to HEADS - 1) of ways;

    -- ahead(i)(j) is the number of counts that head j has moved since the last edge of head i.
    variable ahead   : ways_of_heads := (others => (others => 0));
    variable reached : heads_bits;
    variable one     : integer range -1 to 1;
    variable last    : way;
    -- missing_counts - 1 in a register, so that no subtraction precedes the comparisons
    variable fewer_counts : u_unsigned(missing_counts'range) := (others => '0');

  begin

    if rising_edge(clock) then
      dead <= (others => '0');

      for head in 0 to HEADS - 1 loop
        reached := (others => '0');

        for other in 0 to HEADS - 1 loop
          reached(other) := '1' when other = head else
                            is_beyond(to_signed(ahead(head)(other), missing_counts'length + 1), fewer_counts);
          if steps(head) = '1' or watching = '0' then
            ahead(head)(other) := 0;
          elsif steps(other) = '1' then
            -- One adder counts both up and down.
            one  := 1 when steps_up(other) = '1' else -1;
            last := WATCH_AHEAD_MAX when steps_up(other) = '1' else -WATCH_AHEAD_MAX;
            if ahead(head)(other) /= last then
              ahead(head)(other) := ahead(head)(other) + one;
            end if;
          end if;
        end loop;

        dead(head) <= (and reached) and causes_wanted(3) and watching and (or missing_counts);
      end loop;

      fewer_counts := missing_counts - 1;

      if reset = '1' then
        ahead := (others => (others => 0));
        dead  <= (others => '0');
      end if;
    end if;

  end process missing_edges;

  steps_of_readings : process (clock) is

    variable stored      : stored_readings                    := (others => (others => '0'));
    variable place       : u_unsigned(2 downto 0)             := "000";
    variable is_full     : std_ulogic                         := '0';
    variable is_begun    : std_ulogic                         := '0';
    variable elapsed     : u_unsigned(INTERVAL_BITS - 1 downto 0) := (others => '0');
    variable settling    : natural range 0 to WATCH_SETTLE_CLOCKS := WATCH_SETTLE_CLOCKS;
    -- Comparison: its clock, the changes of the readings, and one bit per head, high if all other heads agree
    variable phase       : natural range 0 to PAIRS + 1       := 0;
    variable moved       : moved_counts                       := (others => (others => '0'));
    variable agree       : heads_bits                         := (others => '0');

    variable oldest_place : u_unsigned(2 downto 0);
    variable oldest      : std_ulogic_vector(differences'range);
    -- step_limit - 1 in a register, so that no subtraction precedes the comparison
    variable below_limit : u_unsigned(step_limit'range) := (others => '0');

    -- The pair of heads of this clock, and the heads that are not in it
    variable first       : moved_count;
    variable second      : moved_count;
    variable left_over   : heads_bits;
    variable is_apart    : std_ulogic;
    variable alone       : heads_bits;

  begin

    if rising_edge(clock) then
      stepped <= (others => '0');
      -- Only one address is read per clock, so that the readings are stored in look-up tables used as memory.
      oldest_place := place when is_full = '1' else "000";
      oldest       := stored(to_integer(oldest_place));

      if phase = 0 then
        agree := (others => '1');

        for head in 0 to HEADS - 1 loop
          moved(head) := resize(u_signed(differences((head + 1) * READING_WIDTH - 1 downto head * READING_WIDTH)), MOVED_WIDTH)
                         - resize(u_signed(oldest((head + 1) * READING_WIDTH - 1 downto head * READING_WIDTH)), MOVED_WIDTH);
        end loop;

        phase := 1 when is_begun = '1' else 0;
      elsif phase <= PAIRS then
        first     := moved(0);
        second    := moved(HEADS - 1);
        left_over := (others => '0');

        for number in PAIR_LIST'range loop
          if phase = number + 1 then
            first  := moved(PAIR_LIST(number).first);
            second := moved(PAIR_LIST(number).second);

            for head in 0 to HEADS - 1 loop
              left_over(head) := '1' when head /= PAIR_LIST(number).first and head /= PAIR_LIST(number).second else '0';
            end loop;

          end if;
        end loop;

        is_apart := is_beyond(first - second, below_limit);
        agree    := agree and not (left_over and (agree'range => is_apart));

        phase := phase + 1;
      else

        -- Head k has stepped if exactly one bit is high, bit k.
        for head in 0 to HEADS - 1 loop
          alone       := (others => '0');
          alone(head) := '1';
          if agree = alone and causes_wanted(4) = '1' and (or step_limit) = '1' then
            stepped(head) <= '1';
          end if;
        end loop;

        phase := 0;
      end if;

      -- Store the readings: at the beginning, then once per interval.
      if settling = 1 or (is_begun = '1' and (and elapsed) = '1') then
        stored(to_integer(place)) := differences;
        is_full  := is_full or (and place);
        place    := place + 1;
        is_begun := '1';
      end if;
      elapsed     := elapsed + 1;
      below_limit := step_limit - 1;

      if settling > 0 then
        settling := settling - 1;
      end if;
      if restart = '1' or watching = '0' or reset = '1' then
        settling := WATCH_SETTLE_CLOCKS;
        place    := "000";
        is_full  := '0';
        is_begun := '0';
        elapsed  := (others => '0');
        phase    := 0;
        stepped  <= (others => '0');
      end if;
    end if;

  end process steps_of_readings;

  report_head : process (clock) is
  begin

    if rising_edge(clock) then
      failed    <= faulty or dead or stepped;
      causes    <= faults;
      causes(3) <= or dead;
      causes(4) <= or stepped;
      if watching = '0' or reset = '1' then
        failed <= (others => '0');
        causes <= (others => '0');
      end if;
    end if;

  end process report_head;

end architecture rtl;
