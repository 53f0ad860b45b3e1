/* SPDX-License-Identifier: Apache-2.0 */

#include "real_follow.h"

#include <math.h>
#include <stddef.h>

#include "arctrue_number_formats.h"
#include "assertion.h"
#include "units.h"

/* Returns the loaded lanes if they are active and at least one lane of a real order takes its phase from `source`;
   otherwise NULL. */
static struct followed *real_follow_lanes(struct application *application,
                                          enum phase_source source) {
    struct followed *followed = &application->load.followed;
    if (load_at_work(&application->load) == NULL || !application->has_active) {
        return NULL;
    }
    for (uint32_t place = 0; place < followed->real_lanes; place++) {
        if (followed->real[place].source == (uint32_t)source) {
            return followed;
        }
    }
    return NULL;
}

/* Finds the number that the core gives to the turn in which head 1 read the first sample. Returns false if this number
   is not certain. */
static bool real_follow_first_turn(const struct application *application, const struct turn *turn,
                                   int32_t *first_turn) {
    struct core_turn_place place;
    int32_t counts_per_rev = turn->counts_per_rev;
    ASSERT(counts_per_rev > 0);
    if (!core_turn_place(&application->core, (uint32_t)counts_per_rev, &place)) {
        return false;
    }
    int64_t since = (int64_t)place.head1_angle -
                    counts_apart(place.head1_turn_position, turn->first) - turn->start_angle;
    *first_turn = place.head1_turn + (int32_t)(since / counts_per_rev);
    /* A remainder shows that the zero of head 1 has moved since the turn began. */
    return since % counts_per_rev == 0;
}

void real_follow_turn(struct application *application, const struct turn *turn) {
    struct load *load = &application->load;
    struct followed *followed = real_follow_lanes(application, PHASE_BY_HEADS);
    int32_t first_turn;
    if (followed == NULL || application->active.mean.heads != 0 ||
        !real_follow_first_turn(application, turn, &first_turn)) {
        return;
    }
    double arcsec = ARCSEC_PER_TURN / turn->counts_per_rev;
    for (uint32_t place = 0; place < followed->real_lanes; place++) {
        struct real_lane *lane = &followed->real[place];
        struct line_finder *finder = &load->finder[place];
        const struct line_sought line = {
            .order = real_lane_order(lane),
            .turn_step = lane->turn_step,
            .amplitude_arcsec =
                fabs((double)lane->amplitude) / (1 << ARCTRUE_AMPLITUDE_FRACTION) * arcsec,
        };
        if (lane->source != PHASE_BY_HEADS) {
            continue;
        }
        /* The finder uses the nominal separation, because a harmonic of a real order changes the measured separation
           from turn to turn. */
        line_finder_add(finder, &line, turn, first_turn,
                        application->parameters.separation_deg * PI / 180.0,
                        application->measured.noise_arcsec);
        if (!finder->is_known) {
            load->phase_given = load->phase_given || lane->phase_known;
            lane->phase_known = false;
            continue;
        }
        /* A negative amplitude equals a phase of half a turn. */
        double phase = line_finder_phase(finder) + (lane->amplitude < 0 ? 0.5 : 0.0);
        bool moved = real_lane_move_phase(lane, phase, 0.0, 0,
                                          application->parameters.temperature_step_counts);
        load->phase_given = load->phase_given || moved;
    }
}

void real_follow_probe(struct application *application) {
    struct load *load = &application->load;
    struct followed *followed = real_follow_lanes(application, PHASE_BY_PROBE);
    struct core_turn_place now;
    if (followed == NULL) {
        return;
    }
    const struct core_probe probe = core_probe(&application->core);
    bool is_new = load->probe_seen && probe.edges != load->probe_edges;
    uint32_t counts_per_rev = (uint32_t)application->parameters.counts_per_rev;
    ASSERT(counts_per_rev > 0);
    load->probe_seen = true;
    load->probe_edges = probe.edges;
    if (!is_new || !core_turn_place(&application->core, counts_per_rev, &now)) {
        return;
    }
    int32_t since = counts_apart(now.position, probe.position);
    if (since <= 0) {
        return;
    }
    /* Number of turns, 0 or negative, from the present turn to the turn of the edge. */
    int64_t back = ((int64_t)now.angle - since - probe.angle) / counts_per_rev;
    double angle_turns = (double)probe.angle / counts_per_rev;
    for (uint32_t place = 0; place < followed->real_lanes; place++) {
        struct real_lane *lane = &followed->real[place];
        if (lane->source == PHASE_BY_PROBE) {
            double phase =
                (double)lane->probe_phase / (1 << ARCTRUE_PHASE_WIDTH) + lane->side * angle_turns;
            bool moved = real_lane_move_phase(lane, phase, angle_turns, now.turn + (int32_t)back,
                                              application->parameters.temperature_step_counts);
            load->phase_given = load->phase_given || moved;
        }
    }
}
