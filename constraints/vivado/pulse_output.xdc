# SPDX-License-Identifier: Apache-2.0
#
# What pulse_output needs of Vivado in any design whose pins it drives: its pulse leaves from a register in the pad, so that
# the edge of a trigger or of a compare stands to the sample or place that it tells by less than half a clock
# of 100 MHz, and always by the same. Clocks of what it goes to are unknown: no output delay.
set pulses [get_cells -hierarchical -filter {NAME =~ *_pulse/pulse_reg}]
set_property IOB TRUE $pulses
set_max_delay -datapath_only -from $pulses -to [all_outputs] 5.000
