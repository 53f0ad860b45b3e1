/* SPDX-License-Identifier: Apache-2.0 */

/* How far a change of order 1 within a turn (heat moves the centre) reaches the other orders. */

#ifndef ARCTRUE_CHANGE_LEAK_H
#define ARCTRUE_CHANGE_LEAK_H

#include <stdint.h>

#include "estimate.h"

/* Standard deviation, arcsec, of a component of `order` where order 1 changes by `change_arcsec` from one
   end of the turn to the other. */
double change_leak_arcsec(double change_arcsec, uint32_t order, double separation_rad);

/* Writes by_change of every order of the estimate: 0 for order 1, whose change it is, and for orders not seen. */
void change_leak_set(struct estimate *estimate, double change_arcsec);

#endif
