/* SPDX-License-Identifier: Apache-2.0 */

/* Computes the residuals of the heads at one sample, and the columns of the design matrix. */

#include <string.h>

#include "heads_steps.h"
#include "units.h"

/* Adds e^{jny} of all orders to the columns of the combinations; returns the error of the disc under the head,
   arcsec. */
static double look_under_head(const struct heads_fit *fit, uint32_t head, struct vector unit) {
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

struct vector heads_look(const struct heads_fit *fit, uint32_t sample,
                         double residual[HEADS_MOST]) {
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

double heads_combined(const struct heads_fit *fit, uint32_t row,
                      const double residual[HEADS_MOST]) {
    double sum = 0.0;
    for (uint32_t head = 1; head < fit->geometry->heads; head++) {
        sum += fit->combination[row][head] * residual[head];
    }
    return sum;
}
