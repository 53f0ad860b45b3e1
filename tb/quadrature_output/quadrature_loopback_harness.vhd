-- SPDX-License-Identifier: Apache-2.0
--
-- Connects the outputs of quadrature_output to the inputs of a quadrature_decoder, for simulation.

library ieee;
  use ieee.std_logic_1164.all;
  use ieee.numeric_std.all;

  use work.decoder_pkg.all;
  use work.number_formats_pkg.all;

entity quadrature_loopback_harness is
  port (
    clock              : in    std_ulogic;
    reset              : in    std_ulogic;
    enable             : in    std_ulogic;
    corrected_position : in    u_signed(POSITION_WIDTH - 1 downto 0);
    corrected_angle    : in    u_unsigned(ANGLE_WIDTH - 1 downto 0);
    counts_per_rev     : in    u_unsigned(COUNTS_PER_REV_WIDTH - 1 downto 0);
    minimum_spacing    : in    u_unsigned(15 downto 0);
    filter_length      : in    u_unsigned(7 downto 0);
    phase_of_zero      : in    u_unsigned(1 downto 0);
    position           : out   u_signed(POSITION_WIDTH - 1 downto 0);
    angle              : out   u_unsigned(ANGLE_WIDTH - 1 downto 0);
    index_seen         : out   std_ulogic;
    index_strobe       : out   std_ulogic;
    index_error        : out   std_ulogic;
    illegal            : out   std_ulogic;
    overspeed          : out   std_ulogic;
    cannot_keep_up     : out   std_ulogic
  );
end entity quadrature_loopback_harness;

architecture bench of quadrature_loopback_harness is

  signal a : std_ulogic;
  signal b : std_ulogic;
  signal z : std_ulogic;

  signal received : decoded_head;

begin

  position     <= received.position;
  angle        <= received.angle;
  index_seen   <= received.index_seen;
  index_strobe <= received.index_strobe;
  index_error  <= received.index_error;
  illegal      <= received.illegal;
  overspeed    <= received.overspeed;

  sender : entity work.quadrature_output
    port map (
      clock              => clock,
      reset              => reset,
      enable             => enable,
      clear              => '0',
      corrected_position => corrected_position,
      corrected_angle    => corrected_angle,
      referenced         => '1',
      phase_of_zero      => phase_of_zero,
      z_gated            => '0',
      z_state            => "00",
      z_width            => "00",
      counts_per_rev     => counts_per_rev,
      minimum_spacing    => minimum_spacing,
      following_limit    => to_unsigned(100, 16),
      a                  => a,
      b                  => b,
      z                  => z,
      following_error    => open,
      cannot_keep_up     => cannot_keep_up
    );

  receiver : entity work.quadrature_decoder
    port map (
      clock                => clock,
      reset                => reset,
      a                    => a,
      b                    => b,
      z                    => z,
      counts_per_rev       => counts_per_rev,
      filter_length        => filter_length,
      -- The decoder reports an overspeed if two edges are closer than the output's minimum spacing.
      minimum_edge_spacing => minimum_spacing,
      timestamp            => to_unsigned(0, TIMESTAMP_WIDTH),
      clear                => '0',
      rearm                => '0',
      decoded              => received
    );

end architecture bench;
