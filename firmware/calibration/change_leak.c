/* SPDX-License-Identifier: Apache-2.0 */

#include "change_leak.h"

#include <math.h>

#include "transfer_function.h"
#include "units.h"

/* Order 1 that grows by c from one end of the turn to the other is, as a sawtooth times a cosine, at
   order n c/2pi (1/(n - 1) + 1/(n + 1)) in head 2 less head 1, less than c/2n; of order 1 itself c/4pi is
   left at the value of the turn's middle. */
double change_leak_arcsec(double change_arcsec, uint32_t order, double separation_rad) {
    double gain = noise_gain(order, separation_rad) / noise_gain(1, separation_rad);
    double share = order == 1 ? 1.0 / (4.0 * PI) : 0.5 / order;
    return change_arcsec * gain * share * sqrt(0.5);
}

void change_leak_set(struct estimate *estimate, double change_arcsec) {
    for (uint32_t place = 0; place < estimate->orders; place++) {
        struct harmonic *harmonic = &estimate->harmonic[place];
        harmonic->by_change =
            place > 0 && harmonic->seen && change_arcsec > 0.0
                ? change_leak_arcsec(change_arcsec, place + 1, estimate->separation_rad)
                : 0.0;
    }
}
