/* SPDX-License-Identifier: Apache-2.0 */

#include "heads_table.h"

#include <math.h>
#include <string.h>

#include "separation.h"
#include "units.h"

/* Least travel of a reading from the first to the last sample of a capture, in turns, that shows the sense of a head.
   A capture lasts a turn; the reading of a head that does not count travels by a few counts only. */
#define SENSE_TURNS_OF_CAPTURE 0.5
/* Least travel from the index, in turns, that shows the sense of a head. Heads that count in the same sense differ by
   less than a turn, because each one has seen its index within the same turn. */
#define SENSE_TURNS 1.0
/* Largest distance from a planned place at which a head counts as the planned head; an eccentricity of 0.5 mm moves the
   reading of a head by 0.5 degrees. */
#define PLACE_TOLERANCE_DEG 1.0

struct place {
    double deg;
    double u_arcsec;
    const char *source;
    bool known;
    bool has_u;
};

static double degrees_of_turn(double rad) {
    double turns = rad / (2.0 * PI);
    return (turns - floor(turns)) * 360.0;
}

static struct place place_of(const struct application *application, const struct core_turns *turns,
                             uint32_t head) {
    const struct heads_found *found = &application->found;
    const struct skew_turn *turn = &application->skew.last;
    uint32_t counts_per_rev = (uint32_t)application->parameters.counts_per_rev;
    if (!core_head_indexed(&application->core, 0) || !core_head_indexed(&application->core, head)) {
        return (struct place){.source = "-"};
    }
    if (head < found->geometry.heads) {
        double rad = found->geometry.offset_rad[head] + found->geometry.late_rad[head];
        return (struct place){degrees_of_turn(rad), found->u_late_arcsec[head], "fit", true, true};
    }
    if (head < turn->heads) {
        double index_rad = index_uncertainty_rad((int32_t)counts_per_rev,
                                                 application->parameters.index_detection_arcsec);
        double u_rad = head > 0 ? sqrt(turn->variance + index_rad * index_rad) : 0.0;
        return (struct place){degrees_of_turn(turn->offset_rad[head]), u_rad * ARCSEC_PER_RAD,
                              "turn", true, true};
    }
    double apart = ((double)turns->angle[head] - turns->angle[0]) / counts_per_rev;
    return (struct place){degrees_of_turn(apart * 2.0 * PI), 0.0, "index", true, false};
}

/* Sets `at` to the number of the planned head at each place. One planned head after another is assumed to be connected
   as head 1; the first assumption that explains all places is used. If none does, all numbers are 0. */
static void planned_heads(const struct application *application, const struct place *places,
                          uint32_t at[HEADS_MOST]) {
    uint32_t heads = application->configuration.heads;
    const uint32_t all = (1U << heads) - 1U;
    uint32_t used = 0;
    for (uint32_t first = 0; first < heads && used != all; first++) {
        double turned = parameters_place_deg(&application->parameters, first);
        used = 0;
        for (uint32_t head = 0; head < heads; head++) {
            at[head] = 0;
            for (uint32_t planned = 0; planned < heads; planned++) {
                double plan = parameters_place_deg(&application->parameters, planned);
                double off = (places[head].deg + turned - plan) / 360.0;
                bool near = fabs(off - rint(off)) * 360.0 <= PLACE_TOLERANCE_DEG;
                if (places[head].known && near && (plan != 0.0 || planned == 0) &&
                    (used >> planned & 1U) == 0) {
                    at[head] = planned + 1;
                    used |= 1U << planned;
                }
            }
        }
    }
    if (used != all) {
        memset(at, 0, HEADS_MOST * sizeof at[0]);
    }
}

static void cell(const struct text_sink *sink, bool known, double value, unsigned decimals) {
    text_word(sink, " ");
    if (known) {
        text_fixed(sink, value, decimals);
    } else {
        text_word(sink, "-");
    }
}

/* Returns the sense in the latest capture or, if head 1 did not travel in a capture, the sense of the travel from the
   index. The latter is wrong after the turn position has wrapped (at 2^24 counts per turn, after 128 turns). */
static const char *sense_of(const struct application *application, const struct core_turns *turns,
                            uint32_t head) {
    double counts_per_rev = application->parameters.counts_per_rev;
    const int32_t *travel = application->capture.travel;
    double least = SENSE_TURNS_OF_CAPTURE * counts_per_rev;
    if (fabs((double)travel[0]) < least) {
        travel = turns->turn_position;
        least = SENSE_TURNS * counts_per_rev;
    }
    if (fabs((double)travel[head]) < least) {
        return " -";
    }
    return travel[head] > 0 ? " up" : " down";
}

void heads_table_show(struct console *console) {
    const struct application *application = console->application;
    const struct text_sink *sink = &console->sink;
    const struct head_skew *skew = &application->skew;
    uint32_t heads = application->configuration.heads;
    struct place places[HEADS_MOST];
    uint32_t at[HEADS_MOST];
    if (application->phase == PHASE_NO_CORE) {
        text_error(sink, "no core", "");
        return;
    }
    (void)core_position(&application->core);
    const struct core_turns turns = core_turns(&application->core, heads);
    for (uint32_t head = 0; head < heads; head++) {
        places[head] = place_of(application, &turns, head);
    }
    planned_heads(application, places, at);
    text_line(sink, "head sense index place_deg u_arcsec from at_head late_ns u_ns radius u");
    for (uint32_t head = 0; head < heads; head++) {
        const struct heads_found *found = &application->found;
        bool has_radius = head < found->geometry.heads;
        text_unsigned(sink, head + 1);
        text_word(sink, sense_of(application, &turns, head));
        text_word(sink, core_head_indexed(&application->core, head) ? " seen" : " unseen");
        cell(sink, places[head].known, places[head].deg, 6);
        cell(sink, places[head].has_u, places[head].u_arcsec, 2);
        text_word(sink, " ");
        text_word(sink, places[head].source);
        cell(sink, at[head] != 0, at[head], 0);
        cell(sink, head < skew->heads, skew->late_ns[head], 1);
        cell(sink, head < skew->heads, head != 0 ? skew->u_ns : 0.0, 1);
        cell(sink, has_radius, has_radius ? 1.0 / found->geometry.ratio[head] : 0.0, 6);
        cell(sink, has_radius, found->u_ratio[head], 6);
        text_line(sink, "");
    }
    text_line(sink, "ok");
}
