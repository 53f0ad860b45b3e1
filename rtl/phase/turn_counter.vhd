-- SPDX-License-Identifier: Apache-2.0
--
-- # turn_counter
--
-- Counts the turns of the angle, so that turn number and angle together give the angle over many turns. The entity
-- assumes that the table went from the previous angle to the new angle the shorter way round: a wrap forwards adds a
-- turn, a wrap backwards subtracts one. This rule also applies when the angle jumps because the zero moves or because
-- the mean uses the reading of another head. A change by exactly half a turn counts as no wrap. If no count is lost,
-- the turn number is also correct after a rearm: the rearm sets the angle to 0, the next index sets it to 0 again, and
-- the two shifts cancel.
--
-- **Latency.** `turn_select` holds the two low bits of the turn number of an angle. It is valid one clock after the
-- angle, until one clock after the next angle that is taken. `turn` is valid two clocks after the angle.
--
-- **Number formats.** angle u24.0 counts below counts_per_rev; turn s23.0 turns, wraps modulo 2²⁴.
--
-- **Reset.** The reset sets the turn number to 0. Hold the reset until two angles have been taken. While
-- `counts_per_rev` changes, angles must be below the old and the new value.

library ieee;
  use ieee.std_logic_1164.all;
  use ieee.numeric_std.all;

  use work.number_formats_pkg.all;

entity turn_counter is
  port (
    clock          : in    std_ulogic;
    reset          : in    std_ulogic;
    take           : in    std_ulogic;                                    -- strobe: the angle of this clock is taken
    angle          : in    u_unsigned(ANGLE_WIDTH - 1 downto 0);          -- counts, below counts_per_rev
    counts_per_rev : in    u_unsigned(COUNTS_PER_REV_WIDTH - 1 downto 0); -- counts
    turn_select    : out   u_unsigned(1 downto 0);                        -- turn number modulo 4, one clock after the angle
    turn           : out   u_signed(TURN_NUMBER_WIDTH - 1 downto 0)       -- turns, two clocks after the angle
  );
end entity turn_counter;

architecture rtl of turn_counter is

  subtype limit is u_signed(ANGLE_WIDTH + 1 downto 0);

  signal half    : limit                              := (others => '0');
  -- The next angle has wrapped if it is below `lowest` (forwards) or above `highest` (backwards).
  signal lowest  : limit                              := (others => '0');
  signal highest : limit                              := (others => '0');
  signal up      : std_ulogic                         := '0';
  signal down    : std_ulogic                         := '0';
  signal number  : u_signed(TURN_NUMBER_WIDTH - 1 downto 0) := (others => '0');

begin

  turn        <= number;
  -- The two bits down & (up or down) are 1, 0 or -1.
  turn_select <= u_unsigned(number(1 downto 0)) + u_unsigned'(down & (up or down));

  count : process (clock) is

    variable now : limit;

  begin

    if rising_edge(clock) then
      now  := resize(u_signed('0' & angle), now'length);
      half <= resize(u_signed(shift_right('0' & counts_per_rev, 1)), half'length);

      up   <= '0';
      down <= '0';
      if take = '1' then
        up      <= '1' when now < lowest else '0';
        down    <= '1' when now > highest else '0';
        lowest  <= now - half;
        highest <= now + half;
      end if;

      if up = '1' then
        number <= number + 1;
      elsif down = '1' then
        number <= number - 1;
      end if;

      if reset = '1' then
        up     <= '0';
        down   <= '0';
        number <= (others => '0');
      end if;
    end if;

  end process count;

end architecture rtl;
