/* SPDX-License-Identifier: Apache-2.0 */

#include "mean_set.h"

#include <math.h>

#include "arctrue_number_formats.h"
#include "assertion.h"

enum {
    WEIGHT_ONE = 1 << ARCTRUE_HEAD_WEIGHT_FRACTION,
    OFFSET_ONE = 1 << ARCTRUE_HEAD_OFFSET_FRACTION
};
#define WEIGHT_LIMIT (1 << (ARCTRUE_HEAD_WEIGHT_WIDTH - 1))
#define ERROR_LIMIT (1 << (ARCTRUE_AMPLITUDE_WIDTH - 1))

bool mean_set_is_valid(const struct mean_set *set, uint32_t heads, uint32_t counts_per_rev) {
    int64_t sum = 0;
    if (set->heads != heads || heads > HEADS_MOST || set->carrier >= heads ||
        set->used >> heads != 0 || (set->used >> set->carrier & 1U) == 0 ||
        set->error_offset < -ERROR_LIMIT || set->error_offset >= ERROR_LIMIT) {
        return false;
    }
    for (uint32_t head = 0; head < heads; head++) {
        bool used = (set->used >> head & 1U) != 0;
        bool fits = set->weight[head] >= -WEIGHT_LIMIT && set->weight[head] < WEIGHT_LIMIT;
        if (!fits || (!used && set->weight[head] != 0) ||
            set->offset[head] >= OFFSET_ONE * counts_per_rev) {
            return false;
        }
        sum += set->weight[head];
    }
    return sum == WEIGHT_ONE;
}

double mean_set_off(const struct mean_set *set, const double place[HEADS_MOST],
                    uint32_t counts_per_rev) {
    double most = 0.0;
    ASSERT(set->heads <= HEADS_MOST && set->carrier < HEADS_MOST);
    for (uint32_t head = 0; head < set->heads; head++) {
        if ((set->used >> head & 1U) != 0) {
            double expected =
                ((double)set->offset[head] - (double)set->offset[set->carrier]) / OFFSET_ONE;
            double off = place[head] - place[set->carrier] - expected;
            most = fmax(most, fabs(off - counts_per_rev * rint(off / counts_per_rev)));
        }
    }
    return most;
}
