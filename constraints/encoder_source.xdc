# SPDX-License-Identifier: Apache-2.0
#
# Assigns the pins of encoder_source_top on a PYNQ-Z2 or an Arty Z7-20: the board's oscillator, and both heads on the
# first Pmod (PMODA, JA), at the pins at which arctrue_zynq_top, on the other board, receives them.

set_property LOC H16 [get_ports oscillator]
set_property IOSTANDARD LVCMOS33 [get_ports oscillator]

set_property LOC Y18 [get_ports head1_a]
set_property IOSTANDARD LVCMOS33 [get_ports head1_a]
set_property LOC Y16 [get_ports head1_b]
set_property IOSTANDARD LVCMOS33 [get_ports head1_b]
set_property LOC Y17 [get_ports head1_z]
set_property IOSTANDARD LVCMOS33 [get_ports head1_z]
set_property LOC U18 [get_ports head2_a]
set_property IOSTANDARD LVCMOS33 [get_ports head2_a]
set_property LOC W18 [get_ports head2_b]
set_property IOSTANDARD LVCMOS33 [get_ports head2_b]
set_property LOC W19 [get_ports head2_z]
set_property IOSTANDARD LVCMOS33 [get_ports head2_z]
