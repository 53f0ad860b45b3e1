-- SPDX-License-Identifier: Apache-2.0
--
-- # position_latch
--
-- Latches the corrected position, the angle and the time at each edge of a probe, for example a touch probe or a
-- camera.
--
-- **Latency.** The entity latches position, angle and time DELAY clocks after `strobe`. The core chooses DELAY so that
-- the probe's edge takes as many clocks to the latch as the pins of head 1 (with the mean: of the carrier) take to the
-- corrected position. So the latched values belong to the head's levels at the probe's edge (with FOLD > 1: up to FOLD -
-- 1 clocks before it), if probe and head have the same input filter and the head's levels are not delayed. `latched` is
-- a strobe and comes 1 clock after the latch, together with the new values.
--
-- **Number formats.** position s31.0 counts; angle u24.0 counts; latched_time u64.0 clocks, the time of the latch minus
-- DELAY; count u16.0, the number of edges, wraps.
--
-- **Edges** may come in consecutive clocks; the values of each edge replace those of the previous edge.
--
-- **Reset** drops edges that are still delayed and clears the count.

library ieee;
  use ieee.std_logic_1164.all;
  use ieee.numeric_std.all;

  use work.number_formats_pkg.all;

entity position_latch is
  generic (
    DELAY : positive -- clocks from the strobe to the position that belongs to it
  );
  port (
    clock            : in    std_ulogic;
    reset            : in    std_ulogic;
    strobe           : in    std_ulogic;
    position         : in    u_signed(POSITION_WIDTH - 1 downto 0);                       -- counts
    angle            : in    u_unsigned(ANGLE_WIDTH - 1 downto 0);                        -- counts
    timestamp        : in    u_unsigned(TIMESTAMP_WIDTH - 1 downto 0);                    -- clocks
    latched          : out   std_ulogic                                 := '0';           -- strobe
    latched_position : out   u_signed(POSITION_WIDTH - 1 downto 0)      := (others => '0');
    latched_angle    : out   u_unsigned(ANGLE_WIDTH - 1 downto 0)       := (others => '0');
    latched_time     : out   u_unsigned(TIMESTAMP_WIDTH - 1 downto 0)   := (others => '0');
    count            : out   u_unsigned(15 downto 0)                    := (others => '0')
  );
end entity position_latch;

architecture rtl of position_latch is

begin

  keep : process (clock) is

    variable under_way : std_ulogic_vector(DELAY - 1 downto 0) := (others => '0');

  begin

    if rising_edge(clock) then
      latched <= under_way(DELAY - 1);
      if under_way(DELAY - 1) = '1' then
        latched_position <= position;
        latched_angle    <= angle;
        latched_time     <= timestamp - DELAY;
        count            <= count + 1;
      end if;

      under_way := under_way(DELAY - 2 downto 0) & strobe;

      if reset = '1' then
        under_way := (others => '0');
        latched   <= '0';
        count     <= (others => '0');
      end if;
    end if;

  end process keep;

end architecture rtl;
