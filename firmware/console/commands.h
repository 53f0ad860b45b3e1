/* SPDX-License-Identifier: Apache-2.0 */

#ifndef ARCTRUE_COMMANDS_H
#define ARCTRUE_COMMANDS_H

#include "console.h"

/* Executes the command in the words and answers it. `number` is at least 1. */
void commands_run(struct console *console, char *const *words, uint32_t number);

#endif
