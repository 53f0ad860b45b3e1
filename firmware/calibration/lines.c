/* SPDX-License-Identifier: Apache-2.0 */

#include "lines.h"

#include <stddef.h>

#include "assertion.h"

uint32_t lines_wanted(uint32_t orders, uint32_t samples) {
    uint32_t most = samples == 0 ? 0 : (samples - 1) / 2;
    uint32_t wanted = orders + NOISE_LINES;
    return wanted < most ? wanted : most;
}

/* Adds samples k and K - k together, because they have the same cosines and opposite sines. */
static void lines_add_pair(struct lines *lines, struct vector step, double sum, double difference) {
    struct vector power = step;
    for (uint32_t place = 0; place < lines->number; place++) {
        lines->sum[place].re += sum * power.re;
        lines->sum[place].im -= difference * power.im;
        power = vector_product(power, step);
    }
}

void lines_transform(struct lines *lines, uint32_t number, const struct unit_circle *circle,
                     line_sample *sample, const void *context, uint32_t samples,
                     double *sum_of_squares) {
    ASSERT(samples > 0 && number <= LINES_MAX);
    *lines = (struct lines){.number = number};
    double squares = 0.0;
    for (uint32_t near = 0; near <= samples / 2; near++) {
        uint32_t far = (samples - near) % samples;
        struct vector step = unit_circle_at(circle, (double)near / samples);
        double first = sample(context, near);
        squares += first * first;
        if (far == near) {
            lines_add_pair(lines, step, first, 0.0);
            continue;
        }
        double second = sample(context, far);
        squares += second * second;
        lines_add_pair(lines, step, first + second, first - second);
    }
    *sum_of_squares = squares;
}

double lines_noise_power(const struct lines *lines, const struct estimate *estimate,
                         uint32_t samples) {
    ASSERT(samples > 0 && lines->number <= LINES_MAX && estimate->orders <= ORDERS_MAX);
    double power = 0.0;
    uint32_t used = 0;
    for (uint32_t line = 1; line <= lines->number && used < NOISE_LINES; line++) {
        bool fitted = line <= estimate->orders && estimate->harmonic[line - 1].seen;
        if (!fitted) {
            power += vector_square(lines->sum[line - 1]) / samples;
            used++;
        }
    }
    return used == 0 ? 0.0 : power / used;
}
