/* SPDX-License-Identifier: Apache-2.0 */

/* The angle between the heads: what the capture says of it, and whether to believe that.

   The mean of head 2 less head 1 over uniform true angle is the true separation; it is good to
   the index's repeatability of one count. An index that is not found at all shows as a value far
   from nominal. */

#ifndef ARCTRUE_SEPARATION_H
#define ARCTRUE_SEPARATION_H

#include <stdbool.h>
#include <stdint.h>

enum separation_choice { SEPARATION_AUTOMATIC, SEPARATION_MEASURED, SEPARATION_NOMINAL };

#define SEPARATION_TOLERANCE_ARCSEC 50.0
/* 0.25 degrees, 0.24 mm at the disc: no head is mounted so badly, the index is at fault. */
#define SEPARATION_BELIEVABLE_ARCSEC 900.0

/* Resolve SEPARATION_AUTOMATIC. */
enum separation_choice separation_judge(double nominal_rad, double measured_rad,
                                        enum separation_choice asked);

/* The heads are as far apart as they should be, the other way round: each sees what the other
   should. Not where both ways are the same. */
bool separation_is_exchanged(double nominal_rad, double measured_rad);

/* Standard uncertainty of the value that `choice` takes. */
double separation_uncertainty_rad(enum separation_choice choice, int32_t counts_per_rev);

/* Standard uncertainty by the index: rectangular over one count to each side. */
double index_uncertainty_rad(int32_t counts_per_rev);

#endif
