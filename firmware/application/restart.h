/* SPDX-License-Identifier: Apache-2.0 */

/* The first start, the start after a fault, and the operator's re-arm. */

#ifndef ARCTRUE_RESTART_H
#define ARCTRUE_RESTART_H

#include "state.h"

/* At power-on the settings are those that were saved. After a fault they are those that were
   kept; or else, with bypass on, the saved ones. What is not there is preset. Kept from now on. */
void application_recover(struct application *application, bool after_fault);

/* The first start. After a fault index, coefficients and correction of the core stay. After several
   faults in a row, and where the settings are lost while a correction is at work, nothing is worked on
   until application_rearm(), and the core stays as it is. */
void application_begin(struct application *application);

/* Find the core and set it up; the phase tells whether it is there. */
void application_start(struct application *application);

/* The operator wants it to begin anew: faults of before are forgotten. */
void application_rearm(struct application *application);

/* Correction off and nothing known, of the calibration and of what was loaded. */
void application_forget(struct application *application);

/* Forgets what turns have shown, and takes the correction off. What was loaded is judged anew; it need not come again. */
void restart_with_nothing(struct application *application);

#endif
