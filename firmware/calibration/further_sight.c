/* SPDX-License-Identifier: Apache-2.0 */

#include "further_orders.h"

#include <math.h>

#include "assertion.h"
#include "transfer_function.h"
#include "units.h"

/* Least 1 - |D|^2 (D: see further_orders.h) with which the sums separate the errors of the two heads; the standard
   uncertainty then grows by a factor of at most 1.4. */
#define SEPARATED 0.5
/* Limit of |<e^{j2mR}>|, above which cosine and sine of order m are no longer nearly orthogonal. */
#define NOT_ORTHOGONAL 0.3

double further_orders_shift_rad(const struct estimate *estimate) {
    return estimate->measured_separation_rad - estimate->separation_rad;
}

/* Tells whether a whole number, 1 or more, lies between `least` and `most`. Samples s turns apart cannot separate order
   m from order l if (m - l) s is a whole number. */
static bool is_whole_between(double least, double most) {
    double whole = floor(most);
    return whole >= 1.0 && whole >= least;
}

static bool is_blurred(const struct further_workspace *workspace, const struct further_order *order,
                       uint32_t fitted_orders) {
    double least = workspace->least_step;
    double most = workspace->most_step;
    double m = order->order;
    double samples = workspace->samples;
    const struct vector doubled = {2.0 * order->products.re - samples, 2.0 * order->products.im};
    bool blurred = is_whole_between((m - fitted_orders) * least, (m + fitted_orders) * most) ||
                   vector_length(doubled) > NOT_ORTHOGONAL * samples;
    for (uint32_t place = 0; place < workspace->number; place++) {
        double other = workspace->order[place].order;
        blurred = blurred || (other != m &&
                              (is_whole_between((m + other) * least, (m + other) * most) ||
                               is_whole_between(fabs(m - other) * least, fabs(m - other) * most)));
    }
    return blurred;
}

/* Converts G = cosine - j sine into a result with its variance. */
static struct sight sight_of(struct vector g, double variance, double by_separation) {
    return (struct sight){SIGHT_CLEAR, vector_conjugate(g), variance, by_separation, 0.0};
}

static double misfit(const struct sight *sight, struct vector applied) {
    return vector_square(vector_difference(sight->value, applied)) /
           (sight->variance + sight->by_separation);
}

static struct sight sight_from_sums(const struct further_workspace *workspace,
                                    const struct estimate *estimate,
                                    const struct further_order *order, double gain_limit,
                                    struct vector applied) {
    double mean = 1.0 / workspace->samples;
    double noise = estimate->noise_arcsec * estimate->noise_arcsec * fmax(estimate->colour, 1.0);
    double variance = 2.0 * noise * mean;
    struct vector turned = vector_unit(order->order * further_orders_shift_rad(estimate));
    struct vector a1 = vector_scaled(vector_conjugate(order->head1), 2.0 * mean);
    struct vector a2 =
        vector_product(vector_scaled(vector_conjugate(order->head2), 2.0 * mean), turned);
    struct vector d = vector_product(vector_scaled(order->apart, mean), vector_conjugate(turned));
    double apart = 1.0 - vector_square(d);
    if (apart >= SEPARATED) {
        struct vector g = vector_difference(vector_product(a2, d), a1);
        return sight_of(vector_scaled(g, 1.0 / apart), variance / apart, 0.0);
    }
    double both = 2.0 - 2.0 * d.re;
    double gain = noise_gain(order->order, estimate->separation_rad);
    if (!(gain <= gain_limit) || both * gain_limit * gain_limit < 1.0) {
        return (struct sight){.state = SIGHT_UNSEEN};
    }
    /* The uncertainty due to alpha is n |TF| |G| u(alpha); each component has half of its square. */
    double by_alpha = order->order * gain * estimate->u_measured_separation_rad;
    struct sight disc =
        sight_of(vector_scaled(vector_difference(a2, a1), 1.0 / both), variance / both,
                 0.5 * by_alpha * by_alpha * vector_square(applied));
    struct sight head1 = sight_of(vector_scaled(a1, -1.0), variance, 0.0);
    return misfit(&head1, applied) < misfit(&disc, applied) ? head1 : disc;
}

struct sight further_orders_sight(const struct further_workspace *workspace,
                                  const struct estimate *estimate, uint32_t order,
                                  double gain_limit, struct vector applied) {
    ASSERT(workspace->number <= LANES_LIMIT);
    for (uint32_t place = 0; place < workspace->number; place++) {
        const struct further_order *found = &workspace->order[place];
        if (found->order != order) {
            continue;
        }
        struct sight sight = sight_from_sums(workspace, estimate, found, gain_limit, applied);
        if (sight.state == SIGHT_CLEAR && is_blurred(workspace, found, estimate->orders)) {
            sight.state = SIGHT_BLURRED;
        }
        return sight;
    }
    return (struct sight){.state = SIGHT_BLURRED};
}
