# SPDX-License-Identifier: Apache-2.0
#
# What chip_dna needs of Vivado in any design that has one: the clock that its register makes for DNA_PORT (twice
# CLOCKS_PER_HALF clocks, 16 with the default), and a bound on the paths to and from the primitive. Both sides change and
# take where that clock falls, half of its 160 ns from where the primitive does, so there is no hold to keep and
# 40 ns are half of what is there.
set dna_primitive [get_cells -hierarchical -filter {REF_NAME == DNA_PORT}]
set dna_divider [get_cells -hierarchical -filter {NAME =~ *port_clock_reg}]
create_generated_clock -name dna_clock -divide_by 16 \
    -source [get_pins -of_objects $dna_divider -filter {REF_PIN_NAME == C}] \
    [get_pins -of_objects $dna_divider -filter {REF_PIN_NAME == Q}]
set_max_delay -datapath_only -from [all_registers -clock fabric_clock] -to $dna_primitive 40.000
set_max_delay -datapath_only -from $dna_primitive -to [all_registers -clock fabric_clock] 40.000
