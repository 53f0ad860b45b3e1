/* SPDX-License-Identifier: Apache-2.0 */

#include "heads_fit.h"

#include <math.h>
#include <string.h>

#include "assertion.h"
#include "cholesky.h"
#include "noise.h"
#include "units.h"

/* Limit of the passes over the turn; a usual turn needs 4 to 6. A pass over 12,000 samples with 40 orders and four
   heads takes an estimated 34 million instructions, or 0.1 s at two cycles each. Nine passes last less than half of the
   2 s after which the watchdog regards the firmware as hung. */
enum { PASSES_MOST = 32 };
#define WORK_MOST (9U * 4U * 12000U * 40U)
/* Least number of samples per order in the normal matrix, which uses every k-th sample: 32 per wave of the highest sum
   of two orders. */
enum { MATRIX_SAMPLES_AN_ORDER = 64 };
/* Share of the largest value. The passes end when a step, or ten times the step that is expected next, is below this
   share. */
#define REFINED_SHARE 1e-11
/* Least variance of a reading, arcsec^2, so that readings without noise cause no division by zero. */
#define LEAST_VARIANCE 1e-6
#define LEAST_U 1e-6
/* Index of the first unknown of each kind at order 1: backward circle of the axis, and d_i of the heads. CIRCLES is the
   number of unknowns of the two circles. */
enum { BACKWARD = 2, LATE = 4, CIRCLES = 4 };

struct fit {
    struct heads_workspace *workspace;
    const struct capture *capture;
    const struct turn *turn;
    const struct heads_settings *settings;
    struct heads_geometry *geometry;
    uint32_t orders;
    uint32_t rows;
    double arcsec_per_count;
    double turns_per_count;
    /* Counts by which a head's word minus that of head 1 exceeds the angle between the two heads. */
    int32_t ahead[HEADS_MOST];
    double combination[COMBINATIONS_MOST][HEADS_MOST];
    /* e^{jd_i} and rho_i e^{jp_i} of each head (heads_fit.h, heads.h). */
    struct vector late[HEADS_MOST];
    struct vector sight[HEADS_MOST];
    /* Circular motion of the axis opposite to the table's rotation, arcsec. */
    struct vector backward;
};

/* Tells whether order 1 is fitted together with the places, which needs three or four heads. */
static bool fits_places(const struct fit *fit) {
    return fit->geometry->heads > 2;
}

static double precision(double u) {
    double least = fmax(u, LEAST_U);
    return 1.0 / (least * least);
}

/* Computes the heads' offsets from the means of their readings over the turn, and removes the whole turns by which
   their counters differ, because these have no meaning. Refuses a head that is too far from its nominal place. */
static enum refusal align(struct fit *fit) {
    const struct capture *capture = fit->capture;
    double turn = capture->counts_per_rev;
    double place[HEADS_MOST];
    if (!capture_places(capture, fit->turn->samples, place)) {
        return REFUSED_INDEX_NOT_SEEN;
    }
    for (uint32_t head = 0; head < fit->geometry->heads; head++) {
        double nominal = fit->settings->place_rad[head] * turn / (2.0 * PI);
        double off = place[head] - nominal;
        off -= turn * rint(off / turn);
        if (fabs(off) * fit->arcsec_per_count > SEPARATION_BELIEVABLE_ARCSEC) {
            return REFUSED_HEADS_ELSEWHERE;
        }
        int32_t start = capture->start[head] - capture->start[0];
        int32_t whole = (int32_t)rint((start - nominal - off) / turn);
        uint32_t first = (uint32_t)counts_apart(capture_word(capture, 0, head), capture->words[0]);
        fit->ahead[head] =
            (int32_t)(first - (uint32_t)start + (uint32_t)whole * capture->counts_per_rev);
        fit->geometry->offset_rad[head] = (nominal + off) * 2.0 * PI / turn;
    }
    return NOT_REFUSED;
}

/* Returns the prior value of d_i, arcsec: the weighted mean of p_i - a_i, which the mounting suggests, and of 0, which
   the index suggests. */
static double late_beforehand(const struct fit *fit, uint32_t head) {
    double mounting = precision(fit->settings->u_place_arcsec);
    double index = precision(fit->settings->u_index_arcsec);
    double apart = fit->settings->place_rad[head] - fit->geometry->offset_rad[head];
    return remainder_of_turn(apart) * ARCSEC_PER_RAD * mounting / (mounting + index);
}

/* Computes the values that depend on the geometry. */
static bool follow_geometry(struct fit *fit) {
    for (uint32_t head = 0; head < fit->geometry->heads; head++) {
        fit->late[head] = vector_unit(fit->geometry->late_rad[head]);
        fit->sight[head] = heads_sight(fit->geometry, head);
    }
    fit->rows = heads_combinations(fit->geometry, fit->combination);
    return fit->rows > 0;
}

static void choose_orders(struct fit *fit) {
    struct gram_layout *layout = &fit->workspace->layout;
    layout->number = 0;
    for (uint32_t order = fits_places(fit) ? 2 : 1; order <= fit->orders; order++) {
        if (isfinite(heads_gain(fit->geometry, order))) {
            layout->order[layout->number++] = order;
        }
    }
}

/* Adds e^{jny} of all orders to the columns of the combinations; returns the error of the disc under the head,
   arcsec. */
static double look_under_head(const struct fit *fit, uint32_t head, struct vector unit) {
    struct heads_workspace *workspace = fit->workspace;
    const double *cosine = workspace->values;
    const double *sine = workspace->values + fit->orders;
    struct vector power = unit;
    double error = (fit->geometry->ratio[head] - 1.0) * (cosine[0] * unit.re + sine[0] * unit.im);
    double first = fit->combination[0][head];
    double second = fit->rows > 1 ? fit->combination[1][head] : 0.0;
    for (uint32_t place = 0; place < fit->orders; place++) {
        struct vector *column = &workspace->columns[0][place];
        error += cosine[place] * power.re + sine[place] * power.im;
        column->re += first * power.re;
        column->im += first * power.im;
        if (fit->rows > 1) {
            column = &workspace->columns[1][place];
            column->re += second * power.re;
            column->im += second * power.im;
        }
        power = vector_product(power, unit);
    }
    return error;
}

/* Computes the residual of every head minus the residual of head 1, arcsec, and the columns; returns e^{jR1}. */
static struct vector look(const struct fit *fit, uint32_t sample, double residual[HEADS_MOST]) {
    const struct turn *turn = fit->turn;
    int32_t word1 = turn->words[2 * sample];
    int32_t angle1 =
        angle_reduced(turn->start_angle + counts_apart(word1, turn->first), turn->counts_per_rev);
    const struct unit_circle *circle = &fit->workspace->circle;
    struct vector unit1 = unit_circle_at(circle, angle1 * fit->turns_per_count);
    struct vector against = vector_product(fit->backward, vector_conjugate(unit1));
    memset(fit->workspace->columns, 0, fit->rows * sizeof fit->workspace->columns[0]);
    for (uint32_t head = 0; head < fit->geometry->heads; head++) {
        int32_t word = capture_word(fit->capture, sample, head);
        int32_t apart = counts_apart(counts_apart(word, word1), fit->ahead[head]);
        int32_t angle = angle_reduced(angle1 + apart, turn->counts_per_rev);
        struct vector unit =
            vector_product(unit_circle_at(circle, angle * fit->turns_per_count), fit->late[head]);
        residual[head] =
            apart * fit->arcsec_per_count - fit->geometry->offset_rad[head] * ARCSEC_PER_RAD -
            look_under_head(fit, head, unit) - vector_product(against, fit->sight[head]).im;
    }
    for (uint32_t head = fit->geometry->heads; head-- > 0;) {
        residual[head] -= residual[0];
    }
    return unit1;
}

static double combined(const struct fit *fit, uint32_t row, const double residual[HEADS_MOST]) {
    double sum = 0.0;
    for (uint32_t head = 1; head < fit->geometry->heads; head++) {
        sum += fit->combination[row][head] * residual[head];
    }
    return sum;
}

/* Returns the element of the design matrix for an unknown at the present sample; cosines come before sines. */
static double column_of(const struct fit *fit, uint32_t row, uint32_t unknown) {
    const struct gram_layout *layout = &fit->workspace->layout;
    bool sine = unknown >= layout->number;
    uint32_t order = layout->order[sine ? unknown - layout->number : unknown];
    const struct vector *column = &fit->workspace->columns[row][order - 1];
    return sine ? column->im : column->re;
}

static void add_to_matrix(const struct fit *fit, uint32_t row) {
    double column[FIT_UNKNOWNS];
    double *element = fit->workspace->packed;
    uint32_t size = 2 * fit->workspace->layout.number;
    for (uint32_t i = 0; i < size; i++) {
        column[i] = column_of(fit, row, i);
        for (uint32_t j = 0; j <= i; j++) {
            *element++ += column[i] * column[j];
        }
    }
}

/* Builds X^T X, scaled to the number of all samples. */
static enum refusal build_matrix(const struct fit *fit) {
    struct heads_workspace *workspace = fit->workspace;
    uint32_t size = 2 * workspace->layout.number;
    uint32_t samples = fit->turn->samples;
    uint32_t every = samples / (MATRIX_SAMPLES_AN_ORDER * fit->orders);
    every = every == 0 ? 1 : every;
    double residual[HEADS_MOST];
    uint32_t used = 0;
    memset(workspace->packed, 0, sizeof workspace->packed);
    for (uint32_t sample = 0; sample < samples; sample += every, used++) {
        (void)look(fit, sample, residual);
        for (uint32_t row = 0; row < fit->rows; row++) {
            add_to_matrix(fit, row);
        }
    }
    for (uint32_t place = 0; place < size * (size + 1) / 2; place++) {
        workspace->packed[place] *= (double)samples / used;
    }
    return size > 0 && cholesky_factor(workspace->packed, size) ? NOT_REFUSED : REFUSED_SINGULAR;
}

static void add_lines(const struct fit *fit, struct vector unit1,
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

static void add_density(const struct fit *fit, struct vector unit1) {
    const double part[LINE_PARTS] = {1.0, unit1.re, unit1.im};
    double *density = fit->workspace->density;
    for (uint32_t i = 0; i < LINE_PARTS; i++) {
        for (uint32_t j = 0; j <= i; j++) {
            *density++ += part[i] * part[j];
        }
    }
}

/* Separates the sums of the residuals into their mean and their component of order 1 (`line`). Both must be solved
   together, because samples at an uneven speed are not evenly spaced. */
static enum refusal separate_lines(const struct fit *fit) {
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

static void pass_over_turn(const struct fit *fit) {
    struct heads_workspace *workspace = fit->workspace;
    double residual[HEADS_MOST];
    memset(workspace->right, 0, sizeof workspace->right);
    memset(workspace->line, 0, sizeof workspace->line);
    memset(workspace->sum, 0, sizeof workspace->sum);
    memset(workspace->head_squares, 0, sizeof workspace->head_squares);
    memset(workspace->density, 0, sizeof workspace->density);
    workspace->squares = 0.0;
    for (uint32_t sample = 0; sample < fit->turn->samples; sample++) {
        struct vector unit1 = look(fit, sample, residual);
        add_lines(fit, unit1, residual);
        add_density(fit, unit1);
        for (uint32_t row = 0; row < fit->rows; row++) {
            const struct vector *column = workspace->columns[row];
            double error = combined(fit, row, residual);
            workspace->squares += error * error;
            for (uint32_t place = 0; place < fit->orders; place++) {
                workspace->right[place] += column[place].re * error;
                workspace->right[fit->orders + place] += column[place].im * error;
            }
        }
    }
}

static double step_of_disc(const struct fit *fit) {
    struct heads_workspace *workspace = fit->workspace;
    const struct gram_layout *layout = &workspace->layout;
    double unknowns[FIT_UNKNOWNS];
    double largest = 0.0;
    uint32_t number = layout->number;
    for (uint32_t place = 0; place < number; place++) {
        unknowns[place] = workspace->right[layout->order[place] - 1];
        unknowns[number + place] = workspace->right[fit->orders + layout->order[place] - 1];
    }
    cholesky_solve(workspace->packed, 2 * number, unknowns);
    for (uint32_t place = 0; place < number; place++) {
        workspace->values[layout->order[place] - 1] += unknowns[place];
        workspace->values[fit->orders + layout->order[place] - 1] += unknowns[number + place];
        largest = fmax(largest, fabs(unknowns[place]) + fabs(unknowns[number + place]));
    }
    return largest;
}

/* Returns the complex amplitude A of order 1, Re(A e^{jR1}), that one unit of an unknown causes in a head's reading. */
static struct vector line_of(const struct fit *fit, uint32_t head, uint32_t unknown) {
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
static bool solve_lines(const struct fit *fit, uint32_t order, uint32_t unknowns, double weight,
                        double *step) {
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
            late ? late_beforehand(fit, head) - fit->geometry->late_rad[head] * ARCSEC_PER_RAD
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

static uint32_t place_unknowns(const struct fit *fit) {
    return LATE + 2 * (fit->geometry->heads - 1);
}

/* Makes one step of the iteration for the places and returns its size; returns NAN if the places cannot be
   determined. */
static double step_of_places(struct fit *fit) {
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

static double step_of_offsets(struct fit *fit) {
    double largest = 0.0;
    for (uint32_t head = 1; head < fit->geometry->heads; head++) {
        double step = fit->workspace->sum[head] / fit->turn->samples;
        fit->geometry->offset_rad[head] += step / ARCSEC_PER_RAD;
        largest = fmax(largest, fabs(step));
    }
    return largest;
}

static double largest_value(const struct fit *fit) {
    double largest = 0.0;
    for (uint32_t place = 0; place < 2 * fit->orders; place++) {
        largest = fmax(largest, fabs(fit->workspace->values[place]));
    }
    return largest;
}

static uint32_t passes_of(const struct fit *fit) {
    uint32_t passes = WORK_MOST / (fit->turn->samples * fit->orders * fit->geometry->heads);
    return passes < PASSES_MOST ? passes : PASSES_MOST;
}

/* Repeats the passes over the turn until the remaining error is small. Successive steps shrink by nearly the same
   factor, so the remaining error is the last step times that factor. */
static enum refusal converge(struct fit *fit, struct estimate *estimate) {
    double before = 0.0;
    for (estimate->iterations = 1; estimate->iterations <= passes_of(fit); estimate->iterations++) {
        pass_over_turn(fit);
        if (fits_places(fit) && separate_lines(fit) != NOT_REFUSED) {
            return REFUSED_SINGULAR;
        }
        double step = step_of_disc(fit);
        double offsets = step_of_offsets(fit);
        double places = fits_places(fit) ? step_of_places(fit) : 0.0;
        step = step + offsets + places;
        if (!isfinite(step) || !follow_geometry(fit)) {
            return REFUSED_NOT_FINITE;
        }
        double least = REFINED_SHARE * largest_value(fit);
        if (step <= least || step * step <= 0.1 * least * before) {
            return NOT_REFUSED;
        }
        before = step;
    }
    return REFUSED_NOT_CONVERGED;
}

static void take_values(const struct fit *fit, struct estimate *estimate) {
    struct heads_workspace *workspace = fit->workspace;
    const struct gram_layout *layout = &workspace->layout;
    uint32_t number = layout->number;
    double *packed = workspace->packed;
    cholesky_invert_factor(packed, 2 * number);
    for (uint32_t place = 0; place < fit->orders; place++) {
        estimate->harmonic[place] = (struct harmonic){.noise_gain = (double)INFINITY};
    }
    for (uint32_t place = 0; place < number; place++) {
        uint32_t order = layout->order[place];
        uint32_t sine = number + place;
        estimate->harmonic[order - 1] = (struct harmonic){
            .seen = true,
            .cosine = workspace->values[order - 1],
            .sine = workspace->values[fit->orders + order - 1],
            .variance_cosine = cholesky_inverse_element(packed, 2 * number, place, place),
            .variance_sine = cholesky_inverse_element(packed, 2 * number, sine, sine),
            .covariance = cholesky_inverse_element(packed, 2 * number, sine, place),
            .noise_gain = heads_gain(fit->geometry, order),
        };
    }
}

/* Tells whether the motion of the axis that does not repeat is wanted, and the heads show it. */
static bool measures_axis(const struct fit *fit) {
    return fit->settings->axis != NULL && fit->geometry->heads == HEADS_MOST;
}

/* Returns the share of the turn that belongs to a sample: half the angle between its neighbours. */
static double share_of(const struct fit *fit, uint32_t sample) {
    const struct turn *turn = fit->turn;
    uint32_t last = turn->samples - 1;
    double whole = turn->step_counts < 0.0 ? -turn->counts_per_rev : turn->counts_per_rev;
    int32_t before = turn->words[2 * (sample == 0 ? last : sample - 1)];
    int32_t after = turn->words[2 * (sample == last ? 0 : sample + 1)];
    double apart = counts_apart(after, before);
    apart += sample == 0 || sample == last ? whole : 0.0;
    return 0.5 * apart / whole;
}

static double residual_sample(const void *context, uint32_t sample) {
    const struct fit *fit = context;
    double residual[HEADS_MOST];
    struct vector unit1 = look(fit, sample, residual);
    if (measures_axis(fit)) {
        axis_add(&fit->workspace->axis, residual, unit1, share_of(fit, sample));
    }
    return combined(fit, 0, residual);
}

static void take_noise(const struct fit *fit, struct estimate *estimate) {
    struct heads_workspace *workspace = fit->workspace;
    double of_one_row;
    if (measures_axis(fit)) {
        axis_begin(&workspace->axis, fit->geometry, fit->orders);
    }
    lines_transform(&workspace->lines, lines_wanted(fit->orders, fit->turn->samples),
                    &workspace->circle, residual_sample, fit, fit->turn->samples, &of_one_row);
    noise_measure(estimate, workspace->squares / fit->rows, &workspace->lines);
    noise_scale_covariance(estimate);
}

/* Takes order 1 of the disc with its covariance, and the uncertainties of places and radii, from the factor of the
   last pass. */
static void take_places(const struct fit *fit, struct heads_found *found,
                        struct estimate *estimate) {
    const struct heads_workspace *workspace = fit->workspace;
    double *packed = fit->workspace->of_places;
    uint32_t unknowns = place_unknowns(fit);
    uint32_t further = fit->geometry->heads - 1;
    cholesky_invert_factor(packed, unknowns);
    estimate->harmonic[0] = (struct harmonic){
        .seen = true,
        .cosine = workspace->values[0],
        .sine = workspace->values[fit->orders],
        .variance_cosine = cholesky_inverse_element(packed, unknowns, 0, 0),
        .variance_sine = cholesky_inverse_element(packed, unknowns, 1, 1),
        .covariance = cholesky_inverse_element(packed, unknowns, 1, 0),
        .noise_gain = 1.0,
    };
    for (uint32_t head = 1; head <= further; head++) {
        uint32_t late = LATE + head - 1;
        uint32_t ratio = late + further;
        found->u_late_arcsec[head] = sqrt(cholesky_inverse_element(packed, unknowns, late, late));
        found->u_ratio[head] = sqrt(cholesky_inverse_element(packed, unknowns, ratio, ratio));
    }
}

/* Computes the circles of the axis. Only four heads show the circles of the orders from 2 on; with fewer heads, the
   fitted orders of the disc contain them. */
static void take_circles(const struct fit *fit, struct heads_found *found) {
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

/* Computes the motion of the axis that does not repeat, from the sums that take_noise() has made. */
static void take_asynchronous(const struct fit *fit, const struct estimate *estimate,
                              struct heads_found *found) {
    const struct heads_workspace *workspace = fit->workspace;
    const double variance = estimate->noise_arcsec * estimate->noise_arcsec;
    double off[HEADS_MOST];
    double of_disc = 0.0;
    for (uint32_t head = 0; head < HEADS_MOST; head++) {
        double apart = fit->geometry->offset_rad[head] - fit->settings->place_rad[head];
        off[head] = remainder_of_turn(apart) * ARCSEC_PER_RAD;
    }
    for (uint32_t place = 1; place < fit->orders; place++) {
        const struct harmonic *harmonic = &estimate->harmonic[place];
        if (harmonic->seen) {
            of_disc += harmonic->noise_gain * harmonic->noise_gain *
                       axis_of_order(&workspace->axis, fit->geometry, place + 1);
        }
    }
    /* The disc's order 1 reads like a forward circle: Re(D e^{jy}) = Im(jD e^{jy}), D = cosine - j sine. */
    const struct axis_turn turn = {
        .samples = fit->turn->samples,
        .still = axis_of_heads(&workspace->axis, off),
        .forward = {workspace->values[fit->orders], workspace->values[0]},
        .backward = fit->backward,
        .variance = variance,
        .of_disc = of_disc * estimate->colour / fit->turn->samples,
    };
    found->asynchronous = axis_end(&workspace->axis, &turn, fit->settings->axis);
}

static enum refusal begin(struct fit *fit, struct heads_found *found) {
    *found = (struct heads_found){.geometry.heads = fit->capture->heads};
    for (uint32_t head = 0; head < HEADS_MOST; head++) {
        found->geometry.ratio[head] = 1.0;
    }
    enum refusal reason = align(fit);
    if (reason != NOT_REFUSED) {
        return reason;
    }
    for (uint32_t head = 1; head < fit->capture->heads; head++) {
        found->geometry.late_rad[head] = late_beforehand(fit, head) / ARCSEC_PER_RAD;
    }
    memset(fit->workspace->values, 0, sizeof fit->workspace->values);
    unit_circle_prepare(&fit->workspace->circle);
    if (!follow_geometry(fit)) {
        return REFUSED_SINGULAR;
    }
    choose_orders(fit);
    return build_matrix(fit);
}

enum refusal heads_estimate(struct heads_workspace *workspace, const struct capture *capture,
                            const struct turn *turn, const struct heads_settings *settings,
                            struct heads_found *found, struct estimate *estimate) {
    ASSERT(settings->orders > 0 && settings->orders <= ORDERS_MAX);
    ASSERT(turn->samples > 0 && turn->counts_per_rev > 0);
    ASSERT(capture->heads >= 2 && capture->heads <= HEADS_MOST);
    struct fit fit = {
        .workspace = workspace,
        .capture = capture,
        .turn = turn,
        .settings = settings,
        .geometry = &found->geometry,
        .orders = settings->orders,
        .arcsec_per_count = ARCSEC_PER_TURN / turn->counts_per_rev,
        .turns_per_count = 1.0 / turn->counts_per_rev,
    };
    enum refusal reason = begin(&fit, found);
    *estimate = (struct estimate){
        .orders = settings->orders,
        .samples = turn->samples,
        .function_of_reading = true,
        .separation_choice = SEPARATION_MEASURED,
    };
    reason = reason == NOT_REFUSED ? converge(&fit, estimate) : reason;
    if (reason != NOT_REFUSED) {
        return reason;
    }
    take_values(&fit, estimate);
    take_noise(&fit, estimate);
    if (measures_axis(&fit)) {
        take_asynchronous(&fit, estimate, found);
    }
    if (fits_places(&fit)) {
        take_places(&fit, found, estimate);
        take_circles(&fit, found);
    }
    for (uint32_t head = 0; head < fit.geometry->heads; head++) {
        found->residual_arcsec[head] = sqrt(workspace->head_squares[head] / turn->samples);
    }
    estimate->measured_separation_rad = found->geometry.offset_rad[1];
    estimate->separation_rad = estimate->measured_separation_rad + found->geometry.late_rad[1];
    estimate->u_measured_separation_rad = found->u_late_arcsec[1] / ARCSEC_PER_RAD;
    return estimate_is_finite(estimate) ? NOT_REFUSED : REFUSED_NOT_FINITE;
}
