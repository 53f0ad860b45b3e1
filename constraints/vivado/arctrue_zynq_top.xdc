# SPDX-License-Identifier: Apache-2.0
#
# What Vivado alone reads of the pins of arctrue_zynq_top and of the differential one, for every board. It names
# ports only, no cell, and is not scoped; what the units inside need stands in scoped files of their names, which any
# other design reads too. The open tools take the clock's frequency as an option and time nothing that leaves the fabric.

# Asynchronous inputs: Vivado times no path from a pin without an input delay; with one of 0 it times each.
set_input_delay -clock fabric_clock 0.000 [get_ports head*]
set_input_delay -clock fabric_clock 0.000 [get_ports sync_in]
set_input_delay -clock fabric_clock 0.000 [get_ports probe_in]

# From a pin to the register that it meets, whichever this is (an input_synchroniser; report_cdc shows any other), half a
# clock of 100 MHz: the pins of a head are moved against each other by less than that, so that they come apart by
# one sample at the most. Such a register may be met at any time, so there is no hold to keep.
set_max_delay -datapath_only -from [get_ports {head* sync_in probe_in}] 5.000
set_false_path -hold -from [get_ports {head* sync_in probe_in}]

# A, B and Z, the trigger and the compare leave from registers in their pads, and are moved by less than half
# a clock in any case. Clocks of what they go to are unknown: no output delay.
set_max_delay -datapath_only -from [get_clocks fabric_clock] -to [get_ports {out_* trigger_out compare_out}] 5.000

# The I2C bus has 100 kHz and the clock of the processor's side.
set_false_path -from [get_ports i2c*]
set_false_path -to [get_ports i2c*]

# Nobody takes these with a clock of ours.
set_false_path -to [get_ports led*]
set_false_path -to [get_ports driver_enable]
set_false_path -to [get_ports alarm]
