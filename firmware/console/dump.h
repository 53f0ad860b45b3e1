/* SPDX-License-Identifier: Apache-2.0 */

/* `dump`: the next turn's capture in frames, a line each, with their number and a CRC-32 over the
   numbers of the line as little-endian words. */

#ifndef ARCTRUE_DUMP_H
#define ARCTRUE_DUMP_H

#include "console.h"

extern const char dump_use[];

void dump_command(struct console *console, char *const *words, uint32_t number);
/* What there is to tell of a capture that was copied, some rows at a time. */
void dump_step(struct console *console);
/* There are rows to tell; and room for one of them. */
bool dump_busy(const struct console *console);
bool dump_can_go_on(const struct console *console);

#endif
