# SPDX-License-Identifier: Apache-2.0
#
# Assigns the ports of arctrue_zynq_top to pins of the Digilent Arty Z7-20 (XC7Z020-1CLG400C). RS-422 receivers and
# drivers are needed between the Pmods and the encoders: docs/device.md. This file contains only constraints that every
# tool reads: LOC, IOSTANDARD and PULLTYPE of ports. All other constraints are in vivado/. Pull-downs hold unconnected
# inputs low, so that no edges are counted there.

# Reference head: connect the receivers' outputs to the upper row of Pmod JA.
set_property LOC Y18 [get_ports head1_a]
set_property IOSTANDARD LVCMOS33 [get_ports head1_a]
set_property PULLTYPE PULLDOWN [get_ports head1_a]
set_property LOC Y16 [get_ports head1_b]
set_property IOSTANDARD LVCMOS33 [get_ports head1_b]
set_property PULLTYPE PULLDOWN [get_ports head1_b]
set_property LOC Y17 [get_ports head1_z]
set_property IOSTANDARD LVCMOS33 [get_ports head1_z]
set_property PULLTYPE PULLDOWN [get_ports head1_z]

# Calibration head: connect the receivers' outputs to the lower row of Pmod JA.
set_property LOC U18 [get_ports head2_a]
set_property IOSTANDARD LVCMOS33 [get_ports head2_a]
set_property PULLTYPE PULLDOWN [get_ports head2_a]
set_property LOC W18 [get_ports head2_b]
set_property IOSTANDARD LVCMOS33 [get_ports head2_b]
set_property PULLTYPE PULLDOWN [get_ports head2_b]
set_property LOC W19 [get_ports head2_z]
set_property IOSTANDARD LVCMOS33 [get_ports head2_z]
set_property PULLTYPE PULLDOWN [get_ports head2_z]

# Corrected encoder signal: connect the drivers' inputs to the upper row of Pmod JB.
set_property LOC W14 [get_ports out_a]
set_property IOSTANDARD LVCMOS33 [get_ports out_a]
set_property LOC T11 [get_ports out_b]
set_property IOSTANDARD LVCMOS33 [get_ports out_b]
set_property LOC T10 [get_ports out_z]
set_property IOSTANDARD LVCMOS33 [get_ports out_z]

# The enable of the line drivers, the alarm and the signals of external instruments use the other pins of Pmod JB and
# one pin of JA. A pin that is coupled with a pin of A (docs/device.md) carries a signal that rarely changes while the
# table turns, so that no crosstalk disturbs A.
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

# The I2C bus of the table's thermometer uses SCL and SDA of the ChipKit header. The pull-ups in the chip hold the wires
# high if no thermometer is connected; they are too weak for a bus with a cable (docs/device.md).
set_property LOC P16 [get_ports i2c_scl]
set_property IOSTANDARD LVCMOS33 [get_ports i2c_scl]
set_property PULLTYPE PULLUP [get_ports i2c_scl]
set_property LOC P15 [get_ports i2c_sda]
set_property IOSTANDARD LVCMOS33 [get_ports i2c_sda]
set_property PULLTYPE PULLUP [get_ports i2c_sda]

# LEDs on the board.
set_property LOC R14 [get_ports led_alive]
set_property IOSTANDARD LVCMOS33 [get_ports led_alive]
set_property LOC P14 [get_ports led_capture]
set_property IOSTANDARD LVCMOS33 [get_ports led_capture]
set_property LOC N16 [get_ports led_fault]
set_property IOSTANDARD LVCMOS33 [get_ports led_fault]
set_property LOC M14 [get_ports led_compensation]
set_property IOSTANDARD LVCMOS33 [get_ports led_compensation]
