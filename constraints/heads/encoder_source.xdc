# SPDX-License-Identifier: Apache-2.0
#
# Assigns the pins of heads 3 and 4 of encoder_source_heads_top on a PYNQ-Z2 or an Arty Z7-20. They are the pins of the
# Arduino (ChipKit) header at which arctrue_zynq_heads_top, on the other board, receives these heads.
# ../encoder_source.xdc assigns the pins of the other ports.

set_property LOC V13 [get_ports head3_a]
set_property IOSTANDARD LVCMOS33 [get_ports head3_a]
set_property LOC V15 [get_ports head3_b]
set_property IOSTANDARD LVCMOS33 [get_ports head3_b]
set_property LOC T15 [get_ports head3_z]
set_property IOSTANDARD LVCMOS33 [get_ports head3_z]
set_property LOC R16 [get_ports head4_a]
set_property IOSTANDARD LVCMOS33 [get_ports head4_a]
set_property LOC U17 [get_ports head4_b]
set_property IOSTANDARD LVCMOS33 [get_ports head4_b]
set_property LOC V17 [get_ports head4_z]
set_property IOSTANDARD LVCMOS33 [get_ports head4_z]
