/* SPDX-License-Identifier: Apache-2.0 */

/* Fits order 1 of the disc, the circles of the axis, and the places and radii of the heads to the components of the
   residuals at the lowest orders. */

#include <math.h>

#include "cholesky.h"
#include "heads_steps.h"
#include "units.h"

/* Least variance of a reading, arcsec^2, so that readings without noise cause no division by zero. */
#define LEAST_VARIANCE 1e-6
#define LEAST_U 1e-6
/* Index of the first unknown of each kind at order 1: backward circle of the axis, and d_i of the heads. CIRCLES is the
   number of unknowns of the two circles. */
enum { BACKWARD = 2, LATE = 4, CIRCLES = 4 };

static double precision(double u) {
    double least = fmax(u, LEAST_U);
    return 1.0 / (least * least);
}

double heads_late_beforehand(const struct heads_fit *fit, uint32_t head) {
    double mounting = precision(fit->settings->u_place_arcsec);
    double index = precision(fit->settings->u_index_arcsec);
    double apart = fit->settings->place_rad[head] - fit->geometry->offset_rad[head];
    return remainder_of_turn(apart) * ARCSEC_PER_RAD * mounting / (mounting + index);
}

bool heads_fits_places(const struct heads_fit *fit) {
    return fit->geometry->heads > 2;
}

void heads_add_lines(const struct heads_fit *fit, struct vector unit1,
                     const double residual[HEADS_MOST]) {
    struct heads_workspace *workspace = fit->workspace;
    uint32_t heads = fit->geometry->heads;
    double mean = 0.0;
    for (uint32_t head = 0; head < heads; head++) {
        mean += residual[head] / heads;
    }
    for (uint32_t head = 0; head < heads; head++) {
        double apart = residual[head] - mean;
        struct vector power = vector_conjugate(unit1);
        workspace->sum[head] += residual[head];
        workspace->head_squares[head] += apart * apart;
        for (uint32_t place = 0; place < CIRCLE_ORDERS; place++) {
            struct vector *line = &workspace->line[place][head];
            *line = vector_sum(*line, vector_scaled(power, residual[head]));
            power = vector_product(power, vector_conjugate(unit1));
        }
    }
}

void heads_add_density(const struct heads_fit *fit, struct vector unit1) {
    const double part[LINE_PARTS] = {1.0, unit1.re, unit1.im};
    double *density = fit->workspace->density;
    for (uint32_t i = 0; i < LINE_PARTS; i++) {
        for (uint32_t j = 0; j <= i; j++) {
            *density++ += part[i] * part[j];
        }
    }
}

enum refusal heads_separate_lines(const struct heads_fit *fit) {
    struct heads_workspace *workspace = fit->workspace;
    double samples = fit->turn->samples;
    if (!cholesky_factor(workspace->density, LINE_PARTS)) {
        return REFUSED_SINGULAR;
    }
    for (uint32_t head = 1; head < fit->geometry->heads; head++) {
        struct vector *line = &workspace->line[0][head];
        double part[LINE_PARTS] = {workspace->sum[head], line->re, -line->im};
        cholesky_solve(workspace->density, LINE_PARTS, part);
        workspace->sum[head] = part[0] * samples;
        *line = (struct vector){0.5 * samples * part[1], -0.5 * samples * part[2]};
    }
    return NOT_REFUSED;
}

/* Returns the complex amplitude A of order 1, Re(A e^{jR1}), that one unit of an unknown causes in a head's reading. */
static struct vector line_of(const struct heads_fit *fit, uint32_t head, uint32_t unknown) {
    struct vector sight = fit->sight[head];
    struct vector backward = vector_conjugate(sight);
    const struct vector disc = {fit->workspace->values[0], -fit->workspace->values[fit->orders]};
    /* The complex amplitude of sin x is that of cos x times -j. */
    switch (unknown) {
    case 0:
        return sight;
    case 1:
        return (struct vector){sight.im, -sight.re};
    case BACKWARD:
        return (struct vector){-backward.im, backward.re};
    case BACKWARD + 1:
        return backward;
    default:
        break;
    }
    uint32_t further = fit->geometry->heads - 1;
    bool late = unknown < LATE + further;
    if (head != (unknown - LATE) % further + 1) {
        return (struct vector){0.0, 0.0};
    }
    struct vector seen = vector_product(sight, disc);
    /* The derivative of the backward circle is neglected: it is a hundredth of the derivative of the disc's error. */
    return late ? vector_scaled((struct vector){-seen.im, seen.re}, 1.0 / ARCSEC_PER_RAD)
                : vector_scaled(seen, 1.0 / fit->geometry->ratio[head]);
}

/* Subtracts the mean of all heads, which contains the motion of the table. */
static void without_mean(uint32_t heads, struct vector line[HEADS_MOST]) {
    struct vector mean = {0.0, 0.0};
    for (uint32_t head = 0; head < heads; head++) {
        mean = vector_sum(mean, vector_scaled(line[head], 1.0 / heads));
    }
    for (uint32_t head = 0; head < heads; head++) {
        line[head] = vector_difference(line[head], mean);
    }
}

/* Fits the first `unknowns` unknowns to the complex amplitudes of the readings at an order. `weight`: inverse variance
   of a component of such an amplitude. The packed matrix is replaced by its factor. */
static bool solve_lines(const struct heads_fit *fit, uint32_t order, uint32_t unknowns,
                        double weight, double *step) {
    struct heads_workspace *workspace = fit->workspace;
    struct vector by[PLACE_UNKNOWNS][HEADS_MOST];
    struct vector found[HEADS_MOST];
    uint32_t heads = fit->geometry->heads;
    uint32_t further = heads - 1;
    double *packed = workspace->of_places;
    for (uint32_t head = 0; head < heads; head++) {
        found[head] = vector_scaled(workspace->line[order - 1][head], 2.0 / fit->turn->samples);
        for (uint32_t i = 0; i < unknowns; i++) {
            by[i][head] = line_of(fit, head, i);
        }
    }
    without_mean(heads, found);
    for (uint32_t i = 0; i < unknowns; i++) {
        without_mean(heads, by[i]);
        step[i] = 0.0;
        for (uint32_t j = 0; j <= i; j++) {
            packed[packed_place(i, j)] = 0.0;
        }
        for (uint32_t head = 0; head < heads; head++) {
            struct vector own = vector_scaled(by[i][head], weight);
            step[i] += own.re * found[head].re + own.im * found[head].im;
            for (uint32_t j = 0; j <= i; j++) {
                packed[packed_place(i, j)] += own.re * by[j][head].re + own.im * by[j][head].im;
            }
        }
    }
    const struct heads_settings *settings = fit->settings;
    for (uint32_t i = LATE; i < unknowns; i++) {
        uint32_t head = (i - LATE) % further + 1;
        bool late = i < LATE + further;
        double known =
            late ? precision(settings->u_place_arcsec) + precision(settings->u_index_arcsec)
                 : precision(settings->u_radius);
        double off =
            late ? heads_late_beforehand(fit, head) - fit->geometry->late_rad[head] * ARCSEC_PER_RAD
                 : 1.0 - fit->geometry->ratio[head];
        packed[packed_place(i, i)] += known;
        step[i] += known * off;
    }
    if (!cholesky_factor(packed, unknowns)) {
        return false;
    }
    cholesky_solve(packed, unknowns, step);
    return true;
}

static uint32_t place_unknowns(const struct heads_fit *fit) {
    return LATE + 2 * (fit->geometry->heads - 1);
}

double heads_step_of_places(struct heads_fit *fit) {
    struct heads_workspace *workspace = fit->workspace;
    uint32_t further = fit->geometry->heads - 1;
    double samples = fit->turn->samples;
    double variance = fmax(workspace->squares / (samples * fit->rows), LEAST_VARIANCE);
    double step[PLACE_UNKNOWNS];
    const struct vector disc = {workspace->values[0], workspace->values[fit->orders]};
    double size = vector_length(disc);
    if (!solve_lines(fit, 1, place_unknowns(fit), samples / (2.0 * variance), step)) {
        return (double)NAN;
    }
    workspace->values[0] += step[0];
    workspace->values[fit->orders] += step[1];
    fit->backward.re += step[BACKWARD];
    fit->backward.im += step[BACKWARD + 1];
    double largest =
        fabs(step[0]) + fabs(step[1]) + fabs(step[BACKWARD]) + fabs(step[BACKWARD + 1]);
    for (uint32_t head = 1; head <= further; head++) {
        double late = step[LATE + head - 1] / ARCSEC_PER_RAD;
        double ratio = step[LATE + further + head - 1];
        fit->geometry->late_rad[head] += late;
        fit->geometry->ratio[head] += ratio;
        largest = fmax(largest, size * (fabs(late) + fabs(ratio)));
    }
    return largest;
}

void heads_take_places(const struct heads_fit *fit, struct heads_found *found,
                       struct estimate *estimate) {
    double *packed = fit->workspace->of_places;
    uint32_t unknowns = place_unknowns(fit);
    uint32_t further = fit->geometry->heads - 1;
    cholesky_invert_factor(packed, unknowns);
    estimate->harmonic[0] = heads_harmonic(fit, 1, packed, unknowns, 0, 1);
    estimate->harmonic[0].noise_gain = 1.0;
    for (uint32_t head = 1; head <= further; head++) {
        uint32_t late = LATE + head - 1;
        uint32_t ratio = late + further;
        found->u_late_arcsec[head] = sqrt(cholesky_inverse_element(packed, unknowns, late, late));
        found->u_ratio[head] = sqrt(cholesky_inverse_element(packed, unknowns, ratio, ratio));
    }
}

void heads_take_circles(const struct heads_fit *fit, struct heads_found *found) {
    found->backward_arcsec[0] = vector_length(fit->backward);
    for (uint32_t order = 2; fit->geometry->heads == HEADS_MOST && order <= CIRCLE_ORDERS;
         order++) {
        double step[PLACE_UNKNOWNS];
        if (solve_lines(fit, order, CIRCLES, 1.0, step)) {
            const struct vector forward = {step[0], step[1]};
            const struct vector backward = {step[BACKWARD], step[BACKWARD + 1]};
            found->forward_arcsec[order - 1] = vector_length(forward);
            found->backward_arcsec[order - 1] = vector_length(backward);
        }
    }
}
