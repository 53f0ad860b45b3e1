/* SPDX-License-Identifier: Apache-2.0 */

/* `dump`: prints the next captured turn, one sample (row) per line, with the row's number and a CRC-32 over the numbers
   of the line as little-endian words. */

#ifndef ARCTRUE_DUMP_H
#define ARCTRUE_DUMP_H

#include "console.h"

extern const char dump_use[];

void dump_command(struct console *console, char *const *words, uint32_t number);
/* Prints a captured turn that was copied, a few rows at a time. */
void dump_step(struct console *console);
/* These functions tell whether rows are left to print, and whether the sink also has room for one of them. */
bool dump_busy(const struct console *console);
bool dump_can_go_on(const struct console *console);

#endif
