/* SPDX-License-Identifier: Apache-2.0 */

/* Prints all data of the heads, for their commissioning: a row for each head. */

#ifndef ARCTRUE_HEADS_TABLE_H
#define ARCTRUE_HEADS_TABLE_H

#include "console.h"

/* The columns: number of the head; `up` or `down`, its sense in the latest capture or, before a capture, since its
   index; `seen` or `unseen`, its index; place after head 1 in degrees and its standard uncertainty in arcsec; source of
   the place: `fit` (the latest turn calibrated the mean), `turn` (mean over a turn) or `index` (one reading, with the
   eccentricity); number of the planned head at this place; delay against head 1 and its standard uncertainty in ns;
   radius divided by the nominal radius and its standard uncertainty. `-` is a value that is not known. */
void heads_table_show(struct console *console);

#endif
