/* SPDX-License-Identifier: Apache-2.0 */

/* Carries out the operator's commands that change the application's behaviour. */

#ifndef ARCTRUE_OPERATOR_H
#define ARCTRUE_OPERATOR_H

#include "state.h"

/* These functions take the table's temperature from the host, and select the source of this temperature. */
void application_tell_temperature(struct application *application, double celsius);
void application_choose_temperature(struct application *application,
                                    enum temperature_source source);

/* These functions switch a function on or off as the operator commands: the freezing of the coefficients, the bypass of
   the correction, and the telemetry. */
void application_freeze(struct application *application, bool frozen);
void application_bypass(struct application *application, bool bypassed);
void application_telemetry(struct application *application, bool on);

/* Requests a copy of the next turn for the console. If the capture takes samples at equal angles, it restarts and takes
   them at equal intervals of time, so that the time of each sample in the copy is known. */
void application_want_dump(struct application *application);

/* Ends the reception of a set after its last frame; returns the answer of load_end(). */
enum load_answer application_load_end(struct application *application, uint32_t crc);

/* Sets a parameter like parameters_set(), and carries out the effect of the new value. */
enum parameter_answer application_set(struct application *application, const char *name,
                                      double value,
                                      const struct parameter_description **description);

#endif
