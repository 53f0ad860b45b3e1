/* SPDX-License-Identifier: Apache-2.0 */

/* `load`: receives coefficients from a file, one frame per line. */

#ifndef ARCTRUE_LOAD_COMMANDS_H
#define ARCTRUE_LOAD_COMMANDS_H

#include "console.h"

extern const char load_use[];

void load_command(struct console *console, char *const *words, uint32_t number);

#endif
