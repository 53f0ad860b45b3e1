/* SPDX-License-Identifier: Apache-2.0 */

/* The thermometer of the table, and loaded lanes that follow it. */

#ifndef ARCTRUE_FOLLOW_TEMPERATURE_H
#define ARCTRUE_FOLLOW_TEMPERATURE_H

#include "state.h"

/* Swaps in the loaded lanes at the table's temperature, where that changes the correction by more than the
   operator wants. Between two turns: a turn that is ready goes first. */
void follow_between_turns(struct application *application);

/* Reads the table's thermometer, with the time constant of the model in use. */
void follow_thermometer(struct application *application);

/* The temperature in the middle of the turn that was taken: the estimate of a turn is that of its middle, and by now the table is warmer. */
void follow_middle_of_turn(struct application *application);

#endif
