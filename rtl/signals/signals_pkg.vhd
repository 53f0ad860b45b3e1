-- SPDX-License-Identifier: Apache-2.0
--
-- # signals_pkg
--
-- Declares the records of instrument_signals: the last edge of the probe, and the oldest event of the queue.

library ieee;
  use ieee.std_logic_1164.all;
  use ieee.numeric_std.all;

  use work.number_formats_pkg.all;

package signals_pkg is

  -- The last edge of the probe, see position_latch.
  type probe_edge is record
    position : u_signed(POSITION_WIDTH - 1 downto 0);    -- counts, corrected
    angle    : u_unsigned(ANGLE_WIDTH - 1 downto 0);     -- counts, corrected
    time     : u_unsigned(TIMESTAMP_WIDTH - 1 downto 0); -- clocks
    number   : u_unsigned(15 downto 0);                  -- number of edges; wraps
  end record probe_edge;

  -- The oldest event of the queue, and the state of the queue, see event_queue.
  type queued_event is record
    kind     : std_ulogic_vector(1 downto 0);            -- kinds of the event; 0: the queue is empty
    number   : u_unsigned(15 downto 0);                  -- number of the event; wraps
    time     : u_unsigned(TIMESTAMP_WIDTH - 1 downto 0); -- clocks
    position : u_signed(POSITION_WIDTH - 1 downto 0);    -- counts, corrected
    angle    : u_unsigned(ANGLE_WIDTH - 1 downto 0);     -- counts, corrected
    waiting  : u_unsigned(6 downto 0);                   -- number of events in the queue
    lost     : u_unsigned(15 downto 0);                  -- number of events that the queue did not take; wraps
  end record queued_event;

end package signals_pkg;
