/* SPDX-License-Identifier: Apache-2.0 */

#include "loaded_watch.h"

#include <math.h>

#include "assertion.h"

/* SHARE: weight of a turn in the running variance. MOST_TIMES: limit of the variance of one turn (a quarter of the
   squared change since the turn before), as a multiple of the running variance. Without the limit, a jump of the order
   itself would count as scatter. */
#define SHARE 0.1
#define MOST_TIMES 9.0

void watch_begin(struct loaded_watch *watch) {
    watch->mean_square = 0.0;
    watch->at_fault = false;
}

/* Updates the running variance of a component from turn to turn, and returns it. The squared difference of two
   independent turns, summed over both components, is on average four times that variance. The result is never below the
   variance that the turn itself states. */
static double watch_follow_variance(struct watched_lane *lane, bool shown, struct vector left,
                                    double stated) {
    double variance = shown ? lane->variance : stated;
    if (shown) {
        const struct vector before = {lane->cosine, lane->sine};
        double found = 0.25 * vector_square(vector_difference(left, before));
        found = fmin(found, MOST_TIMES * fmax(variance, stated));
        variance += SHARE * (found - variance);
    }
    *lane = (struct watched_lane){(float)left.re, (float)left.im, (float)variance};
    return fmax(variance, stated);
}

void watch_lane(struct loaded_watch *watch, uint32_t place, const struct sight *sight,
                struct vector applied) {
    ASSERT(place < LANES_LIMIT);
    uint64_t bit = 1ULL << place;
    struct vector left = vector_difference(sight->value, applied);
    double square = vector_square(left);
    double variance = watch_follow_variance(&watch->lane[place], (watch->shown & bit) != 0, left,
                                            sight->variance);
    double limit =
        WATCH_SIGMAS * WATCH_SIGMAS * (variance + sight->by_separation + sight->by_change);
    watch->shown |= bit;
    if (!(square > limit)) {
        watch->beyond[place] = 0;
    } else if (watch->beyond[place] < WATCH_TURNS) {
        watch->beyond[place]++;
    }
    watch->at_fault = watch->at_fault || watch->beyond[place] == WATCH_TURNS;
    /* Noise increases |left|^2, so its variance is subtracted; the separation's error is added. A cosine of
       amplitude A has the mean square A^2/2. */
    watch->mean_square += 0.5 * fmax(square - 2.0 * sight->variance, 0.0) + sight->by_separation;
}

void watch_table(struct loaded_watch *watch, double evidence, double enough) {
    /* The lower limit of the sum lets a few turns end the fault, however long it lasted. */
    double sum = fmax(fmin(watch->table_evidence + evidence, 0.0), -2.0 * enough);
    watch->table_evidence = (float)sum;
    watch->at_fault = watch->at_fault || sum <= -enough;
}

double watch_left(const struct loaded_watch *watch, uint32_t place) {
    ASSERT(place < LANES_LIMIT);
    const struct watched_lane *lane = &watch->lane[place];
    const struct vector left = {lane->cosine, lane->sine};
    bool shown = (watch->shown >> place & 1U) != 0;
    return shown ? vector_length(left) : -1.0;
}
