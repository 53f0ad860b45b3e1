# SPDX-License-Identifier: Apache-2.0
#
# What input_synchroniser needs of Vivado in any design that has one, and so arctrue_core and each of its units with
# asynchronous pins. Its registers keep together, and the way from a pin has a bound of half a clock of 100 MHz: the
# pins of a head are moved against each other by less than that, so that they come apart by one sample at the most. Such
# a register may be met at any time, so there is no hold to keep. Vivado times no path from a pin without an
# input delay: the design's own file must give its pins one (set_input_delay, 0 will do). Nothing else may be
# reached from such pins: report_cdc tells it.
set synchronisers [get_cells -hierarchical -filter {NAME =~ *synchroniser/stage_registers_reg*}]
set_property ASYNC_REG TRUE $synchronisers
set_max_delay -datapath_only -from [all_inputs] -to $synchronisers 5.000
set_false_path -hold -from [all_inputs] -to $synchronisers
