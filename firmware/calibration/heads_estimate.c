/* SPDX-License-Identifier: Apache-2.0 */

/* Estimates the error of the disc and the places of the heads by passes over the turn, see heads_fit.h. */

#include <math.h>
#include <string.h>

#include "assertion.h"
#include "heads_steps.h"
#include "units.h"

/* Limit of the passes over the turn; a usual turn needs 4 to 6. A pass over 12,000 samples with 40 orders and four
   heads takes an estimated 34 million instructions, or 0.1 s at two cycles each. Nine passes last less than half of the
   2 s after which the watchdog regards the firmware as hung. */
enum { PASSES_MOST = 32 };
#define WORK_MOST (9U * 4U * 12000U * 40U)
/* Share of the largest value. The passes end when a step, or ten times the step that is expected next, is below this
   share. */
#define REFINED_SHARE 1e-11

/* Computes the heads' offsets from the means of their readings over the turn, and removes the whole turns by which
   their counters differ, because these have no meaning. Refuses a head that is too far from its nominal place. */
static enum refusal align(struct heads_fit *fit) {
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

/* Computes the values that depend on the geometry. */
static bool follow_geometry(struct heads_fit *fit) {
    for (uint32_t head = 0; head < fit->geometry->heads; head++) {
        fit->late[head] = vector_unit(fit->geometry->late_rad[head]);
        fit->sight[head] = heads_sight(fit->geometry, head);
    }
    fit->rows = heads_combinations(fit->geometry, fit->combination);
    return fit->rows > 0;
}

static void pass_over_turn(const struct heads_fit *fit) {
    struct heads_workspace *workspace = fit->workspace;
    double residual[HEADS_MOST];
    memset(workspace->right, 0, sizeof workspace->right);
    memset(workspace->line, 0, sizeof workspace->line);
    memset(workspace->sum, 0, sizeof workspace->sum);
    memset(workspace->head_squares, 0, sizeof workspace->head_squares);
    memset(workspace->density, 0, sizeof workspace->density);
    workspace->squares = 0.0;
    for (uint32_t sample = 0; sample < fit->turn->samples; sample++) {
        struct vector unit1 = heads_look(fit, sample, residual);
        heads_add_lines(fit, unit1, residual);
        heads_add_density(fit, unit1);
        for (uint32_t row = 0; row < fit->rows; row++) {
            const struct vector *column = workspace->columns[row];
            double error = heads_combined(fit, row, residual);
            workspace->squares += error * error;
            for (uint32_t place = 0; place < fit->orders; place++) {
                workspace->right[place] += column[place].re * error;
                workspace->right[fit->orders + place] += column[place].im * error;
            }
        }
    }
}

static double step_of_offsets(struct heads_fit *fit) {
    double largest = 0.0;
    for (uint32_t head = 1; head < fit->geometry->heads; head++) {
        double step = fit->workspace->sum[head] / fit->turn->samples;
        fit->geometry->offset_rad[head] += step / ARCSEC_PER_RAD;
        largest = fmax(largest, fabs(step));
    }
    return largest;
}

static double largest_coefficient(const struct heads_fit *fit) {
    double largest = 0.0;
    for (uint32_t place = 0; place < 2 * fit->orders; place++) {
        largest = fmax(largest, fabs(fit->workspace->values[place]));
    }
    return largest;
}

static uint32_t heads_passes(const struct heads_fit *fit) {
    uint32_t passes = WORK_MOST / (fit->turn->samples * fit->orders * fit->geometry->heads);
    return passes < PASSES_MOST ? passes : PASSES_MOST;
}

/* Repeats the passes over the turn until the remaining error is small. Successive steps shrink by nearly the same
   factor, so the remaining error is the last step times that factor. */
static enum refusal converge(struct heads_fit *fit, struct estimate *estimate) {
    double before = 0.0;
    for (estimate->iterations = 1; estimate->iterations <= heads_passes(fit);
         estimate->iterations++) {
        pass_over_turn(fit);
        if (heads_fits_places(fit) && heads_separate_lines(fit) != NOT_REFUSED) {
            return REFUSED_SINGULAR;
        }
        double step = heads_step_of_disc(fit);
        double offsets = step_of_offsets(fit);
        double places = heads_fits_places(fit) ? heads_step_of_places(fit) : 0.0;
        step = step + offsets + places;
        if (!isfinite(step) || !follow_geometry(fit)) {
            return REFUSED_NOT_FINITE;
        }
        double least = REFINED_SHARE * largest_coefficient(fit);
        if (step <= least || step * step <= 0.1 * least * before) {
            return NOT_REFUSED;
        }
        before = step;
    }
    return REFUSED_NOT_CONVERGED;
}

static enum refusal begin_fit(struct heads_fit *fit, struct heads_found *found) {
    *found = (struct heads_found){.geometry.heads = fit->capture->heads};
    for (uint32_t head = 0; head < HEADS_MOST; head++) {
        found->geometry.ratio[head] = 1.0;
    }
    enum refusal reason = align(fit);
    if (reason != NOT_REFUSED) {
        return reason;
    }
    for (uint32_t head = 1; head < fit->capture->heads; head++) {
        found->geometry.late_rad[head] = heads_late_beforehand(fit, head) / ARCSEC_PER_RAD;
    }
    memset(fit->workspace->values, 0, sizeof fit->workspace->values);
    unit_circle_prepare(&fit->workspace->circle);
    if (!follow_geometry(fit)) {
        return REFUSED_SINGULAR;
    }
    heads_choose_orders(fit, heads_fits_places(fit) ? 2 : 1);
    return heads_build_matrix(fit);
}

enum refusal heads_estimate(struct heads_workspace *workspace, const struct capture *capture,
                            const struct turn *turn, const struct heads_settings *settings,
                            struct heads_found *found, struct estimate *estimate) {
    ASSERT(settings->orders > 0 && settings->orders <= ORDERS_MAX);
    ASSERT(turn->samples > 0 && turn->counts_per_rev > 0);
    ASSERT(capture->heads >= 2 && capture->heads <= HEADS_MOST);
    struct heads_fit fit = {
        .workspace = workspace,
        .capture = capture,
        .turn = turn,
        .settings = settings,
        .geometry = &found->geometry,
        .orders = settings->orders,
        .arcsec_per_count = ARCSEC_PER_TURN / turn->counts_per_rev,
        .turns_per_count = 1.0 / turn->counts_per_rev,
    };
    enum refusal reason = begin_fit(&fit, found);
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
    heads_take_disc(&fit, estimate);
    heads_take_noise(&fit, estimate);
    if (heads_measure_axis(&fit)) {
        heads_take_asynchronous(&fit, estimate, found);
    }
    if (heads_fits_places(&fit)) {
        heads_take_places(&fit, found, estimate);
        heads_take_circles(&fit, found);
    }
    for (uint32_t head = 0; head < fit.geometry->heads; head++) {
        found->residual_arcsec[head] = sqrt(workspace->head_squares[head] / turn->samples);
    }
    estimate->measured_separation_rad = found->geometry.offset_rad[1];
    estimate->separation_rad = estimate->measured_separation_rad + found->geometry.late_rad[1];
    estimate->u_measured_separation_rad = found->u_late_arcsec[1] / ARCSEC_PER_RAD;
    return estimate_is_finite(estimate) ? NOT_REFUSED : REFUSED_NOT_FINITE;
}
