/* SPDX-License-Identifier: Apache-2.0 */

/* What a reason to refuse a turn, or an alarm, means for the person at the table. */

#ifndef ARCTRUE_ADVICE_H
#define ARCTRUE_ADVICE_H

/* By the name that telemetry and status tell; NULL for any other word. */
const char *advice_for(const char *name);

#endif
