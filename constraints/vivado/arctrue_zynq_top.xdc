# SPDX-License-Identifier: Apache-2.0
#
# What Vivado alone reads of the pins of arctrue_zynq_top and of the differential one, for every board; what its
# units need stands in files of their names, which any other design reads too. The open tools take the
# clock's frequency as an option and time nothing that leaves the fabric.

# Asynchronous inputs: Vivado times no path from a pin without an input delay; with one of 0 it times each.
set_input_delay -clock fabric_clock 0.000 [get_ports head*]
set_input_delay -clock fabric_clock 0.000 [get_ports sync_in]
set_input_delay -clock fabric_clock 0.000 [get_ports probe_in]

# The I2C bus has 100 kHz and the clock of the processor's side.
set_false_path -from [get_ports i2c*]
set_false_path -to [get_ports i2c*]

# Nobody takes these with a clock of ours.
set_false_path -to [get_ports led*]
set_false_path -to [get_ports driver_enable]
set_false_path -to [get_ports alarm]
