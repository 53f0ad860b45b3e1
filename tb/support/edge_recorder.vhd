-- SPDX-License-Identifier: Apache-2.0
--
-- # edge_recorder
--
-- Writes the changes of its inputs in a simulation to a text file, in the format that `edge_player` plays: a line `0
-- levels` with the levels when `run` rises, then a line `clocks levels` for each change.
--
-- **Latency.** As in the player, rising edge 1 is the first one at which `run` is high. A change that a register
-- outputs after rising edge c is written as clock c. So a recorder that is connected to a player writes the file that
-- the player plays.
--
-- When `run` falls, the recorder closes the file and does not start again.

library ieee;
  use ieee.std_logic_1164.all;
  use ieee.numeric_std.all;

library std;
  use std.textio.all;

entity edge_recorder is
  generic (
    FILE_NAME : string;        -- path of the text file
    PINS      : positive := 3  -- pins recorded
  );
  port (
    clock  : in    std_ulogic;
    run    : in    std_ulogic;
    levels : in    std_ulogic_vector(PINS - 1 downto 0)
  );
end entity edge_recorder;

architecture simulation of edge_recorder is

begin

  write_changes : process is

    file     events   : text;
    variable status   : file_open_status;
    variable row      : line;
    variable previous : std_ulogic_vector(PINS - 1 downto 0);
    variable clocks   : natural;

    procedure write_event (clocks_since : natural) is
    begin
      assert not is_x(levels)
        report FILE_NAME & ": a recorded pin is neither '0' nor '1'"
        severity failure;
      write(row, clocks_since);
      write(row, string'(" "));
      write(row, to_integer(unsigned(levels)));
      writeline(events, row);
    end procedure write_event;

  begin

    wait until rising_edge(clock) and run = '1';
    file_open(status, events, FILE_NAME, write_mode);
    assert status = open_ok
      report FILE_NAME & ": cannot be written"
      severity failure;
    -- A value that a register outputs after edge 1 is sampled at edge 2, so edge 1 counts as clock 0.
    write_event(0);
    previous := levels;
    clocks   := 0;

    loop

      wait until rising_edge(clock);
      exit when run /= '1';
      clocks := clocks + 1;
      if levels /= previous then
        write_event(clocks);
        previous := levels;
        clocks   := 0;
      end if;

    end loop;

    file_close(events);
    wait;

  end process write_changes;

end architecture simulation;
