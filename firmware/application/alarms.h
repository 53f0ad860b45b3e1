/* SPDX-License-Identifier: Apache-2.0 */

/* Raises the operator's alarms, both at the end of a turn and between two turns. */

#ifndef ARCTRUE_ALARMS_H
#define ARCTRUE_ALARMS_H

#include "state.h"

/* Raises an alarm, which the console prints with the next turn or in a line of its own. */
void alarm_between_turns(struct application *application, uint32_t alarm);

/* Returns the alarms of the turn that the report describes, as bits of enum alarm. Also stores the state of the output
   in the report. */
uint32_t alarms_of_turn(struct application *application);

/* Returns the name of the alarm at a bit; NULL for a bit that is no alarm. */
const char *alarm_name(uint32_t bit);

#endif
