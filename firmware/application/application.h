/* SPDX-License-Identifier: Apache-2.0 */

/* What the processor does for ever: wait for the index, capture, verify, calibrate, write the
   idle bank, swap, monitor. One call of application_step() does one piece of it and returns. */

#ifndef ARCTRUE_APPLICATION_H
#define ARCTRUE_APPLICATION_H

#include "alarms.h"
#include "operator.h"
#include "release.h"
#include "restart.h"
#include "saving.h"
#include "state.h"

/* Parameters at their presets, nothing known. */
void application_prepare(struct application *application, const struct core_access *core);

/* Where the temperature of a turn comes from. */
void application_use_temperature(struct application *application, temperature_read *read,
                                 void *context);

/* Where the temperature of the table comes from, unless the operator says otherwise. */
void application_use_thermometer(struct application *application, temperature_read *read,
                                 void *context);

/* Where the operator's settings are kept; `settle` is called after each write. */
void application_keep_settings(struct application *application, struct kept_settings *kept,
                               memory_settle *settle);

/* Where captures are copied to. */
void application_use_copy(struct application *application, struct capture_copy *copy);

/* Where settings and coefficients are saved. */
void application_use_flash(struct application *application, struct save *save);

/* One piece of work; never waits. A calibration is one piece. */
void application_step(struct application *application);

/* The core has interrupted: call before the step that this is to cause. The interrupt says when to
   look, not what is there; a step without one finds the same, so a lost one costs time only. */
void application_interrupt(struct application *application);

/* There is more to do at once: do not sleep before the next step. */
bool application_busy(const struct application *application);

#endif
