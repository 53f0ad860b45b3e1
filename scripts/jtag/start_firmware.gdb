# SPDX-License-Identifier: Apache-2.0
# Loads the file that gdb's command line names, reads it back and starts it.
set confirm off
set pagination off
load
compare-sections
# Supervisor mode, ARM state and disabled interrupts, as after the boot ROM.
set $cpsr = 0x1d3
detach
quit
