/* SPDX-License-Identifier: Apache-2.0 */

/* What the operator is told at once: alarms of a turn, and between two turns. */

#ifndef ARCTRUE_ALARMS_H
#define ARCTRUE_ALARMS_H

#include "state.h"

/* Raises an alarm that is told with the turn that is told next, or else in a line of its own. */
void alarm_between_turns(struct application *application, uint32_t alarm);

/* Alarms of the turn in the report, of enum alarm. */
uint32_t alarms_of_turn(struct application *application);

/* NULL for a bit that is no alarm. */
const char *alarm_name(uint32_t bit);

#endif
