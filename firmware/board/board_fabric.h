/* SPDX-License-Identifier: Apache-2.0 */

#ifndef ARCTRUE_BOARD_FABRIC_H
#define ARCTRUE_BOARD_FABRIC_H

#include <stdbool.h>

#include "fabric.h"
#include "register_access.h"

/* The processor's own registers. */
const struct register_access *board_registers(void);

/* Load the fabric where it is not configured and the flash carries a bitstream. Ends in any case,
   within seconds, and feeds the watchdog meanwhile. */
enum fabric_state board_fabric_start(void);

/* What it came to so far. */
enum fabric_state board_fabric_state(void);
/* After a refusal: was it configured meanwhile, by JTAG? */
enum fabric_state board_fabric_look_again(void);

/* An emulator, whose fabric is memory. */
bool board_fabric_emulated(void);

/* False: an access to the fabric's window would never end. */
bool board_fabric_usable(void);

#endif
