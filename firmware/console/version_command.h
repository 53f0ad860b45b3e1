/* SPDX-License-Identifier: Apache-2.0 */

/* `version`: prints versions of firmware, build and gateware, the gateware's configuration, and the chip. */

#ifndef ARCTRUE_VERSION_COMMAND_H
#define ARCTRUE_VERSION_COMMAND_H

#include "console.h"

extern const char version_use[];

void version_command(struct console *console, char *const *words, uint32_t number);

#endif
