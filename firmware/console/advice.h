/* SPDX-License-Identifier: Apache-2.0 */

/* Explains a reason to refuse a turn, or an alarm, to the person at the table. */

#ifndef ARCTRUE_ADVICE_H
#define ARCTRUE_ADVICE_H

/* Returns the advice for a name that telemetry or status prints; NULL for any other word. */
const char *advice_for(const char *name);

#endif
