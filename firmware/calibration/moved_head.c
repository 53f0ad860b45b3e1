/* SPDX-License-Identifier: Apache-2.0 */

#include "moved_head.h"

#include <math.h>

#include "assertion.h"
#include "units.h"

/* Largest motion of the axis, as an angle on the paper's radius of the disc: 5 um on 53.975 mm. */
#define AXIS_LIMIT_RAD (5e-3 / 53.975)
/* Standard uncertainty of a change of an offset; and the largest RMS of unexplained changes, as a multiple of this
   uncertainty. */
#define U_CHANGE_RAD (0.1 / ARCSEC_PER_RAD)
#define UNEXPLAINED_MOST 4.0

static double wrapped(double angle) {
    return angle - 2.0 * PI * rint(angle / (2.0 * PI));
}

/* Returns |c|, the motion of the axis in the model change_i = z + Im(c s_i). s_i is the result of heads_sight() for a
   head, and z is a change of the zero of all readings. The differences from head 1, which do not contain z, determine c
   by least squares. */
static double axis_motion(const struct heads_geometry *geometry, const double change[HEADS_MOST]) {
    struct vector first = heads_sight(geometry, 0);
    double re_re = 0.0;
    double re_im = 0.0;
    double im_im = 0.0;
    double right_re = 0.0;
    double right_im = 0.0;
    for (uint32_t head = 1; head < HEADS_MOST; head++) {
        struct vector sight = heads_sight(geometry, head);
        double re = sight.re - first.re;
        double im = sight.im - first.im;
        double apart = change[head] - change[0];
        re_re += re * re;
        re_im += re * im;
        im_im += im * im;
        right_re += re * apart;
        right_im += im * apart;
    }
    double determinant = re_re * im_im - re_im * re_im;
    ASSERT(determinant > 0.0);
    const struct vector motion = {(im_im * right_re - re_im * right_im) / determinant,
                                  (re_re * right_im - re_im * right_re) / determinant};
    return vector_length(motion);
}

struct moved_head moved_head_find(const struct heads_geometry *geometry,
                                  const double offset_rad[HEADS_MOST]) {
    struct moved_head found = {0, 0.0};
    double parity[COMBINATIONS_MOST][HEADS_MOST];
    double change[HEADS_MOST];
    double unexplained = 0.0;
    uint32_t explanations = 0;
    if (geometry->heads != HEADS_MOST || heads_combinations(geometry, parity) == 0) {
        return found;
    }
    for (uint32_t head = 0; head < HEADS_MOST; head++) {
        double apart = geometry->offset_rad[head] - geometry->offset_rad[0] -
                       (offset_rad[head] - offset_rad[0]);
        change[head] = wrapped(apart);
        unexplained += parity[0][head] * change[head];
    }
    /* The left side is the RMS over the heads of the changes that neither the zero nor the axis explains. */
    if (fabs(unexplained) / sqrt((double)HEADS_MOST) <= UNEXPLAINED_MOST * U_CHANGE_RAD) {
        return found;
    }
    for (uint32_t head = 0; head < HEADS_MOST; head++) {
        double moved = unexplained / parity[0][head];
        double before = change[head];
        change[head] -= moved;
        if (axis_motion(geometry, change) <= AXIS_LIMIT_RAD) {
            explanations++;
            found = (struct moved_head){head + 1, moved};
        }
        change[head] = before;
    }
    return explanations == 1 ? found : (struct moved_head){0, 0.0};
}
