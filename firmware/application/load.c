/* SPDX-License-Identifier: Apache-2.0 */

#include "load.h"

#include <stddef.h>
#include <string.h>

#include "assertion.h"

const char *load_state_name(enum load_state state) {
    static const char *const names[] = {"none", "receiving", "waiting", "active", "refused"};
    return (unsigned)state <= LOAD_REFUSED ? names[state] : "unknown";
}

const char *load_answer_name(enum load_answer answer) {
    static const char *const names[LOAD_ANSWERS] = {
        [LOAD_TAKEN] = "taken",
        [LOAD_WRONG_CRC] = "wrong_crc",
        [LOAD_WRONG_FRAME] = "wrong_frame",
        [LOAD_TOO_MANY_LANES] = "too_many_lanes",
        [LOAD_OUT_OF_RANGE] = "out_of_range",
        [LOAD_ORDER_TWICE] = "order_twice",
        [LOAD_NOT_WHOLE] = "not_whole",
        [LOAD_ANOTHER_TABLE] = "another_table",
        [LOAD_TOO_STEEP] = "too_steep",
        [LOAD_WORSE] = "worse_prediction",
        [LOAD_NOT_READ_BACK] = "not_read_back",
        [LOAD_UNSEEN] = "unseen_order",
        [LOAD_NO_MODULATORS] = "no_modulators",
        [LOAD_UNSTABLE_SPEED] = "unstable_speed",
        [LOAD_NO_REAL_ORDERS] = "no_real_orders",
        [LOAD_TOO_FEW_COUNTS] = "too_few_counts",
        [LOAD_NO_LOCAL_TABLE] = "no_local_table",
        [LOAD_OTHER_HEADS] = "other_heads",
        [LOAD_OTHER_DELAYS] = "other_delays",
        [LOAD_NO_FAILOVER] = "no_failover",
        [LOAD_HEAD_LEFT_OUT] = "head_left_out",
    };
    return (unsigned)answer < LOAD_ANSWERS ? names[answer] : "unknown";
}

static bool load_has_loaded(const struct load *load) {
    return coefficients_most_order(&load->loaded) > 0 || load->loaded.mean.heads != 0 ||
           load->table.place.choice != 0 || followed_all_lanes(&load->followed) > 0;
}

void load_refuse(struct load *load, enum load_answer reason) {
    load->state = LOAD_REFUSED;
    load->reason = reason;
    load->whole = false;
}

/* Sets the state that follows from the loaded set while no set is being received and no received set waits. */
static void load_settle(struct load *load) {
    load->whole = false;
    if (load->loaded_state == LOADED_PENDING) {
        load->state = LOAD_WAITING;
    } else {
        load->state = load_at_work(load) != NULL ? LOAD_ACTIVE : LOAD_NONE;
    }
}

void load_assert(const struct load *load) {
    ASSERT((unsigned)load->state <= LOAD_REFUSED);
    ASSERT((unsigned)load->loaded_state <= LOADED_REJECTED);
    ASSERT(load->received.lanes <= LANES_LIMIT && load->loaded.lanes <= LANES_LIMIT);
    ASSERT(load->received_thermal.lanes <= THERMAL_LANES_MAX);
    ASSERT(load->thermal.lanes <= THERMAL_LANES_MAX);
    ASSERT(!load->whole || load->state == LOAD_WAITING);
}

void load_abort(struct load *load) {
    load_settle(load);
}

const struct coefficients *load_at_work(const struct load *load) {
    return load->loaded_state == LOADED_AT_WORK && load_has_loaded(load) ? &load->loaded : NULL;
}

/* Marks the phases of real orders as unknown: they are unknown in a new set and after a start of the core, because the
   core then restarts its count of turns. */
static void load_seek_phases(struct load *load) {
    memset(load->finder, 0, sizeof load->finder);
    load->probe_seen = false;
    for (uint32_t place = 0; place < load->followed.real_lanes; place++) {
        load->followed.real[place].phase_known = false;
    }
}

/* Makes a saved or received set the loaded set; a reception in progress continues. */
void load_take_over(struct load *load, const struct coefficients *set,
                    const struct thermal *thermal, const struct followed *followed,
                    const struct load_table *table, uint64_t unjudged) {
    ASSERT(followed->lanes <= FOLLOWED_LANES_MAX);
    ASSERT(set->lanes <= LANES_LIMIT && thermal->lanes <= THERMAL_LANES_MAX);
    load->loaded = *set;
    load->thermal = *thermal;
    load->unjudged = unjudged;
    load->followed = *followed;
    load->table = *table;
    load_seek_phases(load);
    load->loaded_crc = 0;
    load_at_work_again(load);
}

void load_take_over_received(struct load *load) {
    uint32_t crc = load->crc;
    load->whole = false;
    load_take_over(load, &load->received, &load->received_thermal, &load->received_followed,
                   &load->received_table, load->received_unjudged);
    load->loaded_crc = crc;
    load_settle(load);
}

void load_at_work_again(struct load *load) {
    load->loaded_state = LOADED_AT_WORK;
    load->watch = (struct loaded_watch){.shown = 0};
    if (load->state != LOAD_RECEIVING && !load->whole) {
        load_settle(load);
    }
}

void load_reject(struct load *load, enum load_answer reason) {
    load->loaded_state = LOADED_REJECTED;
    if (load->state != LOAD_RECEIVING && !load->whole) {
        load_refuse(load, reason);
    }
}

void load_forget(struct load *load) {
    memset(load, 0, sizeof *load);
}

void load_begin_evidence(struct load *load) {
    memset(load->evidence, 0, sizeof load->evidence);
    load->table_evidence = 0.0;
    load->shown = 0;
    load->shown_twice = 0;
    load->undecided = 0;
    load->refused_order = 0;
}

void load_again(struct load *load, uint32_t counts_per_rev) {
    load_begin_evidence(load);
    if (!load_has_loaded(load)) {
        return;
    }
    load_seek_phases(load);
    if (load->loaded.counts_per_rev == counts_per_rev) {
        load->loaded_state = LOADED_PENDING;
        if (load->state != LOAD_RECEIVING && !load->whole) {
            load_settle(load);
        }
    } else {
        load_reject(load, LOAD_ANOTHER_TABLE);
    }
}

bool load_phase(struct load *load, uint32_t number, uint32_t phase, int32_t turn) {
    if (load_at_work(load) == NULL || number >= load->followed.real_lanes) {
        return false;
    }
    real_lane_set_phase(&load->followed.real[number], phase, turn);
    load->phase_given = true;
    return true;
}

bool load_takes_unseen(const struct load *load) {
    return load->forced || load->unseen_taken;
}

bool load_waits_for(const struct load *load, bool other_direction) {
    const struct followed *followed = &load->received_followed;
    if (!load->whole || load->forced) {
        return false;
    }
    for (uint32_t place = 0; place < followed->lanes; place++) {
        bool direction = followed->lane[place].modulator == MODULATOR_DIRECTION;
        bool once = (load->shown & ~load->shown_twice) >> place & 1U;
        if (once && direction == other_direction) {
            return true;
        }
    }
    return false;
}

struct followed load_followed_at_work(const struct load *load) {
    return load_at_work(load) != NULL ? load->followed : (struct followed){.lanes = 0};
}

void load_own_lanes(const struct load *load, const struct coefficients *active,
                    struct coefficients *own) {
    ASSERT(active == NULL || active->lanes <= LANES_LIMIT);
    *own = (struct coefficients){.counts_per_rev = active != NULL ? active->counts_per_rev : 0};
    for (uint32_t lane = 0; active != NULL && lane < active->lanes; lane++) {
        if (!coefficients_have(load_at_work(load), active->lane[lane].order)) {
            own->lane[own->lanes++] = active->lane[lane];
        }
    }
}

void load_combine(const struct coefficients *set, const struct thermal *thermal, double celsius,
                  const struct coefficients *own, uint32_t lanes, struct coefficients *candidate) {
    uint32_t used = 0;
    uint32_t of_set = set != NULL ? set->lanes : 0;
    uint32_t of_own = own != NULL ? own->lanes : 0;
    const struct coefficients *either = set != NULL ? set : own;
    ASSERT(lanes <= LANES_LIMIT && of_set <= LANES_LIMIT && of_own <= LANES_LIMIT);
    ASSERT(candidate != set && candidate != own);
    *candidate = (struct coefficients){
        .lanes = lanes,
        .counts_per_rev = either != NULL ? either->counts_per_rev : 0,
    };
    if (set != NULL && set->mean.heads != 0) {
        /* The calibration's own lanes correct head 1, not a mean, so the core uses none of these lanes. */
        candidate->mean = set->mean;
        of_own = 0;
    }
    for (uint32_t lane = 0; lane < of_set && used < lanes; lane++) {
        if (set->lane[lane].order != 0) {
            candidate->lane[used++] = thermal_lane_at(thermal, &set->lane[lane], celsius);
        }
    }
    for (uint32_t lane = 0; lane < of_own && used < lanes; lane++) {
        uint32_t order = own->lane[lane].order;
        if (order != 0 && !coefficients_have(set, order)) {
            candidate->lane[used++] = own->lane[lane];
        }
    }
}
