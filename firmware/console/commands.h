/* SPDX-License-Identifier: Apache-2.0 */

#ifndef ARCTRUE_COMMANDS_H
#define ARCTRUE_COMMANDS_H

#include "console.h"

/* Do what the words say and answer. `number` is at least 1. */
void commands_run(struct console *console, char *const *words, uint32_t number);

#endif
