/* SPDX-License-Identifier: Apache-2.0 */

/* Fits the orders of the disc's error to the combinations of the residuals. */

#include <math.h>
#include <string.h>

#include "cholesky.h"
#include "heads_steps.h"

/* Least number of samples per order in the normal matrix, which uses every k-th sample: 32 per wave of the highest sum
   of two orders. */
enum { MATRIX_SAMPLES_AN_ORDER = 64 };

void heads_choose_orders(struct heads_fit *fit, uint32_t first) {
    struct gram_layout *layout = &fit->workspace->layout;
    layout->number = 0;
    for (uint32_t order = first; order <= fit->orders; order++) {
        if (isfinite(heads_gain(fit->geometry, order))) {
            layout->order[layout->number++] = order;
        }
    }
}

/* Returns the element of the design matrix for an unknown at the present sample; cosines come before sines. */
static double column_of(const struct heads_fit *fit, uint32_t row, uint32_t unknown) {
    const struct gram_layout *layout = &fit->workspace->layout;
    bool sine = unknown >= layout->number;
    uint32_t order = layout->order[sine ? unknown - layout->number : unknown];
    const struct vector *column = &fit->workspace->columns[row][order - 1];
    return sine ? column->im : column->re;
}

static void add_to_matrix(const struct heads_fit *fit, uint32_t row) {
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

enum refusal heads_build_matrix(const struct heads_fit *fit) {
    struct heads_workspace *workspace = fit->workspace;
    uint32_t size = 2 * workspace->layout.number;
    uint32_t samples = fit->turn->samples;
    uint32_t every = samples / (MATRIX_SAMPLES_AN_ORDER * fit->orders);
    every = every == 0 ? 1 : every;
    double residual[HEADS_MOST];
    uint32_t used = 0;
    memset(workspace->packed, 0, sizeof workspace->packed);
    for (uint32_t sample = 0; sample < samples; sample += every, used++) {
        (void)heads_look(fit, sample, residual);
        for (uint32_t row = 0; row < fit->rows; row++) {
            add_to_matrix(fit, row);
        }
    }
    for (uint32_t place = 0; place < size * (size + 1) / 2; place++) {
        workspace->packed[place] *= (double)samples / used;
    }
    return size > 0 && cholesky_factor(workspace->packed, size) ? NOT_REFUSED : REFUSED_SINGULAR;
}

double heads_step_of_disc(const struct heads_fit *fit) {
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

struct harmonic heads_harmonic(const struct heads_fit *fit, uint32_t order, const double *packed,
                               uint32_t size, uint32_t cosine, uint32_t sine) {
    const double *values = fit->workspace->values;
    return (struct harmonic){
        .seen = true,
        .cosine = values[order - 1],
        .sine = values[fit->orders + order - 1],
        .variance_cosine = cholesky_inverse_element(packed, size, cosine, cosine),
        .variance_sine = cholesky_inverse_element(packed, size, sine, sine),
        .covariance = cholesky_inverse_element(packed, size, sine, cosine),
    };
}

void heads_take_disc(const struct heads_fit *fit, struct estimate *estimate) {
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
        estimate->harmonic[order - 1] =
            heads_harmonic(fit, order, packed, 2 * number, place, number + place);
        estimate->harmonic[order - 1].noise_gain = heads_gain(fit->geometry, order);
    }
}
