/* SPDX-License-Identifier: Apache-2.0 */

#ifndef ARCTRUE_TELEMETRY_H
#define ARCTRUE_TELEMETRY_H

#include "application.h"
#include "text.h"

/* The latest turn as one line of JSON, with these alarms; the harmonics only where there are any. False:
   the sink has no room for all of it, and nothing is told. */
bool telemetry_turn(const struct text_sink *sink, const struct application *application,
                    uint32_t alarms);

#endif
