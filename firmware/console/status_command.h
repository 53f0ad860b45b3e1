/* SPDX-License-Identifier: Apache-2.0 */

/* `status`: prints the state of device, calibration, output and heads, one value a line, each alarm with its advice. */

#ifndef ARCTRUE_STATUS_COMMAND_H
#define ARCTRUE_STATUS_COMMAND_H

#include "console.h"

extern const char status_use[];

void status_command(struct console *console, char *const *words, uint32_t number);

#endif
