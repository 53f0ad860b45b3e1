-- SPDX-License-Identifier: Apache-2.0
--
-- # edge_file_harness
--
-- Connects the outputs of edge_player to edge_recorder, for simulation.

library ieee;
  use ieee.std_logic_1164.all;

entity edge_file_harness is
  generic (
    PLAYED   : string := "played.txt";
    RECORDED : string := "recorded.txt"
  );
  port (
    clock    : in    std_ulogic;
    run      : in    std_ulogic;
    finished : out   std_ulogic
  );
end entity edge_file_harness;

architecture simulation of edge_file_harness is

  signal levels : std_ulogic_vector(5 downto 0);

begin

  player : entity work.edge_player
    generic map (
      FILE_NAME => PLAYED,
      PINS      => 6
    )
    port map (
      clock    => clock,
      run      => run,
      levels   => levels,
      finished => finished
    );

  recorder : entity work.edge_recorder
    generic map (
      FILE_NAME => RECORDED,
      PINS      => 6
    )
    port map (
      clock  => clock,
      run    => run,
      levels => levels
    );

end architecture simulation;
