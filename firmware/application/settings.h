/* SPDX-License-Identifier: Apache-2.0 */

/* Keeps the operator's settings in memory that survives a fault. */

#ifndef ARCTRUE_SETTINGS_H
#define ARCTRUE_SETTINGS_H

#include "state.h"

/* Returns the present settings. */
struct settings settings_present(const struct application *application);

/* Keeps the present settings. Call it before the firmware carries out an order of the operator: after a fault in
   between, the firmware then restarts with the ordered settings. */
void settings_keep(struct application *application);

/* Applies kept or saved settings. */
void settings_take(struct application *application, const struct settings *settings);

/* Applies the kept settings after a fault. If these are lost, switches the bypass on, because it is then unknown
   whether the operator allows the correction. */
void settings_recover(struct application *application);

#endif
