-- SPDX-License-Identifier: Apache-2.0
--
-- # heads_harness
--
-- Plays the edges of both heads from a file into two decoders, one per head, for simulation.

library ieee;
  use ieee.std_logic_1164.all;
  use ieee.numeric_std.all;

  use work.decoder_pkg.all;
  use work.number_formats_pkg.all;

entity heads_harness is
  generic (
    PLAYED         : string   := "played.txt";
    COUNTS_PER_REV : positive := 4096
  );
  port (
    clock               : in    std_ulogic;
    reset               : in    std_ulogic;
    run                 : in    std_ulogic;
    played_out          : out   std_ulogic;
    head1_turn_position : out   u_signed(POSITION_WIDTH - 1 downto 0);
    head2_turn_position : out   u_signed(POSITION_WIDTH - 1 downto 0);
    head1_angle         : out   u_unsigned(ANGLE_WIDTH - 1 downto 0);
    head2_angle         : out   u_unsigned(ANGLE_WIDTH - 1 downto 0);
    index_seen          : out   std_ulogic_vector(1 downto 0);
    faults              : out   std_ulogic_vector(3 downto 0)
  );
end entity heads_harness;

architecture simulation of heads_harness is

  type head_pair is array (1 to 2) of decoded_head;

  signal pins  : std_ulogic_vector(5 downto 0);
  signal heads : head_pair;

begin

  head1_turn_position <= heads(1).turn_position;
  head2_turn_position <= heads(2).turn_position;
  head1_angle         <= heads(1).angle;
  head2_angle         <= heads(2).angle;
  index_seen          <= heads(2).index_seen & heads(1).index_seen;
  faults              <= heads(2).illegal & heads(2).index_error & heads(1).illegal & heads(1).index_error;

  player : entity work.edge_player
    generic map (
      FILE_NAME => PLAYED,
      PINS      => 6
    )
    port map (
      clock    => clock,
      run      => run,
      levels   => pins,
      finished => played_out
    );

  head1 : entity work.quadrature_decoder
    port map (
      clock                => clock,
      reset                => reset,
      a                    => pins(0),
      b                    => pins(1),
      z                    => pins(2),
      counts_per_rev       => to_unsigned(COUNTS_PER_REV, COUNTS_PER_REV_WIDTH),
      filter_length        => to_unsigned(1, 8),
      minimum_edge_spacing => to_unsigned(0, 16),
      timestamp            => (others => '0'),
      clear                => '0',
      rearm                => '0',
      decoded              => heads(1)
    );

  head2 : entity work.quadrature_decoder
    port map (
      clock                => clock,
      reset                => reset,
      a                    => pins(3),
      b                    => pins(4),
      z                    => pins(5),
      counts_per_rev       => to_unsigned(COUNTS_PER_REV, COUNTS_PER_REV_WIDTH),
      filter_length        => to_unsigned(1, 8),
      minimum_edge_spacing => to_unsigned(0, 16),
      timestamp            => (others => '0'),
      clear                => '0',
      rearm                => '0',
      decoded              => heads(2)
    );

end architecture simulation;
