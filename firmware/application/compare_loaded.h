/* SPDX-License-Identifier: Apache-2.0 */

#ifndef ARCTRUE_COMPARE_LOADED_H
#define ARCTRUE_COMPARE_LOADED_H

#include "state.h"

/* Compares the loaded orders and the loaded local table with the turn. Call it before the turn is averaged, because an
   average would lag behind an order that changes. */
void compare_loaded(struct application *application, const struct turn *turn);
/* Adds the error that remains at the loaded orders to both predictions, because these orders keep this error with
   either choice of coefficients. */
void compare_loaded_add(struct application *application);

#endif
