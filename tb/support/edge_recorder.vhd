-- SPDX-License-Identifier: Apache-2.0
--
-- # edge_recorder
--
-- For simulation: writes the changes of some pins to a text file in the format that `edge_player`
-- plays: a line `0 levels` with the levels when `run` rises, then `clocks levels` for each change.
--
-- **Latency.** Clocks count from the rising edge that sees `run` high for the first time, as in
-- the player: a recorder wired to a player writes the file that is played. A change that leaves
-- a register with rising edge c is written as clock c.
--
-- When `run` falls the file is closed; the recorder does not start again.

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
    -- A value that a register outputs with edge 1 is recorded at edge 2, so edge 1 counts as clock 0.
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
