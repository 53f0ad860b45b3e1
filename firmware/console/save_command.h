/* SPDX-License-Identifier: Apache-2.0 */

/* save: writes parameters, switches and coefficients to the flash, from which power-on loads them. The answer comes
   seconds later, after the record has been read back. */

#ifndef ARCTRUE_SAVE_COMMAND_H
#define ARCTRUE_SAVE_COMMAND_H

#include "console.h"

extern const char save_use[];

void save_command(struct console *console, char *const *words, uint32_t number);
/* Prints the answer when the save has ended. */
void save_step_reported(struct console *console);

#endif
