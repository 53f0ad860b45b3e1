# SPDX-License-Identifier: Apache-2.0
#
# Constraints of encoder_source_top that only Vivado reads: the board's oscillator, 125 MHz, and a bound on the skew
# between A, B and Z of a head.

create_clock -name oscillator -period 8.000 [get_ports oscillator]
set_max_delay -datapath_only -from [get_clocks oscillator] -to [get_ports head*] 10.000
