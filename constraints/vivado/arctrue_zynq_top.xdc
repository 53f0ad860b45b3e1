# SPDX-License-Identifier: Apache-2.0
#
# Constrains the timing at the pins of arctrue_zynq_top, arctrue_zynq_heads_top and arctrue_zynq_differential_top on
# every board; only Vivado reads this file. It names only ports, no cells, and is not scoped. The constraints of a unit
# are in a scoped file with the unit's name, which any other design can read too. The open tools get the clock's
# frequency as an option and do not time paths that leave the fabric.

# Asynchronous inputs: Vivado does not time a path from a pin that has no input delay. So each pin gets an input delay
# of 0.
set_input_delay -clock fabric_clock 0.000 [get_ports head*]
set_input_delay -clock fabric_clock 0.000 [get_ports sync_in]
set_input_delay -clock fabric_clock 0.000 [get_ports probe_in]

# The path from a pin to its first register may take half a clock period at 100 MHz. So the skew between the pins of a
# head is less than half a period, and their samples differ by at most one clock. A pin may change at any time, so there
# is no hold time to check. The first register must be that of an input_synchroniser; report_cdc shows any other.
set_max_delay -datapath_only -from [get_ports {head* sync_in probe_in}] 5.000
set_false_path -hold -from [get_ports {head* sync_in probe_in}]

# The registers of A, B, Z, trigger and compare are in the pads; even if a tool places them elsewhere, this bound keeps
# the skew below half a clock period. The clocks of the receivers are unknown, so there is no output delay.
set_max_delay -datapath_only -from [get_clocks fabric_clock] -to [get_ports {out_* trigger_out compare_out}] 5.000

# The I2C bus runs at 100 kHz and is clocked by the processor, so its paths are not timed.
set_false_path -from [get_ports i2c*]
set_false_path -to [get_ports i2c*]

# No receiver samples these outputs with a clock of this design.
set_false_path -to [get_ports led*]
set_false_path -to [get_ports driver_enable]
set_false_path -to [get_ports alarm]
