/* SPDX-License-Identifier: Apache-2.0 */

#ifndef ARCTRUE_TELEMETRY_H
#define ARCTRUE_TELEMETRY_H

#include "application.h"
#include "text.h"

/* Prints the latest turn as one line of JSON with `alarms`; if the turn was not refused, the line also contains its
   harmonics. If the turn has been printed already, the line contains only the turn's number, `alarms`, the number of
   swaps, released line drivers and heads that are left out. Prints nothing and returns false if the sink has no room
   for the whole line. */
bool telemetry_turn(const struct text_sink *sink, const struct application *application,
                    uint32_t alarms);

#endif
