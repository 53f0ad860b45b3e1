# SPDX-License-Identifier: Apache-2.0
#
# What Vivado alone reads for encoder_source_top: the board's oscillator, 125 MHz, and a bound on how far
# A, B and Z of a head are moved against each other.

create_clock -name oscillator -period 8.000 [get_ports oscillator]
set_max_delay -datapath_only -from [get_clocks oscillator] -to [get_ports head*] 10.000
