# SPDX-License-Identifier: Apache-2.0
#
# Vivado's constraints for zynq_processor in any design: the fabric's clock and the fabric's reset. Scoped (read_xdc
# -ref zynq_processor), and read before the other files, which use the name fabric_clock.

# FCLK 0, set to 100 MHz by the firmware (firmware/board/clocks.h).
create_clock -name fabric_clock -period 10.000 [get_pins {ps7_primitive/FCLKCLK[0]}]

# Jitter of the processor's clocks, peak to peak: 3 % of the period, as AMD's own PS7 block states it.
set_input_jitter fabric_clock 0.300

# The reset comes at any time; reset_release ends it synchronously to the clock.
set_false_path -through [get_pins {ps7_primitive/FCLKRESETN[0]}]
