-- SPDX-License-Identifier: Apache-2.0
--
-- # demo_harness
--
-- Connects the core to a player of recorded encoder edges and to a recorder of its output, for simulation. The test
-- bench drives the AXI4-Lite bus and reads the interrupt, in place of the processor.

library ieee;
  use ieee.std_logic_1164.all;

  use work.axi_lite_pkg.all;
  use work.number_formats_pkg.all;

entity demo_harness is
  generic (
    LANES         : positive := 4;
    CAPTURE_DEPTH : positive := CAPTURE_DEPTH_DEFAULT;
    PLAYED        : string   := "played.txt";
    RECORDED      : string   := "recorded.txt"
  );
  port (
    reset           : in    std_ulogic;
    run             : in    std_ulogic;
    clock           : out   std_ulogic := '0';
    played_out      : out   std_ulogic;
    s_axil_request  : in    axi_lite_request;
    s_axil_response : out   axi_lite_response;
    interrupt       : out   std_ulogic
  );
end entity demo_harness;

architecture simulation of demo_harness is

  signal head_pins : std_ulogic_vector(5 downto 0);
  signal out_pins  : std_ulogic_vector(2 downto 0);

begin

  -- The clock of 100 MHz is generated here, so that Python does not run at every edge.
  clock <= not clock after 5 ns;

  player : entity work.edge_player
    generic map (
      FILE_NAME => PLAYED,
      PINS      => 6
    )
    port map (
      clock    => clock,
      run      => run,
      levels   => head_pins,
      finished => played_out
    );

  core : entity work.arctrue_core
    generic map (
      LANES         => LANES,
      CAPTURE_DEPTH => CAPTURE_DEPTH
    )
    port map (
      clock           => clock,
      reset           => reset,
      s_axil_request  => s_axil_request,
      s_axil_response => s_axil_response,
      interrupt       => interrupt,
      head1_a         => head_pins(0),
      head1_b         => head_pins(1),
      head1_z         => head_pins(2),
      head2_a         => head_pins(3),
      head2_b         => head_pins(4),
      head2_z         => head_pins(5),
      out_a           => out_pins(0),
      out_b           => out_pins(1),
      out_z           => out_pins(2)
    );

  recorder : entity work.edge_recorder
    generic map (
      FILE_NAME => RECORDED,
      PINS      => 3
    )
    port map (
      clock  => clock,
      run    => run,
      levels => out_pins
    );

end architecture simulation;
