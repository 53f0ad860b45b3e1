# SPDX-License-Identifier: Apache-2.0
#
# What Vivado alone reads, for every board: the fabric's clock, which paths need no timing and which a
# bound. The open tools take the clock's frequency as an option and time nothing that
# leaves the fabric.

# FCLK 0, set to 100 MHz by the firmware (firmware/board/clocks.h).
create_clock -name fabric_clock -period 10.000 [get_pins -hierarchical -filter {NAME =~ *ps7_primitive/FCLKCLK[0]}]

# What the processor's clocks jitter by, peak to peak: 3 % of the period, as AMD's own PS7 block states it.
set_input_jitter fabric_clock 0.300

# Asynchronous inputs. Vivado times no path from a pin without an input delay; with one of 0 it times
# each. To the synchronisers they have a bound of half a clock: A, B and Z of a head are moved against each
# other by less than that, so that they come apart by one sample at the most. Such a register may be met at
# any time, so there is no hold to keep. Nothing else may be reached from these pins: report_cdc tells it.
set synchronisers [get_cells -hierarchical -filter {NAME =~ *synchroniser/stage_registers_reg*}]
set_property ASYNC_REG TRUE $synchronisers
set_input_delay -clock fabric_clock 0.000 [get_ports head*]
set_max_delay -datapath_only -from [get_ports head*] -to $synchronisers 5.000
set_false_path -hold -from [get_ports head*] -to $synchronisers
set_input_delay -clock fabric_clock 0.000 [get_ports sync_in]
set_input_delay -clock fabric_clock 0.000 [get_ports probe_in]
set_max_delay -datapath_only -from [get_ports sync_in] -to $synchronisers 5.000
set_max_delay -datapath_only -from [get_ports probe_in] -to $synchronisers 5.000
set_false_path -hold -from [get_ports sync_in] -to $synchronisers
set_false_path -hold -from [get_ports probe_in] -to $synchronisers
set_false_path -through [get_pins -hierarchical -filter {NAME =~ *ps7_primitive/FCLKRESETN[0]}] -to $synchronisers

# A, B and Z leave from registers in their pads, all alike, and are moved against each other by less than half a
# clock in any case. Clocks of what they go to are unknown: no output delay.
set_property IOB TRUE [get_cells -hierarchical -filter {NAME =~ *edges_out/a_reg || NAME =~ *edges_out/b_reg || NAME =~ *edges_out/z_reg}]
set_max_delay -datapath_only -from [get_clocks fabric_clock] -to [get_ports out*] 5.000
set_false_path -to [get_ports led*]
set_false_path -to [get_ports driver_enable]
set_false_path -to [get_ports alarm]
set_false_path -to [get_ports trigger_out]
set_false_path -to [get_ports compare_out]
