/* SPDX-License-Identifier: Apache-2.0 */

/* The operator's settings, kept where they survive a fault. */

#ifndef ARCTRUE_SETTINGS_H
#define ARCTRUE_SETTINGS_H

#include "state.h"

/* Returns the present settings. */
struct settings settings_present(const struct application *application);

/* Keeps the present settings. Call it before an order is carried out: after a fault in between, the firmware then
   restarts with the order. */
void settings_keep(struct application *application);

/* Applies kept or saved settings. */
void settings_take(struct application *application, const struct settings *settings);

/* Applies the kept settings after a fault. If they are lost, it is not known whether the correction may be switched
   on. */
void settings_recover(struct application *application);

#endif
