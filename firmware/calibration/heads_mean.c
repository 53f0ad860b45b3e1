/* SPDX-License-Identifier: Apache-2.0 */

#include "heads_fit.h"

#include <math.h>

#include "arctrue_number_formats.h"
#include "assertion.h"
#include "units.h"

/* Number of readings per turn: more than 16 per wave of the highest order. */
enum { READINGS = 1024, ROUNDS = 6 };
#define WEIGHT_ONE ((double)(1 << ARCTRUE_HEAD_WEIGHT_FRACTION))
#define OFFSET_ONE ((double)(1 << ARCTRUE_HEAD_OFFSET_FRACTION))
#define AMPLITUDE_ONE ((double)(1 << ARCTRUE_AMPLITUDE_FRACTION))

struct mean_error {
    const struct unit_circle *circle;
    const struct estimate *disc;
    const struct heads_geometry *geometry;
    const struct mean_set *set;
    /* Angle p_i of each head, turns: without errors, the head at table angle theta reads the angle theta + p_i of the
       disc. */
    double place_turns[HEADS_MOST];
    /* Sum of the error over all readings, arcsec. */
    double *sum;
};

/* Returns the error g_i of a head at the reading `turns` of the disc, arcsec: the error of the disc, whose order 1 is
   multiplied by the ratio of the radii. */
static double error_under(const struct mean_error *error, uint32_t head, double turns) {
    struct vector unit = unit_circle_at(error->circle, turns);
    struct vector power = unit;
    const struct harmonic *harmonic = error->disc->harmonic;
    double total = (error->geometry->ratio[head] - 1.0) *
                   (harmonic[0].cosine * unit.re + harmonic[0].sine * unit.im);
    for (uint32_t place = 0; place < error->disc->orders; place++) {
        total += harmonic[place].cosine * power.re + harmonic[place].sine * power.im;
        power = vector_product(power, unit);
    }
    return total;
}

/* Returns E = sum of w_i g_i(y_i) at the reading r_s of the carrier, the head s that the mean follows, with theta = r_s
   - g_s and y_i = theta + p_i + g_i(y_i). */
static double error_of_mean(const void *context, uint32_t sample) {
    const struct mean_error *error = context;
    double reading = (double)sample / READINGS;
    uint32_t carrier = error->set->carrier;
    double angle = reading - error_under(error, carrier, reading + error->place_turns[carrier]) /
                                 ARCSEC_PER_TURN;
    double total = 0.0;
    for (uint32_t head = 0; head < error->geometry->heads; head++) {
        if (error->set->weight[head] == 0) {
            continue;
        }
        double nominal = angle + error->place_turns[head];
        double under = 0.0;
        /* Each round multiplies the error of y by the slope of g, which is below 0.01. */
        for (uint32_t round = 0; round < ROUNDS; round++) {
            under = error_under(error, head, nominal + under / ARCSEC_PER_TURN);
        }
        total += error->set->weight[head] / WEIGHT_ONE * under;
    }
    *error->sum += total;
    return total;
}

/* Returns the factor of order n in the mean, sum w_i e^{jnp_i}; the terms of order 1 are multiplied by the ratio of the
   radii. */
static struct vector factor_of(const struct mean_error *error, uint32_t order) {
    struct vector factor = {0.0, 0.0};
    for (uint32_t head = 0; head < error->geometry->heads; head++) {
        double ratio = order == 1 ? error->geometry->ratio[head] : 1.0;
        struct vector at = vector_unit(2.0 * PI * order * error->place_turns[head]);
        factor =
            vector_sum(factor, vector_scaled(at, ratio * error->set->weight[head] / WEIGHT_ONE));
    }
    return factor;
}

/* Returns the variance of a component of an order that is due to the uncertainties of places and radii. */
static double square_by_places(const struct mean_error *error, const struct heads_found *found,
                               uint32_t order) {
    double amplitude = harmonic_amplitude(&error->disc->harmonic[order - 1]);
    double square = 0.0;
    for (uint32_t head = 0; head < error->geometry->heads; head++) {
        double weight = error->set->weight[head] / WEIGHT_ONE * amplitude;
        double place = order * weight * found->u_late_arcsec[head] / ARCSEC_PER_RAD;
        double ratio = order == 1 ? weight * found->u_ratio[head] : 0.0;
        square += place * place + ratio * ratio;
    }
    return 0.5 * square;
}

void heads_estimate_of_mean(struct heads_workspace *workspace, const struct heads_found *found,
                            uint32_t counts_per_rev, struct mean_set *set,
                            struct estimate *estimate) {
    ASSERT(estimate->orders <= ORDERS_MAX && set->carrier < HEADS_MOST);
    double sum = 0.0;
    double squares;
    struct mean_error error = {
        .circle = &workspace->circle,
        .disc = estimate,
        .geometry = &found->geometry,
        .set = set,
        .sum = &sum,
    };
    for (uint32_t head = 0; head < found->geometry.heads; head++) {
        error.place_turns[head] = set->offset[head] / (OFFSET_ONE * counts_per_rev) +
                                  found->geometry.late_rad[head] / (2.0 * PI);
    }
    lines_transform(&workspace->lines, estimate->orders, &workspace->circle, error_of_mean, &error,
                    READINGS, &squares);
    for (uint32_t place = 0; place < estimate->orders; place++) {
        struct harmonic *harmonic = &estimate->harmonic[place];
        double weight = vector_square(factor_of(&error, place + 1));
        double by_places = sqrt(square_by_places(&error, found, place + 1));
        *harmonic = (struct harmonic){
            .seen = harmonic->seen,
            .cosine = workspace->lines.sum[place].re * (2.0 / READINGS),
            .sine = -workspace->lines.sum[place].im * (2.0 / READINGS),
            /* The heads' positions rotate cosine and sine into each other, so both get the mean of both variances. */
            .variance_cosine = 0.5 * weight * (harmonic->variance_cosine + harmonic->variance_sine),
            .variance_sine = 0.5 * weight * (harmonic->variance_cosine + harmonic->variance_sine),
            .by_separation_cosine = by_places,
            .by_separation_sine = by_places,
            .noise_gain = harmonic->noise_gain * sqrt(weight),
        };
    }
    double counts = sum / READINGS * counts_per_rev / ARCSEC_PER_TURN;
    set->error_offset = (int32_t)rint(counts * AMPLITUDE_ONE);
}
