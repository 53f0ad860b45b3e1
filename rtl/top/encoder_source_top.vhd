-- SPDX-License-Identifier: Apache-2.0
--
-- # encoder_source_top
--
-- Connects encoder_source, which generates the signals of a table with two read heads, to the pins and the oscillator
-- of a board. The processor is not used. This top level is for a second PYNQ-Z2 or Arty Z7-20 on the bench:
-- docs/hardware.md.
--
-- **Latency.** The entity has no data input and therefore no latency.
--
-- **Number formats.** All ports are single bits.
--
-- **Reset.** The simulated table starts to turn 67 clocks after the configuration of the chip. A head gives edges of A,
-- B and Z as soon as it has loaded its coefficients.

library ieee;
  use ieee.std_logic_1164.all;

entity encoder_source_top is
  port (
    oscillator : in    std_ulogic; -- 125 MHz
    head1_a    : out   std_ulogic;
    head1_b    : out   std_ulogic;
    head1_z    : out   std_ulogic;
    head2_a    : out   std_ulogic;
    head2_b    : out   std_ulogic;
    head2_z    : out   std_ulogic
  );
end entity encoder_source_top;

architecture rtl of encoder_source_top is

  signal reset : std_ulogic;

begin

  reset_hold : entity work.reset_release
    port map (
      clock                => oscillator,
      asynchronous_reset_n => '1',
      reset                => reset
    );

  source : entity work.encoder_source
    port map (
      clock   => oscillator,
      reset   => reset,
      head1_a => head1_a,
      head1_b => head1_b,
      head1_z => head1_z,
      head2_a => head2_a,
      head2_b => head2_b,
      head2_z => head2_z,
      head3_a => open,
      head3_b => open,
      head3_z => open,
      head4_a => open,
      head4_b => open,
      head4_z => open
    );

end architecture rtl;
