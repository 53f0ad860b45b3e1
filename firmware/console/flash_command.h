/* SPDX-License-Identifier: Apache-2.0 */

/* `flash`: writes boot images into the flash; `arctrue flash` sends these commands. */

#ifndef ARCTRUE_FLASH_COMMAND_H
#define ARCTRUE_FLASH_COMMAND_H

#include "console.h"

extern const char flash_use[];

void flash_command(struct console *console, char *const *words, uint32_t number);

/* Prints the answer of an operation that has ended. */
void flash_step_reported(struct console *console);

#endif
