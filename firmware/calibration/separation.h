/* SPDX-License-Identifier: Apache-2.0 */

/* Decides between the measured and the nominal angle between the heads, and states the uncertainty.

   The mean of head 2 minus head 1 over uniform true angle is the true separation. Its uncertainty comes from the
   repeatability of both indices, one count each, and from the difference between the places where the heads detect
   the mark (10 um at the disc are 38 arcsec). If an index pulse is false, the value is far from nominal. */

#ifndef ARCTRUE_SEPARATION_H
#define ARCTRUE_SEPARATION_H

#include <math.h>
#include <stdbool.h>

#include "units.h"
#include <stdint.h>

enum separation_choice { SEPARATION_AUTOMATIC, SEPARATION_MEASURED, SEPARATION_NOMINAL };

/* Tolerance of the heads' mounting to each side, and its standard uncertainty for a rectangular distribution. */
#define SEPARATION_TOLERANCE_ARCSEC 50.0
#define SEPARATION_TOLERANCE_U_ARCSEC (SEPARATION_TOLERANCE_ARCSEC / 1.7320508075688772)
/* Largest believable deviation from nominal, 0.25 degrees or 0.24 mm at the disc: no mounting has such an error, so a
   larger deviation means a fault of the index. */
#define SEPARATION_BELIEVABLE_ARCSEC 900.0

/* Decides between the measured and the nominal separation if the choice is automatic. */
enum separation_choice separation_judge(double nominal_rad, double measured_rad,
                                        enum separation_choice asked);

/* Removes whole turns: the result is within half a turn. The library's remainder() would need as much code as all of
   separation.c. */
static inline double remainder_of_turn(double angle_rad) {
    double turns = angle_rad / (2.0 * PI);
    return (turns - rint(turns)) * 2.0 * PI;
}

/* Tells whether the measured separation is near minus the nominal separation, the value that exchanged heads would
   give. Returns false if it is also near the nominal separation. */
bool separation_is_exchanged(double nominal_rad, double measured_rad);

/* Returns the standard uncertainty of the value that `choice` selects. */
double separation_uncertainty_rad(enum separation_choice choice, int32_t counts_per_rev,
                                  double index_detection_arcsec);

/* Returns the standard uncertainty of head 2 minus head 1 due to their indices: each repeats within a count to each
   side (rectangular), and `index_detection_arcsec` is the standard uncertainty of the difference between the places
   where the heads detect the mark. */
double index_uncertainty_rad(int32_t counts_per_rev, double index_detection_arcsec);

#endif
