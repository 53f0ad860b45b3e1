/* SPDX-License-Identifier: Apache-2.0 */

#include "head_skew.h"

#include <math.h>

#include "separation.h"

/* Least difference of two speeds, as a share of the faster one. */
#define SPEEDS_APART 0.2
#define NS_PER_S 1e9

void head_skew_add(struct head_skew *skew, const struct skew_turn *turn) {
    const struct skew_turn *last = &skew->last;
    double apart = turn->speed - last->speed;
    double faster = fmax(fabs(turn->speed), fabs(last->speed));
    if (last->speed != 0.0 && turn->speed != 0.0 && fabs(apart) > SPEEDS_APART * faster) {
        skew->heads = turn->heads < last->heads ? turn->heads : last->heads;
        for (uint32_t head = 0; head < skew->heads; head++) {
            double moved = remainder_of_turn(turn->offset_rad[head] - last->offset_rad[head]);
            skew->late_ns[head] = -moved / apart * NS_PER_S;
        }
        skew->u_ns = sqrt(turn->variance + last->variance) / fabs(apart) * NS_PER_S;
    }
    skew->last = *turn;
}
