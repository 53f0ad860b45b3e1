# SPDX-License-Identifier: Apache-2.0
#
# Pins of heads 3 and 4 of arctrue_zynq_heads_top, on the ChipKit header of the Digilent Arty Z7-20; its other ports
# have the pins of ../arty_z7_20.xdc. make bitstream HEADS=4 reads both files.
# Both Pmods are full. The heads use IO3 to IO8, because no two of these pins are a pair of the package; IO2 is left
# out, because during the configuration it is the strap of the pull-ups (PUDC_B).
# An open input is pulled low, so that it counts no edges.

# Head 3: receivers' outputs on IO3, IO4, IO5.
set_property LOC V13 [get_ports head3_a]
set_property IOSTANDARD LVCMOS33 [get_ports head3_a]
set_property PULLTYPE PULLDOWN [get_ports head3_a]
set_property LOC V15 [get_ports head3_b]
set_property IOSTANDARD LVCMOS33 [get_ports head3_b]
set_property PULLTYPE PULLDOWN [get_ports head3_b]
set_property LOC T15 [get_ports head3_z]
set_property IOSTANDARD LVCMOS33 [get_ports head3_z]
set_property PULLTYPE PULLDOWN [get_ports head3_z]

# Head 4: receivers' outputs on IO6, IO7, IO8.
set_property LOC R16 [get_ports head4_a]
set_property IOSTANDARD LVCMOS33 [get_ports head4_a]
set_property PULLTYPE PULLDOWN [get_ports head4_a]
set_property LOC U17 [get_ports head4_b]
set_property IOSTANDARD LVCMOS33 [get_ports head4_b]
set_property PULLTYPE PULLDOWN [get_ports head4_b]
set_property LOC V17 [get_ports head4_z]
set_property IOSTANDARD LVCMOS33 [get_ports head4_z]
set_property PULLTYPE PULLDOWN [get_ports head4_z]
