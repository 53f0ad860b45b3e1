-- SPDX-License-Identifier: Apache-2.0
--
-- # edge_player
--
-- Plays pin changes from a text file in a simulation, so that Python need not drive a long stimulus. The first line of
-- the file, `0 levels`, has the levels before the first change. A line `clocks levels` follows for each change: the
-- clocks since the previous change (1 or more), and the new levels as one decimal number, pin 0 in bit 0.
-- `sim/arctrue/table/pins.py` writes such files.
--
-- **Latency.** Rising edge 1 is the first one at which `run` is high. A change of clock c appears at the output after
-- rising edge c, so a register samples it at edge c + 1.
--
-- While `run` is low, the player pauses. `finished` rises with the last change.

library ieee;
  use ieee.std_logic_1164.all;
  use ieee.numeric_std.all;

library std;
  use std.textio.all;

entity edge_player is
  generic (
    FILE_NAME : string;        -- path of the text file
    PINS      : positive := 6  -- pins played
  );
  port (
    clock    : in    std_ulogic;
    run      : in    std_ulogic;
    levels   : out   std_ulogic_vector(PINS - 1 downto 0);
    finished : out   std_ulogic
  );
end entity edge_player;

architecture simulation of edge_player is

begin

  play : process is

    file     events      : text;
    variable status      : file_open_status;
    variable row         : line;
    variable clocks_left : integer;
    variable value       : integer;
    variable number      : natural;

    procedure read_event is
      variable good : boolean;
    begin
      readline(events, row);
      number := number + 1;
      read(row, clocks_left, good);
      assert good
        report FILE_NAME & ", line " & integer'image(number) & ": expected two whole numbers"
        severity failure;
      read(row, value, good);
      assert good
        report FILE_NAME & ", line " & integer'image(number) & ": expected two whole numbers"
        severity failure;
      assert value >= 0 and value < 2 ** PINS
        report FILE_NAME & ", line " & integer'image(number) & ": levels " & integer'image(value)
               & " do not fit " & integer'image(PINS) & " pins"
        severity failure;
      assert (number = 1 and clocks_left = 0) or (number > 1 and clocks_left > 0)
        report FILE_NAME & ", line " & integer'image(number) & ": found " & integer'image(clocks_left)
               & " clocks; line 1 has 0 and every other line 1 or more"
        severity failure;
    end procedure read_event;

  begin

    finished <= '0';
    file_open(status, events, FILE_NAME, read_mode);
    assert status = open_ok
      report FILE_NAME & ": cannot be read"
      severity failure;
    assert not endfile(events)
      report FILE_NAME & ": is empty"
      severity failure;
    number := 0;
    read_event;
    levels <= std_ulogic_vector(to_unsigned(value, PINS));

    while not endfile(events) loop

      read_event;

      while clocks_left > 0 loop
        wait until rising_edge(clock);
        if run = '1' then
          clocks_left := clocks_left - 1;
        end if;
      end loop;

      levels <= std_ulogic_vector(to_unsigned(value, PINS));

    end loop;

    file_close(events);
    finished <= '1';
    wait;

  end process play;

end architecture simulation;
