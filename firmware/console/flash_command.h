/* SPDX-License-Identifier: Apache-2.0 */

/* `flash`: boot images into the flash, what `arctrue flash` sends. */

#ifndef ARCTRUE_FLASH_COMMAND_H
#define ARCTRUE_FLASH_COMMAND_H

#include "console.h"

extern const char flash_use[];

void flash_command(struct console *console, char *const *words, uint32_t number);

/* The answer of what was under way. */
void flash_step_told(struct console *console);

#endif
