# SPDX-License-Identifier: Apache-2.0
# Loads the file that gdb was started with, reads it back and starts it.
set confirm off
set pagination off
load
compare-sections
# Supervisor, ARM state, no interrupts: how the boot ROM starts a program.
set $cpsr = 0x1d3
detach
quit
