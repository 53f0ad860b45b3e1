/* SPDX-License-Identifier: Apache-2.0 */

#include "gram.h"

#include "assertion.h"
#include "cholesky.h"
#include "units.h"

_Static_assert(DELTA_POWERS == 3, "add_pair writes them out");

static double mean_difference_counts(const struct turn *turn) {
    int64_t sum = 0;
    for (uint32_t sample = 0; sample < turn->samples; sample++) {
        sum += turn_reading(turn, sample).difference;
    }
    return (double)sum / turn->samples;
}

/* Quantities of one sample: e^{jkR1} for successive k (`power`), e^{jR1} (`unit`), and delta, the heads' difference
   minus its mean, rad, with its square. */
struct term {
    struct vector power;
    struct vector unit;
    double delta;
    double delta_squared;
};

/* Adds two samples per pass, because loading and storing the sums takes longer than adding to them. */
static void add_pair(struct gram_sums *sums, struct term a, struct term b) {
    for (uint32_t k = 0; k <= 2 * sums->orders; k++) {
        sums->moment[0][k].re += a.power.re + b.power.re;
        sums->moment[0][k].im += a.power.im + b.power.im;
        sums->moment[1][k].re += a.power.re * a.delta + b.power.re * b.delta;
        sums->moment[1][k].im += a.power.im * a.delta + b.power.im * b.delta;
        sums->moment[2][k].re += a.power.re * a.delta_squared + b.power.re * b.delta_squared;
        sums->moment[2][k].im += a.power.im * a.delta_squared + b.power.im * b.delta_squared;
        a.power = vector_product(a.power, a.unit);
        b.power = vector_product(b.power, b.unit);
    }
}

void gram_accumulate(struct gram_sums *sums, const struct unit_circle *circle,
                     const struct turn *turn, uint32_t orders, double shift_rad) {
    ASSERT(orders <= ORDERS_MAX && turn->samples > 0 && turn->counts_per_rev > 0);
    double rad_per_count = 2.0 * PI / turn->counts_per_rev;
    double turns_per_count = 1.0 / turn->counts_per_rev;
    double mean = mean_difference_counts(turn);
    *sums = (struct gram_sums){
        .beta_rad = mean * rad_per_count - shift_rad,
        .samples = turn->samples,
        .orders = orders,
    };
    for (uint32_t sample = 0; sample < turn->samples; sample += 2) {
        struct term term[2] = {{.delta = 0.0}, {.delta = 0.0}};
        /* If the number of samples is odd, the last sample is added alone. */
        for (uint32_t place = 0; place < 2 && sample + place < turn->samples; place++) {
            struct reading reading = turn_reading(turn, sample + place);
            double delta = (reading.difference - mean) * rad_per_count;
            struct vector unit = unit_circle_at(circle, reading.angle1 * turns_per_count);
            term[place] = (struct term){{1.0, 0.0}, unit, delta, delta * delta};
        }
        add_pair(sums, term[0], term[1]);
    }
}

/* Returns the sum of e^{jkR1} e^{jq delta}; k and q may be negative. */
static struct vector expanded(const struct gram_sums *sums, int32_t k, int32_t q) {
    uint32_t place = (uint32_t)(k < 0 ? -k : k);
    struct vector m[DELTA_POWERS];
    for (uint32_t p = 0; p < DELTA_POWERS; p++) {
        m[p] = sums->moment[p][place];
        m[p] = k < 0 ? vector_conjugate(m[p]) : m[p];
    }
    double second = -0.5 * q * q;
    return (struct vector){m[0].re - q * m[1].im + second * m[2].re,
                           m[0].im + q * m[1].re + second * m[2].im};
}

/* Returns the sum of d_n d_m; for a negative m, d_m is the conjugate of d_|m|. */
static struct vector products(const struct gram_sums *sums, int32_t n, int32_t m) {
    struct vector turned_n = vector_unit(n * sums->beta_rad);
    struct vector turned_m = vector_unit(m * sums->beta_rad);
    struct vector both =
        vector_product(vector_product(turned_n, turned_m), expanded(sums, n + m, n + m));
    struct vector first = vector_product(turned_n, expanded(sums, n + m, n));
    struct vector second = vector_product(turned_m, expanded(sums, n + m, m));
    struct vector crossed = vector_sum(first, second);
    return vector_sum(vector_difference(both, crossed), expanded(sums, n + m, 0));
}

static struct vector sum_of_column(const struct gram_sums *sums, int32_t n) {
    struct vector turned = vector_product(vector_unit(n * sums->beta_rad), expanded(sums, n, n));
    return vector_difference(turned, expanded(sums, n, 0));
}

/* Writes the four elements of the normal matrix that combine cosine and sine of order n with cosine and sine of order
   m; i >= j. */
static void place_pair(const struct gram_sums *sums, const struct gram_layout *layout,
                       double *packed, uint32_t i, uint32_t j) {
    int32_t n = (int32_t)layout->order[i];
    int32_t m = (int32_t)layout->order[j];
    uint32_t number = layout->number;
    struct vector plain = products(sums, n, m);
    struct vector conjugated = products(sums, n, -m);
    packed[packed_place(i, j)] = 0.5 * (plain.re + conjugated.re);
    packed[packed_place(i + number, j + number)] = 0.5 * (conjugated.re - plain.re);
    /* The first element is the sine of n with the cosine of m, the second the cosine of n with the sine of m. */
    packed[packed_place(i + number, j)] = 0.5 * (plain.im + conjugated.im);
    packed[packed_place(j + number, i)] = 0.5 * (plain.im - conjugated.im);
}

void gram_build(const struct gram_sums *sums, const struct gram_layout *layout, double *packed) {
    ASSERT(layout->number <= ORDERS_MAX);
    uint32_t last = 2 * layout->number;
    for (uint32_t i = 0; i < layout->number; i++) {
        for (uint32_t j = 0; j <= i; j++) {
            place_pair(sums, layout, packed, i, j);
        }
        struct vector column = sum_of_column(sums, (int32_t)layout->order[i]);
        packed[packed_place(last, i)] = column.re;
        packed[packed_place(last, i + layout->number)] = column.im;
    }
    packed[packed_place(last, last)] = sums->samples;
}
