/* SPDX-License-Identifier: Apache-2.0 */

#ifndef ARCTRUE_TELEMETRY_H
#define ARCTRUE_TELEMETRY_H

#include "application.h"
#include "text.h"

/* The latest turn as one line of JSON; the harmonics only where there are any. */
void telemetry_turn(const struct text_sink *sink, const struct application *application);

#endif
