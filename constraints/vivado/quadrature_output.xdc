# SPDX-License-Identifier: Apache-2.0
#
# What quadrature_output needs of Vivado in any design whose pins it drives: A, B and Z leave from registers in their pads,
# all alike, and are moved against each other by less than half a clock of 100 MHz in any case. Clocks of what they go
# to are unknown: no output delay.
set edges [get_cells -hierarchical -filter {NAME =~ *edges_out/a_reg || NAME =~ *edges_out/b_reg || NAME =~ *edges_out/z_reg}]
set_property IOB TRUE $edges
set_max_delay -datapath_only -from $edges -to [all_outputs] 5.000
