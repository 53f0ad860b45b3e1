/* SPDX-License-Identifier: Apache-2.0 */

#include "axis_motion.h"

#include <math.h>

#include "assertion.h"

/* Weight of the former turns at each new turn, so that the mean covers about 20 turns. */
#define AXIS_KEEP 0.95

void axis_begin(struct axis_sums *sums, const struct heads_geometry *geometry, uint32_t orders) {
    uint32_t heads = geometry->heads;
    struct vector sight[HEADS_MOST];
    struct vector mean = {0.0, 0.0};
    double re_re = 0.0;
    double re_im = 0.0;
    double im_im = 0.0;
    ASSERT(heads > 2 && heads <= HEADS_MOST && orders > 0 && orders <= ORDERS_MAX);
    *sums = (struct axis_sums){.orders = orders};
    for (uint32_t head = 0; head < heads; head++) {
        sight[head] = heads_sight(geometry, head);
        mean = vector_sum(mean, vector_scaled(sight[head], 1.0 / heads));
    }
    /* The table's rotation is common to all heads, so the mean is subtracted. */
    for (uint32_t head = 0; head < heads; head++) {
        struct vector *own = &sight[head];
        *own = vector_difference(*own, mean);
        re_re += own->re * own->re;
        re_im += own->re * own->im;
        im_im += own->im * own->im;
    }
    /* Head i reads x im + y re. */
    double scale = 1.0 / (re_re * im_im - re_im * re_im);
    for (uint32_t head = 0; head < heads; head++) {
        struct vector own = vector_scaled(sight[head], scale);
        sums->by[head] =
            (struct vector){re_re * own.im - re_im * own.re, im_im * own.re - re_im * own.im};
    }
}

struct vector axis_of_heads(const struct axis_sums *sums, const double value[HEADS_MOST]) {
    struct vector motion = {0.0, 0.0};
    for (uint32_t head = 0; head < HEADS_MOST; head++) {
        motion = vector_sum(motion, vector_scaled(sums->by[head], value[head]));
    }
    return motion;
}

void axis_add(struct axis_sums *sums, const double residual[HEADS_MOST], struct vector unit1,
              double weight) {
    struct vector motion = axis_of_heads(sums, residual);
    struct vector power = {weight, 0.0};
    sums->squares += weight * vector_square(motion);
    for (uint32_t order = 0; order <= sums->orders; order++) {
        sums->x[order] = vector_sum(sums->x[order], vector_scaled(power, motion.re));
        sums->y[order] = vector_sum(sums->y[order], vector_scaled(power, motion.im));
        power = vector_product(power, vector_conjugate(unit1));
    }
}

double axis_of_order(const struct axis_sums *sums, const struct heads_geometry *geometry,
                     uint32_t order) {
    struct vector ahead = {0.0, 0.0};
    struct vector against = {0.0, 0.0};
    for (uint32_t head = 0; head < geometry->heads; head++) {
        double place = geometry->offset_rad[head] + geometry->late_rad[head];
        struct vector unit = vector_unit(order * place);
        ahead = vector_sum(ahead, vector_product(sums->by[head], unit));
        against = vector_sum(against, vector_product(sums->by[head], vector_conjugate(unit)));
    }
    return vector_square(ahead) + vector_square(against);
}

/* Returns the line of the motion at an order: the line of x plus j times the line of y. */
static struct vector line_at(const struct axis_sums *sums, int32_t order) {
    uint32_t place = (uint32_t)(order < 0 ? -order : order);
    struct vector x = sums->x[place];
    struct vector y = sums->y[place];
    return order < 0 ? (struct vector){x.re + y.im, y.re - x.im}
                     : (struct vector){x.re - y.im, x.im + y.re};
}

static struct vector fitted_at(const struct axis_turn *turn, int32_t order) {
    switch (order) {
    case 0:
        return turn->still;
    case 1:
        return turn->forward;
    case -1:
        return turn->backward;
    default:
        return (struct vector){0.0, 0.0};
    }
}

/* Returns the result from two mean squares. `left`: mean square of the motion between the lines. `changed`: mean square
   of the differences between the turn's lines and the lines of the mean, divided by 1 + v. `v`: variance of the mean
   divided by the variance of one turn; it adds v (2 + v)/(1 + v)^2 changed^2 to the variance of the result if one line
   has all of the motion, and less with more lines. */
static struct axis_asynchronous result(const struct axis_sums *sums, const struct axis_turn *turn,
                                       double left, double changed, double v) {
    double xx = 0.0;
    double xy = 0.0;
    double yy = 0.0;
    double samples = turn->samples;
    for (uint32_t head = 0; head < HEADS_MOST; head++) {
        xx += sums->by[head].re * sums->by[head].re;
        xy += sums->by[head].re * sums->by[head].im;
        yy += sums->by[head].im * sums->by[head].im;
    }
    double noise = turn->variance * (xx + yy);
    double square = fmax(left + changed - noise - turn->variance * turn->of_disc, 0.0);
    double freedom = samples - 2.0 * sums->orders;
    double of_noise = 2.0 * turn->variance * turn->variance * (xx * xx + 2.0 * xy * xy + yy * yy);
    double variance = (of_noise + 2.0 * noise * square) / samples + 2.0 * noise * noise / freedom +
                      v * (2.0 + v) * changed * changed / ((1.0 + v) * (1.0 + v));
    double arcsec = sqrt(square);
    return (struct axis_asynchronous){true, arcsec, sqrt(square + sqrt(variance)) - arcsec};
}

struct axis_asynchronous axis_end(const struct axis_sums *sums, const struct axis_turn *turn,
                                  struct axis_mean *mean) {
    const int32_t orders = (int32_t)sums->orders;
    const bool first = mean->orders != sums->orders;
    double left = sums->squares;
    double changed = 0.0;
    double share = 1.0 / (first ? 1.0 : AXIS_KEEP * mean->turns + 1.0);
    double v = mean->variance;
    for (int32_t order = -orders; order <= orders; order++) {
        struct vector *former = &mean->line[order + orders];
        struct vector line = line_at(sums, order);
        left -= vector_square(line);
        line = vector_sum(line, fitted_at(turn, order));
        struct vector change = vector_difference(line, *former);
        changed += vector_square(change);
        *former = first ? line : vector_sum(*former, vector_scaled(change, share));
    }
    mean->orders = sums->orders;
    mean->turns = 1.0 / share;
    mean->variance = first ? 1.0 : (1.0 - share) * (1.0 - share) * v + share * share;
    if (first) {
        return (struct axis_asynchronous){.stated = false};
    }
    return result(sums, turn, left, changed / (1.0 + v), v);
}
