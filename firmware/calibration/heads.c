/* SPDX-License-Identifier: Apache-2.0 */

#include "heads.h"

#include <math.h>

#include "arctrue_number_formats.h"
#include "assertion.h"
#include "cholesky.h"

#define WEIGHT_ONE ((double)(1 << ARCTRUE_HEAD_WEIGHT_FRACTION))
#define WEIGHT_LIMIT (1 << (ARCTRUE_HEAD_WEIGHT_WIDTH - 1))
/* Least length of the parity vector before it is scaled to length 1; a shorter one shows that the four heads stand at
   only two places. The elements of this vector are twice the areas of the four triangles of three heads. */
#define LEAST_PARITY 1e-6
/* Noise gain above which the heads count as insensitive to an order. */
#define UNSEEN_GAIN 1e3
/* Largest distance of a tried word from the rounded weight. */
enum { WORD_REACH = 2, WORD_CHOICES = 2 * WORD_REACH + 1, CONDITIONS = 3 };

struct vector heads_sight(const struct heads_geometry *geometry, uint32_t head) {
    double place = geometry->offset_rad[head] + geometry->late_rad[head];
    return vector_scaled(vector_unit(place), geometry->ratio[head]);
}

/* Returns twice the signed area of a triangle. */
static double triangle(struct vector a, struct vector b, struct vector c) {
    struct vector ab = vector_difference(b, a);
    struct vector ac = vector_difference(c, a);
    return ab.re * ac.im - ac.re * ab.im;
}

/* Computes the vector of length 1 that is orthogonal to (1, 1, 1, 1) and to the real and imaginary parts of
   heads_sight(): the size of each element is proportional to the area of the triangle of the other three heads. */
static bool parity_of(const struct heads_geometry *geometry, double parity[HEADS_MOST]) {
    struct vector sight[HEADS_MOST];
    double square = 0.0;
    for (uint32_t head = 0; head < HEADS_MOST; head++) {
        sight[head] = heads_sight(geometry, head);
    }
    for (uint32_t head = 0; head < HEADS_MOST; head++) {
        double area = triangle(sight[head == 0 ? 1 : 0], sight[head <= 1 ? 2 : 1],
                               sight[head == HEADS_MOST - 1 ? 2 : 3]);
        parity[head] = head % 2 != 0 ? -area : area;
        square += area * area;
    }
    double length = sqrt(square);
    for (uint32_t head = 0; head < HEADS_MOST; head++) {
        parity[head] /= length;
    }
    return length > LEAST_PARITY;
}

uint32_t heads_combinations(const struct heads_geometry *geometry,
                            double combination[COMBINATIONS_MOST][HEADS_MOST]) {
    uint32_t heads = geometry->heads;
    ASSERT(heads >= 2 && heads <= HEADS_MOST);
    if (heads == HEADS_MOST) {
        return parity_of(geometry, combination[0]) ? 1 : 0;
    }
    /* Helmert contrasts: each head minus the mean of the heads before it. */
    for (uint32_t row = 0; row + 1 < heads; row++) {
        double before = row + 1;
        double scale = 1.0 / sqrt(before * (before + 1.0));
        for (uint32_t head = 0; head < HEADS_MOST; head++) {
            double of_head = head == row + 1 ? before : 0.0;
            combination[row][head] = (head <= row ? -1.0 : of_head) * scale;
        }
    }
    return heads - 1;
}

double heads_gain(const struct heads_geometry *geometry, uint32_t order) {
    double combination[COMBINATIONS_MOST][HEADS_MOST];
    uint32_t number = heads_combinations(geometry, combination);
    double square = 0.0;
    for (uint32_t row = 0; row < number; row++) {
        struct vector seen = {0.0, 0.0};
        for (uint32_t head = 0; head < geometry->heads; head++) {
            double place = geometry->offset_rad[head] + geometry->late_rad[head];
            seen =
                vector_sum(seen, vector_scaled(vector_unit(order * place), combination[row][head]));
        }
        square += vector_square(seen);
    }
    double gain = 1.0 / sqrt(square);
    return gain < UNSEEN_GAIN ? gain : (double)INFINITY;
}

/* Computes the weights with the least sum of squares, w = A^T (A A^T)^-1 e, where the rows of A are ones and the
   real and imaginary parts of heads_sight(): the shortest solution of A w = e = (1, 0, 0). */
static bool shortest_weights(const struct heads_geometry *geometry, uint32_t used,
                             double weight[HEADS_MOST]) {
    double row[CONDITIONS][HEADS_MOST] = {{0.0}};
    double packed[CONDITIONS * (CONDITIONS + 1) / 2] = {0.0};
    double right[CONDITIONS] = {1.0, 0.0, 0.0};
    for (uint32_t head = 0; head < geometry->heads; head++) {
        struct vector sight = heads_sight(geometry, head);
        if ((used >> head & 1U) == 0) {
            continue;
        }
        row[0][head] = 1.0;
        row[1][head] = sight.re;
        row[2][head] = sight.im;
        for (uint32_t i = 0; i < CONDITIONS; i++) {
            for (uint32_t j = 0; j <= i; j++) {
                packed[packed_place(i, j)] += row[i][head] * row[j][head];
            }
        }
    }
    if (!cholesky_factor(packed, CONDITIONS)) {
        return false;
    }
    cholesky_solve(packed, CONDITIONS, right);
    double square = 0.0;
    for (uint32_t head = 0; head < geometry->heads; head++) {
        weight[head] = right[0] * row[0][head] + right[1] * row[1][head] + right[2] * row[2][head];
        square += weight[head] * weight[head];
    }
    return square <= MEAN_NOISE_LIMIT * MEAN_NOISE_LIMIT;
}

double heads_leak(const struct heads_geometry *geometry, const int32_t weight[HEADS_MOST]) {
    struct vector leak = {0.0, 0.0};
    for (uint32_t head = 0; head < geometry->heads; head++) {
        leak =
            vector_sum(leak, vector_scaled(heads_sight(geometry, head), weight[head] / WEIGHT_ONE));
    }
    return vector_length(leak);
}

/* Tries combinations of words near the exact weights, and keeps the one that leaves the least motion of the axis in the
   mean. The word of the last head follows from the sum of all words; like the other words, it may differ from the
   exact weight by at most WORD_REACH and half a step. */
bool heads_weights(const struct heads_geometry *geometry, uint32_t used,
                   int32_t weight[HEADS_MOST]) {
    double exact[HEADS_MOST];
    double least = (double)INFINITY;
    uint32_t last = 0;
    uint32_t number = 0;
    uint32_t choices = 1;
    ASSERT(geometry->heads > 2 && geometry->heads <= HEADS_MOST && used >> geometry->heads == 0);
    for (uint32_t head = 0; head < geometry->heads; head++) {
        if ((used >> head & 1U) != 0) {
            last = head;
            choices *= number++ > 0 ? WORD_CHOICES : 1;
        }
    }
    if (number < 3 || !shortest_weights(geometry, used, exact)) {
        return false;
    }
    for (uint32_t choice = 0; choice < choices; choice++) {
        int32_t words[HEADS_MOST] = {0};
        int32_t left = (int32_t)WEIGHT_ONE;
        bool fits = true;
        for (uint32_t head = 0, code = choice; head <= last; head++) {
            if ((used >> head & 1U) == 0) {
                continue;
            }
            int32_t near = (int32_t)rint(exact[head] * WEIGHT_ONE);
            words[head] = head == last ? left : near + (int32_t)(code % WORD_CHOICES) - WORD_REACH;
            left -= words[head];
            code /= WORD_CHOICES;
            fits = fits && words[head] >= -WEIGHT_LIMIT && words[head] < WEIGHT_LIMIT;
        }
        double leak = heads_leak(geometry, words);
        if (fits && leak < least &&
            fabs(words[last] - exact[last] * WEIGHT_ONE) <= WORD_REACH + 0.5) {
            least = leak;
            for (uint32_t head = 0; head < HEADS_MOST; head++) {
                weight[head] = words[head];
            }
        }
    }
    return isfinite(least);
}
