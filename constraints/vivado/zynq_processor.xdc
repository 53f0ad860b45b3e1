# SPDX-License-Identifier: Apache-2.0
#
# Constrains the clock and the reset of the fabric for Vivado, in every design that contains zynq_processor. Read this
# file scoped (read_xdc -ref zynq_processor), and before the other files, which use the name fabric_clock.

# The clock is FCLK 0, which the firmware sets to 100 MHz (firmware/board/clocks.h).
create_clock -name fabric_clock -period 10.000 [get_pins {ps7_primitive/FCLKCLK[0]}]

# The jitter of the processor's clocks, peak to peak, is 3 % of the period, as in AMD's own PS7 block.
set_input_jitter fabric_clock 0.300

# The reset may come at any time; reset_release synchronises it to the clock.
set_false_path -through [get_pins {ps7_primitive/FCLKRESETN[0]}]
