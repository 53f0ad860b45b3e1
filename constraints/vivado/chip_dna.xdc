# SPDX-License-Identifier: Apache-2.0
#
# Constrains chip_dna for Vivado in every design that contains it. The file states the clock that a register of chip_dna
# generates for DNA_PORT (a period is twice CLOCKS_PER_HALF clocks, 16 with the default). It also bounds the delay of
# the paths to and from the primitive. The entity changes and samples the signals at the falling edge of the generated clock, the
# primitive at the rising edge, half a period (80 ns) later. So there is no hold time to check, and the bound of 40 ns
# is half of the time available. Read this file scoped: read_xdc -ref chip_dna.
create_generated_clock -name dna_clock -divide_by 16 -source [get_pins port_clock_reg/C] [get_pins port_clock_reg/Q]
set_max_delay -datapath_only -from [get_cells {load_reg shift_reg}] -to [get_cells dna_primitive] 40.000
set_max_delay -datapath_only -from [get_cells dna_primitive] -to [get_cells identifier_reg*] 40.000
