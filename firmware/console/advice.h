/* SPDX-License-Identifier: Apache-2.0 */

/* Explains the words that telemetry, `status` and refused commands print (reasons, alarms, states) to the operator. */

#ifndef ARCTRUE_ADVICE_H
#define ARCTRUE_ADVICE_H

/* Returns the advice for such a word; NULL for any other word. */
const char *advice_for(const char *name);

#endif
