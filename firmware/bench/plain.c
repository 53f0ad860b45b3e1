/* SPDX-License-Identifier: Apache-2.0 */

#include "plain.h"

#include <math.h>
#include <string.h>

#include "capture.h"
#include "cholesky.h"
#include "further_orders.h"
#include "transfer_function.h"
#include "units.h"

/* Returns the true angle of the first sample, radians. Like the firmware's Fourier method, it assumes equal steps. */
static double start_angle(const struct turn *turn) {
    double sum = 0.0;
    for (uint32_t k = 0; k < turn->samples; k++) {
        sum += turn_reading(turn, k).travel;
    }
    double sign = turn->step_counts > 0.0 ? 1.0 : -1.0;
    double number = turn->samples;
    double turns = (turn->start_angle + sum / number) / turn->counts_per_rev;
    return 2.0 * PI * (turns - sign * (number - 1.0) / (2.0 * number));
}

void plain_fourier(struct plain_workspace *workspace, const struct turn *turn,
                   const struct estimate *estimate, double *values) {
    (void)workspace;
    double start = start_angle(turn);
    double step = (turn->step_counts > 0.0 ? 2.0 : -2.0) * PI / turn->samples;
    double arcsec_per_count = ARCSEC_PER_TURN / turn->counts_per_rev;
    for (uint32_t order = 1; order <= estimate->orders; order++) {
        struct vector sum = {0.0, 0.0};
        for (uint32_t k = 0; k < turn->samples; k++) {
            double angle = order * (start + step * k);
            double difference = turn_reading(turn, k).difference * arcsec_per_count;
            sum.re += difference * cos(angle);
            sum.im -= difference * sin(angle);
        }
        struct vector error = vector_product(vector_scaled(sum, 1.0 / turn->samples),
                                             transfer_function(order, estimate->separation_rad));
        values[order - 1] = 2.0 * error.re;
        values[estimate->orders + order - 1] = -2.0 * error.im;
    }
}

static double fill_row(double *row, const struct turn *turn, const struct estimate *estimate,
                       double nominal_rad, uint32_t sample) {
    struct reading reading = turn_reading(turn, sample);
    double rad_per_count = 2.0 * PI / turn->counts_per_rev;
    double shift = estimate->measured_separation_rad - estimate->separation_rad;
    double angle1 = reading.angle1 * rad_per_count;
    double angle2 = reading.angle2 * rad_per_count - shift;
    for (uint32_t order = 1; order <= estimate->orders; order++) {
        row[order - 1] = cos(order * angle2) - cos(order * angle1);
        row[estimate->orders + order - 1] = sin(order * angle2) - sin(order * angle1);
    }
    row[2 * estimate->orders] = 1.0;
    return (reading.difference * rad_per_count - nominal_rad) * ARCSEC_PER_RAD;
}

bool plain_least_squares(struct plain_workspace *workspace, const struct turn *turn,
                         const struct estimate *estimate, double nominal_rad, double *values) {
    uint32_t size = 2 * estimate->orders + 1;
    memset(workspace, 0, sizeof *workspace);
    for (uint32_t k = 0; k < turn->samples; k++) {
        const double *row = workspace->row;
        double difference = fill_row(workspace->row, turn, estimate, nominal_rad, k);
        double *element = workspace->matrix;
        for (uint32_t i = 0; i < size; i++) {
            for (uint32_t j = 0; j <= i; j++) {
                *element++ += row[i] * row[j];
            }
            workspace->right[i] += row[i] * difference;
        }
    }
    if (!cholesky_factor(workspace->matrix, size)) {
        return false;
    }
    cholesky_solve(workspace->matrix, size, workspace->right);
    memcpy(values, workspace->right, 2 * estimate->orders * sizeof *values);
    return true;
}

static double fitted(const struct estimate *estimate, double angle) {
    double value = 0.0;
    for (uint32_t place = 0; place < estimate->orders; place++) {
        const struct harmonic *harmonic = &estimate->harmonic[place];
        value += harmonic->cosine * cos((place + 1) * angle);
        value += harmonic->sine * sin((place + 1) * angle);
    }
    return value;
}

double plain_further_orders(const struct further_workspace *made, const struct turn *turn,
                            const struct estimate *estimate) {
    static struct vector sum[LANES_LIMIT][3];
    double rad = 2.0 * PI / turn->counts_per_rev;
    double shift = further_orders_shift_rad(estimate);
    double most = 0.0;
    double largest = 0.0;
    for (uint32_t sample = 0; sample < made->samples; sample++) {
        struct reading reading = turn_reading(turn, sample);
        double one = reading.angle1 * rad;
        double two = reading.angle2 * rad;
        double residual =
            (reading.difference * rad - estimate->measured_separation_rad) * ARCSEC_PER_RAD -
            fitted(estimate, two - shift) + fitted(estimate, one);
        for (uint32_t place = 0; place < made->number; place++) {
            uint32_t order = made->order[place].order;
            struct vector unit1 = vector_unit(order * one);
            struct vector unit2 = vector_unit(order * two);
            struct vector *to = sum[place];
            to[0] = vector_sum(to[0], vector_scaled(unit1, residual));
            to[1] = vector_sum(to[1], vector_scaled(unit2, residual));
            to[2] = vector_sum(to[2], vector_product(unit2, vector_conjugate(unit1)));
        }
    }
    for (uint32_t place = 0; place < made->number; place++) {
        const struct further_order *order = &made->order[place];
        largest = fmax(largest, vector_length(sum[place][0]));
        most = fmax(most, vector_length(vector_difference(sum[place][0], order->head1)));
        most = fmax(most, vector_length(vector_difference(sum[place][1], order->head2)));
    }
    return most / largest;
}
