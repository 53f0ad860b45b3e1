# SPDX-License-Identifier: Apache-2.0
#
# Constrains encoder_source_top and encoder_source_heads_top for Vivado only: states the clock of the board's
# oscillator, 125 MHz, and bounds the skew between A, B and Z of a head.

create_clock -name oscillator -period 8.000 [get_ports oscillator]
set_max_delay -datapath_only -from [get_clocks oscillator] -to [get_ports head*] 10.000
