# SPDX-License-Identifier: Apache-2.0
#
# Constrains pulse_output for Vivado in every design in which it drives a pin: the register of the pulse is placed in
# the pad, so that the delay from the strobe of a sample or of position_compare to the edge at the pin is constant. Read
# this file scoped: read_xdc -ref pulse_output.
set_property IOB TRUE [get_cells pulse_reg]
