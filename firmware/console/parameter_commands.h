/* SPDX-License-Identifier: Apache-2.0 */

/* Shows and sets parameters. The pins trigger, sync, probe and compare have commands of their own; `probe` and
   `compare` also print the state of their unit in the core. */

#ifndef ARCTRUE_PARAMETER_COMMANDS_H
#define ARCTRUE_PARAMETER_COMMANDS_H

#include "console.h"

extern const char set_use[];
extern const char trigger_use[];
extern const char sync_use[];
extern const char probe_use[];
extern const char compare_use[];

/* Prints all parameters whose names begin with `beginning`. */
void parameters_show(const struct console *console, const char *beginning);

void set_command(struct console *console, char *const *words, uint32_t number);
/* Executes the commands `trigger`, `sync`, `probe` and `compare`; for example, `compare on 1` sets compare_on. */
void pins_command(struct console *console, char *const *words, uint32_t number);

#endif
