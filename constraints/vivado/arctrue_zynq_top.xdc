# SPDX-License-Identifier: Apache-2.0
#
# Constraints of the pins of arctrue_zynq_top and arctrue_zynq_differential_top that only Vivado reads, for every board.
# This file names ports only, no cells, and is not scoped. The constraints of a unit are in a scoped file with the
# unit's name, which any other design can read too. The open tools take the clock's frequency as an option and time
# nothing that leaves the fabric.

# Asynchronous inputs: Vivado times no path from a pin without an input delay; an input delay of 0 makes it time each
# path.
set_input_delay -clock fabric_clock 0.000 [get_ports head*]
set_input_delay -clock fabric_clock 0.000 [get_ports sync_in]
set_input_delay -clock fabric_clock 0.000 [get_ports probe_in]

# The path from a pin to its first register (that of an input_synchroniser; report_cdc shows any other) may take half a
# clock of 100 MHz. So the skew between the pins of a head is less than half a clock, and their samples differ by at
# most one clock. A pin may change at any time, so there is no hold time to check.
set_max_delay -datapath_only -from [get_ports {head* sync_in probe_in}] 5.000
set_false_path -hold -from [get_ports {head* sync_in probe_in}]

# A, B and Z, the trigger and the compare leave from registers in their pads, and their skew is less than half a clock
# in any case. The clocks of the receivers are unknown, so there is no output delay.
set_max_delay -datapath_only -from [get_clocks fabric_clock] -to [get_ports {out_* trigger_out compare_out}] 5.000

# The I2C bus runs at 100 kHz on the clock of the processor's side.
set_false_path -from [get_ports i2c*]
set_false_path -to [get_ports i2c*]

# No receiver samples these outputs with a clock of this design.
set_false_path -to [get_ports led*]
set_false_path -to [get_ports driver_enable]
set_false_path -to [get_ports alarm]
