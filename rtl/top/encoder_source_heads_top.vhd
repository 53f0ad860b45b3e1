-- SPDX-License-Identifier: Apache-2.0
--
-- # encoder_source_heads_top
--
-- Connects encoder_source, which generates the signals of a table with four read heads, to the pins and the oscillator
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

entity encoder_source_heads_top is
  port (
    oscillator : in    std_ulogic; -- 125 MHz
    head1_a    : out   std_ulogic;
    head1_b    : out   std_ulogic;
    head1_z    : out   std_ulogic;
    head2_a    : out   std_ulogic;
    head2_b    : out   std_ulogic;
    head2_z    : out   std_ulogic;
    head3_a    : out   std_ulogic;
    head3_b    : out   std_ulogic;
    head3_z    : out   std_ulogic;
    head4_a    : out   std_ulogic;
    head4_b    : out   std_ulogic;
    head4_z    : out   std_ulogic
  );
end entity encoder_source_heads_top;

architecture rtl of encoder_source_heads_top is

  -- Angle from head 1 to head 2, counts: 64.3 deg at 2**24 counts per turn. With heads at 0, 64.3, 177 and 257.9 deg any
  -- one head may fail (docs/hardware.md).
  constant HEAD2_AHEAD : natural := 2996597;

  signal reset : std_ulogic;

begin

  reset_hold : entity work.reset_release
    port map (
      clock                => oscillator,
      asynchronous_reset_n => '1',
      reset                => reset
    );

  source : entity work.encoder_source
    generic map (
      HEADS           => 4,
      HEAD_SEPARATION => HEAD2_AHEAD
    )
    port map (
      clock   => oscillator,
      reset   => reset,
      head1_a => head1_a,
      head1_b => head1_b,
      head1_z => head1_z,
      head2_a => head2_a,
      head2_b => head2_b,
      head2_z => head2_z,
      head3_a => head3_a,
      head3_b => head3_b,
      head3_z => head3_z,
      head4_a => head4_a,
      head4_b => head4_b,
      head4_z => head4_z
    );

end architecture rtl;
