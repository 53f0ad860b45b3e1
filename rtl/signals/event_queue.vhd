-- SPDX-License-Identifier: Apache-2.0
--
-- # event_queue
--
-- Stores events, that is edges of a probe and pulses of position_compare, each with its time, corrected position, angle
-- and number, until the processor takes them. The entity position_latch keeps only the last edge; the queue keeps
-- 2**DEPTH_LOG2 events, so that edges may come in bursts that are faster than the processor.
--
-- **Latency.** An event enters the queue in the clock in which the ports `position` and `angle` belong to it: DELAY
-- clocks after `probe`, COMPARE_DELAY clocks after `compare`. If the queue was empty, the outputs show the event 2
-- clocks later. `take` (pulse) removes the oldest event; the outputs show the next event 2 clocks later. `take` of an
-- empty queue does nothing.
--
-- **Number formats.** position s31.0 counts; angle u24.0 counts; event_time u64.0 clocks: for both kinds of events it
-- is `timestamp` in the clock in which the event enters the queue, minus DELAY (not COMPARE_DELAY); number and lost
-- u16.0, both wrap.
--
-- **Events.** Bit 0 of `kind` is high for an edge of the probe, bit 1 for a pulse of position_compare. If an edge and a
-- pulse enter the queue in the same clock, they have the same position and form one event with both bits high. If
-- `kind` is 0, the queue is empty, and the other outputs of the oldest event have no meaning. `recorded` selects the
-- kinds of events that enter the queue. Each event increases the number by 1. If the queue is full, a new event is
-- lost: it increases the number too, and `lost` counts it. So a gap in the numbers shows where events are missing.
--
-- **Reset** empties the queue and clears the event number and `lost`. It must last at least DELAY and at least
-- COMPARE_DELAY clocks to drop events that are still delayed.

library ieee;
  use ieee.std_logic_1164.all;
  use ieee.numeric_std.all;

  use work.number_formats_pkg.all;

entity event_queue is
  generic (
    DELAY         : positive;                     -- clocks from `probe` to the position that belongs to it
    COMPARE_DELAY : positive;                     -- clocks from `compare` to the position that belongs to it
    DEPTH_LOG2    : positive range 1 to 6 := 6    -- log2 of the number of events that can wait
  );
  port (
    clock         : in    std_ulogic;
    reset         : in    std_ulogic;
    probe         : in    std_ulogic;                                                   -- strobe
    compare       : in    std_ulogic;                                                   -- strobe
    recorded      : in    std_ulogic_vector(1 downto 0);                                -- one bit per kind
    position      : in    u_signed(POSITION_WIDTH - 1 downto 0);                        -- counts
    angle         : in    u_unsigned(ANGLE_WIDTH - 1 downto 0);                         -- counts
    timestamp     : in    u_unsigned(TIMESTAMP_WIDTH - 1 downto 0);                     -- clocks
    take          : in    std_ulogic;                                                   -- pulse
    kind          : out   std_ulogic_vector(1 downto 0)                 := "00";        -- kinds of the oldest event
    number        : out   u_unsigned(15 downto 0)                       := (others => '0');
    event_time    : out   u_unsigned(TIMESTAMP_WIDTH - 1 downto 0)      := (others => '0');
    event_position : out   u_signed(POSITION_WIDTH - 1 downto 0)         := (others => '0');
    event_angle   : out   u_unsigned(ANGLE_WIDTH - 1 downto 0)          := (others => '0');
    waiting       : out   u_unsigned(DEPTH_LOG2 downto 0);                              -- number of events
    lost          : out   u_unsigned(15 downto 0)                       := (others => '0')
  );
end entity event_queue;

architecture rtl of event_queue is

  subtype event_word is std_ulogic_vector(2 + 16 + TIMESTAMP_WIDTH + POSITION_WIDTH + ANGLE_WIDTH - 1 downto 0);

  type event_words is array (0 to 2 ** DEPTH_LOG2 - 1) of event_word;

  signal words       : event_words                         := (others => (others => '0'));
  signal write_place : u_unsigned(DEPTH_LOG2 - 1 downto 0) := (others => '0');
  signal read_place  : u_unsigned(DEPTH_LOG2 - 1 downto 0) := (others => '0');
  signal fill        : u_unsigned(DEPTH_LOG2 downto 0)     := (others => '0');
  signal events      : u_unsigned(15 downto 0)             := (others => '0');
  signal kinds       : std_ulogic_vector(1 downto 0);
  signal is_full     : std_ulogic;
  signal enters      : std_ulogic;
  signal leaves      : std_ulogic;

  -- The strobes of the last clocks. They have no reset, so that each is a shift register in one or two look-up tables.
  signal probes      : std_ulogic_vector(DELAY - 1 downto 0)         := (others => '0');
  signal compares    : std_ulogic_vector(COMPARE_DELAY - 1 downto 0) := (others => '0');

begin

  kinds   <= (compares(COMPARE_DELAY - 1) & probes(DELAY - 1)) and recorded;
  is_full <= fill(DEPTH_LOG2);
  enters  <= (or kinds) and not is_full and not reset;
  leaves  <= take and (or fill);
  waiting <= fill;

  hold : process (clock) is
  begin

    if rising_edge(clock) then
      probes   <= probes(DELAY - 2 downto 0) & probe;
      compares <= compares(COMPARE_DELAY - 2 downto 0) & compare;

      if enters = '1' then
        words(to_integer(write_place)) <= kinds & std_ulogic_vector(events) & std_ulogic_vector(timestamp - DELAY)
                                          & std_ulogic_vector(position) & std_ulogic_vector(angle);
      end if;

      write_place <= write_place + ("" & enters);
      read_place  <= read_place + ("" & leaves);
      fill        <= fill + ("" & enters) - ("" & leaves);
      events      <= events + ("" & (or kinds));
      lost        <= lost + ("" & ((or kinds) and is_full));

      if reset = '1' then
        write_place <= (others => '0');
        read_place  <= (others => '0');
        fill        <= (others => '0');
        events      <= (others => '0');
        lost        <= (others => '0');
      end if;
    end if;

  end process hold;

  show : process (clock) is

    variable oldest : event_word;

  begin

    if rising_edge(clock) then
      oldest         := words(to_integer(read_place));
      event_angle    <= u_unsigned(oldest(ANGLE_WIDTH - 1 downto 0));
      event_position <= u_signed(oldest(POSITION_WIDTH + ANGLE_WIDTH - 1 downto ANGLE_WIDTH));
      event_time     <= u_unsigned(oldest(event_word'high - 18 downto POSITION_WIDTH + ANGLE_WIDTH));
      number         <= u_unsigned(oldest(event_word'high - 2 downto event_word'high - 17));
      kind           <= oldest(event_word'high downto event_word'high - 1) and (or fill);
      if reset = '1' then
        kind <= "00";
      end if;
    end if;

  end process show;

end architecture rtl;
