# SPDX-License-Identifier: Apache-2.0
#
# What chip_dna needs of Vivado in any design that has one: the clock that its register makes for DNA_PORT (twice
# CLOCKS_PER_HALF clocks, 16 with the default), and a bound on the paths to and from the primitive. Both sides change and
# take where that clock falls, half of its 160 ns from where the primitive does, so there is no hold to keep and
# 40 ns are half of what is there. Scoped: read_xdc -ref chip_dna.
create_generated_clock -name dna_clock -divide_by 16 -source [get_pins port_clock_reg/C] [get_pins port_clock_reg/Q]
set_max_delay -datapath_only -from [get_cells {load_reg shift_reg}] -to [get_cells dna_primitive] 40.000
set_max_delay -datapath_only -from [get_cells dna_primitive] -to [get_cells identifier_reg*] 40.000
