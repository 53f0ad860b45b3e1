/* SPDX-License-Identifier: Apache-2.0 */

#ifndef ARCTRUE_BOARD_FABRIC_H
#define ARCTRUE_BOARD_FABRIC_H

#include <stdbool.h>

#include "fabric.h"
#include "register_access.h"

/* Returns access to the processor's own registers. */
const struct register_access *board_registers(void);

/* Loads the fabric if it is not configured and the flash contains a bitstream. The function always ends within seconds,
   and feeds the watchdog meanwhile. */
enum fabric_state board_fabric_start(void);

/* Returns the present state of the fabric's configuration. */
enum fabric_state board_fabric_state(void);
/* If the fabric could not be loaded from the flash, checks whether JTAG has configured it meanwhile. Returns the state
   after this check. */
enum fabric_state board_fabric_look_again(void);

/* Tells whether the firmware runs in an emulator, whose fabric is memory. */
bool board_fabric_emulated(void);

/* Returns false if an access to the fabric's window would never end. */
bool board_fabric_usable(void);

#endif
