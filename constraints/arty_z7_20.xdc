# SPDX-License-Identifier: Apache-2.0
#
# Pins of arctrue_zynq_top on the Digilent Arty Z7-20 (XC7Z020-1CLG400C).
# RS-422 receivers and drivers stand between the Pmods and the encoders: docs/device.md.
# This file contains only what every tool reads: LOC, IOSTANDARD and PULLTYPE of ports. All other constraints are in
# vivado/.
# An open input is pulled low, so that it counts no edges.

# Reference head: receivers' outputs on the upper row of Pmod JA.
set_property LOC Y18 [get_ports head1_a]
set_property IOSTANDARD LVCMOS33 [get_ports head1_a]
set_property PULLTYPE PULLDOWN [get_ports head1_a]
set_property LOC Y16 [get_ports head1_b]
set_property IOSTANDARD LVCMOS33 [get_ports head1_b]
set_property PULLTYPE PULLDOWN [get_ports head1_b]
set_property LOC Y17 [get_ports head1_z]
set_property IOSTANDARD LVCMOS33 [get_ports head1_z]
set_property PULLTYPE PULLDOWN [get_ports head1_z]

# Calibration head: receivers' outputs on the lower row of Pmod JA.
set_property LOC U18 [get_ports head2_a]
set_property IOSTANDARD LVCMOS33 [get_ports head2_a]
set_property PULLTYPE PULLDOWN [get_ports head2_a]
set_property LOC W18 [get_ports head2_b]
set_property IOSTANDARD LVCMOS33 [get_ports head2_b]
set_property PULLTYPE PULLDOWN [get_ports head2_b]
set_property LOC W19 [get_ports head2_z]
set_property IOSTANDARD LVCMOS33 [get_ports head2_z]
set_property PULLTYPE PULLDOWN [get_ports head2_z]

# Corrected encoder signal: drivers' inputs on the upper row of Pmod JB.
set_property LOC W14 [get_ports out_a]
set_property IOSTANDARD LVCMOS33 [get_ports out_a]
set_property LOC T11 [get_ports out_b]
set_property IOSTANDARD LVCMOS33 [get_ports out_b]
set_property LOC T10 [get_ports out_z]
set_property IOSTANDARD LVCMOS33 [get_ports out_z]

# Enable of the line drivers, alarm, and the instruments beside the table: the other pins of Pmod JB, and one of JA. The
# pins that are coupled with those of A have signals that do not change while the table turns.
set_property LOC Y14 [get_ports driver_enable]
set_property IOSTANDARD LVCMOS33 [get_ports driver_enable]
set_property LOC V16 [get_ports alarm]
set_property IOSTANDARD LVCMOS33 [get_ports alarm]
set_property LOC W13 [get_ports sync_in]
set_property IOSTANDARD LVCMOS33 [get_ports sync_in]
set_property PULLTYPE PULLDOWN [get_ports sync_in]
set_property LOC W16 [get_ports trigger_out]
set_property IOSTANDARD LVCMOS33 [get_ports trigger_out]
set_property LOC U19 [get_ports probe_in]
set_property IOSTANDARD LVCMOS33 [get_ports probe_in]
set_property PULLTYPE PULLDOWN [get_ports probe_in]
set_property LOC V12 [get_ports compare_out]
set_property IOSTANDARD LVCMOS33 [get_ports compare_out]

# I2C bus of the table's thermometer: SCL and SDA of the ChipKit header. The pull-ups of the chip hold a bus
# without a thermometer high; they are too weak for one with a cable (docs/device.md).
set_property LOC P16 [get_ports i2c_scl]
set_property IOSTANDARD LVCMOS33 [get_ports i2c_scl]
set_property PULLTYPE PULLUP [get_ports i2c_scl]
set_property LOC P15 [get_ports i2c_sda]
set_property IOSTANDARD LVCMOS33 [get_ports i2c_sda]
set_property PULLTYPE PULLUP [get_ports i2c_sda]

# LEDs of the board.
set_property LOC R14 [get_ports led_alive]
set_property IOSTANDARD LVCMOS33 [get_ports led_alive]
set_property LOC P14 [get_ports led_capture]
set_property IOSTANDARD LVCMOS33 [get_ports led_capture]
set_property LOC N16 [get_ports led_fault]
set_property IOSTANDARD LVCMOS33 [get_ports led_fault]
set_property LOC M14 [get_ports led_compensation]
set_property IOSTANDARD LVCMOS33 [get_ports led_compensation]
