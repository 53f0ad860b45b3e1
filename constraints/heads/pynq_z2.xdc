# SPDX-License-Identifier: Apache-2.0
#
# Assigns pins of the Arduino header of the TUL PYNQ-Z2 to heads 3 and 4 of arctrue_zynq_heads_top. The Pmods have no
# room for these heads; ../pynq_z2.xdc assigns the pins of the other ports. make bitstream HEADS=4 reads both files. The
# heads use IO3 to IO8, because no two of these pins form a differential pair. IO2 is not used, because it selects the
# pull-ups during the configuration (PUDC_B). Pull-downs hold unconnected inputs low, so that no edges are counted
# there.

# Head 3: connect the receivers' outputs to IO3, IO4, IO5.
set_property LOC V13 [get_ports head3_a]
set_property IOSTANDARD LVCMOS33 [get_ports head3_a]
set_property PULLTYPE PULLDOWN [get_ports head3_a]
set_property LOC V15 [get_ports head3_b]
set_property IOSTANDARD LVCMOS33 [get_ports head3_b]
set_property PULLTYPE PULLDOWN [get_ports head3_b]
set_property LOC T15 [get_ports head3_z]
set_property IOSTANDARD LVCMOS33 [get_ports head3_z]
set_property PULLTYPE PULLDOWN [get_ports head3_z]

# Head 4: connect the receivers' outputs to IO6, IO7, IO8.
set_property LOC R16 [get_ports head4_a]
set_property IOSTANDARD LVCMOS33 [get_ports head4_a]
set_property PULLTYPE PULLDOWN [get_ports head4_a]
set_property LOC U17 [get_ports head4_b]
set_property IOSTANDARD LVCMOS33 [get_ports head4_b]
set_property PULLTYPE PULLDOWN [get_ports head4_b]
set_property LOC V17 [get_ports head4_z]
set_property IOSTANDARD LVCMOS33 [get_ports head4_z]
set_property PULLTYPE PULLDOWN [get_ports head4_z]
