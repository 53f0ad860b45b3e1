/* SPDX-License-Identifier: Apache-2.0 */

/* The operator's commands that change what the application does. */

#ifndef ARCTRUE_OPERATOR_H
#define ARCTRUE_OPERATOR_H

#include "state.h"

/* From the host, a source, or none. */
void application_tell_temperature(struct application *application, double celsius);
void application_choose_temperature(struct application *application,
                                    enum temperature_source source);

/* The operator's commands. */
void application_freeze(struct application *application, bool frozen);
void application_bypass(struct application *application, bool bypassed);
void application_telemetry(struct application *application, bool on);

/* The next turn is copied for the console, with times: it is captured at equal ones. */
void application_want_dump(struct application *application);

/* All frames of a set have come; what load_end() says. */
enum load_answer application_load_end(struct application *application, uint32_t crc);

/* As parameters_set(), and does what a new value asks for. */
enum parameter_answer application_set(struct application *application, const char *name,
                                      double value,
                                      const struct parameter_description **description);

#endif
