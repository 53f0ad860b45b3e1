/* SPDX-License-Identifier: Apache-2.0 */

/* The angle between the heads: what the capture says of it, and whether to believe that.

   The mean of head 2 less head 1 over uniform true angle is the true separation. It is good to the
   repeatability of both indices, a count each, and to what differs between the places where the
   heads detect the mark (10 um at the disc are 38 arcsec). An index that is not found at all shows
   as a value far from nominal. */

#ifndef ARCTRUE_SEPARATION_H
#define ARCTRUE_SEPARATION_H

#include <math.h>
#include <stdbool.h>

#include "units.h"
#include <stdint.h>

enum separation_choice { SEPARATION_AUTOMATIC, SEPARATION_MEASURED, SEPARATION_NOMINAL };

/* Of the heads' mounting, to each side; its standard uncertainty, rectangular: less 1/sqrt(3). */
#define SEPARATION_TOLERANCE_ARCSEC 50.0
#define SEPARATION_TOLERANCE_U_ARCSEC (SEPARATION_TOLERANCE_ARCSEC / 1.7320508075688772)
/* 0.25 degrees, 0.24 mm at the disc: no head is mounted so badly, the index is at fault. */
#define SEPARATION_BELIEVABLE_ARCSEC 900.0

/* Resolve SEPARATION_AUTOMATIC. */
enum separation_choice separation_judge(double nominal_rad, double measured_rad,
                                        enum separation_choice asked);

/* Less whole turns, to half a turn on each side. The library's remainder() is as long as this whole folder's
   separation. */
static inline double remainder_of_turn(double angle_rad) {
    double turns = angle_rad / (2.0 * PI);
    return (turns - rint(turns)) * 2.0 * PI;
}

/* The heads are as far apart as they should be, the other way round: each sees what the other
   should. Not where both ways are the same. */
bool separation_is_exchanged(double nominal_rad, double measured_rad);

/* Standard uncertainty of the value that `choice` takes. */
double separation_uncertainty_rad(enum separation_choice choice, int32_t counts_per_rev,
                                  double index_detection_arcsec);

/* Standard uncertainty of head 2 less head 1 by their indices: each repeats within a count to each
   side, rectangular; `index_detection_arcsec` is the standard uncertainty of where they are. */
double index_uncertainty_rad(int32_t counts_per_rev, double index_detection_arcsec);

#endif
