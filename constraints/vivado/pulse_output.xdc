# SPDX-License-Identifier: Apache-2.0
#
# Vivado's constraints for pulse_output in any design whose pin it drives: the pulse leaves from a register in the pad,
# so that the delay from the sample or the place to the edge at the pin is always the same. Scoped: read_xdc -ref
# pulse_output.
set_property IOB TRUE [get_cells pulse_reg]
