/* SPDX-License-Identifier: Apache-2.0 */

/* `load`: coefficients from a file, a line a frame. */

#ifndef ARCTRUE_LOAD_COMMANDS_H
#define ARCTRUE_LOAD_COMMANDS_H

#include "console.h"

extern const char load_use[];

void load_command(struct console *console, char *const *words, uint32_t number);

#endif
