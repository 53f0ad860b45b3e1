# SPDX-License-Identifier: Apache-2.0
#
# What Vivado alone reads, for every board: the fabric's clock, which paths need no timing and which a
# bound. The open tools take the clock's frequency as an option and time nothing that
# leaves the fabric.

# FCLK 0, set to 100 MHz by the firmware (firmware/board/clocks.h).
create_clock -name fabric_clock -period 10.000 [get_pins -hierarchical -filter {NAME =~ *ps7_primitive/FCLKCLK[0]}]

# Asynchronous inputs end at the first register of a synchroniser and nowhere else; a path that left one
# of these pins for another register is still timed, and fails.
set synchronisers [get_cells -hierarchical -filter {NAME =~ *synchroniser/stage_registers_reg*}]
set_property ASYNC_REG TRUE $synchronisers
set_false_path -from [get_ports head*] -to $synchronisers
set_false_path -through [get_pins -hierarchical -filter {NAME =~ *ps7_primitive/FCLKRESETN[0]}] -to $synchronisers

# A, B and Z may be moved against each other by one clock at most: each gets from its register to its pin
# within one. Clocks of what they go to are unknown: no output delay.
set_max_delay -datapath_only -from [get_clocks fabric_clock] -to [get_ports out*] 10.000
set_false_path -to [get_ports led*]
