/* SPDX-License-Identifier: Apache-2.0 */

/* `save`: parameters, switches and coefficients into the flash. Its answer comes when the record
   was read back, seconds later. */

#ifndef ARCTRUE_SAVE_COMMAND_H
#define ARCTRUE_SAVE_COMMAND_H

#include "console.h"

extern const char save_use[];

void save_command(struct console *console, char *const *words, uint32_t number);
/* The answer, once the save has ended. */
void save_step_told(struct console *console);

#endif
