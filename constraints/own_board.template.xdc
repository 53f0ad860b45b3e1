# SPDX-License-Identifier: Apache-2.0
#
# Assigns the ports of arctrue_zynq_top to pins of your own board. Copy this file to constraints/my_board.xdc. Replace
# each PIN by a pin of the package, and each STANDARD by the I/O standard for the supply of the pin's bank (LVCMOS33 at
# 3.3 V, LVCMOS25 at 2.5 V, LVCMOS18 at 1.8 V). Then run
#
#     make bitstream BOARD=my_board PART=xc7z020clg484-1
#
# Every port needs a pin and a standard, and a pin may appear only once; make bitstream checks this before it starts. A
# signal that your board does not use needs a pin too. For differential pairs (TOP=arctrue_zynq_differential_top)
# replace each encoder port by two ports, for example head1_a by head1_a_p and head1_a_n; both get the standard of the
# pair (LVDS_25 or TMDS_33), and their pins must be the two pins of one pair.
#
# Pull-downs hold unconnected inputs low, so that no edges are counted there. Pairs have no pull-down: delete their lines
# with PULLTYPE. Write no other commands into this file: make bitstream refuses them, because the open tools
# would ignore them and Vivado would not.

# Reference head
set_property LOC PIN [get_ports head1_a]
set_property IOSTANDARD STANDARD [get_ports head1_a]
set_property PULLTYPE PULLDOWN [get_ports head1_a]
set_property LOC PIN [get_ports head1_b]
set_property IOSTANDARD STANDARD [get_ports head1_b]
set_property PULLTYPE PULLDOWN [get_ports head1_b]
set_property LOC PIN [get_ports head1_z]
set_property IOSTANDARD STANDARD [get_ports head1_z]
set_property PULLTYPE PULLDOWN [get_ports head1_z]

# Calibration head.
set_property LOC PIN [get_ports head2_a]
set_property IOSTANDARD STANDARD [get_ports head2_a]
set_property PULLTYPE PULLDOWN [get_ports head2_a]
set_property LOC PIN [get_ports head2_b]
set_property IOSTANDARD STANDARD [get_ports head2_b]
set_property PULLTYPE PULLDOWN [get_ports head2_b]
set_property LOC PIN [get_ports head2_z]
set_property IOSTANDARD STANDARD [get_ports head2_z]
set_property PULLTYPE PULLDOWN [get_ports head2_z]

# Corrected encoder signal.
set_property LOC PIN [get_ports out_a]
set_property IOSTANDARD STANDARD [get_ports out_a]
set_property LOC PIN [get_ports out_b]
set_property IOSTANDARD STANDARD [get_ports out_b]
set_property LOC PIN [get_ports out_z]
set_property IOSTANDARD STANDARD [get_ports out_z]

# Enable of the line drivers (an external resistor must pull it to its inactive level), alarm, and the signals of
# external instruments.
set_property LOC PIN [get_ports driver_enable]
set_property IOSTANDARD STANDARD [get_ports driver_enable]
set_property LOC PIN [get_ports alarm]
set_property IOSTANDARD STANDARD [get_ports alarm]
set_property LOC PIN [get_ports sync_in]
set_property IOSTANDARD STANDARD [get_ports sync_in]
set_property PULLTYPE PULLDOWN [get_ports sync_in]
set_property LOC PIN [get_ports trigger_out]
set_property IOSTANDARD STANDARD [get_ports trigger_out]
set_property LOC PIN [get_ports probe_in]
set_property IOSTANDARD STANDARD [get_ports probe_in]
set_property PULLTYPE PULLDOWN [get_ports probe_in]
set_property LOC PIN [get_ports compare_out]
set_property IOSTANDARD STANDARD [get_ports compare_out]

# I2C bus of the table's thermometer; each wire needs an external pull-up too.
set_property LOC PIN [get_ports i2c_scl]
set_property IOSTANDARD STANDARD [get_ports i2c_scl]
set_property PULLTYPE PULLUP [get_ports i2c_scl]
set_property LOC PIN [get_ports i2c_sda]
set_property IOSTANDARD STANDARD [get_ports i2c_sda]
set_property PULLTYPE PULLUP [get_ports i2c_sda]

# LEDs, lit while the pin is high.
set_property LOC PIN [get_ports led_alive]
set_property IOSTANDARD STANDARD [get_ports led_alive]
set_property LOC PIN [get_ports led_capture]
set_property IOSTANDARD STANDARD [get_ports led_capture]
set_property LOC PIN [get_ports led_fault]
set_property IOSTANDARD STANDARD [get_ports led_fault]
set_property LOC PIN [get_ports led_compensation]
set_property IOSTANDARD STANDARD [get_ports led_compensation]
