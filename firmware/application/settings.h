/* SPDX-License-Identifier: Apache-2.0 */

/* The operator's settings, kept where they outlive a fault. */

#ifndef ARCTRUE_SETTINGS_H
#define ARCTRUE_SETTINGS_H

#include "state.h"

/* As they are now. */
struct settings settings_present(const struct application *application);

/* Writes them where they are kept. Before an order is carried out: a fault in between then begins anew with the order. */
void settings_keep(struct application *application);

/* Uses those that were kept or saved. */
void settings_take(struct application *application, const struct settings *settings);

/* Takes the kept ones after a fault. Where they are lost nobody knows whether the correction may be switched on. */
void settings_recover(struct application *application);

#endif
